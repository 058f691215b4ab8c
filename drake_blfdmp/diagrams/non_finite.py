"""Which system of a diagram made the first number that is not finite."""

import math
from dataclasses import dataclass

import numpy as np
from pydrake.systems.framework import Context, Diagram, PortDataType, System


@dataclass(frozen=True)
class Origin:
    """Where a number that is not finite stands first.

    Attributes:
        system: its name; `a::b` for b inside a.
        port: the output port that shows it, the input port where something not finite was put in, or empty for a state
            that no output shows.
        kind: "output", "input" or "state".
        value: what stands there.
    """

    system: str
    port: str
    kind: str
    value: np.ndarray


def state_of(context: Context) -> np.ndarray:
    """All continuous and discrete state of a context, in one new vector."""
    discrete = context.get_discrete_state()
    parts = [discrete.value(i) for i in range(discrete.num_groups())]
    if context.num_continuous_states():
        parts.append(context.get_continuous_state_vector().CopyToVector())
    return np.concatenate(parts) if parts else np.zeros(0)


def set_state(context: Context, state: np.ndarray) -> None:
    """Put back what `state_of` took out."""
    first = 0
    for i in range(context.num_discrete_state_groups()):
        last = first + context.get_discrete_state(i).size()
        context.SetDiscreteState(i, state[first:last])
        first = last
    if context.num_continuous_states():
        context.SetContinuousState(state[first:])


def states_by_system(diagram: Diagram, context: Context) -> dict[str, dict]:
    """The state of every system that has one, as lists, by the systems' names."""
    found = {}
    for system in diagram.GetSystems():
        mine = system.GetMyContextFromRoot(context)
        entry: dict = {}
        if mine.num_continuous_states():
            entry["continuous"] = mine.get_continuous_state_vector().CopyToVector().tolist()
        if mine.num_discrete_state_groups():
            values = mine.get_discrete_state()
            entry["discrete"] = [values.value(i).tolist() for i in range(values.num_groups())]
        if entry:
            found[system.get_name()] = entry
    return found


def by_data_flow(diagram: Diagram) -> list[System]:
    """The diagram's systems, each after those it listens to; a feedback loop is opened where it is entered first."""
    sources: dict[System, list[System]] = {system: [] for system in diagram.GetSystems()}
    for (target, _), (source, _) in diagram.connection_map().items():
        sources[target].append(source)
    numbers = {system: i for i, system in enumerate(sources)}
    order: list[System] = []
    entered: set[System] = set()

    def visit(system: System) -> None:
        if system not in entered:
            entered.add(system)
            for source in sorted(sources[system], key=numbers.__getitem__):
                visit(source)
            order.append(system)

    for system in sources:
        visit(system)
    return order


def find_origin(diagram: Diagram, before: Context, after: Context, start: Context) -> Origin | None:
    """The first system, in the direction of the data, that makes something not finite out of what is finite.

    Args:
        diagram: the root, or a diagram inside it.
        before: a root context whose state is finite, at the time of the update that went wrong: what the systems read.
        after: the same after it, or the same as `before` where the update raised an exception.
        start: of the run's first state. What is infinite there is so by design.

    Returns:
        None where everything is finite.
    """
    order = by_data_flow(diagram)
    wires = diagram.connection_map()
    bad = {
        (system, i): value
        for system in order
        for i in range(system.num_output_ports())
        if (value := _not_finite(system.get_output_port(i), system, before, start)) is not None
    }
    for system in order:
        # A value put in by hand, or from outside the diagram; a wire's other end has its turn.
        for i in range(system.num_input_ports()):
            port = system.get_input_port(i)
            if (system, port.get_index()) not in wires:
                value = _not_finite(port, system, before)
                if value is not None:
                    return _inside(system, before, after, start) or Origin(
                        system.get_name(), port.get_name(), "input", value
                    )
        for i in range(system.num_output_ports()):
            if (system, i) in bad and not _passed_on(system, i, bad, wires):
                name = system.get_output_port(i).get_name()
                inner = _inside(system, before, after, start)
                return inner or Origin(system.get_name(), name, "output", bad[system, i])
    # Everything that was read is finite: a system's own update made it.
    for system in order:
        state, first = (state_of(system.GetMyContextFromRoot(context)) for context in (after, start))
        if not _finite(state, first):
            for i in range(system.num_output_ports()):
                port = system.get_output_port(i)
                value = _not_finite(port, system, after, start)
                if value is not None:
                    inner = _inside(system, before, after, start)
                    return inner or Origin(system.get_name(), port.get_name(), "output", value)
            return Origin(system.get_name(), "", "state", state)
    return None


def _finite(value: np.ndarray, first: np.ndarray) -> bool:
    return bool(np.all(np.isfinite(value) | (np.isinf(first) & (value == first))))


def _not_finite(port, system: System, context: Context, start: Context | None = None) -> np.ndarray | None:
    """The value of a vector port that is not finite; None where it is, or where it cannot be computed."""
    if port.get_data_type() != PortDataType.kVectorValued:
        return None
    try:
        mine = system.GetMyContextFromRoot(context)
        if hasattr(port, "HasValue") and not port.HasValue(mine):
            return None
        value = np.array(port.Eval(mine))
        if np.isfinite(value).all():
            return None
        if start is None or np.isnan(value).any():
            return value
        return None if _finite(value, np.array(port.Eval(system.GetMyContextFromRoot(start)))) else value
    except Exception:  # An output that cannot be computed is no witness; whatever made it so is found before it.
        return None


def _passed_on(system: System, output: int, bad: dict, wires) -> bool:
    """Whether the output follows directly from an input that is not finite itself."""
    return any(
        listener is system and (source, int(port)) in bad and system.HasDirectFeedthrough(int(entry), output)
        for (listener, entry), (source, port) in wires.items()
    )


def _inside(system: System, before: Context, after: Context, start: Context) -> Origin | None:
    if not isinstance(system, Diagram):
        return None
    found = find_origin(system, before, after, start)
    if found is None:
        return None
    return Origin(f"{system.get_name()}::{found.system}", found.port, found.kind, found.value)


def described(origin: Origin) -> str:
    """The origin in a few words."""
    value = origin.value
    count = int(np.sum(~np.isfinite(value)))
    kind = "nan" if any(map(math.isnan, value)) else "inf"
    where = f"{origin.kind} port '{origin.port}' of system" if origin.port else "the state of system"
    return f"{where} '{origin.system}' is not finite ({kind} in {count} of {len(value)})"
