"""Speeds that can be braked: persistence of the bounds under any command, sharpness, and the linear limit."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drake_blfdmp.robot.braking import braking_share, braking_speed
from drake_blfdmp.robot.differential_ik import DEFAULT_GAINS, velocity_bounds, within_reach

STEP = 0.004
gains = st.floats(0.5, 200.0)
accelerations = st.floats(0.1, 100.0)
rooms = st.floats(0.0, 6.0)
seeds = st.integers(0, 2**32 - 1)


@given(rooms, gains, accelerations, st.floats(0.0, 1.0))
def test_after_a_step_within_the_bound_braking_is_within_the_bound(room, gain, acceleration, share):
    """The claim of `braking`: recursive feasibility of one limit."""
    v = share * braking_speed(room, gain, acceleration, STEP)
    left = room - STEP * v
    assert left >= -1e-12
    assert max(v - acceleration * STEP, 0.0) <= braking_speed(left, gain, acceleration, STEP) + 1e-9


@given(st.floats(0.05, 6.0), accelerations)
def test_the_bound_is_sharp(room, acceleration):
    """With the stiffest approach, a little faster could not be stopped: the bound is not bought by timidity."""
    gain = 1.0 / STEP
    v = 1.02 * float(braking_speed(room, gain, acceleration, STEP)) + 2.0 * acceleration * STEP
    x = 0.0
    while v > 0:
        x, v = x + STEP * v, v - acceleration * STEP
    assert x > room


@given(rooms, gains)
def test_without_a_limit_of_acceleration_the_approach_is_linear(room, gain):
    assert braking_speed(room, gain, np.inf, STEP) == pytest.approx(gain * room)
    assert braking_speed(-room, gain, np.inf, STEP) == 0.0


@given(gains, accelerations)
def test_line_and_parabola_meet_smoothly(gain, acceleration):
    knee = acceleration * (1.0 / gain - 0.5 * STEP) / gain
    h = 1e-5 * knee
    below, at, above = braking_speed(knee + np.array([-h, 0.0, h]), gain, acceleration, STEP)
    assert above - at == pytest.approx(at - below, rel=1e-3)


@given(st.lists(rooms, min_size=2, max_size=6), gains, accelerations)
def test_the_bound_rises_with_the_room_and_arrays_are_computed_as_numbers(values, gain, acceleration):
    values = np.sort(values)
    speeds = braking_speed(values, gain, acceleration, STEP)
    assert np.all(np.diff(speeds) >= 0)
    np.testing.assert_allclose(speeds, [braking_speed(v, gain, acceleration, STEP) for v in values], atol=1e-12)


@given(st.floats(1e-4, 3.0), gains, accelerations)
def test_the_share_of_a_correction_is_the_bounds(error, gain, acceleration):
    share = braking_share(gain**2 * error / acceleration, gain, STEP)
    assert 0.0 < share <= 1.0 + 1e-12
    assert share * gain * error == pytest.approx(braking_speed(error, gain, acceleration, STEP), rel=1e-9)


@given(seeds, st.sampled_from([0.001, 0.004, 0.02]), st.floats(0.0, 0.2))
def test_whatever_the_commands_a_joint_always_has_an_admissible_velocity(seed, step, margin):
    """Position, velocity and acceleration at once, from rest anywhere; commands jump between anything and absurdity."""
    rng = np.random.default_rng(seed)
    own = replace(DEFAULT_GAINS, limit_gain=rng.uniform(1.0, 1.0 / step), limit_margin=margin)
    lower, upper = -rng.uniform(0.3, 3.0, 7), rng.uniform(0.3, 3.0, 7)
    top, acceleration = rng.uniform(0.2, 10.0, 7), rng.uniform(0.5, 50.0, 7)
    q, v = rng.uniform(lower + margin, upper - margin), np.zeros(7)
    for k in range(150):
        least, most = velocity_bounds(q, lower, upper, top, own, acceleration, step)
        low, high = within_reach(least, most, v, acceleration * step)
        # Not only not empty: within the position and velocity bounds AND within reach.
        assert np.all(low <= high)
        assert np.all((low >= least - 1e-9) & (high <= most + 1e-9))
        assert np.all((low >= v - acceleration * step - 1e-12) & (high <= v + acceleration * step + 1e-12))
        if k % 10 == 0:
            command = rng.choice([-1e9, -1.0, 0.0, 1.0, 1e9, rng.normal()], 7)
        v = np.clip(command, low, high)
        q = q + step * v
        assert np.all((q >= lower + margin - 1e-9) & (q <= upper - margin + 1e-9))
        assert np.all(np.abs(v) <= own.velocity_share * top + 1e-12)


def test_a_joint_that_is_too_fast_for_its_bounds_brakes_as_hard_as_it_can():
    low, high = within_reach(np.array([-0.1]), np.array([0.2]), np.array([1.0]), np.array([0.05]))
    assert low[0] == high[0] == pytest.approx(0.95)
    low, high = within_reach(np.array([-0.1]), np.array([0.2]), np.array([-1.0]), np.array([0.05]))
    assert low[0] == high[0] == pytest.approx(-0.95)
