"""Postures that are found are ones; arms get along a way where they can, not through each other or by a jump."""

import numpy as np
import pytest

from drake_blfdmp.evaluation.robustness.joined_postures import (
    JoinedPostures,
    _grown,
    _joined,
    _joined_up,
    _on_the_way,
)
from drake_blfdmp.robot.box import BoxParameters, TableParameters
from drake_blfdmp.robot.elbow_paths import Scene
from drake_blfdmp.robot.kinematics import DualArmKinematics
from drake_blfdmp.robot.plant import ARMS, MakeKinematicPlant, ReadJointLimits
from drake_blfdmp.robot.reach_evaluation import JOINT_MARGIN, kept_limits

EASY = np.array([0.0, 0.47, 0.72])
RISE = np.array([0.1, 0.05, 0.25])
SAMPLES = 9
SMALL = BoxParameters(width=0.1, depth=0.1, height=0.1)


@pytest.fixture(scope="module")
def joined():
    return JoinedPostures()


def along(*ends):
    """A straight way (SAMPLES, 3)."""
    return np.linspace(*map(np.array, ends), SAMPLES)


def reached(joined, middles, yaw=0.0, apart=0.3):
    return joined.reached(middles, np.full(len(middles), yaw), np.full(len(middles), apart))


@pytest.mark.parametrize("arm", [0, 1])
def test_postures_are_ones(joined, arm):
    plant = MakeKinematicPlant()
    limits = ReadJointLimits(plant, [plant.GetModelInstanceByName(name) for name in ARMS])
    own = slice(7 * arm, 7 * arm + 7)
    normal = np.array([np.cos(0.3), np.sin(0.3), 0.0]) * (1.0, -1.0)[arm]
    palm = EASY - 0.15 * normal
    found, places = joined._postures(arm, palm[None], normal[None])[0]
    assert len(found) == len(places) >= 20  # Of many swivel angles.
    kinematics, q, swivels = DualArmKinematics(plant), np.zeros(14), []
    for posture in found:
        assert np.all(posture >= limits.lower[own]) and np.all(posture <= limits.upper[own])
        q[own] = posture
        state = kinematics.evaluate(q)[arm]
        np.testing.assert_allclose(state.position, palm, atol=1e-9)
        np.testing.assert_allclose(state.rotation[:, 2], normal, atol=1e-9)
        swivels.append(state.swivel)
    assert np.ptp(swivels) > 1.0


def test_an_easy_way_is_got_along(joined):
    assert reached(joined, along(EASY, EASY + RISE)) == SAMPLES


def test_the_sample_that_is_out_of_reach_is_told(joined):
    middles = along(EASY, EASY + RISE)
    for k in (0, 4, SAMPLES - 1):
        broken = middles.copy()
        broken[k, 1] = 1.6
        assert reached(joined, broken) == k


def test_palms_that_are_nearly_one_are_arms_that_overlap(joined):
    """Both palms are reached, by postures that overlap."""
    assert len(joined._postures(0, EASY[None], np.array([[1.0, 0.0, 0.0]]))[0][0])
    assert reached(joined, along(EASY, EASY), apart=-0.12) < SAMPLES


def test_links_do_not_get_into_a_table(joined):
    """One that stands where the arms' links are, whatever the elbows do; one under the box is in nobody's way."""
    middles = along(EASY, EASY + RISE)
    yaw, apart = np.zeros(SAMPLES), np.full(SAMPLES, 0.3)
    below = TableParameters(name="table", top_center=(0.0, 0.47, 0.6), size=(0.3, 0.2))
    among = TableParameters(name="table", top_center=(0.0, 0.0, 0.8), size=(0.6, 0.2))
    for tables, gets_along in (([below], True), ([among], False)):
        scene = Scene(tables, SMALL, np.tile([1.0, 0, 0, 0, 0, 3.0, 3.0], (SAMPLES, 1)), 0.0)
        assert joined.get_along(middles, yaw, apart, scene.clear) is gets_along
    assert joined.get_along(middles, yaw, apart)


def test_links_do_not_get_into_the_box(joined):
    middles = along(EASY, EASY + RISE)
    yaw, apart = np.zeros(SAMPLES), np.full(SAMPLES, 0.3)
    for big, gets_along in ((SMALL, True), (BoxParameters(width=0.3, depth=1.2, height=1.2), False)):
        scene = Scene([], big, np.concatenate([np.tile([1.0, 0, 0, 0], (SAMPLES, 1)), middles], axis=-1), 0.0)
        assert joined.get_along(middles, yaw, apart, scene.clear) is gets_along


def test_only_what_is_free_of_the_other_arm_is_asked_for_and_each_pair_keeps_its_own_answer():
    free = np.zeros((4, 3), dtype=bool)
    free[1, 0] = free[3, 0] = free[3, 2] = True
    now = [postures(np.zeros(n, dtype=int), np.arange(n), np.arange(n)) for n in free.shape]
    asked = []

    def clear(k, left, right):
        asked.append((k, left[:, 0].tolist(), right[:, 0].tolist()))
        return np.array([[True, True], [False, True]])

    kept = JoinedPostures._kept(clear, 7, (now, free))[1]
    assert asked == [(7, [1.0, 3.0], [0.0, 2.0])]
    np.testing.assert_array_equal(np.argwhere(kept), [[1, 0], [3, 2]])
    assert free.sum() == 3  # It is another's, too.
    nothing = np.zeros((4, 3), dtype=bool)
    assert not JoinedPostures._kept(clear, 0, (now, nothing))[1].any() and len(asked) == 1


def test_narrower_limits_and_a_clearance_are_kept():
    """Less room leaves fewer postures, and arms that come near each other are too near."""
    plant = MakeKinematicPlant()
    limits = ReadJointLimits(plant, [plant.GetModelInstanceByName(name) for name in ARMS])
    kept = kept_limits(limits, DualArmKinematics(plant))
    palm, normal = EASY[None] - [0.15, 0.0, 0.0], np.array([[1.0, 0.0, 0.0]])
    own, inner = (JoinedPostures(bounds)._postures(0, palm, normal)[0][0] for bounds in (None, kept))
    assert 0 < len(inner) < len(own)
    assert np.all(inner >= limits.lower[:7] + JOINT_MARGIN) and np.all(inner <= limits.upper[:7] - JOINT_MARGIN)
    middles = along(EASY, EASY)
    near, far = JoinedPostures(clearance=0.0), JoinedPostures(clearance=0.3)
    assert reached(near, middles, apart=0.05) == SAMPLES
    assert reached(far, middles, apart=0.05) == 0


def postures(branches, angles, q):
    return np.array(q, dtype=float)[:, None] * np.ones(7), np.stack([angles, branches], axis=-1)


def test_a_jump_is_none():
    """From branch to branch and past angles that are not there nothing is joined, unless the postures are alike."""
    here = postures([0, 0, 1], [3, 71, 5], [0.0, 1.0, 2.0])
    there = postures([0, 0, 0, 1], [4, 5, 0, 3], [0.9, 0.8, 3.0, 2.2])
    np.testing.assert_array_equal(_joined(here, there), [[1, 0, 0, 0], [1, 1, 1, 0], [0, 0, 0, 1]])


def test_a_joint_does_not_pass_its_limits_on_the_way_round():
    """From one end of its range to the other by less than a turn's rest, beside each other as the wrist goes."""
    here, there = postures([0], [3], [2.8]), postures([0, 0], [4, 4], [-2.8, 0.5])
    np.testing.assert_array_equal(_joined(here, there), [[0, 1]])


def test_elbows_may_turn_while_the_palms_wait_as_far_as_the_pairs_are_free():
    chain = np.eye(6, dtype=np.float32) + np.eye(6, k=1, dtype=np.float32) + np.eye(6, k=-1, dtype=np.float32)
    free = np.ones((6, 6), dtype=bool)
    free[3] = False  # Of the left arm's postures the fourth is never free.
    there = np.zeros((6, 6), dtype=bool)
    there[0, 0] = True
    grown = _grown(there, free, chain, chain)
    assert grown[:3].all() and not grown[3:].any()
    assert not _grown(np.zeros((6, 6), dtype=bool), free, chain, chain).any()


def test_a_way_that_only_a_turning_elbow_gets_along_is_got_along():
    """Two samples whose free pairs are far apart, and one between them at which the elbows may turn."""
    line = postures(np.zeros(9, dtype=int), np.arange(9), 2.0 * np.arange(9))
    first, last, all_free = np.zeros((9, 9), dtype=bool), np.zeros((9, 9), dtype=bool), np.ones((9, 9), dtype=bool)
    first[0, 0] = last[8, 8] = True
    both = [line, line]
    assert _joined_up([(both, first), (both, all_free), (both, last)]) == 3
    wall = all_free.copy()
    wall[4] = False
    assert _joined_up([(both, first), (both, wall), (both, last)]) == 2


def test_an_arms_postures_that_lead_nowhere_are_left_out():
    """Those of a branch that ends, and those beyond a gap; not those from which the elbow turns to the others."""
    first = postures([0, 0, 0, 1], [0, 1, 2, 8], [0.0, 2.0, 4.0, 9.0])
    middle = postures([0, 0, 0, 1], [0, 1, 5, 8], [0.0, 2.0, 6.0, 9.0])
    last = postures([0, 0], [0, 6], [0.0, 7.0])
    got, kept = _on_the_way([first, middle, last])
    assert got == 3 and [places[:, 0].tolist() for _, places in kept] == [[0, 1, 2], [0, 1], [0]]
    assert [q[:, 0].tolist() for q, _ in kept] == [[0.0, 2.0, 4.0], [0.0, 2.0], [0.0]]
    samples = [first, middle, postures([0], [9], [20.0])]
    got, kept = _on_the_way(samples)
    assert got == 2 and kept is samples
    assert _on_the_way([first, postures([], [], []), last])[0] == 1
    assert _on_the_way([postures([], [], []), first])[0] == 0


def test_where_another_way_failed_says_nothing_of_one_that_goes_well():
    joined, yaw, apart = JoinedPostures(), np.zeros(SAMPLES), np.full(SAMPLES, 0.3)
    middles = along(EASY, EASY + RISE)
    for k in (4, 8, 0):
        broken = middles.copy()
        broken[k, 1] = 1.6
        assert not joined.get_along(broken, yaw, apart)
        assert joined.get_along(middles, yaw, apart)
        assert joined.get_along(middles[:2], yaw[:2], apart[:2])  # A way that ends before.
