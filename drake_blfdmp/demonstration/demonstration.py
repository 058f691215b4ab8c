"""What a reader hands over (`Recording`) and what a skill is learned from (`Demonstration`)."""

from dataclasses import dataclass, field

import numpy as np


@dataclass(frozen=True)
class KnownDimensions:
    """Lengths known beforehand (a scenario's, or a synthetic person's), in metres."""

    upper_arm: float | None = None
    forearm: float | None = None
    box_width: float | None = None


@dataclass(frozen=True)
class Recording:
    """Samples as they stand in a file: nothing removed, filled or rotated; only the unit is metres, time seconds.

    Attributes:
        t: (N,) time, s. May repeat or run backwards.
        x: (N, 6, 3) positions in the order of `skeleton.POINTS`, m, in the file's frame; NaN where missing.
        source: where it came from, for people to read.
        format: the reader's name.
        frames: (N,) the file's own frame numbers (int), or the row's number from 0.
        synthetic: True when no person was recorded.
        known: dimensions known beforehand.
    """

    t: np.ndarray
    x: np.ndarray
    source: str
    format: str
    frames: np.ndarray
    synthetic: bool = False
    known: KnownDimensions = KnownDimensions()


@dataclass(frozen=True)
class Demonstration:
    """A clean motion of both arms on a uniform clock.

    Attributes:
        t: (N,) time from 0, uniform, s.
        x: (N, 6, 3) positions, m, in the order of `skeleton.POINTS`; x to the person's right, y forward, z up.
        source: where it came from.
        synthetic: True when no person was recorded.
        repairs: what cleaning did, name of the repair -> number of samples (0 when not needed).
        known: dimensions known beforehand.
    """

    t: np.ndarray
    x: np.ndarray
    source: str
    synthetic: bool = False
    repairs: dict[str, int] = field(default_factory=dict)
    known: KnownDimensions = KnownDimensions()

    @property
    def rate_hz(self) -> float:
        """Samples a second."""
        return float((len(self.t) - 1) / (self.t[-1] - self.t[0]))

    @property
    def duration_s(self) -> float:
        """Length, s."""
        return float(self.t[-1] - self.t[0])
