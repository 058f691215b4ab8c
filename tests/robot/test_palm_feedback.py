"""What the robot feels: the effective distance, its filter, the lag, and how much tempo that leaves."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drake_blfdmp.robot.palm_feedback import (
    effective_distance,
    filter_matrices,
    filtered,
    kept_share,
    middle_error,
)

WIDTH, COMPLIANCE, TOUCH = 0.3, 4e-4, 10.0
SQUEEZE = WIDTH, COMPLIANCE, TOUCH


@given(st.floats(0.1, 0.6))
def test_without_contact_it_is_the_distance(distance):
    assert effective_distance(distance, 0.0, *SQUEEZE) == pytest.approx(distance, rel=1e-15)


@given(st.floats(0.24, 0.5))
def test_where_all_is_as_believed_it_is_what_was_commanded(commanded):
    """Springs of compliance c in series press a rigid box of width w with (w - rho_c) / c."""
    force = max(0.0, WIDTH - commanded) / COMPLIANCE
    distance = max(WIDTH, commanded)
    assert effective_distance(distance, force, *SQUEEZE) == pytest.approx(commanded, abs=1e-12)


@given(st.floats(-0.02, 0.02), st.floats(15.0, 120.0))
def test_in_contact_it_tells_the_force_whatever_the_width_really_is(error, force):
    assert effective_distance(WIDTH + error, force, *SQUEEZE) == pytest.approx(WIDTH - COMPLIANCE * force)


def test_it_is_continuous_across_the_contact():
    force = np.linspace(0.0, 20.0, 2001)
    assert np.abs(np.diff(effective_distance(0.31, force, *SQUEEZE))).max() < 3e-5


@pytest.mark.parametrize("length", [0.004, 0.1, 1.0])
def test_a_step_of_the_error_is_followed_as_a_critically_damped_filter_does(length):
    rate, t = 12.0, length * np.arange(1, 8)
    offset, offset_rate, found = 0.0, 0.0, []
    for _ in t:
        offset, offset_rate = filtered(offset, offset_rate, 0.01, filter_matrices(rate, length))
        found.append(offset)
    np.testing.assert_allclose(found, 0.01 * (1.0 - (1.0 + rate * t) * np.exp(-rate * t)), atol=1e-14)


def test_the_middle_does_not_feel_a_squeeze():
    palms = np.array([[-0.15, 0.5, 0.9], [0.15, 0.5, 0.9]])
    squeezed = palms + np.array([[0.012, 0, 0], [-0.012, 0, 0]])
    assert middle_error(palms, squeezed) == pytest.approx(0.0, abs=1e-15)
    assert middle_error(palms + np.array([0.0, 0.003, 0.004]), squeezed) == pytest.approx(0.005)


def test_half_the_tempo_is_left_at_slack_and_scale():
    found = kept_share(np.array([0.0, 0.01, 0.03, 0.05]), 0.01, 0.02)
    np.testing.assert_allclose(found, [1.0, 1.0, 0.5, 0.2])
