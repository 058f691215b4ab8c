"""The law's gains, and the time steps at which the sampled law still keeps its promise.

With the acceleration held over a step dt, the error of one link is a double integrator under state feedback,
xi'' = -(1 + k_1 k_2) xi - (k_1 + k_2) xi' near the middle of the band. Jury's test asks for

    (k_1 + k_2) dt < 2   and   (1 + k_1 k_2) dt < 2 (k_1 + k_2).

The slope grows towards the edge of the band, and what changes within a step (the pull to the goal, the links'
directions) disturbs the law in proportion to dt; a soft law, with a small 1 + k_1 k_2, gives way to it.
`docs/sampling.md` derives the first and measures the second; the limits enforced here are those below which no band
was left.
"""

from dataclasses import dataclass

import numpy as np

from drake_blfdmp.errors import ScenarioError

SAFE_PRODUCT = 0.2
"""Largest (k_1 + k_2) dt: a tenth of Jury's limit."""

SAFE_SOFTNESS = 5e-5
"""Largest dt / (1 + k_1 k_2), s^3."""

LONGEST_STEP = 0.008
"""s; with a longer one no gains keep both limits."""


@dataclass(frozen=True)
class Gains:
    """k_1 and k_2 of the default law, 1/s: numbers, or arrays (..., 1) for a batch; the methods take numbers alone."""

    k_1: float | np.ndarray = 8.0
    k_2: float | np.ndarray = 20.0

    def largest_step(self) -> float:
        """The longest time step, s, the gains allow."""
        k_1, k_2 = float(self.k_1), float(self.k_2)
        total, stiffness = k_1 + k_2, 1.0 + k_1 * k_2
        return min(SAFE_PRODUCT / total, SAFE_PRODUCT * total / stiffness, SAFE_SOFTNESS * stiffness)

    def check(self, time_step: float) -> None:
        """Refuse gains that the sampled law cannot carry.

        Raises:
            ScenarioError: a gain is not positive, or the time step is too long for the gains.
        """
        if not (self.k_1 > 0 and self.k_2 > 0):
            raise ScenarioError(f"law: k_1 and k_2 must be positive, not {self.k_1} and {self.k_2} 1/s")
        largest = self.largest_step()
        if time_step > largest:
            soft = SAFE_SOFTNESS * (1.0 + self.k_1 * self.k_2) == largest
            gains = f", or {'larger' if soft else 'smaller'} gains" if time_step <= LONGEST_STEP else ""
            raise ScenarioError(
                f"law: the time step {time_step:g} s is too long for k_1 = {self.k_1:g}, k_2 = {self.k_2:g} 1/s; use "
                f"at most {largest:.3g} s{gains}"
            )
