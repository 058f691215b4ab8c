"""A number that is not finite is put in at one place after another: the guard stops there and names the place."""

import math
from dataclasses import replace

import numpy as np
import pytest
from poisoned import Breaking, BreakingSkill, Growing
from pydrake.multibody.plant import AddMultibodyPlant, MultibodyPlantConfig
from pydrake.multibody.tree import PdControllerGains, RevoluteJoint, SpatialInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder, LeafSystem
from pydrake.systems.primitives import Adder, ConstantVectorSource, Integrator, Saturation, ZeroOrderHold

from drake_blfdmp import interruption
from drake_blfdmp.demonstration.modelled_person import hold_and_place
from drake_blfdmp.diagrams.finite_guard import FiniteGuard
from drake_blfdmp.diagrams.hold_and_place import MakeHoldAndPlace, SetInitialState
from drake_blfdmp.diagrams.non_finite import by_data_flow, set_state, state_of
from drake_blfdmp.diagrams.skill import AddSkill
from drake_blfdmp.errors import NonFiniteError, SimulationError
from drake_blfdmp.skill.bands import make_bands
from drake_blfdmp.skill.learning import learn_skill
from drake_blfdmp.skill.profiles import HandDistance

DT = 0.004
SKILL = learn_skill(*hold_and_place(), basis_functions=12)
BANDS = make_bands(0.22, 0.28, HandDistance(0.37, 0.28, 0.3, 3.0, 0.6)).opened_to(SKILL.start)


def stop(diagram, end=1.0, prepare=lambda context: None):
    """The error that the guard stops a simulation with."""
    simulator = Simulator(diagram)
    prepare(simulator.get_mutable_context())
    guard = FiniteGuard(simulator)
    simulator.Initialize()
    with pytest.raises(NonFiniteError) as caught:
        guard.AdvanceTo(end)
    assert "\n" not in str(caught.value)
    return caught.value


def check(error, system, port, time=0.1, within=DT):
    assert (error.system, error.port) == (system, port)
    assert error.time == pytest.approx(time, abs=within + 1e-9)
    for word in (f"'{system}'", f"'{port}'", f"{error.time:.6g} s"):
        assert word in str(error)


def all_finite(states):
    return all(
        np.isfinite(vector).all()
        for entry in states.values()
        for vector in [*entry.get("discrete", []), *entry.get("continuous", [[]])]
    )


@pytest.mark.parametrize(("law", "time_step"), [("default", DT), ("published", DT), ("none", 0.0), ("default", 0.0)])
def test_a_forcing_that_breaks_is_named_though_all_others_break_with_it(law, time_step):
    builder = DiagramBuilder()
    AddSkill(builder, BreakingSkill.of(SKILL), BANDS, law=law, time_step=time_step)
    error = stop(builder.Build())
    check(error, "forcing", "forcing", within=DT if time_step else 0.1)
    assert set(error.states) == {"canonical", "transformation"} | (
        {"point_coupler"} if law == "published" and time_step else set()
    )


@pytest.mark.parametrize("time_step", [DT, 0.0])
def test_what_is_put_into_the_skill_is_named_and_not_who_passes_it_on(time_step):
    builder = DiagramBuilder()
    systems = AddSkill(builder, SKILL, BANDS, time_step=time_step)
    source = builder.AddNamedSystem("camera", Breaking(3, value=0.35))
    builder.Connect(source.get_output_port(), systems.coupler.GetInputPort("measured_distance"))
    check(stop(builder.Build()), "camera", "value", within=DT if time_step else 0.1)


@pytest.mark.parametrize(("system", "port", "size"), [("canonical", "tempo", 1), ("coupler", "measured_distance", 3)])
def test_a_fixed_input_is_named(system, port, size):
    builder = DiagramBuilder()
    systems = AddSkill(builder, SKILL, BANDS, time_step=DT)

    def fix(context):
        target = getattr(systems, system)
        target.GetInputPort(port).FixValue(target.GetMyMutableContextFromRoot(context), np.full(size, np.nan))

    error = stop(builder.Build(), prepare=fix)
    check(error, system, port, time=0.0)
    assert str(error).startswith("input port")


def pendulum(builder, desired):
    """One arm of a plant under joint PD that follows a source."""
    plant, _ = AddMultibodyPlant(
        MultibodyPlantConfig(time_step=0.002, discrete_contact_approximation="lagged"), builder
    )
    instance = plant.AddModelInstance("arm")
    body = plant.AddRigidBody("rod", instance, SpatialInertia.SolidBoxWithMass(1.0, 0.1, 0.1, 0.5))
    joint = plant.AddJoint(RevoluteJoint("hinge", plant.world_frame(), body.body_frame(), [1.0, 0.0, 0.0]))
    actuator = plant.AddJointActuator("motor", joint)
    plant.Finalize()
    actuator.set_controller_gains(PdControllerGains(p=100.0, d=10.0))
    builder.Connect(desired.get_output_port(), plant.get_desired_state_input_port(instance))
    return plant


def test_a_plants_desired_state_that_breaks_is_named():
    builder = DiagramBuilder()
    pendulum(builder, builder.AddNamedSystem("wish", Breaking(2)))
    error = stop(builder.Build())
    check(error, "wish", "value", within=0.002)
    assert set(error.states) == {"plant"}
    assert all_finite(error.states)


def test_a_state_that_grows_past_all_numbers_is_its_own_origin():
    builder = DiagramBuilder()
    growing = builder.AddNamedSystem("growing", Growing())
    hold = builder.AddNamedSystem("hold", ZeroOrderHold(0.01, 1))
    builder.Connect(growing.get_output_port(), hold.get_input_port())
    error = stop(builder.Build())
    check(error, "growing", "state", time=0.08, within=1e-9)  # 10^512 is none.
    assert error.states["growing"]["discrete"][0] == pytest.approx([1e256])
    assert "inf in 1 of 1" in str(error)


def test_a_system_inside_a_diagram_is_named_with_its_diagram():
    inner = DiagramBuilder()
    source = inner.AddNamedSystem("source", Breaking(1))
    inner.ExportOutput(source.get_output_port(), "out")
    box = inner.Build()
    box.set_name("box")
    builder = DiagramBuilder()
    builder.AddSystem(box)
    integrator = builder.AddNamedSystem("integrator", Integrator(1))
    builder.Connect(box.get_output_port(), integrator.get_input_port())
    check(stop(builder.Build()), "box::source", "value", within=0.1)


def test_what_reaches_no_state_does_not_stop_the_run():
    builder = DiagramBuilder()
    builder.AddNamedSystem("unheard", Breaking(1))
    builder.AddNamedSystem("clock", ZeroOrderHold(0.01, 1))
    builder.ExportInput(builder.GetSubsystemByName("clock").get_input_port())
    diagram = builder.Build()
    simulator = Simulator(diagram)
    diagram.get_input_port().FixValue(simulator.get_mutable_context(), [1.0])
    FiniteGuard(simulator).AdvanceTo(0.3)
    assert simulator.get_context().get_time() == pytest.approx(0.3)


class Distance(LeafSystem):
    """A distance that is infinite as long as nothing is near, and becomes what it is told to at 0.1 s."""

    def __init__(self, then):
        super().__init__()
        self._then = then
        self.DeclareStateOutputPort("distance", self.DeclareDiscreteState([np.inf]))
        self.DeclarePeriodicDiscreteUpdateEvent(0.01, 0.0, self._update)

    def _update(self, context, discrete_state):
        late = context.get_time() > 0.1 - 1e-9
        discrete_state.get_mutable_vector().SetFromVector([self._then if late else np.inf])


def test_what_starts_infinite_may_be_infinite_but_nothing_else():
    def diagram(then):
        builder = DiagramBuilder()
        builder.AddNamedSystem("distance", Distance(then))
        return builder.Build()

    for then in (np.inf, 0.2):
        simulator = Simulator(diagram(then))
        FiniteGuard(simulator).AdvanceTo(0.3)
    for then in (np.nan, -np.inf):
        check(stop(diagram(then)), "distance", "distance", within=0.01)


class Raising(LeafSystem):
    def __init__(self, error):
        super().__init__()
        self._error = error
        self.DeclarePeriodicPublishEvent(0.1, 0.1, self._publish)

    def _publish(self, context):
        raise self._error


def test_what_drake_gives_up_on_without_such_a_number_is_one_line_too():
    builder = DiagramBuilder()
    builder.AddNamedSystem("raising", Raising(RuntimeError("the solver\n  failed to converge")))
    guard = FiniteGuard(Simulator(builder.Build()))
    with pytest.raises(SimulationError, match=r"at t = 0.1 s: the solver failed to converge; try"):
        guard.AdvanceTo(1.0)


def test_an_error_with_a_name_keeps_it():
    builder = DiagramBuilder()
    builder.AddNamedSystem("raising", Raising(ZeroDivisionError("a mistake of ours")))
    guard = FiniteGuard(Simulator(builder.Build()))
    with pytest.raises(ZeroDivisionError, match="a mistake of ours"):
        guard.AdvanceTo(1.0)


def test_a_state_that_starts_as_no_number_is_refused():
    builder = DiagramBuilder()
    integrator = builder.AddNamedSystem("integrator", Integrator([math.nan]))
    builder.Connect(builder.AddSystem(ConstantVectorSource([0.0])).get_output_port(), integrator.get_input_port())
    with pytest.raises(NonFiniteError, match="starts from a state that is not a number"):
        FiniteGuard(Simulator(builder.Build())).AdvanceTo(0.1)


def test_systems_come_after_those_they_listen_to():
    builder = DiagramBuilder()
    last = builder.AddNamedSystem("last", Saturation(min_value=[-1.0], max_value=[1.0]))
    first = builder.AddNamedSystem("first", ConstantVectorSource([1.0]))
    loop = builder.AddNamedSystem("loop", Integrator(1))
    adder = builder.AddNamedSystem("adder", Adder(2, 1))
    builder.Connect(adder.get_output_port(), last.get_input_port())
    builder.Connect(first.get_output_port(), adder.get_input_port(0))
    builder.Connect(loop.get_output_port(), adder.get_input_port(1))
    builder.Connect(adder.get_output_port(), loop.get_input_port())
    order = [system.get_name() for system in by_data_flow(builder.Build())]
    assert sorted(order) == ["adder", "first", "last", "loop"]
    assert order.index("first") < order.index("adder") < order.index("last")


def test_the_state_goes_out_and_in_again(default_plan):
    diagram, parts = MakeHoldAndPlace(default_plan)
    context = diagram.CreateDefaultContext()
    SetInitialState(parts, diagram, context)
    state = state_of(context)
    other = diagram.CreateDefaultContext()
    set_state(other, state)
    np.testing.assert_array_equal(state_of(other), state)
    assert state.size == sum(context.get_discrete_state(i).size() for i in range(context.num_discrete_state_groups()))


# The whole diagram.


@pytest.fixture(scope="module")
def whole(default_plan):
    return MakeHoldAndPlace(default_plan)


def from_rest(whole, change):
    diagram, parts = whole

    def prepare(context):
        SetInitialState(parts, diagram, context)
        change(parts, context)

    return prepare


def test_the_guard_lets_the_whole_diagram_run(whole):
    diagram, parts = whole
    simulator = Simulator(diagram)
    SetInitialState(parts, diagram, simulator.get_mutable_context())
    FiniteGuard(simulator).AdvanceTo(0.1)
    plain = Simulator(diagram)
    SetInitialState(parts, diagram, plain.get_mutable_context())
    plain.AdvanceTo(0.1)
    np.testing.assert_array_equal(state_of(simulator.get_context()), state_of(plain.get_context()))


def test_the_forcing_of_the_whole_diagram(default_plan):
    task = replace(default_plan.task, skill=BreakingSkill.of(default_plan.task.skill))
    whole = MakeHoldAndPlace(replace(default_plan, task=task))
    error = stop(whole[0], prepare=from_rest(whole, lambda parts, context: None))
    check(error, "forcing", "forcing")
    assert set(error.states) >= {"plant", "canonical", "transformation", "ik"}
    assert len(error.states["plant"]["discrete"][0]) == whole[1].plant.num_multibody_states()
    del error.states["ik"]  # The clearance is infinite as long as nobody looks.
    assert all_finite(error.states)


@pytest.mark.parametrize("port", ["left_arm_actuation", "applied_generalized_force"])
def test_a_torque_that_is_no_number_is_named_whatever_the_contact_solver_makes_of_it(whole, port):
    def push(parts, context):
        target = parts.plant.GetInputPort(port)
        target.FixValue(parts.plant.GetMyMutableContextFromRoot(context), np.full(target.size(), np.nan))

    check(stop(whole[0], prepare=from_rest(whole, push)), "plant", port, time=0.0)


def test_measured_joints_that_are_no_numbers_are_named_when_they_are_read(whole):
    """The arms wait at first; the differential inverse kinematics then refuses them in words of its own."""

    def measure(parts, context):
        ik = parts.ik
        ik.GetInputPort("measured_position").FixValue(ik.GetMyMutableContextFromRoot(context), np.full(14, np.inf))

    error = stop(whole[0], prepare=from_rest(whole, measure))
    check(error, "ik", "measured_position", time=whole[1].plan.settle_s, within=2 * DT)


class Interrupted(LeafSystem):
    """A signal comes while bindings convert arguments."""

    def __init__(self):
        super().__init__()
        self.DeclarePeriodicPublishEvent(0.1, 0.1, self._publish)

    def _publish(self, context):
        interruption._received.append(15)
        raise TypeError("incompatible function arguments")


def test_an_interruption_that_comes_as_another_error_is_one_again(monkeypatch):
    monkeypatch.setattr(interruption, "_received", [])
    simulator = Simulator(Interrupted())
    guard = FiniteGuard(simulator)
    simulator.Initialize()
    with pytest.raises(interruption.Terminated):
        guard.AdvanceTo(1.0)
