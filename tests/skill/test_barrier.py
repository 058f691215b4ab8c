"""The law's proof, checked by symbolic differentiation, and its functions against finite differences."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydrake.symbolic import Expression, Variable, log
from scipy.integrate import solve_ivp

from drake_blfdmp.skill.barrier import (
    barrier_derivative,
    barrier_function,
    error_acceleration,
    length_acceleration,
    normalised_error,
)

XI, XI_DOT, K_1, K_2 = (Variable(name) for name in ("xi", "xi_dot", "k_1", "k_2"))


def symbols(*variables):
    return tuple(Expression(v) for v in variables)


def test_the_barriers_derivative_along_the_law_is_the_one_claimed():
    """V' - claimed, times 1 - xi^2, is a polynomial of degree 3 in xi: its expansion must vanish identically."""
    xi, xi_dot, k_1, k_2 = symbols(XI, XI_DOT, K_1, K_2)
    z_2 = xi_dot + k_1 * xi
    v = -0.5 * log(1 - xi * xi) + 0.5 * z_2 * z_2
    xi_ddot = error_acceleration(xi, xi_dot, k_1, k_2)
    v_dot = v.Differentiate(XI) * xi_dot + v.Differentiate(XI_DOT) * xi_ddot
    claimed = barrier_derivative(xi, xi_dot, k_1, k_2)

    # With u for 1 / (1 - xi^2), a variable of its own, both sides are polynomials.
    u = Variable("u")
    law = -xi * Expression(u) - k_2 * z_2 - k_1 * xi_dot
    by_hand = xi * Expression(u) * xi_dot + z_2 * (law + k_1 * xi_dot)
    rational = -k_1 * xi * xi * Expression(u) - k_2 * z_2 * z_2
    assert (by_hand - rational).Expand().EqualTo(Expression(0.0))

    # And the package's functions are those two sides.
    for seed in range(200):
        rng = np.random.default_rng(seed)
        env = {
            XI: rng.uniform(-0.99, 0.99),
            XI_DOT: rng.normal() * 5,
            K_1: rng.uniform(0.1, 50),
            K_2: rng.uniform(0.1, 50),
        }
        full = env | {u: 1.0 / (1.0 - env[XI] ** 2)}
        value = claimed.Evaluate(env)
        tolerance = 1e-9 * max(1.0, abs(value), abs(xi_ddot.Evaluate(env) * z_2.Evaluate(env)))
        assert abs(v_dot.Evaluate(env) - value) < tolerance
        assert abs(rational.Evaluate(full) - value) < tolerance
        assert abs(law.Evaluate(full) - xi_ddot.Evaluate(env)) < tolerance


@given(
    xi=st.fractions(Fraction(-99, 100), Fraction(99, 100), max_denominator=1000),
    xi_dot=st.fractions(-20, 20, max_denominator=100),
    k_1=st.fractions(Fraction(1, 10), 50, max_denominator=50),
    k_2=st.fractions(Fraction(1, 10), 50, max_denominator=50),
)
def test_the_identity_holds_exactly_in_rational_numbers(xi, xi_dot, k_1, k_2):
    xi_ddot = -xi / (1 - xi * xi) - k_2 * (xi_dot + k_1 * xi) - k_1 * xi_dot
    assert float(xi_ddot) == pytest.approx(
        error_acceleration(float(xi), float(xi_dot), float(k_1), float(k_2)), rel=1e-9, abs=1e-9
    )
    z_2 = xi_dot + k_1 * xi
    v_dot = xi / (1 - xi * xi) * xi_dot + z_2 * (xi_ddot + k_1 * xi_dot)
    assert v_dot == -k_1 * xi**2 / (1 - xi**2) - k_2 * z_2**2
    if (xi, xi_dot) != (0, 0):
        assert v_dot < 0
        assert barrier_derivative(float(xi), float(xi_dot), float(k_1), float(k_2)) < 0


def test_a_moving_band_is_differentiated_correctly():
    """Rho = m(t) + w(t) xi(t) differentiated twice by pydrake.symbolic is what `length_acceleration` returns."""
    t = Variable("t")
    time = Expression(t)
    m = 0.3 + 0.05 * time - 0.02 * time * time
    w = 0.01 + 0.03 * time + 0.04 * time * time * time
    xi = 0.4 - 0.3 * time + 0.2 * time * time
    rho = m + w * xi
    first = rho.Differentiate(t)
    lower, upper = m - w, m + w
    rows = [lower, upper]
    for order in (1, 2):
        for row in rows[2 * order - 2 : 2 * order]:
            rows.append(row.Differentiate(t))
    bands = np.array(rows)[:, None]
    got_xi, got_rate = normalised_error(np.array([rho]), np.array([first]), bands)
    got = length_acceleration(
        np.array([xi]), np.array([xi.Differentiate(t)]), np.array([xi.Differentiate(t).Differentiate(t)]), bands
    )
    for value in (0.0, 0.3, 1.1):
        env = {t: value}
        assert got_xi[0].Evaluate(env) == pytest.approx(xi.Evaluate(env), abs=1e-12)
        assert got_rate[0].Evaluate(env) == pytest.approx(xi.Differentiate(t).Evaluate(env), abs=1e-12)
        assert got[0].Evaluate(env) == pytest.approx(first.Differentiate(t).Evaluate(env), abs=1e-12)


@given(xi=st.floats(-0.999, 0.999), xi_dot=st.floats(-10, 10), k_1=st.floats(0.1, 50))
def test_the_barrier_is_positive_off_the_origin_and_infinite_at_the_edges(xi, xi_dot, k_1):
    assert barrier_function(xi, xi_dot, k_1) >= 0.0
    assert barrier_function(0.0, 0.0, k_1) == 0.0
    assert barrier_function(1.0 - 1e-15, -k_1, k_1) > 15.0


@pytest.mark.parametrize("start", [(0.9, 10.0), (-0.99, -3.0), (0.0, 8.0)])
def test_the_barrier_falls_along_the_continuous_law(start):
    k_1, k_2 = 8.0, 20.0
    solution = solve_ivp(
        lambda _, z: (z[1], error_acceleration(z[0], z[1], k_1, k_2)), (0.0, 2.0), start, rtol=1e-10, atol=1e-12
    )
    v = barrier_function(*solution.y, k_1)
    assert np.abs(solution.y[0]).max() < 1.0
    assert np.all(np.diff(v) < 1e-12)
    assert v[-1] < 1e-6
