"""The quadratic programme of the last resort: against SciPy, its order of priorities, absurd commands."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import lsq_linear

from drake_blfdmp.robot.differential_ik import largest_scale, null_interval, scale_interval
from drake_blfdmp.robot.nearest_velocity import NULL, PALM, PATH, PROGRESS, nearest_velocities, twist_size

METRIC = np.array([PALM, PALM, PALM, 1.0, 1.0, 1.0])
seeds = st.integers(0, 2**32 - 1)


def random_arm(rng):
    """A palm Jacobian, joint velocities of a twist, bounds around a last velocity that need not allow it."""
    jacobian, last = rng.normal(size=(6, 7)), rng.uniform(-1, 1, 7)
    change = rng.uniform(0.01, 0.3, 7)
    return jacobian, rng.uniform(-1, 1, 7), last - change, last + change


@given(seeds)
@settings(max_examples=40, deadline=None)
def test_it_is_the_weighted_least_squares_solution(seed):
    rng = np.random.default_rng(seed)
    jacobian, base, low, high = random_arm(rng)
    wished = rng.uniform(low, high)
    got, scale = nearest_velocities(jacobian[None], base[None], wished[None], low[None], high[None])
    weighted = PATH * METRIC[:, None] * jacobian
    a = np.zeros((14, 8))
    a[:6] = np.hstack([weighted, -(weighted @ base)[:, None]])
    a[6:13, :7], a[13, 7] = NULL * np.eye(7), PROGRESS
    b = np.concatenate([np.zeros(6), NULL * wished, [PROGRESS]])

    def cost(velocity, share):
        return float(np.sum((a @ np.append(velocity, share) - b) ** 2))

    reference = lsq_linear(a, b, (np.append(low, 0.0), np.append(high, 1.0)), method="bvls", tol=1e-14)
    assert np.all((got >= low) & (got <= high))
    assert 0.0 <= scale[0] <= 1.0
    assert cost(got[0], scale[0]) <= reference.cost * 2.0 * (1.0 + 1e-4) + 1e-6


@given(seeds, st.floats(0.1, 1e6))
@settings(max_examples=40, deadline=None)
def test_a_path_that_can_be_kept_is_kept_at_the_largest_scale(seed, size):
    """Where one arm alone needs no programme, the programme agrees with the closed form."""
    rng = np.random.default_rng(seed)
    u, _ = np.linalg.qr(rng.normal(size=(6, 6)))
    v, _ = np.linalg.qr(rng.normal(size=(7, 7)))
    jacobian = u @ np.diag(rng.uniform(0.2, 1.5, 6)) @ v[:, :6].T
    bound = rng.uniform(0.2, 1.5, 7)
    base = v[:, :6] @ (size * rng.uniform(-0.5, 0.5, 6))
    scale = largest_scale(base, v[:, 6], -bound, bound)
    alpha = np.mean(null_interval(scale * base, v[:, 6], -bound, bound))
    wished = scale * base + alpha * v[:, 6]
    got, share = nearest_velocities(jacobian[None], base[None], wished[None], -bound[None], bound[None])
    assert share[0] == pytest.approx(scale, rel=0.03, abs=1e-9)
    assert twist_size(jacobian @ (got[0] - share[0] * base)) < 2e-3


def test_clearance_comes_before_the_path_and_the_path_before_progress():
    jacobians = np.stack([np.eye(6, 7)] * 2)
    bases, wide = np.zeros((2, 7)), np.full((2, 7), 2.0)
    bases[0, 4], bases[1, 3] = 0.5, 0.5
    rows = np.zeros((1, 14))
    rows[0, 4] = -1.0  # Joint 5 of the left arm closes the distance at its own speed; the palm needs it.
    got, scale = nearest_velocities(jacobians, bases, bases, -wide, wide, rows, np.array([-0.1]))
    np.testing.assert_allclose(scale, [0.2, 1.0], atol=1e-3)
    np.testing.assert_allclose(got, scale[:, None] * bases, atol=1e-3)
    # A pair that must part pushes the palm off its path, as nothing else helps.
    got, scale = nearest_velocities(jacobians, bases, bases, -wide, wide, rows, np.array([0.05]))
    assert got[0, 4] == pytest.approx(-0.05, abs=1e-3)
    assert scale[0] == pytest.approx(0.0, abs=1e-3)


def test_the_null_space_gives_way_first():
    """Joint 7 moves no palm here; a distance it closes is kept by it alone."""
    jacobian, base, wide = np.eye(6, 7)[None], np.full((1, 7), 0.3), np.ones((1, 7))
    base[0, 6] = 0.0
    wished = base.copy()
    wished[0, 6] = 0.8
    rows = np.zeros((1, 7))
    rows[0, 6] = -1.0
    got, scale = nearest_velocities(jacobian, base, wished, -wide, wide, rows, np.array([-0.2]))
    assert scale[0] == pytest.approx(1.0, abs=1e-4)
    np.testing.assert_allclose(got[0], [0.3, 0.3, 0.3, 0.3, 0.3, 0.3, 0.2], atol=1e-4)


@given(seeds)
@settings(max_examples=40, deadline=None)
def test_the_interval_of_scales_is_where_a_null_motion_exists(seed):
    """Bounds that need not contain 0, as acceleration leaves them."""
    rng = np.random.default_rng(seed)
    _, base, low, high = random_arm(rng)
    n = rng.normal(size=7)
    n[rng.random(7) < 0.2] = 0.0
    smallest, largest = scale_interval(base, n, low, high)

    def possible(s):
        a, b = (low - s * base)[n != 0] / n[n != 0], (high - s * base)[n != 0] / n[n != 0]
        alone = np.all((low <= s * base) & (s * base <= high) | (n != 0))
        return bool(alone and np.maximum.reduce(np.minimum(a, b)) <= np.minimum.reduce(np.maximum(a, b)))

    if smallest < largest:
        inside = smallest + np.array([1e-6, 0.5, 1 - 1e-6]) * (largest - smallest)
        assert all(possible(s) for s in inside)
        outside = np.array([smallest, largest]) + 1e-6 * np.array([-1, 1])
        assert not any(possible(s) for s in outside)
    else:
        assert not any(possible(s) for s in np.linspace(-3, 3, 101))
