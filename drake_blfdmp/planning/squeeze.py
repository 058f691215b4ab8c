"""How hard the palms press on the box, and how deep they must be commanded into it for that."""

from dataclasses import dataclass, replace

import numpy as np
from pydrake.multibody.plant import MultibodyPlant

from drake_blfdmp.errors import TaskError
from drake_blfdmp.planning.held_squeeze import HeldSqueeze
from drake_blfdmp.planning.scenario_sections import TaskConfig
from drake_blfdmp.robot.box import BoxParameters
from drake_blfdmp.robot.contact import palm_stiffness
from drake_blfdmp.robot.grasp_force import (
    GRAVITY,
    PADS_FACTOR,
    PALM_FRICTION,
    combined_friction,
    largest_squeeze,
    least_squeeze,
)
from drake_blfdmp.robot.plant import ARMS, DEFAULT_STIFFNESS

USUAL_FORCE = 55.0
"""What is planned where the box does not need more, N."""

ARMS_NEED = 2.2
"""On the friction cone's estimate, what the simulated arms were measured to need."""

UNSURE = 0.2
"""A box may be so much heavier and so much smoother than believed, and is still held, where the limits allow it."""

EVEN, UNEVEN = 0.5, 1.0
"""Shares of a box's weight that a palm bears: where both bear alike, and at worst; 0.9 was measured."""

OVERSHOOT = 1.2
"""A palm may press by this factor more than its static force: trials measured 1.13 to 1.16 (`palm_stiffness`)."""


REMEDY = "use a lighter or rougher box, or a slower carry (task.duration_scale), or raise task.force_limit"

LARGEST_FORCE = TaskConfig().force_limit / OVERSHOOT
"""Largest static force, N, that is planned of a palm with the default limit and arms strong enough."""


@dataclass(frozen=True)
class Squeeze:
    """A planned squeeze: the depth of each palm, m, its mean force, N, and sentences on what was changed."""

    depth: float
    force: float
    notes: tuple[str, ...] = ()


def AskedForce(task: TaskConfig) -> float:
    """The mean force, N, that a task asks for where the box does not need more."""
    return USUAL_FORCE if task.squeeze_force is None else task.squeeze_force


def Compliances(plant: MultibodyPlant, postures: np.ndarray) -> np.ndarray:
    """By how much, m/N, both palms together yield along their normals in postures (N, 14): (N,)."""
    context = plant.CreateDefaultContext()
    arms = [plant.GetModelInstanceByName(arm) for arm in ARMS]
    compliance = np.empty(len(postures))
    for k, q in enumerate(postures):
        plant.SetPositions(context, q)
        compliance[k] = sum(1.0 / palm_stiffness(plant, context, arm, DEFAULT_STIFFNESS) for arm in arms)
    return compliance


def Strengths(plant: MultibodyPlant, postures: np.ndarray, mass: float, share: float = EVEN) -> np.ndarray:
    """The force (N,), N, with which both arms can press in postures (N, 14) while each bears a share of a mass, kg."""
    context = plant.CreateDefaultContext()
    arms = [plant.GetModelInstanceByName(arm) for arm in ARMS]
    load, strengths = (0.0, 0.0, -share * GRAVITY * mass), np.empty(len(postures))
    for k, q in enumerate(postures):
        plant.SetPositions(context, q)
        strengths[k] = min(largest_squeeze(plant, context, arm, load) for arm in arms)
    return strengths


def SqueezeCompliance(compliances: np.ndarray) -> float:
    """The one compliance, m/N, with which a squeeze's force is right on average over those of postures (N,)."""
    return float(1.0 / np.mean(1.0 / compliances))


def NeededForce(box: BoxParameters, acceleration: float, factor: float) -> float:
    """The least force, N, of each palm that carries the box with an acceleration, m/s^2; see `least_squeeze`."""
    friction = combined_friction(box.friction, PALM_FRICTION)
    return float(least_squeeze(box.mass, friction, acceleration, factor=factor))


def WantedForce(box: BoxParameters, acceleration: float) -> float:
    """The force, N, that a box is squeezed with where nothing limits it: `USUAL_FORCE`, or what it may need.

    Of the estimate for the box as it is believed to be that is some three times, more than `ARMS_FACTOR`.
    """
    worse = replace(box, mass=(1.0 + UNSURE) * box.mass, friction=(1.0 - UNSURE) * box.friction)
    return max(USUAL_FORCE, NeededForce(worse, acceleration, ARMS_NEED))


def RefuseForce(task: TaskConfig, box: BoxParameters) -> None:
    """Refuse what no posture could change: a force beyond the limit, asked for or needed to hold the box at rest.

    Raises:
        TaskError: of reason force.
    """
    if task.squeeze_force is not None and task.squeeze_force > task.force_limit:
        raise TaskError(
            f"force: task.squeeze_force is {task.squeeze_force:g} N, more than task.force_limit, {task.force_limit:g} "
            "N; lower the one or raise the other",
            reason="force",
        )
    least = NeededForce(box, 0.0, PADS_FACTOR)
    if least > task.force_limit:
        raise TaskError(
            f"force: a box of {box.mass:g} kg with friction {box.friction:g} needs {least:.0f} N of each palm at rest, "
            f"more than task.force_limit, {task.force_limit:g} N; use a lighter or rougher box, or raise the limit",
            reason="force",
        )


def AskedSqueeze(task: TaskConfig, compliances: np.ndarray) -> Squeeze:
    """The squeeze that a task asks for, whatever palms, arms and the box make of it.

    Args:
        task: its squeeze, else its squeeze_force, else `USUAL_FORCE`.
        compliances: (N,) of the held postures, m/N.
    """
    mean = _force_per_depth(compliances)
    depth = AskedForce(task) / mean if task.squeeze is None else task.squeeze
    return Squeeze(depth, depth * mean)


def ChooseSqueeze(
    task: TaskConfig,
    box: BoxParameters,
    compliances: np.ndarray,
    strengths: np.ndarray,
    uneven: np.ndarray,
    acceleration: float,
    held: HeldSqueeze | None = None,
) -> Squeeze:
    """The squeeze of a carry: what is asked for, else `USUAL_FORCE` or what the box needs; within the limits.

    Both palms yield: the force of a depth d is 2 d / (1/k_left + 1/k_right). In no held posture it passes the force
    limit or the arms' strength, less what `OVERSHOOT` keeps free. What is pressed more than usual, and more than the
    box as it is believed to be needs, leaves room for palms that bear it unevenly; where that is too little for a box
    that is worse, what palms and motors are predicted to bear counts.

    Args:
        task: its squeeze, squeeze_force and force_limit.
        box: the box.
        compliances: (N,) of the held postures, m/N.
        strengths: (N,) of the arms in them, N.
        uneven: (N,) the same where one palm bears all of the box (`UNEVEN`), N.
        acceleration: largest of the carried box, m/s^2.
        held: tells what becomes of a box that needs more than is allowed so; such a box is refused when None, and one
            that is worse than believed may slip.

    Raises:
        TaskError: of reason force: no allowed squeeze holds the box, or more is asked for than is allowed.
    """
    mean = _force_per_depth(compliances)
    deepest = _deepest(task, compliances, strengths)
    allowed = deepest * mean
    by = "task.force_limit" if strengths.min() >= task.force_limit else "the arms' strength"
    needed = NeededForce(box, acceleration, ARMS_NEED)
    if needed > allowed:
        if held is None:
            raise TaskError(
                f"force: a box of {box.mass:g} kg with friction {box.friction:g} needs {needed:.0f} N of each palm, "
                f"and {by} allows {allowed:.0f} N on average; {REMEDY}",
                reason="force",
            )
        return _held_squeeze(task, box, mean, held)
    if task.squeeze is not None and task.squeeze > deepest:
        raise TaskError(
            f"force: task.squeeze is {task.squeeze:g} m, but beyond {deepest:.4f} m ({allowed:.0f} N on average) a "
            f"palm could press harder than {by} allows; squeeze less",
            reason="force",
        )
    if task.squeeze is None and task.squeeze_force is not None and task.squeeze_force > allowed:
        raise TaskError(
            f"force: task.squeeze_force is {task.squeeze_force:g} N, but beyond {allowed:.0f} N on average a palm "
            f"could press harder than {by} allows in some posture; squeeze less",
            reason="force",
        )
    room = mean * _deepest(task, compliances, uneven)
    safe = WantedForce(box, acceleration)
    wanted = min(max(USUAL_FORCE, needed, min(safe, room)), allowed)
    if task.squeeze_force is None and task.squeeze is None and wanted < safe and held is not None:
        wanted = mean * held.harder(wanted / mean, safe / mean, UNSURE)
    force = wanted if task.squeeze_force is None else task.squeeze_force
    depth = force / mean if task.squeeze is None else task.squeeze
    force, notes = depth * mean, []
    if force < needed:
        notes.append(f"squeezed with {force:.0f} N as asked, where the box needs about {needed:.0f} N not to slip")
    elif task.squeeze is None and task.squeeze_force is None and abs(force - USUAL_FORCE) > 0.5:
        why = f"a box of {box.mass:g} kg with friction {box.friction:g} may need it" if force > USUAL_FORCE else by
        notes.append(f"squeezed with {force:.0f} N in place of the usual {USUAL_FORCE:.0f} N: {why}")
    return Squeeze(depth, force, tuple(notes))


def _force_per_depth(compliances: np.ndarray) -> float:
    """Its mean over held postures, N/m."""
    return 2.0 * float(np.mean(1.0 / compliances))


def _deepest(task: TaskConfig, compliances: np.ndarray, strengths: np.ndarray) -> float:
    """The largest depth, m, of which no posture makes more force than the limit and the arms allow."""
    return float(0.5 * np.min(np.minimum(task.force_limit, strengths) / OVERSHOOT * compliances))


def _held_squeeze(task: TaskConfig, box: BoxParameters, mean: float, held: HeldSqueeze) -> Squeeze:
    """Of a box for which rules of thumb have too little force: what is asked for, or found, if it is predicted to hold.

    Raises:
        TaskError: nothing does.
    """
    asked = task.squeeze
    if asked is None and task.squeeze_force is not None:
        asked = task.squeeze_force / mean
    what = f"a box of {box.mass:g} kg with friction {box.friction:g}"
    if asked is None:
        depth, told = held.find(mean, UNSURE)
    else:
        problem = held.problem(asked)
        depth, told = (asked, "") if problem is None else (None, f"with {asked * mean:.0f} N {problem.what}")
    if depth is None:
        raise TaskError(f"force: {what} cannot be held: {told}; {REMEDY}", reason="force")
    note = f"squeezed with {depth * mean:.0f} N, with which palms and motors are predicted to hold {what}"
    return Squeeze(depth, depth * mean, (f"{note}; {told}" if told else note,))
