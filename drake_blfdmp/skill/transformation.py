"""The transformation system (1), written as in (6): a spring and damper pulled to the goal and pushed by the forcing.

The state is the paper's (x, v) with v = tau x'. "Velocity" and "acceleration" without a qualifier are x' and x'',
in m/s and m/s^2. Every function broadcasts and takes float, AutoDiffXd or Expression entries.
"""

import numpy as np
from scipy.linalg import expm


def nominal_acceleration(x, v, f, goal, tau, alpha_z, beta_z):
    """X'' of the uncoupled system (1): (alpha_z (beta_z (g - x) - v) + f) / tau^2."""
    return (alpha_z * (beta_z * (goal - x) - v) + f) / tau**2


def derivatives(x, v, f, goal, coupling_acceleration, tau, alpha_z, beta_z):
    """X' and v' of the coupled system: (6) with u = f / tau + tau times the coupling acceleration (m/s^2)."""
    a = nominal_acceleration(x, v, f, goal, tau, alpha_z, beta_z)
    return v / tau, tau * (a + coupling_acceleration)


def step_matrices(dt: float, tau: float | np.ndarray, alpha_z: float, beta_z: float) -> tuple[np.ndarray, np.ndarray]:
    """The exact solution of (1) over one step with all inputs held.

    With e = x - g and a constant forcing f, (e, v)(t + dt) = A (e, v)(t) + b f.

    Args:
        tau: time scale (...), s.

    Returns:
        A (..., 2, 2), b (..., 2).
    """
    rate = 1.0 / np.asarray(tau, dtype=float)
    m = np.zeros((*rate.shape, 3, 3))
    m[..., 0, 1] = rate
    m[..., 1, :] = np.array([-alpha_z * beta_z, -alpha_z, 1.0]) * rate[..., None]
    e = expm(m * dt)
    return e[..., :2, :2], e[..., :2, 2]


def uncoupled_step(x, v, f, goal, matrices):
    """The state of (1) one step later; `matrices` are those of `step_matrices`."""
    a, b = matrices
    e = x - goal
    return (
        goal + a[..., 0, 0] * e + a[..., 0, 1] * v + b[..., 0] * f,
        a[..., 1, 0] * e + a[..., 1, 1] * v + b[..., 1] * f,
    )


def mean_acceleration(x, v, f, goal, tau, matrices, dt):
    """X'' of the uncoupled system averaged over the coming step: what the coupling of a sampled system must cancel."""
    return (uncoupled_step(x, v, f, goal, matrices)[1] - v) / (tau * dt)


def step(x, v, f, goal, coupling_acceleration, tau, matrices, dt):
    """The state one step later, the coupling acceleration (m/s^2) held.

    The coupling acts beside the spring and damper and not through them: so the velocity changes by exactly dt times
    the mean uncoupled acceleration plus the coupling, and what the law demands is met over the whole step.
    """
    x, v = uncoupled_step(x, v, f, goal, matrices)
    return x + 0.5 * dt**2 * coupling_acceleration, v + tau * dt * coupling_acceleration


def target_forcing(x, velocity, acceleration, goal, tau, alpha_z, beta_z):
    """The forcing (4) that makes (1) follow a demonstrated x, x', x''."""
    return tau**2 * acceleration - alpha_z * (beta_z * (goal - x) - tau * velocity)
