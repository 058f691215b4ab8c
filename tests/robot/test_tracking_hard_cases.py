"""What the closed loop does when too much is asked: limits hold by construction, the path is kept, it comes back."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from drake_blfdmp.robot import tracking
from drake_blfdmp.robot.differential_ik import DEFAULT_GAINS
from drake_blfdmp.robot.kinematics import DualArmKinematics
from drake_blfdmp.robot.plant import ARMS, HOME, MakeKinematicPlant, ReadJointLimits
from drake_blfdmp.robot.swivel import wrap
from drake_blfdmp.robot.tracking import DualArmTracker, bent_limits, pose_error, rotation_matrix

PLANT = MakeKinematicPlant()
LIMITS = ReadJointLimits(PLANT, [PLANT.GetModelInstanceByName(arm) for arm in ARMS])
KINEMATICS = DualArmKinematics(PLANT)
START = np.tile(HOME, 2) + np.array([0.1, 0, -0.2, 0, 0.15, 0, 0, -0.1, 0, 0.2, 0, -0.15, 0, 0])
STILL, REST = np.zeros((2, 6)), np.zeros(2)
DT = 0.004
INNER = DEFAULT_GAINS.limit_margin
WRIST = [5, 12]
seeds = st.integers(0, 2**32 - 1)


@dataclass
class Motion:
    """What became of a command: (N, ...) each."""

    q: np.ndarray
    velocity: np.ndarray
    scale: np.ndarray
    deviation: np.ndarray
    palms: np.ndarray
    error: np.ndarray
    swivel_error: np.ndarray


def poses(q):
    states = KINEMATICS.evaluate(q)
    pose = np.array([[*np.roll(Rotation.from_matrix(s.rotation).as_quat(), 1), *s.position] for s in states])
    return pose, np.array([s.swivel for s in states])


def turned(pose, rotation_vector):
    pose = pose.copy()
    for arm in range(2):
        rotation = Rotation.from_rotvec(rotation_vector).as_matrix() @ rotation_matrix(pose[arm, :4])
        pose[arm, :4] = np.roll(Rotation.from_matrix(rotation).as_quat(), 1)
    return pose


def run(command, seconds, q=START, tracker=None) -> Motion:
    """Follow command(t) -> pose, twist, swivel, rate from rest; limits are checked at every step."""
    tracker = tracker or DualArmTracker(KINEMATICS, LIMITS)
    v, rows = np.zeros(14), []
    for k in range(round(seconds / DT)):
        pose, twist, swivel, rate = command(k * DT)
        tracked = tracker.velocity(q, pose, twist, swivel, rate, v, DT)
        change = np.abs(tracked.velocity - v)
        assert np.all(change <= DEFAULT_GAINS.acceleration_share * LIMITS.acceleration * DT + 1e-12)
        v = tracked.velocity
        q = q + DT * v
        assert np.all(np.abs(v) <= DEFAULT_GAINS.velocity_share * LIMITS.velocity + 1e-12)
        assert np.all(np.minimum(q - LIMITS.lower, LIMITS.upper - q) >= INNER - 1e-9)
        states = KINEMATICS.evaluate(q)
        off = [np.abs(pose_error(state, pose[arm])).max() for arm, state in enumerate(states)]
        turn = [abs(wrap(swivel[arm] - state.swivel)) for arm, state in enumerate(states)]
        rows.append((q, v, tracked.scale, tracked.deviation, [s.position for s in states], off, turn))
    return Motion(*(np.array(column) for column in zip(*rows, strict=True)))


def assert_arrived(motion: Motion, swivel=2e-2):
    assert motion.error[-1].max() < 1e-4
    assert motion.swivel_error[-1].max() < swivel
    assert np.abs(motion.velocity[-1]).max() < 0.05
    np.testing.assert_allclose(motion.scale[-1], 1.0)


@given(seeds)
@settings(max_examples=25, deadline=None)
def test_whatever_is_asked_for_position_velocity_and_acceleration_stay_within_their_limits(seed):
    """`run` asserts it at every step; the commands jump between near, far, absurd and back."""
    rng = np.random.default_rng(seed)
    start = rng.uniform(LIMITS.lower + INNER, bent_limits(LIMITS, KINEMATICS.straight_elbow).upper - INNER)
    pose, _ = poses(start)
    chosen = []
    for _ in range(6):
        goal = turned(pose, rng.normal(size=3))
        size = 10.0 ** rng.uniform(-2, 6)
        goal[:, 4:] += rng.choice([0.0, 0.1, 1.0, size]) * rng.normal(size=(2, 3))
        chosen.append((goal, size * rng.normal(size=(2, 6)), rng.uniform(-9, 9, 2), size * rng.normal(size=2)))
    motion = run(lambda t: chosen[int(t / (10 * DT)) % 6], 60 * DT, start)
    assert np.all(np.isfinite(motion.q))
    assert np.all((motion.scale >= 0) & (motion.scale <= 1))


@pytest.mark.parametrize("shift", [(0.0, 0.1, -0.28), (0.1, 0.25, -0.1), (-0.25, 0.1, 0.1)])
def test_a_jump_of_the_pose_is_a_straight_way_without_overshoot(shift):
    shift = np.array(shift)
    pose, swivel = poses(START)
    goal = pose.copy()
    goal[:, 4:] += shift
    motion = run(lambda t: (goal, STILL, swivel, REST), 2.0)
    assert motion.error[-1].max() < 1e-4
    distance = np.linalg.norm(shift)
    along = (motion.palms - pose[:, 4:]) @ shift / distance
    across = np.linalg.norm(motion.palms - pose[:, 4:] - along[..., None] * shift / distance, axis=-1)
    assert along.max() < distance + 2e-4
    assert across.max() < 2e-3
    assert motion.scale.min() < 0.1  # The limits did bite.
    assert motion.deviation.max() < 1e-3


def test_without_braking_in_time_the_loop_overshoots(monkeypatch):
    """Why the corrections are `_brakeable`: a bounded acceleration under a linear gain of 20 1/s overshoots."""
    monkeypatch.setattr(tracking, "CORRECTION_SHARE", 1e9)
    pose, swivel = poses(START)
    goal = pose.copy()
    goal[:, 4:] += (0.0, 0.1, -0.28)
    motion = run(lambda t: (goal, STILL, swivel, REST), 1.5)
    along = (motion.palms - pose[:, 4:]) @ np.array([0.0, 0.1, -0.28]) / np.hypot(0.1, 0.28)
    assert along.max() > np.hypot(0.1, 0.28) + 0.01


def test_an_arm_that_is_asked_to_reach_beyond_its_length_stretches_and_comes_back():
    """The goal moves out to 0.6 m beyond, with its twist, and back, in 4 s."""
    pose, swivel = poses(START)

    def command(t):
        goal, twist, u = pose.copy(), STILL.copy(), min(t, 4.0) * np.pi / 2.0
        goal[:, 5] += 0.3 * (1.0 - np.cos(u))
        twist[:, 4] = 0.3 * np.pi / 2.0 * np.sin(u)
        return goal, twist, swivel, REST

    motion = run(command, 6.0)
    assert motion.error[: round(4 / DT)].max() > 0.2
    straight = KINEMATICS.straight_elbow
    assert np.all(motion.q[:, [3, 10]] <= straight - INNER + 1e-9)
    assert np.abs(motion.q[:, [3, 10]] - straight + INNER).min() < 0.02  # It did stretch.
    assert_arrived(motion)
    # On the same side: the arms come home to the posture they left.
    np.testing.assert_allclose(motion.q[-1], START, atol=0.05)


@pytest.mark.parametrize("off", [0.8, -0.8])
def test_an_elbow_that_was_held_off_comes_back_calmly(off):
    """No faster than `swivel_return`, whatever the swivel's own rate may be, and all the way."""
    pose, swivel = poses(START)
    motion = run(lambda t: (pose, STILL, swivel + off * np.array([1.0, -1.0]), REST), 5.0)
    gains = DEFAULT_GAINS
    found = np.array([[state.swivel for state in KINEMATICS.evaluate(q)] for q in motion.q])
    rates = np.abs(wrap(np.diff(found, axis=0))) / DT
    assert 0.9 * gains.swivel_return < rates.max() < 1.02 * gains.swivel_return < gains.swivel_rate
    np.testing.assert_allclose(wrap(found[-1] - swivel - off * np.array([1.0, -1.0])), 0.0, atol=0.02)


@pytest.mark.parametrize("way", [(0.0, 2.0, 0.0), (0.0, 1.4, 1.4)])
def test_a_goal_two_metres_away_and_back(way):
    pose, swivel = poses(START)
    far = pose.copy()
    far[:, 4:] += way
    motion = run(lambda t: (far if t < 3.0 else pose, STILL, swivel, REST), 6.5)
    half = round(3.0 / DT)
    assert motion.error[half - 1].min() > 0.5
    # Stretched, and still: no elbow that swings to gain a little (`calm_scale`).
    assert np.abs(motion.velocity[half - 50 : half]).max() < 0.1
    assert_arrived(motion)


@pytest.mark.parametrize("axis", [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)])
def test_the_wrists_axes_in_line(axis):
    """Joint 6 at pi: axes 5 and 7 are parallel. From there the palms turn about each axis, and back."""
    q = START.copy()
    q[WRIST] = np.pi
    pose, swivel = poses(q)
    goal = turned(pose, 0.25 * np.array(axis))
    motion = run(lambda t: (goal if t < 2.5 else pose, STILL, swivel, REST), 5.5, q)
    assert motion.error[round(2.5 / DT) - 1].max() < 1e-3
    assert_arrived(motion)


def test_through_the_wrists_axes_in_line_and_back():
    q = START.copy()
    q[WRIST] = np.pi - 0.4
    speed = 2.0 * np.pi / 4.0

    def command(t):
        now = q.copy()
        now[WRIST] += 0.35 * (1.0 - np.cos(speed * min(t, 4.0)))
        pose, swivel = poses(now)
        return pose, STILL, swivel, REST

    motion = run(command, 5.0, q)
    assert motion.error.max() < 0.04  # 0.55 rad/s without feed-forward, over a gain of 20 1/s.
    np.testing.assert_array_equal(motion.scale, 1.0)
    assert_arrived(motion)


@pytest.mark.parametrize("turns", [0, 1, -2])
def test_the_swivel_passes_pi_as_any_other_angle(turns):
    """START has it at -3.0 and 3.0 rad; it swings by 0.6 rad to either side, whole turns added."""
    pose, swivel = poses(START)
    assert np.abs(swivel).min() > 2.9
    side = np.array([1.0, -1.0])

    def command(t):
        asked = swivel - side * 0.6 * np.sin(t)
        return pose, STILL, asked + 2.0 * np.pi * turns, -side * 0.6 * np.cos(t)

    motion = run(command, 6.5)
    assert motion.swivel_error[250:].max() < 0.02
    assert motion.error.max() < 1e-4
    assert np.abs(motion.velocity).max() < 1.5


def test_a_swivel_half_a_turn_away_is_no_shaking():
    """The error's sign flips with every sample; the palms rest and the elbows choose a side or wait."""
    pose, swivel = poses(START)
    flip = np.pi + 1e-3 * np.array([1.0, -1.0])
    motion = run(lambda t: (pose, STILL, swivel + flip[round(t / DT) % 2], REST), 1.5)
    assert motion.error.max() < 1e-3
    assert np.abs(np.diff(motion.velocity, axis=0)).max() <= DEFAULT_GAINS.null_acceleration * DT + 1e-3


@pytest.mark.parametrize("swing", [(0.5, -0.5), (0.7, 0.2), (-0.15, -0.3)])
def test_after_convergence_the_robots_swivel_is_the_persons(swing):
    """0.02 rad, wherever the elbows can go; the null space does not move the palms."""
    pose, _ = poses(START)
    outward = np.array([1.0, -1.0])
    asked = wrap(np.pi - outward * np.array(swing))
    motion = run(lambda t: (pose, STILL, asked, REST), 4.0)
    assert motion.swivel_error[0].max() > 0.1
    assert motion.swivel_error[-1].max() < 0.02
    assert motion.error.max() < 1e-4
    for k in range(0, len(motion.q) - 1, 50):
        states, q_dot = KINEMATICS.evaluate(motion.q[k]), motion.velocity[k + 1].reshape(2, 7)
        for arm, state in enumerate(states):
            correction = DEFAULT_GAINS.pose * pose_error(state, pose[arm])
            np.testing.assert_allclose(state.jacobian @ q_dot[arm], correction, atol=1e-9)


def test_a_start_at_speed_and_beyond_a_limit_is_braked_not_jumped():
    """A last velocity that nothing allowed: the acceleration limit still holds."""
    q, v = START.copy(), np.full(14, 2.0)
    q[1] = LIMITS.upper[1] - 0.01
    pose, swivel = poses(START)
    tracker = DualArmTracker(KINEMATICS, LIMITS)
    for _ in range(10):
        got = tracker.velocity(q, pose, STILL, swivel, REST, v, DT).velocity
        assert np.all(np.abs(got - v) <= 0.9 * LIMITS.acceleration * DT + 1e-12)
        q, v = q + DT * got, got
    assert v[1] == pytest.approx(2.0 - 10 * 0.9 * 7.5 * DT)


def test_the_limit_of_a_straight_arm_costs_less_than_a_millimetre_of_reach():
    q, context, lengths = np.tile(HOME, 2).astype(float), PLANT.CreateDefaultContext(), []
    left = PLANT.GetModelInstanceByName(ARMS[0])
    straight = KINEMATICS.straight_elbow[0]
    for angle in (straight - INNER, straight, LIMITS.upper[3]):
        q[3] = angle
        PLANT.SetPositions(context, q)
        shoulder, wrist = (
            np.asarray(PLANT.GetFrameByName(name, left).CalcPoseInWorld(context).translation())
            for name in ("shoulder", "wrist")
        )
        lengths.append(np.linalg.norm(wrist - shoulder))
    short, longest, beyond = lengths
    assert longest > beyond
    assert 0.0 < longest - short < 1e-3
    limits = bent_limits(LIMITS, KINEMATICS.straight_elbow)
    np.testing.assert_array_equal(np.nonzero(limits.upper != LIMITS.upper)[0], [3, 10])
    np.testing.assert_array_equal(bent_limits(limits, np.zeros(2)).upper, limits.upper)


def test_accelerations_are_not_limited_where_nobody_says_when_the_last_velocity_was():
    pose, swivel = poses(START)
    goal = pose.copy()
    goal[:, 5] += 0.05
    free = DualArmTracker(KINEMATICS, LIMITS).velocity(START, goal, STILL, swivel, REST)
    gains = replace(DEFAULT_GAINS, acceleration_share=np.inf, null_acceleration=np.inf)
    endless = DualArmTracker(KINEMATICS, LIMITS, gains).velocity(START, goal, STILL, swivel, REST, np.zeros(14), DT)
    np.testing.assert_allclose(endless.velocity, free.velocity, atol=1e-9)
    assert np.abs(free.velocity).max() > 10 * 0.9 * LIMITS.acceleration.max() * DT
