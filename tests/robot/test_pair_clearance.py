"""Velocity dampers between the arms: gradients against finite differences, and what the closed loop keeps apart."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from drake_blfdmp.errors import ScenarioError
from drake_blfdmp.robot.clearance import ClearanceChecker
from drake_blfdmp.robot.kinematics import DualArmKinematics
from drake_blfdmp.robot.pair_clearance import (
    CARRIED,
    INFLUENCE,
    MOST_PAIRS,
    NEAR_SIZE,
    RECEDE,
    REFRESH,
    PairClearance,
)
from drake_blfdmp.robot.plant import ARMS, HOME, MakeKinematicPlant, ReadJointLimits
from drake_blfdmp.robot.swivel import wrap
from drake_blfdmp.robot.tracking import DualArmTracker, pose_error

PLANT = MakeKinematicPlant()
LIMITS = ReadJointLimits(PLANT, [PLANT.GetModelInstanceByName(arm) for arm in ARMS])
KINEMATICS = DualArmKinematics(PLANT)
CLEARANCE = 0.05
PAIRS, CHECKER = PairClearance(CLEARANCE), ClearanceChecker(max_distance=CLEARANCE + INFLUENCE)
START = np.tile(HOME, 2) + np.array([0.1, 0, -0.2, 0, 0.15, 0, 0, -0.1, 0, 0.2, 0, -0.15, 0, 0])
DT = 0.004


def near_postures(count):
    """Postures near HOME at which the two arms are near each other, but do not overlap; one pair is clearly nearest."""
    rng, found = np.random.default_rng(0), []
    while len(found) < count:
        q = np.tile(HOME, 2) + rng.uniform(-0.35, 0.35, 14)
        q[[0, 7]] += [-0.3, 0.3]
        distance, names = CHECKER.min_clearance(q)
        if distance > 0.01 and names[0].split("::")[0] != names[1].split("::")[0]:
            distances, _ = PAIRS.pairs(q)
            if len(distances) > 1 and distances[1] > distances[0] + 0.01:
                found.append(q)
    return found


@pytest.mark.parametrize("q", near_postures(4))
def test_distances_are_the_checkers_and_rows_are_their_derivatives(q):
    distances, rows = PAIRS.pairs(q)
    assert rows.shape == (len(distances), 14)
    assert 0 < len(distances) <= MOST_PAIRS
    assert np.all(np.diff(distances) >= 0)
    assert distances[0] == pytest.approx(CHECKER.min_clearance(q)[0], abs=1e-9)
    # Now and then Drake's distance of two capsules is off by up to a millimetre; joints for which differences over five
    # steps do not agree among themselves say nothing.
    differences = np.empty((5, 14))
    for k, step in enumerate((5e-4, 7e-4, 1e-3, 1.4e-3, 2e-3)):
        for joint in range(14):
            ends = [PAIRS.pairs(q + h * np.eye(14)[joint])[0][0] for h in (-step, step)]
            differences[k, joint] = (ends[1] - ends[0]) / (2 * step)
    smooth = np.ptp(differences, axis=0) < 0.02
    assert np.count_nonzero(smooth) >= 10
    np.testing.assert_allclose(rows[0, smooth], np.median(differences, axis=0)[smooth], atol=5e-3)
    assert np.abs(rows[0, :7]).max() > 0.05
    assert np.abs(rows[0, 7:]).max() > 0.05


def test_a_record_is_kept_while_no_joint_has_moved_far_and_made_anew_then():
    q = near_postures(1)[0]
    record = PAIRS.near(q)
    assert record.shape == (NEAR_SIZE,)
    for found, wanted in zip(PAIRS.carried_on(record, q), PAIRS.pairs(q), strict=True):
        np.testing.assert_array_equal(found, wanted)
    assert PAIRS.near(q + 0.99 * REFRESH, record) is record
    moved = q + np.where(np.arange(14) == 3, 1.01 * REFRESH, 0.0)
    np.testing.assert_array_equal(PAIRS.near(moved, record), PAIRS.near(moved))
    np.testing.assert_array_equal(PAIRS.near(q, np.full(NEAR_SIZE, np.inf)), record)


def test_distances_carried_on_are_off_by_no_more_than_the_clearance_is_widened():
    """The least one, over random moves of all joints by up to REFRESH; Drake's own digits (see above) left out."""
    rng, worst = np.random.default_rng(5), []
    for q in near_postures(4):
        record = PAIRS.near(q)
        for _ in range(40):
            moved = q + rng.uniform(-REFRESH, REFRESH, 14)
            worst.append(abs(PAIRS.carried_on(record, moved)[0].min() - PAIRS.pairs(moved)[0].min()))
    assert np.quantile(worst, 0.95) < CARRIED
    assert max(worst) < CARRIED + 1e-3


def test_a_pair_may_come_no_nearer_than_it_can_brake_and_must_part_when_too_near():
    rows, acceleration = np.ones((4, 14)) / 14, np.full(14, 2.0)
    distances = CLEARANCE + CARRIED + np.array([-0.2, -0.01, 0.0, 0.01])
    least = PAIRS.least_rates(distances, rows, 5.0, acceleration, DT)
    np.testing.assert_allclose(least, [RECEDE, 0.05, 0.0, -0.05], atol=1e-12)
    far = PAIRS.least_rates(np.array([CLEARANCE + CARRIED + 4.0]), rows[:1], 5.0, acceleration, DT)
    assert far[0] == pytest.approx(-np.sqrt(2 * 2.0 * 4.0), rel=0.05)


def carry_out(goal, swivel, seconds=2.0):
    """From START to palm positions (2, 3) and swivel angles and, after `seconds`, back; the least distance kept."""
    states = KINEMATICS.evaluate(START)
    home, angles = [s.position for s in states], np.array([s.swivel for s in states])
    matrices = [s.rotation for s in states]
    quaternions = [_quaternion(m) for m in matrices]
    tracker = DualArmTracker(KINEMATICS, LIMITS, clearance=CLEARANCE)
    q, v, least, scales, speeds = START, np.zeros(14), np.inf, [], []
    for k in range(round(2 * seconds / DT)):
        out = k * DT < seconds
        places, asked = (goal, swivel) if out else (home, angles)
        pose = np.array([[*r, *p] for r, p in zip(quaternions, places, strict=True)])
        tracked = tracker.velocity(q, pose, np.zeros((2, 6)), asked, np.zeros(2), v, DT)
        assert np.all(np.abs(tracked.velocity - v) <= 0.9 * LIMITS.acceleration * DT + 1e-9)
        assert tracked.deviation.max() < 5e-3  # The path is kept.
        v = tracked.velocity
        q = q + DT * v
        least = min(least, tracked.clearance)
        scales.append(tracked.scale.min())
        speeds.append(np.abs(v).max())
        if k == round(seconds / DT) - 1:
            reached = [np.abs(pose_error(s, pose[arm])).max() for arm, s in enumerate(KINEMATICS.evaluate(q))]
    back = max(np.abs(pose_error(s, pose[arm])).max() for arm, s in enumerate(KINEMATICS.evaluate(q)))
    return least, np.array(scales), max(reached), back, np.array(speeds)


def _quaternion(matrix):
    return np.roll(Rotation.from_matrix(matrix).as_quat(), 1)


def test_elbows_that_would_meet_wait_and_the_palms_do_not_notice():
    """The null space gives way first."""
    states = KINEMATICS.evaluate(START)
    swivel = wrap(np.array([s.swivel for s in states]) + np.array([0.9, -0.9]))
    least, scales, reached, back, _ = carry_out([s.position for s in states], swivel)
    assert least == pytest.approx(CLEARANCE, abs=2e-3)
    assert scales.min() > 0.999
    assert reached < 1e-3
    assert back < 1e-3


def test_palms_that_would_cross_stop_before_they_meet_and_come_back():
    """Then the task is scaled."""
    states = KINEMATICS.evaluate(START)
    goal = np.array([s.position for s in states])
    goal[:, 0] = [0.05, -0.05]
    least, scales, reached, back, speeds = carry_out(goal, [s.swivel for s in states])
    assert least > CLEARANCE - 1e-3
    assert scales.min() < 0.1
    assert reached > 0.1  # It would have been possible for each arm alone.
    assert speeds[round(2.0 / DT) - 20 : round(2.0 / DT)].max() < 0.2  # At rest before each other.
    assert back < 1e-3


def test_nothing_near_changes_nothing():
    states = KINEMATICS.evaluate(START)
    pose = np.array([[*_quaternion(s.rotation), *s.position] for s in states])
    pose[:, 6] += 0.05
    asked = pose, np.zeros((2, 6)), np.array([s.swivel for s in states]), np.zeros(2)
    with_it, without = (
        DualArmTracker(KINEMATICS, LIMITS, clearance=c).velocity(START, *asked, np.zeros(14), DT) for c in (0.02, None)
    )
    np.testing.assert_array_equal(with_it.velocity, without.velocity)
    assert without.clearance == np.inf
    assert with_it.clearance > 0.02


@pytest.mark.parametrize("clearance", [0.0, -0.1, float("nan"), float("inf")])
def test_a_clearance_that_is_none_is_refused(clearance):
    with pytest.raises(ScenarioError, match=r"clearance .* must be > 0 m, or None") as error:
        DualArmTracker(KINEMATICS, LIMITS, clearance=clearance)
    assert "\n" not in str(error.value)
