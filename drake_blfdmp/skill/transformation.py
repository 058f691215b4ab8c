"""The transformation system (1), written as in (6): a spring and damper pulled to the goal and pushed by the forcing.

The state is the paper's (x, v) with v = tau x'. "Velocity" and "acceleration" without a qualifier are x' and x'',
in m/s and m/s^2. Every function broadcasts and takes float, AutoDiffXd or Expression entries.
"""

import numpy as np
from scipy.linalg import expm


def nominal_acceleration(x, v, f, goal, tau, alpha_z, beta_z):
    """x'' of the uncoupled system (1): (alpha_z (beta_z (g - x) - v) + f) / tau^2."""
    return (alpha_z * (beta_z * (goal - x) - v) + f) / tau**2


def derivatives(x, v, f, goal, coupling_acceleration, tau, alpha_z, beta_z):
    """x' and v' of the coupled system: (6) with u = f / tau + tau times the coupling acceleration (m/s^2)."""
    a = nominal_acceleration(x, v, f, goal, tau, alpha_z, beta_z)
    return v / tau, tau * (a + coupling_acceleration)


def step_matrices(dt: float, tau: float, alpha_z: float, beta_z: float) -> tuple[np.ndarray, np.ndarray]:
    """The exact solution of (1) over one step with all inputs held.

    With e = x - g and a constant push p = f + tau^2 coupling, (e, v)(t + dt) = A (e, v)(t) + b p.

    Returns:
        A (2, 2), b (2,).
    """
    m = np.zeros((3, 3))
    m[0, 1] = 1.0 / tau
    m[1] = np.array([-alpha_z * beta_z, -alpha_z, 1.0]) / tau
    e = expm(m * dt)
    return e[:2, :2], e[:2, 2]


def step(x, v, f, goal, coupling_acceleration, tau, matrices):
    """The state one step later; `matrices` are those of `step_matrices`."""
    (a, b) = matrices
    e = x - goal
    p = f + tau**2 * coupling_acceleration
    return goal + a[0, 0] * e + a[0, 1] * v + b[0] * p, a[1, 0] * e + a[1, 1] * v + b[1] * p


def target_forcing(x, velocity, acceleration, goal, tau, alpha_z, beta_z):
    """The forcing (4) that makes (1) follow a demonstrated x, x', x''."""
    return tau**2 * acceleration - alpha_z * (beta_z * (goal - x) - tau * velocity)
