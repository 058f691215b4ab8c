"""Postures that are found are ones; arms get along a way where they can, not through each other or by a jump."""

import numpy as np
import pytest

from drake_blfdmp.evaluation.robustness import joined_postures
from drake_blfdmp.evaluation.robustness.joined_postures import JoinedPostures
from drake_blfdmp.robot.kinematics import DualArmKinematics
from drake_blfdmp.robot.plant import ARMS, MakeKinematicPlant, ReadJointLimits

EASY = np.array([0.0, 0.47, 0.72])
RISE = np.array([0.1, 0.05, 0.25])
SAMPLES = 9


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
    found = joined._postures(arm, palm, normal, np.empty((0, 7)))
    assert len(found) >= 20  # Of many swivel angles.
    kinematics, q, swivels = DualArmKinematics(plant), np.zeros(14), []
    for posture in found:
        assert np.all(posture >= limits.lower[own]) and np.all(posture <= limits.upper[own])
        q[own] = posture
        state = kinematics.evaluate(q)[arm]
        np.testing.assert_allclose(state.position, palm, atol=1e-5)
        np.testing.assert_allclose(state.rotation[:, 2], normal, atol=1e-5)
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
    assert len(joined._postures(0, EASY, np.array([1.0, 0.0, 0.0]), np.empty((0, 7))))
    assert reached(joined, along(EASY, EASY), apart=-0.12) == 0


def test_a_jump_is_none(joined, monkeypatch):
    middles = along(EASY, EASY + RISE)
    monkeypatch.setattr(joined_postures, "MOVE", 0.01)
    assert reached(joined, middles) == 1


def test_where_another_way_failed_says_nothing_of_one_that_goes_well():
    joined, yaw, apart = JoinedPostures(), np.zeros(SAMPLES), np.full(SAMPLES, 0.3)
    middles = along(EASY, EASY + RISE)
    for k in (4, 4, 8, 0, 2):  # The second time it is looked at there first.
        broken = middles.copy()
        broken[k, 1] = 1.6
        assert not joined.get_along(broken, yaw, apart)
        assert joined.get_along(middles, yaw, apart)
        assert joined.get_along(middles[:2], yaw[:2], apart[:2])  # A way that ends before.
