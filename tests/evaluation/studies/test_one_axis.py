from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drake_blfdmp.evaluation.studies.one_axis import (
    OneAxis,
    growing,
    lagged_roots,
    lagged_slopes,
    other_sign_acceleration,
    run_one_axis,
    swinging,
)
from drake_blfdmp.skill.laws.follower import PublishedGains, follower_acceleration
from drake_blfdmp.skill.laws.published_lagged import as_lagged

UNIT = PublishedGains(k_z=1.0, d_z=1.0, largest_rate=1e3)
MOVING = OneAxis(distance=swinging(0.3, 0.1, 3.0), start=-0.3, gains=UNIT, time_step=5e-4, duration=1.0)


def test_a_moving_band_is_crossed_without_and_kept_with_feed_forward():
    assert run_one_axis(MOVING).left_at == pytest.approx(0.034, abs=0.001)
    fed = run_one_axis(replace(MOVING, fed_forward=True))
    assert fed.left_at == np.inf and np.abs(fed.error).max() < 1e-3
    assert np.ptp(fed.middle) > 0.09


def test_the_goal_cancels():
    one, other = (run_one_axis(replace(MOVING, goal=goal, fed_forward=True)) for goal in (-0.15, 0.4))
    assert np.abs(one.x - other.x).max() < 1e-3 * (0.4 + 0.15)  # Of how far the goals are apart.


def test_the_other_sign_leaves_a_constant_band():
    trial = OneAxis(gains=PublishedGains(), start=-0.299, time_step=5e-4, duration=0.5)
    assert run_one_axis(trial).left_at == np.inf
    assert run_one_axis(replace(trial, sign=-1)).left_at < 0.1


def test_the_signs_agree_at_the_middle_and_differ_off_it():
    arguments = (0.0, -0.01, 0.01, 0.2, 0.5, 1.0, UNIT)
    at = [law(0.0, *arguments) for law in (follower_acceleration, other_sign_acceleration)]
    off = [law(0.002, *arguments) for law in (follower_acceleration, other_sign_acceleration)]
    assert at[0] - at[1] == pytest.approx(2 * 0.2)  # Only the rates of z_1 differ.
    assert off[0] < at[0] and off[1] > at[1]


@given(p=st.floats(0.0, 1e6), c=st.floats(0.1, 1e4), h=st.floats(1e-5, 0.1))
def test_one_root_lies_below_minus_one(p, c, h):
    roots = lagged_roots(p, c, h)
    matrix = np.array([[1 - h * h * p / 2, h - h * h * c / 2, -h * h / 2], [-h * p, 1 - h * c, -h], [-p, -c, -1.0]])
    np.testing.assert_allclose(np.poly(roots), np.poly(matrix), rtol=1e-6, atol=1e-6 * (1 + h * c + h * h * p))
    real = roots[np.abs(roots.imag) < 1e-9].real
    assert real.min() < -1.0 + 1e-12
    assert abs(np.prod(roots) + 1.0) < 1e-6 * max(1.0, np.abs(roots).max() ** 2)


@pytest.mark.parametrize("step", [1e-3, 4e-3])
def test_the_lagged_reading_grows_as_predicted_and_leaves(step):
    trial = OneAxis(reading=as_lagged, gains=PublishedGains(), time_step=step, push=1e-9, duration=0.5)
    predicted = np.abs(lagged_roots(*lagged_slopes(trial), step)).max()
    run = run_one_axis(trial)
    small = np.argmax(np.abs(run.error) > 1e-3)
    change = np.abs(np.diff(run.acceleration[:small]))
    assert len(change) > 8
    assert change[-1] / change[-2] == pytest.approx(predicted, rel=0.01)
    assert run.left_at < 0.5


def test_growing_measures_that_while_it_is_linear():
    trial = OneAxis(reading=as_lagged, gains=PublishedGains(), time_step=1e-3, push=1e-9, duration=0.5)
    found = growing(trial)
    assert found.measured == pytest.approx(found.predicted, rel=1e-4) and found.predicted > 1.2
    assert len(found.change) < len(run_one_axis(trial).t) - 1  # Ends where the band is no longer flat.
    np.testing.assert_allclose(found.change[-1] / found.change[-2], found.predicted, rtol=0.01)


def test_a_trial_that_overflows_ends():
    trial = OneAxis(reading=as_lagged, gains=PublishedGains(), time_step=4e-3, push=1e-3, duration=2.0)
    run = run_one_axis(trial)
    assert len(run.t) < 501 and np.all(np.isfinite(run.x))
