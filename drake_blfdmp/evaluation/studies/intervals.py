"""How sure a counted share is: the exact (Clopper-Pearson) confidence interval of a proportion."""

from typing import NamedTuple

from scipy.stats import binomtest


class Proportion(NamedTuple):
    """`count` of `trials`, with the interval that covers the true share at the stated confidence."""

    count: int
    trials: int
    lower: float
    upper: float

    @property
    def share(self) -> float:
        """Count / trials."""
        return self.count / self.trials

    def percent(self) -> str:
        """For example "12 of 2000 (0.60 %, 0.31 to 1.05 %)"."""
        lower, upper = 100.0 * self.lower, 100.0 * self.upper
        return f"{self.count} of {self.trials} ({100.0 * self.share:.3g} %, {lower:.3g} to {upper:.3g} %)"


def proportion(count: int, trials: int, confidence: float = 0.95) -> Proportion:
    """The share `count` / `trials` with its exact two-sided interval.

    Raises:
        ValueError: no trials, or more successes than trials.
    """
    if not 0 <= count <= trials or trials < 1:
        raise ValueError(f"{count} of {trials} is no proportion")
    interval = binomtest(int(count), int(trials)).proportion_ci(confidence_level=confidence, method="exact")
    return Proportion(int(count), int(trials), float(interval.low), float(interval.high))
