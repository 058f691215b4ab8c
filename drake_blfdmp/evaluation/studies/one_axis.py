"""Trials of the published law on one axis: what its theorem covers, and what it does not.

The own coordinate must stay within a half width of x_partner - d; both partner and d may move. The trial runs the
discrete systems' arithmetic: spring and damper exact over a step, the coupling held beside them.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from drake_blfdmp.skill.laws.follower import (
    PublishedGains,
    follower_acceleration,
    limited_barrier_gain,
    virtual_control,
)
from drake_blfdmp.skill.laws.published import as_follower
from drake_blfdmp.skill.transformation import mean_acceleration, step, step_matrices

Motion = Callable[[float], tuple[float, float, float]]
"""Coordinate, velocity, acceleration (m, m/s, m/s^2) at a time, s."""

Reading = Callable[[float, float, float], float]
"""From the follower's, the uncoupled and the previous sample's acceleration to the one that is taken."""


def still(place: float) -> Motion:
    """A coordinate that rests."""
    return lambda t: (place, 0.0, 0.0)


def swinging(middle: float, amplitude: float, rate: float) -> Motion:
    """The coordinate middle + amplitude sin(rate t); m, rad/s."""
    return lambda t: (
        middle + amplitude * np.sin(rate * t),
        amplitude * rate * np.cos(rate * t),
        -amplitude * rate**2 * np.sin(rate * t),
    )


@dataclass(frozen=True)
class OneAxis:
    """One trial.

    Attributes:
        partner, distance: motions of the partner and of d.
        goal, start: of the own primitive (no forcing), m; a start of None is the middle of the band, moving with it.
        half_width: m.
        tau, alpha_z: of the primitive, critically damped.
        time_step, duration: s.
        gains: of the law.
        reading: one of (12)'s, `skill.laws.published.as_follower` and its like.
        fed_forward: give the law the middle's velocity and acceleration, d' and d'' included, not the partner's.
        sign: 1, or -1 for own minus partner in z_1.
        push: m/s, added to the velocity at the start.
    """

    partner: Motion = field(default_factory=lambda: still(0.0))
    distance: Motion = field(default_factory=lambda: still(0.3))
    goal: float = -0.3
    start: float | None = None
    half_width: float = 0.01
    tau: float = 1.0
    alpha_z: float = 48.0
    time_step: float = 1e-4
    duration: float = 1.0
    gains: PublishedGains = PublishedGains(k_z=1.0, d_z=1.0, largest_rate=1e4)
    reading: Reading = as_follower
    fed_forward: bool = False
    sign: int = 1
    push: float = 0.0


@dataclass(frozen=True)
class OneAxisResult:
    """What came of a trial, N samples (fewer than asked for where the numbers overflow).

    Attributes:
        t, x, middle: (N,) s, m, m.
        acceleration: (N,) that was taken at each sample, m/s^2.
        half_width: m.
    """

    t: np.ndarray
    x: np.ndarray
    middle: np.ndarray
    acceleration: np.ndarray
    half_width: float

    @property
    def error(self) -> np.ndarray:
        """Distance from the middle of the band, signed, m."""
        return self.x - self.middle

    @property
    def left_at(self) -> float:
        """When the band is first left, s; infinite where it never is."""
        outside = np.flatnonzero(~(np.abs(self.error) < self.half_width))
        return float(self.t[outside[0]]) if len(outside) else np.inf


def other_sign_acceleration(x_own, velocity, lower, upper, partner_velocity, partner_acceleration, tau, gains):
    """The law (9) as in `follower_acceleration`, with z_1 read as own minus partner."""
    half = gains.k_z * 0.5 * (upper - lower)
    z_1 = -gains.k_z * (0.5 * (upper + lower) - x_own)
    z_1_dot = -gains.k_z * (partner_velocity - velocity)
    z_2 = gains.d_z * (virtual_control(z_1, -half, half, partner_velocity, tau, gains) - tau * velocity)
    k_n = limited_barrier_gain(z_1, -half, half, tau, gains)
    return partner_acceleration + (z_1_dot / gains.d_z + (k_n + gains.k_2) * z_2) / tau


def run_one_axis(trial: OneAxis) -> OneAxisResult:
    """Roll the trial out."""
    law = follower_acceleration if trial.sign > 0 else other_sign_acceleration
    h, w, tau = trial.time_step, trial.half_width, trial.tau
    matrices = step_matrices(h, tau, trial.alpha_z, trial.alpha_z / 4)
    (p, p_dot, _), (d, d_dot, _) = trial.partner(0.0), trial.distance(0.0)
    x = p - d if trial.start is None else trial.start
    v = tau * ((p_dot - d_dot if trial.start is None else 0.0) + trial.push)
    taken, rows = 0.0, []
    for k in range(round(trial.duration / h) + 1):
        t = k * h
        (p, p_dot, p_ddot), (d, d_dot, d_ddot) = trial.partner(t), trial.distance(t)
        if trial.fed_forward:
            p_dot, p_ddot = p_dot - d_dot, p_ddot - d_ddot
        nominal = mean_acceleration(x, v, 0.0, trial.goal, tau, matrices, h)
        wanted = law(x, v / tau, p - d - w, p - d + w, p_dot, p_ddot, tau, trial.gains)
        taken = trial.reading(float(wanted), float(nominal), taken)
        if not abs(taken) < 1e12:
            break
        rows.append((t, x, p - d, taken))
        x, v = step(x, v, 0.0, trial.goal, taken - nominal, tau, matrices, h)
    columns = np.array(rows).T
    return OneAxisResult(columns[0], columns[1], columns[2], columns[3], w)


def lagged_roots(slope_x: float, slope_v: float, time_step: float) -> np.ndarray:
    """Roots (3,) of the lagged law a_k = -a_(k-1) - p x_k - c v_k on a double integrator with held acceleration.

    Their product is -1 and the polynomial is 2 c h > 0 at z = -1: one real root lies below -1 whatever p, and c > 0.

    Args:
        slope_x, slope_v: p, 1/s^2, and c, 1/s.
        time_step: h, s.
    """
    p, c, h = slope_x, slope_v, time_step
    return np.roots([1.0, h * c + h * h * p / 2 - 1.0, h * h * p / 2 - h * c - 1.0, 1.0])


def lagged_slopes(trial: OneAxis) -> tuple[float, float]:
    """P and c of `lagged_roots` at the middle of the band: what follower and primitive together pull back with."""
    gains, tau = trial.gains, trial.tau
    k_n = float(limited_barrier_gain(0.0, -gains.k_z * trial.half_width, gains.k_z * trial.half_width, tau, gains))
    a, b = gains.k_z / (gains.d_z * tau), gains.d_z * (k_n + gains.k_2)
    matrices = step_matrices(trial.time_step, tau, trial.alpha_z, trial.alpha_z / 4)
    h = trial.time_step
    by_x, by_v = (float(mean_acceleration(x, v, 0.0, 0.0, tau, matrices, h)) for x, v in ((1.0, 0.0), (0.0, tau)))
    return float(a * b - by_x), float(a + b - by_v)


@dataclass(frozen=True)
class Growth:
    """How the lagged reading grows while it is linear.

    Attributes:
        change: (N,) |a_k - a_(k-1)|, m/s^2.
        measured: its growth a sample over the second half; `predicted` by the largest of `lagged_roots`.
    """

    change: np.ndarray
    measured: float
    predicted: float


def growing(trial: OneAxis) -> Growth:
    """The growth of a trial of the lagged reading, as long as its error is below a tenth of the half width."""
    predicted = float(np.abs(lagged_roots(*lagged_slopes(trial), trial.time_step)).max())
    run = run_one_axis(trial)
    linear = int(np.argmax(np.abs(run.error) > 0.1 * trial.half_width)) or len(run.t)
    change = np.abs(np.diff(run.acceleration[:linear]))
    half = change[len(change) // 2 :]
    return Growth(change, float((half[-1] / half[0]) ** (1.0 / (len(half) - 1))), predicted)
