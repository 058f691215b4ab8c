"""Smooth changes of a scalar in time, and the hands' desired distance d_j(t) of a hold-and-place task.

Every function broadcasts over time and takes float, AutoDiffXd or Expression entries.
"""

from dataclasses import dataclass

import numpy as np

from drake_blfdmp.errors import ScenarioError


def smooth_step(u):
    """The quintic step 10 u^3 - 15 u^4 + 6 u^5 from 0 to 1, held outside [0, 1], and its first two derivatives.

    Twice continuously differentiable everywhere.
    """
    u = 0.5 * (1.0 + np.abs(u) - np.abs(u - 1.0))  # clip(u, 0, 1) in a form that symbolic entries allow
    w = 1.0 - u
    return u**3 * (10.0 - 15.0 * u + 6.0 * u**2), 30.0 * (u * w) ** 2, 60.0 * u * w * (w - u)


@dataclass(frozen=True)
class HandDistance:
    """d_j(t): open to clear the box, closed to squeeze it, held, opened to release it.

    Attributes:
        open_m: distance before the grasp and after the release, m.
        closed_m: distance while the box is held, m.
        close_s, open_s: when closing and opening begin, s.
        duration_s: how long closing, and opening, takes, s.

    Each is a number, or (...) for a batch, each member its own.
    """

    open_m: float | np.ndarray
    closed_m: float | np.ndarray
    close_s: float | np.ndarray
    open_s: float | np.ndarray
    duration_s: float | np.ndarray

    def __post_init__(self):
        if not np.all(np.asarray(self.duration_s) > 0):
            raise ScenarioError(f"hand distance: closing must take a positive time, not {np.min(self.duration_s):g} s")
        opens, closed = np.broadcast_arrays(self.open_s, self.close_s + self.duration_s)
        if np.any(opens < closed):
            worst = np.argmax(closed - opens)
            raise ScenarioError(
                f"hand distance: opening at {opens.flat[worst]:.2f} s begins before closing ends at "
                f"{closed.flat[worst]:.2f} s; hold the box longer"
            )

    def evaluate(self, t):
        """d_j, d_j', d_j'' at time t (...), in m, m/s, m/s^2; the second derivative is continuous."""
        depth = self.closed_m - self.open_m
        shut = smooth_step((t - self.close_s) / self.duration_s)
        opened = smooth_step((t - self.open_s) / self.duration_s)
        d, rate, acceleration = (depth * (a - b) for a, b in zip(shut, opened, strict=True))
        return self.open_m + d, rate / self.duration_s, acceleration / self.duration_s**2


@dataclass(frozen=True)
class ConstantDistance:
    """d_j(t) = distance_m."""

    distance_m: float

    def evaluate(self, t):
        """d_j, d_j', d_j'' at time t (...)."""
        zero = 0.0 * np.asarray(t)
        return zero + self.distance_m, zero, zero
