"""The choice of scale, place and rolls: a small motion fits, an absurd one is refused in one line."""

from dataclasses import replace

import numpy as np
import pytest
from lifted import ANCHOR, TIME, lift_and_carry

from drake_blfdmp.errors import TaskError
from drake_blfdmp.robot import reach as reach_module
from drake_blfdmp.robot.clearance import ClearanceChecker
from drake_blfdmp.robot.differential_ik import DEFAULT_GAINS
from drake_blfdmp.robot.following import Following
from drake_blfdmp.robot.kinematics import DualArmKinematics
from drake_blfdmp.robot.plant import ARMS, MakeKinematicPlant, ReadJointLimits
from drake_blfdmp.robot.reach import CENTRE, SCALES, SHIFTS, WIDE, find_reach
from drake_blfdmp.robot.reach_evaluation import (
    ACCELERATION_SHARE,
    JOINT_MARGIN,
    VELOCITY_SHARE,
    Reach,
    evaluate,
    kept_limits,
    needed_stretch,
)
from drake_blfdmp.robot.retargeting import retarget_motion
from drake_blfdmp.robot.rigid import rigid
from drake_blfdmp.robot.tracking import pose_error

PLANT = MakeKinematicPlant()
LIMITS = ReadJointLimits(PLANT, [PLANT.GetModelInstanceByName(arm) for arm in ARMS])
KINEMATICS = DualArmKinematics(PLANT)
SEARCH = {"kinematics": KINEMATICS, "limits": LIMITS}


MOTION = lift_and_carry()


@pytest.fixture(scope="module")
def reach():
    shares = []
    return find_reach(TIME, MOTION, ANCHOR, scale=0.7, progress=shares.append, **SEARCH), shares


def test_a_small_motion_is_reachable_and_sound(reach):
    reach, _ = reach
    assert reach.sound
    assert reach.following.pose_error < 2e-3
    assert reach.following.joint_margin > 0.09
    assert reach.clearance >= 0.02
    assert 1.0 <= reach.stretch < 3.0


def test_the_reported_postures_carry_out_the_motion(reach):
    """Asked afresh of the kinematics: rolls, place and start belong to one retargeting."""
    reach, _ = reach
    pose, *_ = retarget_motion(MOTION, 0 * MOTION, reach.retarget)
    pose = pose[reach.samples]
    for q, goals in zip(reach.following.q, pose, strict=True):
        for arm, state in enumerate(KINEMATICS.evaluate(q)):
            assert np.abs(pose_error(state, goals[arm])).max() <= reach.following.pose_error + 1e-12
        assert np.all(np.minimum(q - LIMITS.lower, LIMITS.upper - q) >= reach.following.joint_margin - 1e-12)
    for arm, state in enumerate(KINEMATICS.evaluate(reach.start)):
        assert np.abs(pose_error(state, pose[0, arm])).max() < 2e-3
    # The rolls are those of the grasp's posture, which leaves the roll to joint 7 = 0.
    grasp = reach.following.q[int(np.flatnonzero(reach.samples == ANCHOR)[0])]
    np.testing.assert_allclose(grasp[[6, 13]], 0.0, atol=0.05)
    checker = ClearanceChecker(max_distance=0.1)
    assert reach.clearance == pytest.approx(min(checker.min_clearance(q)[0] for q in reach.following.q[::2]))


def test_a_fixed_scale_is_kept_and_the_place_is_searched_about_the_centre(reach):
    reach, shares = reach
    assert reach.retarget.scale == 0.7
    np.testing.assert_allclose(reach.retarget.person, [0, 0, 1.40])
    pose, *_ = retarget_motion(MOTION, 0 * MOTION, reach.retarget)
    middle = pose[..., 4:].mean(axis=1)
    shift = 0.5 * (middle.min(axis=0) + middle.max(axis=0)) - CENTRE
    assert min(np.abs(shift - tried).max() for tried in SHIFTS) < 1e-9
    assert shares == sorted(shares)
    assert shares[-1] == 1.0


def test_a_fixed_place_is_kept_and_the_largest_comfortable_scale_is_found(reach):
    world = reach[0].retarget.world
    free = find_reach(TIME, MOTION, ANCHOR, world=world, **SEARCH)
    np.testing.assert_array_equal(free.retarget.world, world)
    assert free.sound
    assert free.retarget.scale in SCALES
    # A larger scale at this place was looked at and left for a reason.
    for larger in (s for s in SCALES if s > free.retarget.scale):
        retarget = replace(reach[0].retarget, scale=larger, rolls=np.zeros(2))
        other = evaluate(KINEMATICS, LIMITS, ClearanceChecker(max_distance=0.1), TIME, MOTION, retarget, ANCHOR)
        assert other is None or not other.comfortable or other.stretch >= free.stretch
    both = find_reach(TIME, MOTION, ANCHOR, scale=0.5, world=world, level=False, elbow_up=True, **SEARCH)
    assert both.retarget.scale == 0.5
    np.testing.assert_array_equal(both.retarget.world, world)
    assert not both.retarget.level


def one_line(error):
    message = str(error.value)
    assert "\n" not in message
    return message


def test_a_box_of_a_metre_and_a_half_is_refused_in_one_line():
    with pytest.raises(TaskError) as error:
        find_reach(TIME, lift_and_carry(width=1.5), ANCHOR, scale=0.5, **SEARCH)
    message = one_line(error)
    assert "1.50 m wide" in message
    assert "use a narrower box" in message


def test_a_motion_too_large_for_a_fixed_scale_is_refused_with_how_far_off_it_is(reach):
    with pytest.raises(TaskError, match=r"no place at scale 1 makes.*palms \d+ mm off.*or use a smaller box") as error:
        find_reach(TIME, lift_and_carry(lift=1.0), ANCHOR, scale=1.0, world=reach[0].retarget.world, **SEARCH)
    assert one_line(error)


def test_a_wide_search_finds_what_is_nowhere_near_the_centre(monkeypatch):
    """With the usual places moved out of reach; places that no arm is long enough for are not even looked at."""
    motion = lift_and_carry(lift=0.3, carry=0.3)
    monkeypatch.setattr(reach_module, "SHIFTS", (np.array([0.0, 2.0, 0.0]),))
    with pytest.raises(TaskError, match="anywhere in front"):
        find_reach(TIME, motion, ANCHOR, scale=1.0, **SEARCH)
    looked_at, real = [], reach_module.evaluate_all

    def evaluate_all(kinematics, limits, checker, t, x, retargets, *rest):
        looked_at.extend(retargets)
        return real(kinematics, limits, checker, t, x, retargets, *rest)

    monkeypatch.setattr(reach_module, "evaluate_all", evaluate_all)
    found = find_reach(TIME, motion, ANCHOR, scale=1.0, calms=(1.0,), wide=True, **SEARCH)
    assert found.sound and 0 < len(looked_at) < len(WIDE)
    for retarget in looked_at:
        pose, *_ = retarget_motion(motion, 0 * motion, retarget)
        assert (np.linalg.norm(pose[..., 4:] - KINEMATICS.shoulders, axis=-1) < KINEMATICS.arm_length + 1e-3).all()


def test_no_palm_is_farther_from_its_shoulder_than_an_arm_is_long():
    rng, lower, upper = np.random.default_rng(0), LIMITS.lower.copy(), LIMITS.upper.copy()
    upper[[3, 10]] = KINEMATICS.straight_elbow
    farthest = np.zeros(2)
    for q in rng.uniform(lower, upper, (500, 14)):
        for arm, state in enumerate(KINEMATICS.evaluate(q)):
            farthest[arm] = max(farthest[arm], np.linalg.norm(state.position - KINEMATICS.shoulders[arm]))
    assert (farthest <= KINEMATICS.arm_length).all() and (farthest > 0.8 * KINEMATICS.arm_length).all()


def test_elbows_below_the_line_are_refused(reach):
    """What docs/redundancy.md measures: without the mirrored elbow the motion has no posture, or not the swivel."""
    fixed = {"scale": 0.7, "world": reach[0].retarget.world}
    with pytest.raises(TaskError, match="cannot take"):
        find_reach(TIME, MOTION, ANCHOR, elbow_up=False, **fixed, **SEARCH)


def test_a_grasp_out_of_reach_evaluates_to_none(reach):
    retarget = reach[0].retarget
    far = replace(retarget, world=retarget.world + np.array([0, 1.0, 0]))
    assert evaluate(KINEMATICS, LIMITS, ClearanceChecker(), TIME, MOTION, far, ANCHOR) is None


@pytest.mark.parametrize(
    ("pose_error", "joint_margin", "clearance", "sound"),
    [(1e-3, 0.1, 0.03, True), (3e-3, 0.1, 0.03, False), (1e-3, 0.05, 0.03, False), (1e-3, 0.1, 0.01, False)],
)
def test_sound_means_exact_with_margin_and_clearance(reach, pose_error, joint_margin, clearance, sound):
    following = Following(np.zeros((2, 14)), pose_error, 0.0, joint_margin)
    assert Reach(reach[0].retarget, np.zeros(14), following, np.arange(2), clearance, 1.0).sound is sound


def test_a_pose_becomes_drakes():
    half = np.sqrt(0.5)
    X = rigid(np.array([2 * half, 0, 0, 2 * half, 0.1, 0.2, 0.3]))
    np.testing.assert_allclose(X.translation(), [0.1, 0.2, 0.3])
    np.testing.assert_allclose(X.rotation().matrix(), [[0, -1, 0], [1, 0, 0], [0, 0, 1]], atol=1e-12)


def test_a_path_is_stretched_by_what_the_slowest_joint_needs():
    """Minimum-jerk steps of one joint: peak speed 15/8 a/T, peak acceleration 10/sqrt(3) a/T^2."""
    share = np.linspace(0, 1, 2001)
    step = share**3 * (10 - 15 * share + 6 * share**2)
    for joint in (1, 6, 12):
        for duration, amplitude in ((0.5, 1.2), (2.0, 1.2), (0.2, 0.05)):
            q = amplitude * np.outer(step, np.eye(14)[joint])
            speed, acceleration = 15 / 8 * amplitude / duration, 10 / np.sqrt(3) * amplitude / duration**2
            by_speed = speed / (VELOCITY_SHARE * LIMITS.velocity[joint])
            by_acceleration = np.sqrt(acceleration / (ACCELERATION_SHARE * LIMITS.acceleration[joint]))
            stretch = needed_stretch(duration * share, q, LIMITS)
            assert stretch == pytest.approx(max(1.0, by_speed, by_acceleration), rel=1e-3)
            # Slowed down by it, the path needs no more.
            assert needed_stretch(stretch * duration * share, q, LIMITS) == pytest.approx(1.0, rel=1e-3)


def test_hands_may_shrink_with_the_motion_only_where_they_hold_nothing():
    """1.2 m apart is too wide for palms that face each other at this place; half of it is not."""
    wide = lift_and_carry(width=1.2, lift=0.1, carry=0.05)
    place = {"scale": 0.5, "world": np.array([0.0, 0.35, 0.9])}
    with pytest.raises(TaskError, match="reach: "):
        find_reach(TIME, wide, ANCHOR, **place, **SEARCH)
    reach = find_reach(TIME, wide, ANCHOR, shrink_hands=True, **place, **SEARCH)
    assert reach.sound and reach.retarget.hands_scale == 0.5
    palms = retarget_motion(wide, 0 * wide, reach.retarget)[0][..., 4:]
    np.testing.assert_allclose(np.linalg.norm(palms[:, 1] - palms[:, 0], axis=-1), 0.6, atol=1e-12)


def test_what_is_found_holds_on_as_many_samples_a_second_as_asked():
    t = np.linspace(0.0, 12.0, 601)
    x = np.repeat(lift_and_carry()[:1], len(t), axis=0)
    x[:, [2, 5], 2] += 0.1 * (1.0 - np.cos(2 * np.pi * t / 0.8))[:, None]  # Too fast for 60 samples to see.
    place = {"scale": 0.7, "world": np.array([0.0, 0.3, 0.9])}
    coarse, fine = (find_reach(t, x, 10, sample_rate_hz=rate, **place, **SEARCH) for rate in (0.0, 20.0))
    assert len(fine.samples) >= 240 > len(coarse.samples)
    assert fine.sound and fine.stretch > 1.5 * coarse.stretch


def test_the_remedy_is_the_callers(reach):
    place = {"scale": 1.0, "world": reach[0].retarget.world}
    with pytest.raises(TaskError, match=r"^reach: no place at scale [^\n]*; try something else$"):
        find_reach(TIME, lift_and_carry(lift=1.0), ANCHOR, remedy="try something else", **place, **SEARCH)
    with pytest.raises(TaskError, match=r"^reach: the arms cannot hold their palms 0\.30 m apart [^\n]*; stay near$"):
        away = {"scale": 1.0, "world": np.array([0.0, 3.0, 1.0])}
        find_reach(TIME, MOTION, ANCHOR, shrink_hands=True, remedy="stay near", **away, **SEARCH)


def test_kept_limits_are_within_what_the_inverse_kinematics_keeps_and_no_elbow_is_straight():
    kept, elbows = kept_limits(LIMITS, KINEMATICS), [3, 10]
    np.testing.assert_allclose(kept.lower, LIMITS.lower + JOINT_MARGIN)
    others = np.delete(np.arange(14), elbows)
    np.testing.assert_allclose(kept.upper[others], LIMITS.upper[others] - JOINT_MARGIN)
    np.testing.assert_allclose(kept.upper[elbows], KINEMATICS.straight_elbow - JOINT_MARGIN)
    assert np.all(kept.upper[elbows] < LIMITS.upper[elbows] - JOINT_MARGIN)
    assert DEFAULT_GAINS.limit_margin >= JOINT_MARGIN  # What is within is never left at run time.
    np.testing.assert_array_equal(kept.velocity, LIMITS.velocity)
