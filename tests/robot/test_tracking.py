"""The closed loop: pose errors, convergence of palms and elbows, limits; against Drake's own differential IK."""

from dataclasses import replace

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from pydrake.multibody.inverse_kinematics import (
    DifferentialInverseKinematicsParameters,
    DifferentialInverseKinematicsStatus,
    DoDifferentialInverseKinematics,
)
from scipy.spatial.transform import Rotation

from drake_blfdmp.robot.differential_ik import DEFAULT_GAINS
from drake_blfdmp.robot.kinematics import ArmState, DualArmKinematics
from drake_blfdmp.robot.plant import ARMS, HOME, MakeKinematicPlant, ReadJointLimits
from drake_blfdmp.robot.swivel import wrap
from drake_blfdmp.robot.tracking import DualArmTracker, pose_error, rotation_matrix

PLANT = MakeKinematicPlant()
INSTANCES = [PLANT.GetModelInstanceByName(arm) for arm in ARMS]
LIMITS = ReadJointLimits(PLANT, INSTANCES)
KINEMATICS = DualArmKinematics(PLANT)
START = np.tile(HOME, 2) + np.array([0.1, 0, -0.2, 0, 0.15, 0, 0, -0.1, 0, 0.2, 0, -0.15, 0, 0])
REST = np.zeros((2, 6)), np.zeros(2)
DT = 0.01
seeds = st.integers(0, 2**32 - 1)


def wxyz(rotation):
    return np.roll(Rotation.from_matrix(rotation).as_quat(), 1)


def poses(q):
    """Palm poses (2, 7) and swivel angles (2,) at q."""
    states = KINEMATICS.evaluate(q)
    return np.array([[*wxyz(s.rotation), *s.position] for s in states]), np.array([s.swivel for s in states])


def errors(q, pose, swivel):
    states = KINEMATICS.evaluate(q)
    palm = max(np.abs(pose_error(state, pose[arm])).max() for arm, state in enumerate(states))
    return palm, max(abs(wrap(swivel[arm] - state.swivel)) for arm, state in enumerate(states))


@given(seeds)
def test_quaternions_are_w_x_y_z(seed):
    rotation = Rotation.random(random_state=np.random.default_rng(seed))
    quaternion = np.roll(rotation.as_quat(), 1)
    for sign in (1.0, -1.0):
        np.testing.assert_allclose(rotation_matrix(sign * quaternion), rotation.as_matrix(), atol=1e-12)


@given(seeds, st.floats(0.0, 3.0))
def test_the_pose_error_points_from_the_palm_to_its_goal(seed, angle):
    rng = np.random.default_rng(seed)
    now, axis = Rotation.random(random_state=rng), rng.normal(size=3)
    axis /= np.linalg.norm(axis)
    desired, shift = Rotation.from_rotvec(angle * axis) * now, rng.normal(size=3)
    state = ArmState(now.as_matrix(), np.ones(3), np.zeros((6, 7)), 0.0, np.zeros(7))
    error = pose_error(state, np.concatenate([np.roll(desired.as_quat(), 1), 1.0 + shift]))
    np.testing.assert_allclose(error, np.concatenate([np.sin(angle) * axis, shift]), atol=1e-12)


def test_palms_and_elbows_converge_to_a_pose_at_rest():
    pose, swivel = poses(START)
    for arm in range(2):
        turn = Rotation.from_rotvec([0.2, -0.1, 0.15]).as_matrix()
        pose[arm, :4] = wxyz(turn @ rotation_matrix(pose[arm, :4]))
        pose[arm, 4:] += [0.04, -0.05, 0.06]
    swivel = swivel + np.array([0.25, -0.2])
    tracker, q = DualArmTracker(KINEMATICS, LIMITS), START
    before = errors(q, pose, swivel)
    assert before[0] > 0.05
    assert before[1] > 0.15
    history = []
    for _ in range(300):
        q_dot, scale, now, *_ = tracker.velocity(q, pose, REST[0], swivel, REST[1])
        np.testing.assert_allclose(now, poses(q)[1])
        q = q + DT * q_dot
        history.append(errors(q, pose, swivel))
    assert history[-1][0] < 1e-6
    assert history[-1][1] < 1e-3
    np.testing.assert_array_equal(scale, 1.0)
    # The swivel waits for nothing: it falls as exp(-swivel gain t), the palm as exp(-pose gain t).
    assert history[60][0] < 1e-3 * before[0] + 1e-6
    assert history[199][1] < 0.02 * before[1]


def test_a_moving_goal_with_its_twist_is_followed_without_lag():
    pose0, swivel0 = poses(START)
    tracker, q = DualArmTracker(KINEMATICS, LIMITS), START
    amplitude, rate, worst, still = np.array([0.03, 0.02, 0.04]), 2.0, 0.0, 0.0
    for k in range(300):
        t = k * DT
        pose, twist = pose0.copy(), np.zeros((2, 6))
        turn = Rotation.from_rotvec([0, 0, 0.1 * np.sin(rate * t)]).as_matrix()
        for arm in range(2):
            pose[arm, :4] = wxyz(turn @ rotation_matrix(pose0[arm, :4]))
        pose[:, 4:] += amplitude * np.sin(rate * t)
        twist[:, 2] = 0.1 * rate * np.cos(rate * t)
        twist[:, 3:] = amplitude * rate * np.cos(rate * t)
        swivel = swivel0 + 0.1 * np.sin(rate * t)
        if k > 50:
            palm, elbow = errors(q, pose, swivel)
            worst, still = max(worst, palm), max(still, elbow)
        q = q + DT * tracker.velocity(q, pose, twist, swivel, np.full(2, 0.1 * rate * np.cos(rate * t)))[0]
    # Without the feed-forward the lag would be speed / gain: 0.08 / 20 = 4 mm and 0.2 / 3 = 0.067 rad.
    assert worst < 5e-4
    assert still < 3e-3


def test_each_arm_follows_its_own_goal_only():
    pose, swivel = poses(START)
    pose[1, 4:] += 0.02
    q_dot, *_ = DualArmTracker(KINEMATICS, LIMITS).velocity(START, pose, REST[0], swivel, REST[1])
    np.testing.assert_allclose(q_dot[:7], 0.0, atol=1e-9)
    assert np.abs(q_dot[7:]).max() > 0.1


@given(seeds)
def test_whatever_is_asked_for_joints_stay_within_their_limits(seed):
    rng = np.random.default_rng(seed)
    inner = DEFAULT_GAINS.limit_margin
    q = rng.uniform(LIMITS.lower + inner, LIMITS.upper - inner)
    pose, swivel = poses(rng.uniform(LIMITS.lower, LIMITS.upper))
    tracker = DualArmTracker(KINEMATICS, LIMITS)
    for _ in range(5):
        q_dot, scale, *_ = tracker.velocity(q, pose, rng.normal(size=(2, 6)), swivel, rng.normal(size=2))
        assert np.all(np.abs(q_dot) <= 0.9 * LIMITS.velocity + 1e-6)
        assert np.all((scale >= 0) & (scale <= 1))
        q = q + 0.1 * q_dot
        assert np.all(np.minimum(q - LIMITS.lower, LIMITS.upper - q) >= inner - 1e-6)


def drakes_velocity(context, twist, q, nominal):
    """Drake's quadratic programme for both palms, one after the other."""
    PLANT.SetPositions(context, q)
    q_dot = np.zeros(14)
    for arm, instance in enumerate(INSTANCES):
        parameters = DifferentialInverseKinematicsParameters(14, 14)
        parameters.set_time_step(DT)
        parameters.set_nominal_joint_position(nominal)
        parameters.set_joint_position_limits((LIMITS.lower, LIMITS.upper))
        parameters.set_joint_velocity_limits((-LIMITS.velocity, LIMITS.velocity))
        result = DoDifferentialInverseKinematics(
            PLANT, context, twist[arm], PLANT.GetFrameByName("palm", instance), parameters
        )
        assert result.status == DifferentialInverseKinematicsStatus.kSolutionFound
        q_dot[7 * arm : 7 * arm + 7] = result.joint_velocities[7 * arm : 7 * arm + 7]
    return q_dot


def test_palm_paths_agree_with_drakes_differential_inverse_kinematics():
    """The same twists, open loop, so that no feedback hides a difference; the elbows may, and do, go other ways."""
    tracker = DualArmTracker(KINEMATICS, LIMITS, replace(DEFAULT_GAINS, pose=0.0))
    context = PLANT.CreateDefaultContext()
    ours = drakes = START
    pose0, swivel0 = poses(START)
    apart = 0.0
    for k in range(100):
        speed = 0.15 * np.sin(np.pi * k * DT)
        twist = np.array([[0.0, 0.2, 0.1, 0.6, 0.2, 1.0], [0.1, 0.0, -0.2, -0.6, 0.3, 1.0]]) * speed
        ours = ours + DT * tracker.velocity(ours, pose0, twist, swivel0 + 0.3 * k * DT, np.full(2, 0.3))[0]
        drakes = drakes + DT * drakes_velocity(context, twist, drakes, START)
        a, b = poses(ours)[0], poses(drakes)[0]
        apart = max(apart, np.linalg.norm((a - b)[:, 4:], axis=-1).max())
    assert np.linalg.norm((a - pose0)[:, 4:], axis=-1).min() > 0.08
    assert np.abs(ours - drakes).max() > 0.05
    assert apart < 1e-3
    assert np.abs(wrap(poses(ours)[1] - swivel0 - 0.3)).max() < 0.01
