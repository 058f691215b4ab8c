"""The redundancy resolution of one arm: palm first, swivel beneath, limits always; against linear programming."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.optimize import linprog

from drake_blfdmp.robot.differential_ik import (
    DEFAULT_GAINS,
    damped_inverse,
    largest_scale,
    null_interval,
    resolve,
    velocity_bounds,
)

GAINS = DEFAULT_GAINS
WIDE = np.full(7, 1e3)
seeds = st.integers(0, 2**32 - 1)


def random_arm(seed):
    """A well conditioned palm Jacobian (6, 7), a swivel Jacobian with a clear null-space part, and a twist."""
    rng = np.random.default_rng(seed)
    u, _ = np.linalg.qr(rng.normal(size=(6, 6)))
    v, _ = np.linalg.qr(rng.normal(size=(7, 7)))
    jacobian = u @ np.diag(rng.uniform(0.1, 1.5, 6)) @ v[:, :6].T
    swivel = v @ np.append(rng.uniform(-1, 1, 6), rng.choice([-1, 1]) * rng.uniform(0.3, 2.0))
    return jacobian, swivel, rng.uniform(-0.5, 0.5, 6), rng


def random_bounds(rng):
    """low <= 0 <= high; some joints cannot move one way."""
    low, high = -rng.uniform(0, 1.5, 7), rng.uniform(0, 1.5, 7)
    low[rng.random(7) < 0.15] = 0.0
    high[rng.random(7) < 0.15] = 0.0
    return low, high


@given(seeds, st.floats(-2, 2))
def test_without_limits_palm_twist_and_swivel_rate_are_both_met(seed, rate):
    jacobian, swivel, twist, _ = random_arm(seed)
    q_dot, scale = resolve(jacobian, twist, swivel, rate, -WIDE, WIDE, GAINS)
    assert scale == 1.0
    np.testing.assert_allclose(jacobian @ q_dot, twist, atol=1e-9)
    assert swivel @ q_dot == pytest.approx(rate, abs=1e-9)


@given(seeds, st.floats(-2, 2), st.floats(-2, 2))
def test_the_swivel_changes_no_palm_twist(seed, one, other):
    jacobian, swivel, twist, rng = random_arm(seed)
    low, high = random_bounds(rng)
    a, b = (resolve(jacobian, twist, swivel, rate, low, high, GAINS)[0] for rate in (one, other))
    np.testing.assert_allclose(jacobian @ (a - b), 0.0, atol=1e-9)


@given(seeds)
def test_away_from_singularities_the_inverse_is_the_pseudo_inverse(seed):
    jacobian, *_ = random_arm(seed)
    inverse, n = damped_inverse(jacobian, GAINS.singular_value, GAINS.damping)
    np.testing.assert_allclose(inverse, np.linalg.pinv(jacobian), atol=1e-9)
    np.testing.assert_allclose(jacobian @ n, 0.0, atol=1e-12)
    assert np.linalg.norm(n) == pytest.approx(1.0)


@given(seeds, st.floats(-3, 3), st.floats(0.1, 20.0))
def test_bounds_hold_and_the_palm_keeps_its_direction(seed, rate, size):
    jacobian, swivel, twist, rng = random_arm(seed)
    low, high = random_bounds(rng)
    q_dot, scale = resolve(jacobian, size * twist, swivel, rate, low, high, GAINS)
    assert np.all(q_dot >= low - 1e-7)
    assert np.all(q_dot <= high + 1e-7)
    assert 0.0 <= scale <= 1.0
    np.testing.assert_allclose(jacobian @ q_dot, scale * size * twist, atol=1e-7)


@given(seeds, st.floats(-3, 3))
def test_the_swivel_comes_as_near_as_the_bounds_allow(seed, rate):
    """Where the whole twist fits, alpha solves the bounded scalar problem: no other one is nearer to the rate."""
    jacobian, swivel, twist, rng = random_arm(seed)
    low, high = random_bounds(rng)
    q_dot, scale = resolve(jacobian, 0.2 * twist, swivel, rate, low, high, GAINS)
    assume(scale == 1.0)
    inverse, n = damped_inverse(jacobian, GAINS.singular_value, GAINS.damping)
    base = inverse @ (0.2 * twist)
    rows = [(sign * n, sign * (bound - base)) for sign, bound in ((1, high), (-1, low))]
    reach = [
        linprog(
            [c], np.concatenate([r[0] for r in rows])[:, None], np.concatenate([r[1] for r in rows]), bounds=(-99, 99)
        )
        for c in (1.0, -1.0)
    ]
    assume(all(r.status == 0 for r in reach))
    ends = sorted(float(swivel @ (base + r.x[0] * n)) for r in reach)
    assert swivel @ q_dot == pytest.approx(np.clip(rate, *ends), abs=1e-6)


@given(seeds, st.floats(0.1, 20.0))
def test_the_scale_is_the_linear_programmes(seed, size):
    """Largest s in [0, 1] for which some alpha has low <= s base + alpha n <= high, asked of a second solver."""
    rng = np.random.default_rng(seed)
    n = rng.normal(size=7)
    n[rng.random(7) < 0.2] = 0.0  # The null motion of an arm often leaves single joints alone.
    assume(np.any(n))
    base, (low, high) = size * rng.uniform(-1, 1, 7), random_bounds(rng)
    columns = np.stack([base, n], axis=1)
    programme = linprog(
        [-1.0, 0.0], np.vstack([columns, -columns]), np.append(high, -low), bounds=[(0, 1), (None, None)]
    )
    assert programme.status == 0
    assert largest_scale(base, n, low, high) == pytest.approx(programme.x[0], abs=1e-6)


@given(seeds)
def test_the_null_interval_is_where_the_bounds_hold(seed):
    rng = np.random.default_rng(seed)
    n, base = rng.normal(size=7), 0.2 * rng.uniform(-1, 1, 7)
    n[rng.integers(7)] = 0.0
    low, high = random_bounds(rng)
    least, most = null_interval(base, n, low, high)

    def allowed(alpha):
        return bool(np.all((low <= base + alpha * n) & (base + alpha * n <= high)))

    if least < most:
        assert allowed(0.5 * (least + most))
        assert allowed(least + 1e-6 * (most - least))
        assert not allowed(least - 1e-6)
        assert not allowed(most + 1e-6)
    else:
        assert not any(allowed(alpha) for alpha in np.linspace(-3, 3, 200))


def test_where_no_null_motion_helps_the_twist_is_scaled():
    """One joint that the null motion does not move is asked for twice its speed: half the twist is left."""
    jacobian = np.eye(6, 7)
    twist = np.array([2.0, 0.4, 0, 0, 0, 0])
    bounds = np.ones(7)
    q_dot, scale = resolve(jacobian, twist, np.eye(7)[6], 0.3, -bounds, bounds, GAINS)
    assert scale == pytest.approx(0.5)
    np.testing.assert_allclose(q_dot, [1.0, 0.2, 0, 0, 0, 0, 0.3], atol=1e-9)


def test_a_joint_that_may_not_move_at_all_stops_the_palm_but_not_the_swivel():
    jacobian, bounds = np.eye(6, 7), np.ones(7)
    high = bounds.copy()
    high[0] = 0.0
    q_dot, scale = resolve(jacobian, np.array([1.0, 1, 0, 0, 0, 0]), np.eye(7)[6], 0.3, -bounds, high, GAINS)
    assert scale == 0.0
    np.testing.assert_allclose(q_dot, 0.3 * np.eye(7)[6], atol=1e-9)


def test_a_joint_the_null_motion_leaves_alone_counts_however_little_it_moves():
    """Just outside the tolerance of `null_interval`: a scale of 1 would leave it an empty interval, and NaN."""
    base, n = 1.5e-12 * np.eye(7)[0], np.array([0.0, 1, 1, 1, 1, 1, 1]) / np.sqrt(6)
    low, high = -np.ones(7), np.append(0.0, np.ones(6))
    least, most = null_interval(base, n, low, high)
    assert least > most
    assert largest_scale(base, n, low, high) == 0.0


@given(seeds, st.floats(0, 1), st.floats(0, 0.05))
def test_a_singular_arm_moves_at_a_bounded_speed(seed, share, smallest):
    """Two singular values near zero: the undamped inverse would be as large as 1 / smallest."""
    rng = np.random.default_rng(seed)
    u, _ = np.linalg.qr(rng.normal(size=(6, 6)))
    v, _ = np.linalg.qr(rng.normal(size=(7, 7)))
    s = np.append(rng.uniform(0.1, 1.5, 4), [smallest, share * smallest])
    inverse, n = damped_inverse(u @ np.diag(s) @ v[:, :6].T, GAINS.singular_value, GAINS.damping)
    assert np.all(np.isfinite(inverse))
    # The largest gain of s / (s^2 + (1 - s^2 / b^2) d^2) with b = d is 1 / d, at s = d.
    assert np.linalg.norm(inverse, 2) <= 1.0 / GAINS.damping * (1 + 1e-9)
    assert np.linalg.norm(n) == pytest.approx(1.0)


@pytest.mark.parametrize("share", [0.0, 1e-6, 0.5, 0.99])
def test_where_the_null_motion_hardly_turns_the_arm_the_swivel_fades(share):
    """J_psi n under the floor: the joint speed stays under rate / floor and the palm is undisturbed."""
    jacobian, along = np.eye(6, 7), share * GAINS.null_floor
    q_dot, scale = resolve(jacobian, np.zeros(6), along * np.eye(7)[6], 1.0, -WIDE, WIDE, GAINS)
    assert scale == 1.0
    assert abs(q_dot[6]) == pytest.approx(along / GAINS.null_floor**2)
    assert abs(q_dot[6]) <= 1.0 / GAINS.null_floor


@given(seeds, st.floats(1e-4, 0.2))
def test_steps_within_the_bounds_never_leave_the_position_limits(seed, time_step):
    rng = np.random.default_rng(seed)
    lower, upper, top = -rng.uniform(0.5, 3, 7), rng.uniform(0.5, 3, 7), rng.uniform(0.5, 3, 7)
    inner = GAINS.limit_margin
    q = rng.uniform(lower + inner, upper - inner)
    for _ in range(30):
        low, high = velocity_bounds(q, lower, upper, top, GAINS)
        assert np.all(low <= 0)
        assert np.all(high >= 0)
        assert np.all(np.maximum(-low, high) <= GAINS.velocity_share * top)
        q = q + time_step * np.where(rng.random(7) < 0.5, low, high)
        assert np.all(q >= lower + inner - 1e-9)
        assert np.all(q <= upper - inner + 1e-9)


def test_a_joint_beyond_its_limit_may_only_come_back():
    low, high = velocity_bounds(np.array([2.0]), np.array([-1.0]), np.array([1.0]), np.array([2.0]), GAINS)
    assert high[0] == 0.0
    assert low[0] == pytest.approx(-GAINS.velocity_share * 2.0)
    low, high = velocity_bounds(np.array([-2.0]), np.array([-1.0]), np.array([1.0]), np.array([2.0]), GAINS)
    assert low[0] == 0.0
    assert high[0] == pytest.approx(GAINS.velocity_share * 2.0)
    # The nearer the limit, the slower; far from it, the share of the velocity limit.
    _, near = velocity_bounds(np.array([0.8]), np.array([-1.0]), np.array([1.0]), np.array([2.0]), GAINS)
    assert near[0] == pytest.approx(GAINS.limit_gain * (0.2 - GAINS.limit_margin))
    _, far = velocity_bounds(np.array([0.0]), np.array([-1.0]), np.array([1.0]), np.array([0.5]), GAINS)
    assert far[0] == pytest.approx(GAINS.velocity_share * 0.5)
    assert replace(GAINS, velocity_share=0.5).velocity_share == 0.5
