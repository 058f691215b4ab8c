"""The published law's facts as one-axis trials: what its theorem leaves out, each as a number.

Trials have tau = 1 s unless said otherwise, no forcing, and start at rest at the middle of the band.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from drake_blfdmp.evaluation.studies.one_axis import (
    Growth,
    OneAxis,
    OneAxisResult,
    growing,
    lagged_roots,
    run_one_axis,
    still,
    swinging,
)
from drake_blfdmp.skill.laws.follower import PublishedGains, barrier_derivative
from drake_blfdmp.skill.laws.published_lagged import as_lagged
from drake_blfdmp.skill.laws.published_loop import as_loop

UNIT = PublishedGains(k_z=1.0, d_z=1.0, largest_rate=1e4)
DAMPING = 1.0
"""The k_2, m/s, that makes V' definite."""

OWN_GOAL = -0.15
"""m, 0.15 m from where the partner leads."""

RATES = (1.0, 3.0, 10.0, 20.0, 30.0, 50.0, 100.0, 300.0)
"""K_z / (d_z tau), 1/s, with which a moving band is tried."""

_MOVES: dict[str, Any] = {"distance": swinging(0.3, 0.1, 3.0), "start": -0.3}


@dataclass(frozen=True)
class Semidefinite:
    """V' on the line z_1 - mid = z_2 / 2, at z_2 as a share of its largest, (N,): as printed, and damped, 1/s."""

    share: np.ndarray
    printed: np.ndarray
    damped: np.ndarray


def on_the_line(half_width: float = 0.01) -> Semidefinite:
    """Fact 1: V' vanishes on a line through the origin, and a further damping mends it."""
    share = np.linspace(-0.95, 0.95, 39)
    z_2 = 2.0 * share * UNIT.k_z * half_width
    printed, damped = (
        barrier_derivative(0.5 * z_2, z_2, -half_width, half_width, 1.0, replace(UNIT, k_2=k_2))
        for k_2 in (0.0, DAMPING)
    )
    return Semidefinite(share, printed, damped)


def in_a_moving_band(time_step: float) -> dict[str, OneAxisResult]:
    """Fact 2: d moves by 0.1 sin 3t m; unit gains, as printed and with the middle fed forward."""
    gains = replace(UNIT, largest_rate=0.5 / time_step)  # A sampled system carries no rate above one over its step.
    return {
        name: run_one_axis(OneAxis(**_MOVES, gains=gains, time_step=time_step, duration=3.0, fed_forward=fed))
        for name, fed in (("as printed", False), ("fed forward", True))
    }


def crossed_at(time_step: float) -> np.ndarray:
    """When that band is crossed, s, with each of `RATES`; infinite where it is not."""
    gains = replace(UNIT, largest_rate=0.5 / time_step)
    trials = (
        OneAxis(**_MOVES, gains=replace(gains, k_z=rate), time_step=time_step, duration=2.1)  # A period.
        for rate in RATES
    )
    return np.array([run_one_axis(trial).left_at for trial in trials])


def with_a_goal_elsewhere() -> dict[str, OneAxisResult]:
    """Fact 3, two readings of (12): a goal 0.15 m off where the partner leads, another goal, and the loop solved."""
    trial = OneAxis(
        goal=OWN_GOAL, gains=PublishedGains(k_z=100.0, d_z=1.0, largest_rate=150.0), start=-0.3, time_step=1e-3
    )
    trial = replace(trial, duration=3.0)
    return {
        "published": run_one_axis(trial),
        "published, goal 0": run_one_axis(replace(trial, goal=0.0)),
        "loop": run_one_axis(replace(trial, reading=as_loop)),
    }


def lagged() -> OneAxisResult:
    """Fact 3, the third reading: 2 mm off the middle of a constant band, the gains in use, 1 ms."""
    return run_one_axis(OneAxis(reading=as_lagged, gains=PublishedGains(), time_step=1e-3, start=-0.298, duration=0.05))


def lagged_growth(time_steps: tuple[float, ...] = (1e-3, 1e-4)) -> Mapping[float, Growth]:
    """How its change from sample to sample grows at these steps, s, from a push of 1e-9 m/s."""
    return {
        h: growing(OneAxis(reading=as_lagged, gains=PublishedGains(), time_step=h, push=1e-9, duration=2.0))
        for h in time_steps
    }


def largest_lagged_roots(trials: int, seed: int) -> np.ndarray:
    """The largest root's size, (trials,), for random slopes p to 1e6 1/s^2, c to 1e4 1/s and steps to 1 s."""
    draws = 10.0 ** np.random.default_rng(seed).uniform((0.0, -1.0, -5.0), (6.0, 4.0, 0.0), (trials, 3))
    return np.array([np.abs(lagged_roots(*draw)).max() for draw in draws])


def both_signs(time_step: float) -> dict[str, OneAxisResult]:
    """The two readings of z_1's sign, 1 mm off the middle of a constant band."""
    trial = OneAxis(
        partner=still(0.0), gains=replace(PublishedGains(), largest_rate=1e3), start=-0.299, time_step=time_step
    )
    return {
        "partner minus own": run_one_axis(trial),
        "own minus partner": run_one_axis(replace(trial, sign=-1)),
    }
