"""The transformation system (1), written as in (6): a spring and damper pulled to the goal and pushed by the forcing.

The state is the paper's (x, v) with v = tau x'. "Velocity" and "acceleration" without a qualifier are x' and x'',
in m/s and m/s^2. Every function broadcasts and takes float, AutoDiffXd or Expression entries.
"""

import numpy as np


def nominal_acceleration(x, v, f, goal, tau, alpha_z, beta_z):
    """X'' of the uncoupled system (1): (alpha_z (beta_z (g - x) - v) + f) / tau^2."""
    return (alpha_z * (beta_z * (goal - x) - v) + f) / tau**2


def derivatives(x, v, f, goal, coupling_acceleration, tau, alpha_z, beta_z):
    """X' and v' of the coupled system: (6) with u = f / tau + tau times the coupling acceleration (m/s^2)."""
    a = nominal_acceleration(x, v, f, goal, tau, alpha_z, beta_z)
    return v / tau, tau * (a + coupling_acceleration)


CRITICAL = 1e-12
"""Relative difference of beta_z from alpha_z / 4 below which the damping counts as critical."""


def step_matrices(dt, tau, alpha_z: float, beta_z: float) -> tuple[np.ndarray, np.ndarray]:
    """The exact solution of (1) over one step with all inputs held.

    With e = x - g and a constant forcing f, (e, v)(t + dt) = A (e, v)(t) + b f. In closed form, so that a step may be
    of any length, or of a scalar type that carries gradients: A = exp(-r dt) (C I + S (M + r I)), with the system's
    matrix M, r = alpha_z / (2 tau), and C, S the cosh and sinh, cos and sin, or 1 and dt that the damping asks for.

    Args:
        dt: s.
        tau: time scale (...), s.

    Returns:
        A (..., 2, 2), b (..., 2).
    """
    rate, stiffness = 1.0 / np.asarray(tau), alpha_z * beta_z
    r = 0.5 * alpha_z * rate
    surplus = 0.25 * alpha_z**2 - stiffness
    w = np.sqrt(abs(surplus)) * rate
    if abs(surplus) <= CRITICAL * stiffness:
        c, s = 1.0 + 0.0 * w * dt, dt + 0.0 * w
    elif surplus > 0:
        c, s = np.cosh(w * dt), np.sinh(w * dt) / w
    else:
        c, s = np.cos(w * dt), np.sin(w * dt) / w
    decay = np.exp(-r * dt)
    a = decay * (c + r * s), decay * rate * s, -stiffness * decay * rate * s, decay * (c - r * s)
    matrix = np.stack([np.stack(a[:2], axis=-1), np.stack(a[2:], axis=-1)], axis=-2)
    return matrix, np.stack([(1.0 - a[0]) / stiffness, -a[2] / stiffness], axis=-1)


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
