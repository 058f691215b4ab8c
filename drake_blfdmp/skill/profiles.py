"""Smooth changes of a scalar in time, and the hands' desired distance d_j(t): a box's, a constant, or a person's own.

Every function broadcasts over time and takes float, AutoDiffXd or Expression entries, unless it says otherwise.
"""

from dataclasses import dataclass
from math import factorial
from typing import Any

import numpy as np
from scipy.interpolate import PPoly, make_interp_spline

from drake_blfdmp.errors import ScenarioError, SkillError


def smooth_step(u):
    """The quintic step 10 u^3 - 15 u^4 + 6 u^5 from 0 to 1, held outside [0, 1], and its first two derivatives.

    Twice continuously differentiable everywhere.
    """
    u = 0.5 * (1.0 + np.abs(u) - np.abs(u - 1.0))  # clip(u, 0, 1) in a form that symbolic entries allow
    w = 1.0 - u
    return u**3 * (10.0 - 15.0 * u + 6.0 * u**2), 30.0 * (u * w) ** 2, 60.0 * u * w * (w - u)


def softly_at_least(values, least: float, blend: float):
    """Values (...) raised to `least` without a kink: twice continuously differentiable where they are.

    Args:
        blend: values less than this from `least` are rounded, by at most 0.16 of it; those farther above stay as they
            are.
    """
    u = np.clip((np.asarray(values) - least + blend) / (2.0 * blend), 0.0, 1.0)
    rounded = least + 2.0 * blend * u**4 * (2.5 + u * (u - 3.0))  # The integral of the quintic step.
    return np.where(np.asarray(values) > least + blend, values, rounded)


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


_DEGREE = 5
_ORDERS = 5  # The distance, the two derivatives a law needs, and the two that carry a gradient through those.


class RecordedDistance:
    """d_j(t) of a motion without a box: a quintic spline through the person's own distance, held before and after it.

    Twice continuously differentiable everywhere where the samples begin and end at rest. Takes float and AutoDiffXd
    times, these by a Taylor step of second order about their values; a spline has no symbolic form.
    """

    def __init__(self, t, distance):
        """Of distances (N,), m, at increasing times (N,), s.

        Raises:
            SkillError: fewer than six samples, times that do not increase, or distances that are not positive.
        """
        t, distance = np.asarray(t, dtype=float), np.asarray(distance, dtype=float)
        if t.ndim != 1 or t.shape != distance.shape or len(t) <= _DEGREE or not np.all(np.diff(t) > 0):
            raise SkillError(
                f"recorded distance: needs {_DEGREE + 1} samples or more at increasing times, got shapes {t.shape}, "
                f"{distance.shape}"
            )
        if not np.all(np.isfinite(distance) & (distance > 0)):
            raise SkillError("recorded distance: the hands' distance must be positive and finite at every sample")
        spline = make_interp_spline(t, distance, k=_DEGREE)
        knots = np.unique(spline.t)
        taylor = [spline(knots[:-1], nu=order) for order in range(_DEGREE + 1)]
        # All orders in one piecewise polynomial: one look-up of the piece serves them all.
        pieces = np.zeros((_DEGREE + 1, len(knots) - 1, _ORDERS))
        for order in range(_ORDERS):
            for power in range(_DEGREE + 1 - order):
                pieces[_DEGREE - power, :, order] = taylor[order + power] / factorial(power)
        self._pieces, self._first, self._last = PPoly(pieces, knots), float(t[0]), float(t[-1])

    def evaluate(self, t):
        """d_j, d_j', d_j'' at time t (...), in m, m/s, m/s^2.

        Raises:
            SkillError: a time is neither a number nor an AutoDiffXd.
        """
        t = np.asarray(t)
        if t.dtype != object:
            return self._orders(t)[:3]
        times = np.reshape([_number(entry) for entry in t.flat], t.shape)
        orders, step = self._orders(times), t - times
        return tuple(orders[k] + step * (orders[k + 1] + 0.5 * step * orders[k + 2]) for k in range(3))

    def _orders(self, t) -> tuple[np.ndarray, ...]:
        """The distance at numbers t (...) and its first four derivatives, 0 outside the samples."""
        d, *derivatives = np.moveaxis(self._pieces(np.clip(t, self._first, self._last)), -1, 0)
        inside = (t >= self._first) & (t <= self._last)
        return d, *(inside * derivative for derivative in derivatives)


def _number(entry: Any) -> float:
    """A number as it is, an AutoDiffXd's value; nothing here knows Drake, so it is asked for by its method's name."""
    if isinstance(entry, (int, float)):
        return float(entry)
    value = getattr(entry, "value", None)
    if not callable(value):
        raise SkillError(
            "recorded distance: a spline through samples has no symbolic form; use float or AutoDiffXd, or the "
            "distance of a task with a box"
        )
    return float(value())  # pyright: ignore[reportArgumentType]
