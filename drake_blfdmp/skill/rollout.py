"""Batch rollouts of a skill with any law: the systems' mathematics without a diagram, over leading axes."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from drake_blfdmp.skill.bands import Bands
from drake_blfdmp.skill.barrier import middles_and_half_widths
from drake_blfdmp.skill.canonical import phase_at
from drake_blfdmp.skill.geometry import link_lengths
from drake_blfdmp.skill.laws import default, none
from drake_blfdmp.skill.sampled import Gains
from drake_blfdmp.skill.skill import Skill
from drake_blfdmp.skill.transformation import mean_acceleration, step, step_matrices


@dataclass(frozen=True)
class Rollout:
    """A rolled-out skill on a uniform clock of N samples.

    Attributes:
        t: (N,) s.
        x, velocity: (N, ..., 6, 3) m, m/s.
        bands: (N, ..., 6, 5), or None without bands.
    """

    t: np.ndarray
    x: np.ndarray
    velocity: np.ndarray
    bands: np.ndarray | None

    @property
    def lengths(self) -> np.ndarray:
        """The five links' lengths (N, ..., 5), m."""
        return link_lengths(self.x)

    @property
    def margins(self) -> np.ndarray:
        """1 - |xi| of every link (N, ..., 5): negative where a band is left."""
        if self.bands is None:
            raise ValueError("this rollout has no bands")
        (m, _, _), (w, _, _) = middles_and_half_widths(self.bands)
        return 1.0 - np.abs(self.lengths - m) / w


def roll_out(
    skill: Skill,
    *,
    time_step: float,
    duration: float | None = None,
    bands: Bands | None = None,
    law: Callable = default,
    gains: Gains = Gains(),
    start: np.ndarray | None = None,
    goal: np.ndarray | None = None,
    progress: Callable[[float], None] = lambda share: None,
) -> Rollout:
    """Run the skill as the discrete systems do: linear part exact over a step, inputs held, forcing taken mid-step.

    Args:
        time_step, duration: s; the duration is the skill's tau by default.
        bands: needed by every law but `none`, which is used when there are none.
        start, goal: (..., 6, 3) m, the skill's own by default; leading axes make a batch.
        progress: called with the share done, 0 to 1.
    """
    law = none if bands is None else law
    duration = skill.tau if duration is None else duration
    n = round(duration / time_step) + 1
    t = time_step * np.arange(n)
    start = skill.start if start is None else np.asarray(start, dtype=float)
    goal = skill.goal if goal is None else np.asarray(goal, dtype=float)
    x = np.array(np.broadcast_to(start, np.broadcast_shapes(start.shape, goal.shape)))
    v = np.zeros_like(x)
    forcings = skill.forcing(phase_at(t + 0.5 * time_step, skill.tau, skill.gamma)).reshape(n, 6, 3)
    matrices = step_matrices(time_step, skill.tau, skill.alpha_z, skill.beta_z)
    xs, velocities, all_bands = np.empty((n, *x.shape)), np.empty((n, *x.shape)), None
    if bands is not None:
        all_bands = np.stack([np.broadcast_to(bands.evaluate(time), (*x.shape[:-2], 6, 5)) for time in t])
    for k in range(n):
        xs[k], velocities[k] = x, v / skill.tau
        coupling = 0.0
        if all_bands is not None:
            nominal = mean_acceleration(x, v, forcings[k], goal, skill.tau, matrices, time_step)
            coupling = law(x, velocities[k], nominal, all_bands[k], gains)
        x, v = step(x, v, forcings[k], goal, coupling, skill.tau, matrices, time_step)
        if k % 200 == 0:
            progress((k + 1) / n)
    progress(1.0)
    return Rollout(t=t, x=xs, velocity=velocities, bands=all_bands)
