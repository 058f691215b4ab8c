"""Clearance: known distances, what counts and what does not."""

import numpy as np
import pytest
from pydrake.math import RigidTransform

from drake_blfdmp.errors import TaskError
from drake_blfdmp.robot.box import BoxParameters, TableParameters
from drake_blfdmp.robot.clearance import ClearanceChecker
from drake_blfdmp.robot.plant import HOME

MIRROR = np.array([-1, 1, -1, 1, -1, 1, -1])
Q_HOME = np.concatenate([HOME, MIRROR * HOME])
TABLE = TableParameters(name="table", top_center=(0.0, 0.45, 0.6))


@pytest.fixture(scope="module")
def checker():
    return ClearanceChecker([TABLE], BoxParameters())


def test_home_is_clear(checker):
    distance, names = checker.min_clearance(Q_HOME)
    assert distance > 0.05, names
    assert all(name.startswith(("left_arm::", "right_arm::")) for name in names)


def test_mirrored_postures_have_the_same_clearance(checker):
    q = np.array([0.2, -0.3, 0.1, -2.1, 0.3, 1.6, 0.4])
    q_other = np.array([0.1, -0.2, -0.1, -1.9, 0.2, 1.9, 0.2])
    one, _ = checker.min_clearance(np.concatenate([q, q_other]))
    # The knob on link 7 is the one part that is not symmetric.
    other, _ = checker.min_clearance(np.concatenate([MIRROR * q_other, MIRROR * q]))
    assert one == pytest.approx(other, abs=0.02)


@pytest.mark.parametrize("gap", [0.07, 0.04, 0.005, -0.01])
def test_a_table_under_the_palm_is_seen_at_its_distance(gap):
    """The forearm level and the wrist at a right angle: the pads look straight down on a table `gap` below one."""
    q = np.array([0, 0, 0, -np.pi / 2, 0, np.pi / 2, 0.0])
    both = np.concatenate([q, q])
    probe = ClearanceChecker()
    context = probe.plant.CreateDefaultContext()
    probe.plant.SetPositions(context, both)
    palm = probe.plant.GetFrameByName("palm", probe.plant.GetModelInstanceByName("left_arm"))
    X_WP = palm.CalcPoseInWorld(context)
    np.testing.assert_allclose(X_WP.rotation().matrix()[:, 2], [0, 0, -1], atol=1e-12)
    top = X_WP.translation() - [0, 0, gap]
    table = TableParameters(name="stand", top_center=tuple(top), size=(0.1, 0.1), thickness=0.02)
    distance, names = ClearanceChecker([table], max_distance=0.3).min_clearance(both)
    assert set(names) == {"left_arm::palm", "stand"}
    assert distance == pytest.approx(gap, abs=1e-4)


def test_arms_driven_into_each_other_overlap(checker):
    q = Q_HOME.copy()
    q[0], q[7] = -0.6, 0.6
    distance, names = checker.min_clearance(q)
    assert distance < 0
    assert {name.split("::")[0] for name in names} == {"left_arm", "right_arm"}


def test_an_arm_bent_into_its_pedestal_overlaps(checker):
    q = Q_HOME.copy()
    q[1], q[3], q[5] = 1.7, -2.9, 1.0
    distance, names = checker.min_clearance(q)
    assert distance < 0
    assert any("pedestal" in name or "link0" in name for name in names)


def test_the_box_counts_against_arms_but_not_palms_or_table(checker):
    on_table = RigidTransform([0.0, 0.45, 0.7])
    without, _ = checker.min_clearance(Q_HOME)
    assert checker.min_clearance(Q_HOME, on_table)[0] <= without
    # Half sunk in the table, which is no business of the checker.
    sunk = RigidTransform([0.0, 0.45, 0.6])
    assert checker.min_clearance(Q_HOME, sunk)[0] > 0
    # In the left forearm.
    context = checker.plant.CreateDefaultContext()
    checker.plant.SetPositions(context, checker.plant.GetModelInstanceByName("left_arm"), Q_HOME[:7])
    elbow = checker.plant.GetFrameByName("elbow", checker.plant.GetModelInstanceByName("left_arm"))
    distance, names = checker.min_clearance(Q_HOME, RigidTransform(elbow.CalcPoseInWorld(context).translation()))
    assert distance < -0.01
    assert "box" in names


def test_distant_things_are_reported_as_the_maximum():
    distance, names = ClearanceChecker(max_distance=0.01).min_clearance(Q_HOME)
    assert (distance, names) == (0.01, ("", ""))


@pytest.mark.parametrize("q", [np.zeros(7), np.full(14, np.nan)])
def test_bad_angles_are_refused(checker, q):
    with pytest.raises(TaskError, match="14 finite"):
        checker.min_clearance(q)


def test_a_box_pose_without_a_box_is_refused():
    with pytest.raises(TaskError, match="without a box"):
        ClearanceChecker().min_clearance(Q_HOME, RigidTransform())
    with pytest.raises(TaskError, match="max_distance"):
        ClearanceChecker(max_distance=0.0)


def test_links_are_told_from_what_stands_around_each_arm_by_itself():
    """A slab under the left elbow, arms driven into each other: neither the other arm nor the palms count."""
    q = Q_HOME.copy()
    q[0], q[7] = -0.6, 0.6
    probe = ClearanceChecker()
    context = probe.plant.CreateDefaultContext()
    probe.plant.SetPositions(context, q)
    arms = [probe.plant.GetModelInstanceByName(arm) for arm in ("left_arm", "right_arm")]
    wrist = probe.plant.GetFrameByName("wrist", arms[0]).CalcPoseInWorld(context).translation()
    told = []
    for below in (0.10, 0.12):
        slab = TableParameters(
            name="slab", top_center=(*wrist[:2], wrist[2] - below), size=(0.02, 0.02), thickness=0.01
        )
        told.append(ClearanceChecker([slab], max_distance=0.08, among_arms=False).link_clearances(q))
    (near, _), (farther, _) = told
    assert 0.0 < near < farther < 0.08 and farther - near <= 0.02 + 1e-9
    palm = probe.plant.GetFrameByName("palm", arms[1]).CalcPoseInWorld(context).translation()
    box = BoxParameters(width=0.02, depth=0.02, height=0.02)
    around = ClearanceChecker(box=box, max_distance=0.01, among_arms=False)
    np.testing.assert_array_equal(around.link_clearances(q, RigidTransform(palm)), 0.01)
    elbow = probe.plant.GetFrameByName("elbow", arms[1]).CalcPoseInWorld(context).translation()
    left, right = around.link_clearances(q, RigidTransform(elbow))
    assert left == 0.01 and right < 0.0
    np.testing.assert_array_equal(around.link_clearances(q), 0.01)  # Without the box.


@pytest.mark.parametrize("clearance", [0.0, 0.02, 0.1])
def test_pairs_nearer_than_a_clearance_count_as_overlapping(checker, clearance):
    """Against the signed distances of all capsules, pair by pair."""
    rng = np.random.default_rng(2)
    left, right = (np.array(HOME) + rng.normal(scale=0.5, size=(12, 7)) for _ in range(2))
    near = checker.overlapping(left, right, clearance)
    context = checker.plant.CreateDefaultContext()
    arms = [checker.plant.GetModelInstanceByName(arm) for arm in ("left_arm", "right_arm")]
    for i, j in np.ndindex(near.shape):
        for arm, q in zip(arms, (left[i], right[j]), strict=True):
            checker.plant.SetPositions(context, arm, q)
        assert near[i, j] == np.any(checker._capsules.distances(context) <= clearance)
    assert clearance == 0.1 or not near.all()
    assert near.any()
