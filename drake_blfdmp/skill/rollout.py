"""Batch rollouts of a skill with any law: the systems' mathematics without a diagram, over leading axes."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from drake_blfdmp.skill.bands import Bands
from drake_blfdmp.skill.barrier import middles_and_half_widths
from drake_blfdmp.skill.canonical import phase_at
from drake_blfdmp.skill.geometry import link_lengths
from drake_blfdmp.skill.laws import default, none
from drake_blfdmp.skill.laws.primitive import Primitive
from drake_blfdmp.skill.skill import Skill
from drake_blfdmp.skill.transformation import mean_acceleration, step, step_matrices

BLOCK = 500
"""Samples whose bands and forcing are found at once."""

MovingGoal = Callable[[float], np.ndarray]
"""A goal (..., 6, 3), m, for a time, s."""


class Sample(NamedTuple):
    """One sample of a rollout: t in s, x and velocity (..., 6, 3), bands (..., 6, 5) or None without bands."""

    t: float
    x: np.ndarray
    velocity: np.ndarray
    bands: np.ndarray | None


@dataclass(frozen=True)
class Rollout:
    """A rolled-out skill on a uniform clock of N samples.

    Attributes:
        t: (N,) s.
        x, velocity: (N, ..., 6, 3) m, m/s.
        bands: (N, ..., 6, 5), or None without bands.
        turn, turn_rate: (N, 4) orientation and (N, 3) angular velocity, rad/s, of a skill that has them, else None; see
            `skill.orientation`.
    """

    t: np.ndarray
    x: np.ndarray
    velocity: np.ndarray
    bands: np.ndarray | None
    turn: np.ndarray | None = None
    turn_rate: np.ndarray | None = None

    @property
    def lengths(self) -> np.ndarray:
        """The five links' lengths (N, ..., 5), m."""
        return link_lengths(self.x)

    @property
    def margins(self) -> np.ndarray:
        """1 - |xi| of every link (N, ..., 5): negative where a band is left."""
        if self.bands is None:
            raise ValueError("this rollout has no bands")
        return margins(self.x, self.bands)


def margins(x, bands) -> np.ndarray:
    """1 - |xi| (..., 5) of points (..., 6, 3) in bands (..., 6, 5): negative where a band is left."""
    (m, _, _), (w, _, _) = middles_and_half_widths(bands)
    return 1.0 - np.abs(link_lengths(x) - m) / w


def steps(
    skill: Skill,
    *,
    time_step: float,
    samples: int,
    bands: Bands | None = None,
    law: Callable = default,
    gains: Any = None,
    start: np.ndarray | None = None,
    goal: np.ndarray | MovingGoal | None = None,
    tau: float | np.ndarray | None = None,
) -> Iterator[Sample]:
    """Run the skill as the discrete systems do: linear part exact over a step, inputs held, forcing taken mid-step.

    Args:
        time_step: s; samples: their number, the first at t = 0.
        bands: needed by every law but `none`, which is used when there are none.
        law: one of `skill.laws`; gains: of that law, its defaults if None. The skill's mobility goes to the default
            law, the only one that has it.
        start, goal: (..., 6, 3) m, the skill's own by default; leading axes make a batch. A goal may move in time.
        tau: time scale, s, the skill's own by default; (..., 1, 1) gives every member of a batch its own.
    """
    law = none if bands is None else law
    tau = skill.tau if tau is None else tau
    goal = skill.goal if goal is None else goal
    move = goal if callable(goal) else None
    target = np.asarray(goal(0.0) if callable(goal) else goal, dtype=float)
    x = np.asarray(skill.start if start is None else start, dtype=float)
    x = np.array(np.broadcast_to(x, np.broadcast_shapes(x.shape, target.shape)))
    v, previous = np.zeros_like(x), np.zeros_like(x)
    matrices = step_matrices(time_step, tau, skill.alpha_z, skill.beta_z)
    options = {} if gains is None else {"gains": gains}
    if law is default and skill.mobility is not None:
        options["mobility"] = np.asarray(skill.mobility, dtype=float)
    for k, (t, band, forcing) in enumerate(_known_beforehand(skill, time_step, samples, bands, tau, x.shape[:-2])):
        velocity = v / tau
        yield Sample(t, x, velocity, band)
        if k == samples - 1:
            return
        target = target if move is None else np.asarray(move(t), dtype=float)
        coupling = 0.0
        if band is not None:
            nominal = mean_acceleration(x, v, forcing, target, tau, matrices, time_step)
            coupling = law(x, velocity, nominal, previous, band, Primitive(tau, skill.alpha_z), **options)
            previous = nominal + coupling
        x, v = step(x, v, forcing, target, coupling, tau, matrices, time_step)


def _known_beforehand(skill: Skill, time_step: float, samples: int, bands: Bands | None, tau, batch: tuple[int, ...]):
    """T, the bands (*batch, 6, 5) or None, and the forcing (*batch, 6, 3) at every sample.

    They depend on time alone: of one rollout they are found in blocks of samples, of a batch, whose members have each
    their own, sample by sample.
    """
    for first in range(0, samples, BLOCK):
        times = time_step * np.arange(first, min(first + BLOCK, samples))
        if not batch:
            blocks = [None] * len(times) if bands is None else bands.evaluate(times)
            forcings = skill.forcing(phase_at(times + 0.5 * time_step, tau, skill.gamma)).reshape(-1, 6, 3)
            yield from zip(times.tolist(), blocks, forcings, strict=True)
            continue
        for t in times.tolist():
            band = None if bands is None else np.broadcast_to(bands.evaluate(t), (*batch, 6, 5))
            phase = np.asarray(phase_at(t + 0.5 * time_step, tau, skill.gamma))
            forcing = skill.forcing(phase[..., 0, 0] if phase.ndim else phase)
            yield t, band, forcing.reshape(*forcing.shape[:-1], 6, 3)


def roll_out(
    skill: Skill,
    *,
    time_step: float,
    duration: float | None = None,
    progress: Callable[[float], None] = lambda share: None,
    **options: Any,
) -> Rollout:
    """All samples of `steps`, whose other arguments it takes.

    Args:
        duration: s, the skill's tau by default.
        progress: called with the share done, 0 to 1.
    """
    n = round((skill.tau if duration is None else duration) / time_step) + 1
    xs, velocities, all_bands = [], [], []
    for k, sample in enumerate(steps(skill, time_step=time_step, samples=n, **options)):
        xs.append(sample.x)
        velocities.append(sample.velocity)
        all_bands.append(sample.bands)
        if k % 200 == 0:
            progress((k + 1) / n)
    progress(1.0)
    return Rollout(
        t=time_step * np.arange(n),
        x=np.array(xs),
        velocity=np.array(velocities),
        bands=None if all_bands[0] is None else np.array(all_bands),
    )
