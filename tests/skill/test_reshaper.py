import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drake_blfdmp.skeleton import HANDS, LINKS
from drake_blfdmp.skill.geometry import link_states
from drake_blfdmp.skill.reshaper import DEFAULT_MOBILITY, needs, reshape, reshape_limited, solve_chain

seeds = st.integers(0, 2**32 - 1)
ARMS = np.arange(len(LINKS)) != HANDS


def problem(seed, leading=()):
    """Random points, velocities, nominal accelerations, demands and mobilities."""
    rng = np.random.default_rng(seed)
    x, velocity, nominal = (rng.normal(size=(*leading, 6, 3)) * scale for scale in (0.3, 1.0, 3.0))
    return x, velocity, nominal, rng.normal(size=(*leading, 5)) * 10.0, rng.uniform(0.1, 2.0, 6)


def incidence(n):
    """G (5, 18) with G Delta = n^T (Delta_b - Delta_a)."""
    g = np.zeros((len(LINKS), 6, 3))
    for i, link in enumerate(LINKS):
        g[i, link.a], g[i, link.b] = -n[i], n[i]
    return g.reshape(len(LINKS), 18)


def length_accelerations(x, velocity, acceleration):
    _, _, n, centripetal = link_states(x, velocity)
    r = np.stack([acceleration[..., link.b, :] - acceleration[..., link.a, :] for link in LINKS], axis=-2)
    return np.sum(n * r, axis=-1) + centripetal


def test_the_link_states_are_the_derivatives_of_the_lengths():
    x, velocity, acceleration, _, _ = problem(0)
    h = 1e-4

    def lengths(t):
        return link_states(x + t * velocity + 0.5 * t**2 * acceleration, velocity)[0]

    rho, rho_dot, _, _ = link_states(x, velocity)
    np.testing.assert_allclose(rho_dot, (lengths(h) - lengths(-h)) / (2 * h), rtol=1e-5)
    second = (lengths(h) - 2 * rho + lengths(-h)) / h**2
    np.testing.assert_allclose(length_accelerations(x, velocity, acceleration), second, rtol=1e-4, atol=1e-4)


@given(seed=seeds)
def test_all_five_demands_are_met(seed):
    x, velocity, nominal, demanded, mobility = problem(seed)
    delta = reshape(x, velocity, nominal, demanded, mobility)
    scale = np.abs(needs(x, velocity, nominal, demanded)[0]).max() + np.abs(delta).max()
    np.testing.assert_allclose(length_accelerations(x, velocity, nominal + delta), demanded, atol=1e-10 * scale)


@given(seed=seeds)
def test_the_change_is_the_weighted_least_one(seed):
    """Minimise 1/2 Delta^T W^-1 Delta subject to G Delta = need, solved by its optimality conditions."""
    x, velocity, nominal, demanded, mobility = problem(seed)
    need, n = needs(x, velocity, nominal, demanded)
    g = incidence(n)
    weight = np.diag(1.0 / np.repeat(mobility, 3))
    kkt = np.block([[weight, g.T], [g, np.zeros((5, 5))]])
    want = np.linalg.solve(kkt, np.concatenate([np.zeros(18), need]))[:18].reshape(6, 3)
    got = reshape(x, velocity, nominal, demanded, mobility)
    np.testing.assert_allclose(got, want, atol=1e-9 * np.linalg.cond(kkt) ** 0.5 * np.abs(want).max())


@given(seed=seeds)
def test_the_elimination_along_the_chain_is_the_dense_solution(seed):
    x, velocity, nominal, demanded, mobility = problem(seed)
    need, n = needs(x, velocity, nominal, demanded)
    g, w = incidence(n), np.diag(np.repeat(mobility, 3))
    dense = np.linalg.solve(g @ w @ g.T, need)
    np.testing.assert_allclose(solve_chain(n, need, mobility), dense, rtol=1e-7, atol=1e-9 * np.abs(dense).max())


def test_nothing_is_changed_that_is_right_already():
    x, velocity, nominal, _, _ = problem(3)
    demanded = length_accelerations(x, velocity, nominal)
    np.testing.assert_allclose(reshape(x, velocity, nominal, demanded), 0.0, atol=1e-12)


@pytest.mark.parametrize("leading", [(4,), (2, 3)])
def test_leading_axes_are_independent_problems(leading):
    x, velocity, nominal, demanded, mobility = problem(5, leading)
    together = reshape(x, velocity, nominal, demanded, mobility)
    limited, given_up = reshape_limited(x, velocity, nominal, demanded, 8.0, mobility)
    assert together.shape == limited.shape == (*leading, 6, 3) and given_up.shape == leading
    for i in np.ndindex(leading):
        np.testing.assert_allclose(
            together[i], reshape(x[i], velocity[i], nominal[i], demanded[i], mobility), rtol=1e-12
        )
        one, one_given_up = reshape_limited(x[i], velocity[i], nominal[i], demanded[i], 8.0, mobility)
        np.testing.assert_allclose(limited[i], one, rtol=1e-10)
        np.testing.assert_allclose(given_up[i], one_given_up, rtol=1e-10, atol=1e-12)


@given(seed=seeds, limit=st.floats(0.5, 60.0))
def test_a_limit_is_kept_the_arms_come_first_and_what_is_given_up_is_told(seed, limit):
    x, velocity, nominal, demanded, mobility = problem(seed)
    full = reshape(x, velocity, nominal, demanded, mobility)
    got, given_up = reshape_limited(x, velocity, nominal, demanded, limit, mobility)
    scale = 1.0 + np.abs(full).max() + np.abs(got).max()
    met = length_accelerations(x, velocity, nominal + got)
    np.testing.assert_allclose(met[ARMS], demanded[ARMS], atol=1e-8 * scale)
    np.testing.assert_allclose(abs(demanded[HANDS] - met[HANDS]), given_up, atol=1e-8 * scale)

    # The arms' least change with the hands left alone, by its own equations.
    need, n = needs(x, velocity, nominal, demanded)
    g, w = incidence(n)[ARMS], np.diag(np.repeat(mobility, 3))
    alone = (w @ g.T @ np.linalg.solve(g @ w @ g.T, need[ARMS])).reshape(6, 3)

    def largest(delta):
        return np.linalg.norm(nominal + delta, axis=-1).max()

    shares = np.linspace(0.0, 1.0, 1001)
    allowed = [share for share in shares if largest(alone + share * (full - alone)) <= limit]
    share = np.sum((got - alone) * (full - alone)) / np.sum((full - alone) ** 2)
    if allowed:
        assert largest(got) <= limit + 1e-8 * scale
        assert share >= allowed[-1] - 1e-6  # No more is given up than needed.
    elif largest(got) > limit + 1e-8 * scale:
        np.testing.assert_allclose(got, alone, atol=1e-7 * scale)


def test_shoulders_move_less_than_hands():
    x, velocity, nominal, demanded, _ = problem(11, (500,))
    size = np.linalg.norm(reshape(x, velocity, nominal, demanded), axis=-1).mean(axis=0)
    assert DEFAULT_MOBILITY[0] < DEFAULT_MOBILITY[1] < DEFAULT_MOBILITY[2]
    assert size[0] < 0.5 * size[2] and size[3] < 0.5 * size[5]
