"""The canonical system (2): tau s' = -gamma s, s(0) = 1; the phase that takes the place of time.

Every function broadcasts and takes float, AutoDiffXd or Expression entries.
"""

import numpy as np

DEFAULT_GAMMA = float(np.log(100.0))
"""The phase ends at s(tau) = 0.01."""


def phase_at(t, tau, gamma=DEFAULT_GAMMA):
    """The solution s(t) = exp(-gamma t / tau) of (2)."""
    return np.exp(-gamma * np.asarray(t) / tau)


def phase_rate(s, tau, gamma=DEFAULT_GAMMA):
    """S' by (2), 1/s."""
    return -gamma * s / tau


def time_at(s, tau, gamma=DEFAULT_GAMMA):
    """The time, s, at which an undisturbed canonical system has phase s: the inverse of `phase_at`."""
    return -(tau / gamma) * np.log(s)
