"""Elbows that are turned as asked, about the line from shoulder to wrist, and nothing else of a person."""

import numpy as np
import pytest

from drake_blfdmp.robot.swings import Swings
from drake_blfdmp.robot.swivel import swivel_angle, wrap
from drake_blfdmp.skeleton import ELBOWS, SHOULDERS, WRISTS
from drake_blfdmp.skill.geometry import link_lengths

T = np.linspace(0.0, 2.0, 21)


def person(seed=0):
    """Points (21, 6, 3) of arms that move."""
    rng = np.random.default_rng(seed)
    still = np.array(
        [[-0.2, 0, 1.4], [-0.3, 0.1, 1.1], [-0.15, 0.35, 1.1], [0.2, 0, 1.4], [0.3, 0.1, 1.1], [0.15, 0.35, 1.1]]
    )
    return still + 0.05 * np.cumsum(rng.normal(size=(21, 6, 3)), axis=0) / 5.0


def angles(x):
    return swivel_angle(x[:, SHOULDERS], x[:, ELBOWS], x[:, WRISTS])


@pytest.fixture
def swings():
    return Swings(T, np.stack([np.linspace(0.2, 2.0, 21), np.linspace(4.0, 3.0, 21)], axis=-1))


def test_the_elbows_have_the_angles_and_the_rest_stays(swings):
    x = person()
    swung = swings.of(T, x)
    np.testing.assert_allclose(wrap(angles(swung) - swings.angle), 0.0, atol=1e-9)
    np.testing.assert_allclose(link_lengths(swung), link_lengths(x), atol=1e-12)
    np.testing.assert_array_equal(swung[:, [0, 2, 3, 5]], x[:, [0, 2, 3, 5]])


def test_between_the_times_they_are_interpolated_and_outside_held(swings):
    x = person()[:3]
    swung = swings.of(np.array([-1.0, 0.05, 9.0]), x)
    expected = [swings.angle[0], swings.angle[:2].mean(axis=0), swings.angle[-1]]
    np.testing.assert_allclose(wrap(angles(swung) - expected), 0.0, atol=1e-9)


def test_how_far_they_turn(swings):
    x = person()
    assert swings.farthest(T, x) == pytest.approx(np.abs(wrap(swings.angle - angles(x))).max())
    assert swings.farthest(T, swings.of(T, x)) < 1e-9


def test_what_was_learned_is_corrected_to_what_was_wanted(swings):
    """A learner that always falls short by a tenth of the change is made up for."""
    x = person()
    taught = swings
    for _ in range(20):
        learned = x + 0.9 * (taught.of(T, x) - x)
        taught = taught.corrected(swings, T, learned)
    lacking = wrap(swings.angle - angles(x + 0.9 * (taught.of(T, x) - x)))
    once = wrap(swings.angle - angles(x + 0.9 * (swings.of(T, x) - x)))
    assert np.abs(lacking).max() < 0.05 * np.abs(once).max()
