import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource

from drake_blfdmp.errors import ScenarioError
from drake_blfdmp.skill.canonical import phase_at
from drake_blfdmp.systems.canonical_system import CanonicalSystem
from drake_blfdmp.systems.live_goal import LiveGoal
from drake_blfdmp.vectors import towards

STEP, RATE, SCALE, TAU, WINDOW = 0.01, 0.1, 0.8, 5.0, (1.0, 3.0)
PLANNED = np.linspace(-0.7, 1.3, 18)


def make(**changes):
    given = {"scale": SCALE, "window": WINDOW, "rate": RATE, "tau": TAU, "time_step": STEP}
    return LiveGoal(**{**given, **changes})


def running():
    """A simulator of a goal with the phase it goes by, and the goal."""
    builder = DiagramBuilder()
    phase = builder.AddSystem(CanonicalSystem(tau=TAU, time_step=STEP))
    goal = builder.AddSystem(make())
    planned = builder.AddSystem(ConstantVectorSource(PLANNED))
    builder.Connect(phase.get_output_port(), goal.GetInputPort("phase"))
    builder.Connect(planned.get_output_port(), goal.GetInputPort("planned_goal"))
    return Simulator(builder.Build()), goal


def want(simulator, goal, offset):
    context = goal.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    goal.GetInputPort("wanted_offset").FixValue(context, offset)


def found(simulator, goal, port):
    return np.array(goal.GetOutputPort(port).Eval(goal.GetMyContextFromRoot(simulator.get_context())))


def test_untouched_it_is_the_planned_goal_to_the_last_bit():
    simulator, goal = running()
    simulator.AdvanceTo(4.0)
    assert found(simulator, goal, "goal").tobytes() == PLANNED.tobytes()
    want(simulator, goal, np.zeros(3))
    simulator.AdvanceTo(4.5)
    assert found(simulator, goal, "goal").tobytes() == PLANNED.tobytes()


def test_it_goes_straight_to_where_it_is_wanted_at_its_rate_and_all_points_alike():
    simulator, goal = running()
    wanted = np.array([0.12, -0.09, 0.0])  # 0.15 m away: 1.5 s.
    simulator.AdvanceTo(1.0 - 0.5 * STEP)
    want(simulator, goal, wanted)
    for share in (0.2, 0.5, 0.8):
        simulator.AdvanceTo(1.0 + 1.5 * share - 0.5 * STEP)
        np.testing.assert_allclose(found(simulator, goal, "offset"), share * wanted, atol=1.01 * RATE * STEP)
        moved = found(simulator, goal, "goal").reshape(6, 3) - PLANNED.reshape(6, 3)
        np.testing.assert_allclose(moved, np.tile(found(simulator, goal, "offset") / SCALE, (6, 1)), atol=1e-15)
    simulator.AdvanceTo(2.6)
    np.testing.assert_allclose(found(simulator, goal, "offset"), wanted, atol=1e-15)


def test_outside_of_its_window_it_stays_and_what_was_wanted_before_counts_from_then_on():
    simulator, goal = running()
    want(simulator, goal, [1.0, 0.0, 0.0])
    simulator.AdvanceTo(0.99)
    np.testing.assert_array_equal(found(simulator, goal, "offset"), 0.0)
    simulator.AdvanceTo(4.5)  # The window lasts for 2 s: 0.2 m of the metre.
    np.testing.assert_allclose(found(simulator, goal, "offset"), [0.2, 0.0, 0.0], atol=1.01 * RATE * STEP)
    want(simulator, goal, np.zeros(3))
    simulator.AdvanceTo(5.0)
    assert found(simulator, goal, "offset")[0] > 0.19


def test_the_window_goes_by_the_skills_clock_and_not_by_the_time():
    goal = make()
    context = goal.CreateDefaultContext()
    goal.GetInputPort("wanted_offset").FixValue(context, [1.0, 0.0, 0.0])
    goal.GetInputPort("planned_goal").FixValue(context, PLANNED)
    for clock, moves in ((0.9, False), (1.1, True), (2.9, True), (3.1, False)):
        context.SetTime(100.0)
        goal.GetInputPort("phase").FixValue(context, [phase_at(clock, TAU)])
        after = goal.EvalUniquePeriodicDiscreteUpdate(context).value(0)
        assert (np.linalg.norm(after) > 0) == moves, clock


@pytest.mark.parametrize("name", ["scale", "rate", "tau", "time_step"])
@pytest.mark.parametrize("value", [0.0, -1.0, np.inf, np.nan])
def test_what_is_out_of_range_is_refused(name, value):
    with pytest.raises(ScenarioError, match=f"live goal: {name} is out of range"):
        make(**{name: value})


VECTORS = arrays(float, 3, elements=st.floats(-10.0, 10.0))


@given(value=VECTORS, target=VECTORS, largest=st.floats(1e-6, 20.0))
def test_a_step_towards_is_never_too_long_and_ends_at_the_target(value, target, largest):
    after = towards(value, target, largest)
    before, left = np.linalg.norm(target - value), np.linalg.norm(target - after)
    assert np.linalg.norm(after - value) <= largest * (1 + 1e-9) + 1e-14
    assert left == pytest.approx(max(0.0, before - largest), abs=1e-12 + 1e-9 * before)
