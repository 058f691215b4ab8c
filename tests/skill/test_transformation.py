import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from drake_blfdmp.skill.transformation import (
    derivatives,
    mean_acceleration,
    nominal_acceleration,
    step,
    step_matrices,
    target_forcing,
)

ALPHA, BETA = 25.0, 6.25
TIMES = np.array([0.1, 0.2, 0.5, 1.0])
REFERENCE = [0.355364207, 0.712702505, 0.986004208, 0.999949690]


def unforced_discrete(tau, dt, end):
    """Positions from 0 to 1 at t = 0, dt, ..., end."""
    matrices = step_matrices(dt, tau, ALPHA, BETA)
    x, v, path = 0.0, 0.0, [0.0]
    for _ in range(round(end / dt)):
        x, v = step(x, v, 0.0, 1.0, 0.0, tau, matrices, dt)
        path.append(x)
    return np.array(path)


@pytest.mark.parametrize("dt", [0.1, 0.01, 0.001])
def test_the_discrete_unforced_response_has_the_reference_values_at_any_step(dt):
    path = unforced_discrete(1.0, dt, 1.0)
    np.testing.assert_allclose(path[np.round(TIMES / dt).astype(int)], REFERENCE, atol=1e-8)


def test_the_continuous_unforced_response_has_the_reference_values():
    def rate(_, state):
        return derivatives(state[0], state[1], 0.0, 1.0, 0.0, 1.0, ALPHA, BETA)

    solution = solve_ivp(rate, (0.0, 1.0), [0.0, 0.0], t_eval=TIMES, rtol=1e-11, atol=1e-13)
    np.testing.assert_allclose(solution.y[0], REFERENCE, atol=1e-8)


@given(
    st.floats(1e-5, 0.5), st.floats(0.2, 20.0), st.floats(1.0, 200.0), st.sampled_from([0.05, 0.2, 0.25, 0.3, 1.0, 4.0])
)
def test_the_step_is_the_matrix_exponential_whatever_the_damping(dt, tau, alpha, ratio):
    beta = ratio * alpha
    system = np.array([[0.0, 1.0, 0.0], [-alpha * beta, -alpha, 1.0], [0.0, 0.0, 0.0]]) / tau
    want = expm(system * dt)
    a, b = step_matrices(dt, tau, alpha, beta)
    size = np.abs(want[:2, :2]).max()
    np.testing.assert_allclose(a, want[:2, :2], rtol=1e-9, atol=1e-11 * size)
    np.testing.assert_allclose(b, want[:2, 2], rtol=1e-6, atol=1e-12)


def test_the_steps_of_a_batch_are_each_ones_own():
    a, b = step_matrices(0.02, np.array([[1.0], [3.0]]), ALPHA, BETA)
    assert a.shape == (2, 1, 2, 2) and b.shape == (2, 1, 2)
    for k, tau in enumerate((1.0, 3.0)):
        np.testing.assert_array_equal(a[k, 0], step_matrices(0.02, tau, ALPHA, BETA)[0])


@pytest.mark.parametrize("tau", [2.0, 4.0])
def test_another_duration_gives_the_same_path(tau):
    np.testing.assert_allclose(unforced_discrete(tau, 0.01 * tau, tau), unforced_discrete(1.0, 0.01, 1.0), atol=1e-12)


def test_a_constant_coupling_moves_the_mean_acceleration_by_itself():
    rng = np.random.default_rng(0)
    x, v, f, goal, coupling = rng.normal(size=(5, 6, 3))
    tau, dt = 3.0, 0.02
    matrices = step_matrices(dt, tau, ALPHA, BETA)
    mean = mean_acceleration(x, v, f, goal, tau, matrices, dt)
    _, later = step(x, v, f, goal, coupling, tau, matrices, dt)
    np.testing.assert_allclose((later - v) / (tau * dt), mean + coupling, atol=1e-12)


def test_the_mean_acceleration_tends_to_the_nominal_one():
    rng = np.random.default_rng(1)
    x, v, f, goal = rng.normal(size=(4, 6, 3))
    nominal = nominal_acceleration(x, v, f, goal, 3.0, ALPHA, BETA)
    errors = [
        np.abs(mean_acceleration(x, v, f, goal, 3.0, step_matrices(dt, 3.0, ALPHA, BETA), dt) - nominal).max()
        for dt in (0.01, 0.005)
    ]
    assert 0.0 < errors[1] < 0.55 * errors[0]


def test_the_target_forcing_reproduces_the_demonstrated_acceleration():
    rng = np.random.default_rng(2)
    x, velocity, acceleration, goal = rng.normal(size=(4, 50, 18))
    tau = 2.5
    f = target_forcing(x, velocity, acceleration, goal, tau, ALPHA, BETA)
    np.testing.assert_allclose(
        nominal_acceleration(x, tau * velocity, f, goal, tau, ALPHA, BETA), acceleration, atol=1e-11
    )
