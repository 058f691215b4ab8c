"""Differential inverse kinematics as a system: ports, the update against the tracker, measured positions, refusals."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from scipy.spatial.transform import Rotation

from drake_blfdmp.errors import ScenarioError, TaskError
from drake_blfdmp.robot.differential_ik import DEFAULT_GAINS, IkGains
from drake_blfdmp.robot.kinematics import DualArmKinematics
from drake_blfdmp.robot.plant import ARMS, HOME, MakeKinematicPlant, ReadJointLimits
from drake_blfdmp.robot.swivel import wrap
from drake_blfdmp.robot.tracking import DualArmTracker
from drake_blfdmp.systems.swivel_differential_ik import SwivelDifferentialIk

PLANT = MakeKinematicPlant()
LIMITS = ReadJointLimits(PLANT, [PLANT.GetModelInstanceByName(arm) for arm in ARMS])
KINEMATICS = DualArmKinematics(PLANT)
START = np.tile(HOME, 2) + np.array([0.1, 0, -0.2, 0, 0.15, 0, 0, -0.1, 0, 0.2, 0, -0.15, 0, 0])
DT = 0.01
OUTPUTS = {
    "position": 14,
    "velocity": 14,
    "desired_state_left": 14,
    "desired_state_right": 14,
    "task_scale": 2,
    "swivel_now": 2,
    "task_deviation": 2,
    "tempo": 1,
    "clearance": 1,
    "commanded_palms": 6,
}


def goal(shift=(0.03, 0.02, -0.04), twist=0.1, swing=0.2):
    """Palm poses (2, 7), twists (2, 6), swivel angles and rates (2,) a little away from START."""
    states = KINEMATICS.evaluate(START)
    pose = np.array([[*np.roll(Rotation.from_matrix(s.rotation).as_quat(), 1), *s.position] for s in states])
    pose[:, 4:] += shift
    swivel = np.array([s.swivel for s in states]) + swing
    return pose, np.full((2, 6), twist) * np.array([[1.0], [-0.5]]), swivel, np.array([0.1, -0.05])


def make(**changes):
    arguments = {"kinematics": KINEMATICS, "limits": LIMITS, "initial_position": START, "time_step": DT} | changes
    return SwivelDifferentialIk(**arguments)


def fix(system, context, values):
    for name, value in zip(("palm_poses", "palm_twists", "swivel", "swivel_rate"), values, strict=True):
        system.GetInputPort(name).FixValue(context, np.ravel(value))


def outputs(system, context):
    return {name: system.GetOutputPort(name).Eval(context).copy() for name in OUTPUTS}


def update(system, context):
    context.SetDiscreteState(system.EvalUniquePeriodicDiscreteUpdate(context))


@pytest.fixture
def system():
    return make()


def test_ports_have_their_names_and_sizes_and_no_output_needs_an_input(system):
    inputs = [system.get_input_port(i) for i in range(system.num_input_ports())]
    assert [(port.get_name(), port.size()) for port in inputs] == [
        ("palm_poses", 14),
        ("palm_twists", 12),
        ("swivel", 2),
        ("swivel_rate", 2),
        ("measured_position", 14),
    ]
    ports = [system.get_output_port(i) for i in range(system.num_output_ports())]
    assert {port.get_name(): port.size() for port in ports} == OUTPUTS
    assert not system.HasAnyDirectFeedthrough()


def test_it_starts_at_rest_at_the_initial_position(system):
    values = outputs(system, system.CreateDefaultContext())
    np.testing.assert_array_equal(values["position"], START)
    np.testing.assert_array_equal(values["velocity"], 0.0)
    np.testing.assert_array_equal(values["task_scale"], 1.0)
    np.testing.assert_array_equal(values["task_deviation"], 0.0)
    assert values["tempo"] == 1.0
    assert values["clearance"] == np.inf
    np.testing.assert_allclose(values["swivel_now"], [s.swivel for s in KINEMATICS.evaluate(START)])


def test_it_says_where_its_angles_have_the_palms_to_second_order_in_the_step():
    errors = {}
    for dt in (DT, DT / 2):
        system = make(time_step=dt)
        context = system.CreateDefaultContext()
        fix(system, context, goal())
        errors[dt] = 0.0
        for _ in range(round(0.2 / dt)):
            values = outputs(system, context)
            want = np.concatenate([state.position for state in KINEMATICS.evaluate(values["position"])])
            errors[dt] = max(errors[dt], np.abs(values["commanded_palms"] - want).max())
            update(system, context)
        assert np.linalg.norm(values["commanded_palms"][:3] - KINEMATICS.evaluate(START)[0].position) > 0.01
    assert errors[DT] < 5e-5
    assert errors[DT / 2] < 0.35 * errors[DT]


def test_the_update_is_one_step_of_the_tracker(system):
    context, values = system.CreateDefaultContext(), goal()
    fix(system, context, values)
    tracker, q, q_dot = DualArmTracker(KINEMATICS, LIMITS), START, np.zeros(14)
    for _ in range(5):
        update(system, context)
        q_dot, scale, now, *rest = tracker.velocity(q, *values, q_dot, DT)
        q = q + DT * q_dot
        got = outputs(system, context)
        np.testing.assert_allclose(got["position"], q, atol=1e-13)
        np.testing.assert_allclose(got["velocity"], q_dot, atol=1e-13)
        np.testing.assert_array_equal(got["task_scale"], scale)
        np.testing.assert_allclose(got["swivel_now"], now)
        np.testing.assert_array_equal(got["task_deviation"], rest[0])
    assert np.abs(q - START).max() > 0.01


def test_desired_states_are_positions_then_velocities_of_one_arm(system):
    context = system.CreateDefaultContext()
    fix(system, context, goal())
    update(system, context)
    got = outputs(system, context)
    for name, joints in (("left", slice(0, 7)), ("right", slice(7, 14))):
        state = got[f"desired_state_{name}"]
        np.testing.assert_array_equal(state[:7], got["position"][joints])
        np.testing.assert_array_equal(state[7:], got["velocity"][joints])
    assert np.abs(got["velocity"]).min() > 0  # so that a mix-up of the halves would show


def test_a_simulator_updates_it_at_its_period_and_brings_the_palms_home(system):
    simulator = Simulator(system)
    context = simulator.get_mutable_context()
    pose, twist, swivel, rate = goal(twist=0.0)
    fix(system, context, (pose, twist, swivel, 0 * rate))
    by_hand = system.CreateDefaultContext()
    fix(system, by_hand, (pose, twist, swivel, 0 * rate))
    # Updates at 0, DT, 2 DT; what happens at the final time is done by the next AdvanceTo.
    simulator.AdvanceTo(2.5 * DT)
    for _ in range(3):
        update(system, by_hand)
    np.testing.assert_array_equal(outputs(system, context)["position"], outputs(system, by_hand)["position"])
    simulator.AdvanceTo(3.0)
    for arm, state in enumerate(KINEMATICS.evaluate(outputs(system, context)["position"])):
        np.testing.assert_allclose(state.position, pose[arm, 4:], atol=1e-5)
        assert wrap(state.swivel - swivel[arm]) == pytest.approx(0.0, abs=2e-3)


def test_two_contexts_share_nothing(system):
    """The system keeps one plant context for its kinematics; it must hold no state of the loop."""
    goals = goal(), goal((-0.05, 0.0, 0.05), -0.2, -0.3)
    alone = []
    for values in goals:
        context = system.CreateDefaultContext()
        fix(system, context, values)
        for _ in range(4):
            update(system, context)
        alone.append(outputs(system, context)["position"])
    contexts = [system.CreateDefaultContext() for _ in goals]
    for context, values in zip(contexts, goals, strict=True):
        fix(system, context, values)
    for _ in range(4):
        for context in contexts:
            update(system, context)
    for context, wanted in zip(contexts, alone, strict=True):
        np.testing.assert_array_equal(outputs(system, context)["position"], wanted)
    assert np.abs(alone[0] - alone[1]).max() > 0.01


def test_a_measured_position_is_where_the_kinematics_are_but_the_command_goes_on_from_itself(system):
    context, values = system.CreateDefaultContext(), goal()
    fix(system, context, values)
    measured = START + 0.03
    system.GetInputPort("measured_position").FixValue(context, measured)
    update(system, context)
    tracker = DualArmTracker(KINEMATICS, LIMITS)
    q_dot, _, now, *_ = tracker.velocity(measured, *values, np.zeros(14), DT)
    got = outputs(system, context)
    np.testing.assert_allclose(got["velocity"], q_dot, atol=1e-13)
    np.testing.assert_allclose(got["position"], START + DT * q_dot, atol=1e-13)
    np.testing.assert_allclose(got["swivel_now"], now)
    assert np.abs(q_dot - tracker.velocity(START, *values, np.zeros(14), DT)[0]).max() > 1e-3


def test_a_blocked_arm_does_not_wind_the_command_past_its_limits(system):
    context = system.CreateDefaultContext()
    fix(system, context, goal((0.0, 0.2, 0.2), 0.0))
    system.GetInputPort("measured_position").FixValue(context, START)
    inner = LIMITS.lower + DEFAULT_GAINS.limit_margin, LIMITS.upper - DEFAULT_GAINS.limit_margin
    before = np.zeros(14)
    for _ in range(600):
        update(system, context)
        got = outputs(system, context)
        assert np.all((got["position"] >= inner[0] - 1e-9) & (got["position"] <= inner[1] + 1e-9))
        assert np.all(np.abs(got["velocity"] - before) <= DT * 0.9 * LIMITS.acceleration + 1e-9)
        before = got["velocity"]
    margin = np.minimum(got["position"] - inner[0], inner[1] - got["position"])
    assert margin.min() < 1e-3  # It was blocked for long enough.


def test_the_share_that_limits_let_through_is_reported(system):
    context = system.CreateDefaultContext()
    pose, twist, swivel, rate = goal()
    pose[0, 4:] -= (0.03, 0.02, -0.04)  # The left palm is where it should be.
    pose[1, 4:] += [0.0, 1.5, 0.5]  # Far beyond what the right arm can do in one step.
    fix(system, context, (pose, 0.1 * twist, swivel, rate))
    update(system, context)
    got = outputs(system, context)
    left, right = got["task_scale"]
    assert left == 1.0
    assert right < 0.9
    assert got["tempo"] == pytest.approx(1.0 - (1.0 - right) * (1.0 - np.exp(-DT / DEFAULT_GAINS.tempo_fall)))


@pytest.mark.parametrize("time_step", [0.0, -0.01, 0.06, float("nan")])
def test_a_time_step_that_cannot_work_is_refused(time_step):
    with pytest.raises(ScenarioError, match=r"time_step.*at most 0\.05 s, or lower its largest gain, 20") as error:
        make(time_step=time_step)
    assert "\n" not in str(error.value)
    make(time_step=0.06, gains=IkGains(pose=15.0))


@pytest.mark.parametrize("initial_position", [START[:7], np.full(14, np.nan), np.zeros((2, 7))])
def test_an_initial_position_that_is_none_is_refused(initial_position):
    with pytest.raises(TaskError, match="14 finite joint angles"):
        make(initial_position=initial_position)


@pytest.mark.parametrize("port", ["palm_poses", "palm_twists", "swivel", "swivel_rate", "measured_position"])
@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_an_input_that_is_no_number_is_refused_by_name_in_a_running_simulation(port, bad):
    builder = DiagramBuilder()
    system = builder.AddNamedSystem("both_arms", make())
    diagram = builder.Build()
    simulator = Simulator(diagram)
    context = system.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    fix(system, context, goal())
    simulator.AdvanceTo(1.5 * DT)
    value = np.zeros(system.GetInputPort(port).size())
    value[-1] = bad
    system.GetInputPort(port).FixValue(context, value)
    with pytest.raises(TaskError, match=rf"input port '{port}' of system '.*both_arms' is not finite at t = 0\.02 s"):
        simulator.AdvanceTo(3.5 * DT)


@pytest.mark.parametrize("clearance", [0.0, -0.01, float("nan"), float("inf")])
def test_a_clearance_that_is_none_is_refused(clearance):
    with pytest.raises(ScenarioError, match=r"clearance .* must be > 0 m, or None"):
        make(clearance=clearance)


def test_the_arms_wait_until_told(kinematics=KINEMATICS):
    system = SwivelDifferentialIk(
        kinematics=kinematics, limits=LIMITS, initial_position=START, time_step=DT, hold_until=3.0 * DT
    )
    context, values = system.CreateDefaultContext(), goal()
    fix(system, context, values)
    for k in range(6):
        context.SetTime(k * DT)
        update(system, context)
        moved = np.abs(outputs(system, context)["position"] - START).max()
        assert (moved > 0.0) == (k >= 3)


def test_a_jump_of_the_persons_swivel_angle_is_no_jump_of_the_null_motion(system):
    context, values = system.CreateDefaultContext(), list(goal())
    tracker = DualArmTracker(KINEMATICS, LIMITS)
    fix(system, context, values)
    for _ in range(100):
        update(system, context)
    before = outputs(system, context)["velocity"]
    values[2] = values[2] + 1.0
    fix(system, context, values)
    q = outputs(system, context)["position"]
    update(system, context)
    after = outputs(system, context)["velocity"]
    free = tracker.velocity(q, *values)[0]
    assert np.abs(after - before).max() < 0.2 * np.abs(free - before).max()


@pytest.mark.parametrize("mirrored", [True, False])
@pytest.mark.parametrize("redundancy", ["swivel", "none", "published"])
def test_what_fills_the_null_space_is_the_trackers(redundancy, mirrored):
    system = make(redundancy=redundancy, mirrored=mirrored)
    context, values = system.CreateDefaultContext(), goal()
    fix(system, context, values)
    update(system, context)
    tracker = DualArmTracker(KINEMATICS, LIMITS, redundancy=redundancy, mirrored=mirrored)
    q_dot, _, now, *_ = tracker.velocity(START, *values, np.zeros(14), DT)
    got = outputs(system, context)
    np.testing.assert_allclose(got["velocity"], q_dot, atol=1e-13)
    np.testing.assert_allclose(got["swivel_now"], now)


def test_what_fills_the_null_space_matters_and_is_the_swivel_by_default():
    velocities = {}
    for redundancy in (None, "swivel", "none", "published"):
        system = make() if redundancy is None else make(redundancy=redundancy)
        context = system.CreateDefaultContext()
        pose, twist, swivel, rate = goal((0.0, 0.0, 0.0), 0.02, 0.0)
        # The elbows are where they should be: the swivel asks for little, (18) for the same as ever.
        fix(system, context, (pose, twist, swivel, 0.0 * rate))
        update(system, context)
        velocities[redundancy] = outputs(system, context)["velocity"]
    np.testing.assert_array_equal(velocities[None], velocities["swivel"])
    for other in ("none", "published"):
        assert np.abs(velocities[other] - velocities["swivel"]).max() > 1e-3
    assert np.abs(velocities["published"] - velocities["none"]).max() > 1e-3


def test_an_unknown_filling_of_the_null_space_is_refused():
    with pytest.raises(ScenarioError, match="redundancy 'both' is none; choose one of swivel, none, published"):
        make(redundancy="both")
