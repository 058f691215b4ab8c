import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drake_blfdmp.errors import ScenarioError
from drake_blfdmp.skill.profiles import ConstantDistance, HandDistance, smooth_step

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
