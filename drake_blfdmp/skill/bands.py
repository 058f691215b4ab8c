"""The bands (5), (13), (20) of the five links as functions of time, with the two derivatives the law needs.

A set of bands is an array (..., 6, 5): rows lower, upper, lower', upper', lower'', upper''; columns in the order of
`skeleton.LINKS`; m, m/s, m/s^2.
"""

from dataclasses import dataclass, replace

import numpy as np

from drake_blfdmp.errors import ScenarioError
from drake_blfdmp.skeleton import HANDS, LINKS
from drake_blfdmp.skill.geometry import link_vectors
from drake_blfdmp.skill.profiles import ConstantDistance, HandDistance, RecordedDistance

LOWER, UPPER, LOWER_RATE, UPPER_RATE, LOWER_ACCELERATION, UPPER_ACCELERATION = range(6)

ONLY_HANDS = np.array([float(i == HANDS) for i in range(len(LINKS))])


@dataclass(frozen=True)
class Bands:
    """Desired lengths and half widths d(t) +- sigma(t) of the five links.

    sigma_l(t) = final_l + (initial_l - final_l + opening_l) exp(-rate t): the paper's (13) with initial = final, and
    (20) for the hands, whose exp(-k/10) at 30 samples a second is exp(-3 t). `opening` widens the funnel to the error
    at t = 0, so that the guarantee holds from the first sample on.

    Attributes:
        bones: (5,) desired lengths, m; the hands' entry is not used.
        hands: d_j(t).
        initial, final: (5,) half widths at t = 0 and as t -> infinity, m.
        rate: decay of the funnel, 1/s; (...) for a batch, each its own.
        opening: (..., 5) additional half width at t = 0, m.
    """

    bones: np.ndarray
    hands: HandDistance | ConstantDistance | RecordedDistance
    initial: np.ndarray
    final: np.ndarray
    rate: float | np.ndarray = 3.0
    opening: np.ndarray | float = 0.0

    def __post_init__(self):
        if np.any(np.asarray(self.final) <= 0) or np.any(np.asarray(self.initial) < np.asarray(self.final)):
            raise ScenarioError("bands: half widths must be positive and must not grow with time")
        if np.any(np.asarray(self.rate) <= 0):
            raise ScenarioError(f"bands: the funnel's rate must be positive, not {np.min(self.rate):g} 1/s")

    def desired(self, t):
        """Desired lengths and their first two derivatives, each (..., 5)."""
        length, rate, acceleration = (np.asarray(value)[..., None] * ONLY_HANDS for value in self.hands.evaluate(t))
        return length + np.asarray(self.bones) * (1.0 - ONLY_HANDS), rate, acceleration

    def half_widths(self, t):
        """Sigma and its first two derivatives, each (..., 5)."""
        rate = np.asarray(self.rate)[..., None]
        decay = np.exp(-rate * np.asarray(t)[..., None])
        excess = (np.asarray(self.initial) - np.asarray(self.final) + self.opening) * decay
        return np.asarray(self.final) + excess, -rate * excess, rate**2 * excess

    def evaluate(self, t):
        """The bands at time t (...): (..., 6, 5)."""
        d, sigma = self.desired(t), self.half_widths(t)
        rows = [d[order] + sign * sigma[order] for order in range(3) for sign in (-1.0, 1.0)]
        return np.stack(rows, axis=-2)

    def paper(self) -> "Bands":
        """The bands without the opening: what (13) and (20) print."""
        return replace(self, opening=0.0)

    def opened_to(self, x, filling: float = 0.8) -> "Bands":
        """The funnel opened just so far that at t = 0 every link of the points x (..., 6, 3) fills at most `filling`.

        Leading axes of x give a batch of funnels, which `evaluate` takes at one time t.
        """
        rho = np.linalg.norm(link_vectors(np.asarray(x, dtype=float)), axis=-1)
        error = np.abs(rho - self.desired(0.0)[0])
        return replace(self, opening=np.maximum(0.0, error / filling - np.asarray(self.initial)))


def make_bands(
    upper_arm: float,
    forearm: float,
    hands: HandDistance | ConstantDistance | RecordedDistance,
    *,
    bone_half_width: float = 0.01,
    hands_half_width: float = 0.01,
    hands_funnel: float = 0.02,
    rate: float = 3.0,
) -> Bands:
    """The paper's bands: sigma_s = sigma_e = 0.01 m, and (20) for the hands. Lengths in m, rate in 1/s."""
    bones = {"upper_arm": upper_arm, "forearm": forearm, "hands": 0.0}
    final = np.full(len(LINKS), bone_half_width)
    final[HANDS] = hands_half_width
    initial = final.copy()
    initial[HANDS] += hands_funnel
    lengths = np.array([bones[link.name.removeprefix("left_").removeprefix("right_")] for link in LINKS])
    return Bands(bones=lengths, hands=hands, initial=initial, final=final, rate=rate)
