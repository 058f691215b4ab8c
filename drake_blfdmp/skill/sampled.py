"""The law's gains, and the time steps at which the sampled law still keeps its promise.

With the acceleration held over a step dt, the error of one link is a double integrator under state feedback. Its
slope grows towards the edge of the band, (1 + xi^2) / (1 - xi^2)^2, and the linear loop is stable only while
(k_1 + k_2) dt < 2 (Jury). `docs/sampling.md` measures where the band is first crossed; the limit enforced here keeps
a factor of two from it.
"""

from dataclasses import dataclass

from drake_blfdmp.errors import ScenarioError

SAFE_PRODUCT = 0.4
"""Largest (k_1 + k_2) dt."""


@dataclass(frozen=True)
class Gains:
    """k_1 and k_2 of the default law, 1/s."""

    k_1: float = 8.0
    k_2: float = 20.0

    def largest_step(self) -> float:
        """The longest time step, s, the gains allow."""
        return SAFE_PRODUCT / (self.k_1 + self.k_2)

    def check(self, time_step: float) -> None:
        """Refuse gains that the sampled law cannot carry.

        Raises:
            ScenarioError: a gain is not positive, or the time step is too long for the gains.
        """
        if not (self.k_1 > 0 and self.k_2 > 0):
            raise ScenarioError(f"law: k_1 and k_2 must be positive, not {self.k_1} and {self.k_2} 1/s")
        if time_step > self.largest_step():
            raise ScenarioError(
                f"law: the time step {time_step:g} s is too long for k_1 = {self.k_1:g}, k_2 = {self.k_2:g} 1/s; use at "
                f"most {self.largest_step():.3g} s, or gains with k_1 + k_2 <= {SAFE_PRODUCT / time_step:.3g} 1/s"
            )
