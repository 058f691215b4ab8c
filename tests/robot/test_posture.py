"""A start by Newton's method, rolls, and following a path of palm poses."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from drake_blfdmp.robot.differential_ik import DEFAULT_GAINS
from drake_blfdmp.robot.following import follow
from drake_blfdmp.robot.kinematics import DualArmKinematics
from drake_blfdmp.robot.plant import ARMS, MakeKinematicPlant, ReadJointLimits
from drake_blfdmp.robot.posture import palm_rolls, starting_posture
from drake_blfdmp.robot.retargeting import OUTWARD, multiply, palm_offsets
from drake_blfdmp.robot.swivel import wrap
from drake_blfdmp.robot.tracking import pose_error, rotation_matrix

PLANT = MakeKinematicPlant()
LIMITS = ReadJointLimits(PLANT, [PLANT.GetModelInstanceByName(arm) for arm in ARMS])
KINEMATICS = DualArmKinematics(PLANT)
# Palms that face each other; elbows 20 degrees outward from straight up.
GRASP = np.hstack([palm_offsets(np.zeros(2)), [[-0.15, 0.45, 0.7], [0.15, 0.45, 0.7]]])
ELBOWS = wrap(np.pi - OUTWARD * np.deg2rad(20))


def margin(q):
    return np.minimum(q - LIMITS.lower, LIMITS.upper - q)


@pytest.fixture(scope="module")
def start():
    return starting_posture(KINEMATICS, LIMITS, GRASP, ELBOWS)


def test_the_start_meets_position_normal_and_swivel_within_the_limits(start):
    assert margin(start).min() > 0.1
    np.testing.assert_array_equal(start[[6, 13]], 0.0)
    for arm, state in enumerate(KINEMATICS.evaluate(start)):
        np.testing.assert_allclose(state.position, GRASP[arm, 4:], atol=1e-5)
        np.testing.assert_allclose(state.rotation[:, 2], [[1, 0, 0], [-1, 0, 0]][arm], atol=1e-5)
        assert wrap(state.swivel - ELBOWS[arm]) == pytest.approx(0.0, abs=1e-5)


def test_the_start_is_the_same_each_time(start):
    np.testing.assert_array_equal(starting_posture(KINEMATICS, LIMITS, GRASP, ELBOWS), start)


def test_more_seeds_never_find_less_margin(start):
    few = starting_posture(KINEMATICS, LIMITS, GRASP, ELBOWS, seeds=2)
    assert few is None or margin(few).min() <= margin(start).min() + 1e-6


def test_rolls_make_the_pose_the_palms_own(start):
    rolls = palm_rolls(KINEMATICS, start, GRASP)
    assert np.abs(rolls).max() > 0.1
    for arm, state in enumerate(KINEMATICS.evaluate(start)):
        spin = np.array([np.cos(rolls[arm] / 2), 0, 0, np.sin(rolls[arm] / 2)])
        np.testing.assert_allclose(rotation_matrix(multiply(GRASP[arm, :4], spin)), state.rotation, atol=1e-5)
    rolled = np.hstack([palm_offsets(rolls), GRASP[:, 4:]])
    np.testing.assert_allclose(palm_rolls(KINEMATICS, start, rolled), 0.0, atol=1e-5)


@pytest.mark.parametrize(
    ("shift", "swing"), [([0.0, 2.0, 0.0], 20.0), ([0.0, 0.0, 1.5], 20.0), ([0.0, 0.0, 0.0], 180.0)]
)
def test_what_cannot_be_reached_has_no_start(shift, swing):
    """Too far, too high, and the elbow straight below, which the limit of joint 2 forbids."""
    pose = GRASP.copy()
    pose[:, 4:] += shift
    assert starting_posture(KINEMATICS, LIMITS, pose, wrap(np.pi - OUTWARD * np.deg2rad(swing)), seeds=4) is None


def test_postures_with_joint_6_beyond_pi_are_found():
    """Joint 6 goes to 3.75 rad; poses made from such postures must not be refused for want of a whole turn."""
    rng, beyond = np.random.default_rng(0), 0
    for _ in range(6):
        q = rng.uniform(LIMITS.lower + 0.4, LIMITS.upper - 0.4)
        q[[5, 12]], q[[6, 13]] = 3.25, 0.0
        states = KINEMATICS.evaluate(q)
        pose = np.array([[*np.roll(Rotation.from_matrix(s.rotation).as_quat(), 1), *s.position] for s in states])
        found = starting_posture(KINEMATICS, LIMITS, pose, np.array([s.swivel for s in states]))
        if found is not None:
            assert margin(found).min() > 0
            beyond += int(np.sum(found[[5, 12]] > np.pi))
    assert beyond >= 1


def straight_path(start, shift, samples=25):
    """Poses with the rolls of `start`, the palms moved along a line by `shift`, the elbows kept."""
    rolls = palm_rolls(KINEMATICS, start, GRASP)
    pose = np.tile(np.hstack([palm_offsets(rolls), GRASP[:, 4:]]), (samples, 1, 1))
    pose[:, :, 4:] += np.linspace(0, 1, samples)[:, None, None] * np.asarray(shift)
    return pose, np.tile(ELBOWS, (samples, 1))


def test_a_reachable_path_is_followed(start):
    pose, swivel = straight_path(start, [0.03, 0.05, 0.15])
    following = follow(KINEMATICS, LIMITS, start, pose, swivel)
    assert following.q.shape == (25, 14)
    assert following.pose_error < 1e-4
    assert following.swivel_error < 0.05
    assert following.joint_margin == pytest.approx(margin(following.q).min())
    worst = max(
        np.abs(pose_error(state, pose[k, arm])).max()
        for k in range(25)
        for arm, state in enumerate(KINEMATICS.evaluate(following.q[k]))
    )
    assert following.pose_error == pytest.approx(worst)
    # Followed, not jumped: the joints move evenly.
    assert np.abs(np.diff(following.q, axis=0)).max() < 0.2


def test_a_path_out_of_reach_shows_its_error_and_respects_the_limits(start):
    pose, swivel = straight_path(start, [0.0, 0.6, 0.3])
    following = follow(KINEMATICS, LIMITS, start, pose, swivel)
    assert following.pose_error > 0.05
    assert following.joint_margin >= DEFAULT_GAINS.limit_margin - 1e-6
    early = follow(KINEMATICS, LIMITS, start, pose, swivel, give_up=0.01)
    assert early.pose_error > 0.01
    assert early.pose_error <= following.pose_error
    last = int(np.flatnonzero(np.any(np.diff(early.q, axis=0) != 0, axis=1))[-1]) + 1
    assert last < 24
    np.testing.assert_array_equal(early.q[: last + 1], following.q[: last + 1])
