"""Hands that close and open about a middle that stands still."""

import numpy as np
import pytest

from drake_blfdmp.demonstration.timing import TaskMotion
from drake_blfdmp.planning.moved_carry import HandsMiddle
from drake_blfdmp.planning.steady import RAMP_S, SHORT_RAMP_S, WORTH, Dwells, Steadied, swing
from drake_blfdmp.skill.geometry import link_lengths

EVENTS = {"grasp": 1.0, "grasp_end": 2.0, "release": 5.0, "release_end": 6.0}
T = np.linspace(0.0, 7.0, 1401)
WHOLE = Dwells.of(EVENTS)


def made(middle):
    """A motion whose hands have that middle, and points that differ from each other."""
    x = np.random.default_rng(0).normal(size=(6, 3))[None] + 0.0 * T[:, None, None]
    x = x + (middle - 0.5 * (x[:, 2] + x[:, 5]))[:, None]
    return TaskMotion(t=T, x=x, recorded=T, events=EVENTS)


def test_it_stands_still_in_both_dwells_and_nowhere_else():
    share = WHOLE.stillness(T)
    dwell = ((T >= 1.0) & (T <= 2.0)) | ((T >= 5.0) & (T <= 6.0))
    np.testing.assert_allclose(share[dwell], 1.0, atol=1e-12)
    away = np.min([np.maximum(a - T, T - b) for a, b in ((1.0, 2.0), (5.0, 6.0))], axis=0) > RAMP_S
    np.testing.assert_allclose(share[away], 0.0, atol=1e-12)
    assert np.abs(np.diff(share)).max() < 0.06


def test_only_what_swings_in_the_dwells_is_taken_out():
    drift = 0.03 * np.sin(1.3 * T)[:, None] * [1.0, -0.5, 0.2]
    left = drift - swing(T, drift, WHOLE)
    for a, b in ((1.0, 2.0), (5.0, 6.0)):
        assert np.ptp(left[(a <= T) & (b >= T)], axis=0).max() < 1e-6
    carry = (T > 2.0 + RAMP_S) & (T < 5.0 - RAMP_S)
    np.testing.assert_allclose(left[carry], drift[carry], atol=1e-9)
    # Before and after it goes as it went, from elsewhere.
    before = T < 1.0 - RAMP_S
    np.testing.assert_allclose(np.diff(left[before], axis=0), np.diff(drift[before], axis=0), atol=1e-12)


def test_a_carry_that_is_fast_beside_the_dwells_is_left_alone():
    """What the hands' middle does while they close and open is taken out, and next to nothing of the way between."""
    drift = 0.03 * np.sin(1.3 * T)[:, None] * [1.0, -0.5, 0.2]
    moving = Dwells.while_moving(EVENTS, (1.85, 5.15))
    change = swing(T, drift, moving)
    for a, b in ((1.0, 1.85), (5.15, 6.0)):
        assert np.ptp((drift - change)[(a <= T) & (b >= T)], axis=0).max() < 1e-6
    between = (T > 1.85 + SHORT_RAMP_S) & (T < 5.15 - SHORT_RAMP_S)
    np.testing.assert_allclose(moving.stillness(T)[between], 0.0, atol=1e-12)
    carry = (T > 2.0) & (T < 5.0)
    np.testing.assert_allclose(change[carry], 0.0, atol=1e-9)
    motion = made(drift)
    np.testing.assert_allclose(
        HandsMiddle(Steadied(motion, T, drift, moving)[0])[carry], HandsMiddle(motion)[carry], atol=1e-9
    )


def test_no_length_changes():
    drift = 0.03 * np.sin(1.3 * T)[:, None] * [1.0, -0.5, 0.2]
    motion = made(drift)
    steadied, largest = Steadied(motion, T, drift)
    assert largest == pytest.approx(np.linalg.norm(swing(T, drift, WHOLE), axis=1).max())
    np.testing.assert_allclose(link_lengths(steadied.x), link_lengths(motion.x), atol=1e-12)
    assert np.abs(steadied.x - motion.x).max() > 0.01


def test_what_is_not_worth_it_stays():
    motion = made(0.0 * T[:, None] * np.ones(3))
    drift = 0.3 * WORTH * np.sin(T)[:, None] * np.ones(3)
    assert Steadied(motion, T, drift) == (motion, 0.0)


def test_the_planned_hands_close_and_open_about_a_point(default_plan):
    """The law brings hands that were recorded nearer to each other to the box's width without dragging it."""
    plan = default_plan
    for name in ("grasp", "release"):
        dwell = [plan.task.skill.events[event] for event in (name, f"{name}_end")]
        inside = (plan.coupled.t >= dwell[0]) & (plan.coupled.t <= dwell[1])
        lengths = link_lengths(plan.coupled.x[inside])[:, 2]
        assert np.ptp(lengths) > 0.09
        assert np.ptp(HandsMiddle(plan.coupled)[inside], axis=0).max() < 1e-3
