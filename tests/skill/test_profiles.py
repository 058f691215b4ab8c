import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydrake.autodiffutils import AutoDiffXd
from pydrake.symbolic import Expression, Variable

from drake_blfdmp.errors import ScenarioError, SkillError
from drake_blfdmp.skill.profiles import (
    ConstantDistance,
    HandDistance,
    RecordedDistance,
    smooth_step,
    softly_at_least,
)

HANDS = HandDistance(open_m=0.37, closed_m=0.27, close_s=1.0, open_s=4.0, duration_s=0.8)


@given(st.floats(-0.5, 1.5))
def test_the_steps_derivatives_are_those_of_the_step(u):
    h = 1e-5
    rate = (smooth_step(u + h)[0] - smooth_step(u - h)[0]) / (2 * h)
    acceleration = (smooth_step(u + h)[1] - smooth_step(u - h)[1]) / (2 * h)
    np.testing.assert_allclose(smooth_step(u)[1:], (rate, acceleration), atol=2e-3 * h / 1e-5 * 0.5)


def test_the_step_goes_from_0_to_1_and_is_smooth_at_both_ends():
    for end, value in ((0.0, 0.0), (1.0, 1.0)):
        for side in (-1e-9, 0.0, 1e-9):
            np.testing.assert_allclose(smooth_step(end + side), (value, 0.0, 0.0), atol=1e-7)
    np.testing.assert_allclose(smooth_step(0.5), (0.5, 1.875, 0.0), atol=1e-15)
    np.testing.assert_array_equal(smooth_step(np.array([-3.0, 7.0]))[0], [0.0, 1.0])


def test_the_hands_open_close_hold_and_open():
    d, rate, _ = HANDS.evaluate(np.array([0.0, 1.0, 1.4, 1.8, 3.9, 4.4, 5.0]))
    np.testing.assert_allclose(d, [0.37, 0.37, 0.32, 0.27, 0.27, 0.32, 0.37], atol=1e-15)
    assert rate[2] < 0 < rate[5]


def test_the_hands_derivatives_are_those_of_the_distance():
    t, h = np.linspace(0.5, 5.5, 301) + 1.7e-4, 1e-5
    d, rate, acceleration = HANDS.evaluate(t)
    np.testing.assert_allclose(rate, (HANDS.evaluate(t + h)[0] - HANDS.evaluate(t - h)[0]) / (2 * h), atol=1e-8)
    np.testing.assert_allclose(acceleration, (HANDS.evaluate(t + h)[1] - HANDS.evaluate(t - h)[1]) / (2 * h), atol=1e-6)
    assert d.shape == t.shape


def test_a_constant_distance_does_not_move():
    d, rate, acceleration = ConstantDistance(0.3).evaluate(np.zeros((4, 2)))
    assert d.shape == (4, 2) and np.all(d == 0.3) and not np.any(rate) and not np.any(acceleration)


def test_an_impossible_profile_is_refused():
    with pytest.raises(ScenarioError, match="positive time"):
        HandDistance(0.37, 0.27, 1.0, 4.0, 0.0)
    with pytest.raises(ScenarioError, match=r"opening at 1\.50 s begins before closing ends at 1\.80 s"):
        HandDistance(0.37, 0.27, 1.0, 1.5, 0.8)
    with pytest.raises(ScenarioError, match=r"positive time, not -0\.2 s"):
        HandDistance(0.37, 0.27, 1.0, 4.0, np.array([0.8, -0.2]))
    with pytest.raises(ScenarioError, match=r"opening at 1\.50 s begins before closing ends at 1\.80 s"):
        HandDistance(0.37, 0.27, 1.0, np.array([4.0, 1.5]), 0.8)


TIMES = np.linspace(0.0, 5.0, 251)


def waved(t):
    """A distance that starts and ends at rest."""
    return 0.4 + 0.2 * np.sin(3.0 * t) * np.sin(np.pi * t / 5.0) ** 4


RECORDED = RecordedDistance(TIMES, waved(TIMES))


def test_a_recorded_distance_is_the_persons_with_its_derivatives():
    t, h = np.linspace(0.1, 4.9, 301), 1e-4
    d, rate, acceleration = RECORDED.evaluate(t)
    np.testing.assert_allclose(d, waved(t), atol=1e-7)
    np.testing.assert_allclose(rate, (waved(t + h) - waved(t - h)) / (2 * h), atol=1e-6)
    np.testing.assert_allclose(acceleration, (waved(t + h) - 2 * waved(t) + waved(t - h)) / h**2, atol=1e-4)


def test_a_recorded_distance_is_held_before_and_after_without_a_step():
    for end, value in ((0.0, 0.4), (5.0, 0.4)):
        for side in (-2.0, -1e-6, 1e-6, 2.0):
            if not 0.0 < end + side < 5.0 or abs(side) < 1.0:
                np.testing.assert_allclose(RECORDED.evaluate(end + side), (value, 0.0, 0.0), atol=2e-3)
    np.testing.assert_array_equal(RECORDED.evaluate(np.array([-3.0, 9.0]))[1:], 0.0)


def test_a_recorded_distance_keeps_the_shape_of_the_times():
    t = np.linspace(0.0, 5.0, 12).reshape(3, 4)
    for part, flat in zip(RECORDED.evaluate(t), RECORDED.evaluate(t.ravel()), strict=True):
        assert part.shape == (3, 4)
        np.testing.assert_array_equal(part.ravel(), flat)


def test_the_gradient_of_a_recorded_distance_is_its_rate():
    for t in (0.5, 2.0, 3.3, 7.0):
        values = RECORDED.evaluate(np.array([AutoDiffXd(t, [2.0, -1.0])]))
        plain = RECORDED.evaluate(np.array([t]))
        for k in range(3):
            assert values[k][0].value() == pytest.approx(plain[k][0], abs=1e-12)
            if k < 2:
                np.testing.assert_allclose(values[k][0].derivatives(), plain[k + 1][0] * np.array([2.0, -1.0]))
    h = 1e-5
    third = (RECORDED.evaluate(1.3 + h)[2] - RECORDED.evaluate(1.3 - h)[2]) / (2 * h)
    gradient = RECORDED.evaluate(np.array(AutoDiffXd(1.3, [1.0])))[2].derivatives()
    np.testing.assert_allclose(gradient, third, rtol=1e-4)


def test_a_recorded_distance_has_no_symbolic_form_and_says_so_in_one_line():
    with pytest.raises(SkillError, match=r"^recorded distance: .* no symbolic form; use [^\n]*$"):
        RECORDED.evaluate(np.array([Expression(Variable("t"))]))


@pytest.mark.parametrize(
    ("t", "distance", "words"),
    [
        (TIMES[:5], waved(TIMES[:5]), "6 samples or more"),
        (TIMES[::-1], waved(TIMES), "increasing times"),
        (TIMES, waved(TIMES)[:-1], "got shapes"),
        (TIMES, 0.0 * TIMES, "positive and finite"),
        (TIMES, np.where(TIMES == 2.0, np.nan, 0.3), "positive and finite"),
    ],
)
def test_samples_that_are_no_distance_over_time_are_refused(t, distance, words):
    with pytest.raises(SkillError, match=f"^recorded distance: [^\n]*{words}[^\n]*$"):
        RecordedDistance(t, distance)


@given(st.floats(-1.0, 2.0), st.floats(0.05, 0.5))
def test_softly_raised_values_keep_what_is_above_and_never_fall_below(value, blend):
    raised = softly_at_least(value, 0.3, blend)
    assert raised >= 0.3
    assert 0.0 <= raised - max(value, 0.3) <= 0.16 * blend
    if value >= 0.3 + blend:
        assert raised == value


def test_softly_raised_values_have_no_kink():
    d, blend = np.linspace(0.0, 0.6, 60001), 0.1
    step = d[1] - d[0]
    raised = softly_at_least(d, 0.3, blend)
    slope = np.diff(raised) / step
    assert slope.min() >= -1e-9 and slope.max() <= 1.0 + 1e-9
    bend = np.diff(slope) / step
    assert np.abs(np.diff(bend)).max() < 1e-2  # Continuous: the bend itself is up to 9.4.
    assert bend.max() == pytest.approx(1.875 / (2 * blend), rel=1e-2)
