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
        confidence: (N, 6) what the sensor itself says of each point, 0 not seen, 0.5 guessed, 1 tracked; None where it
            says nothing.
        orientations: (N, 2, 4) of left and right hand in the file's frame, unit quaternions w x y z of some axes of the
            hand's own; NaN where missing; None where the file has none.
        up: the axis that points up by the file or its format ("z", "y", "-y", ...); None where neither tells.
        evidence: sentences on how the file was understood: format, unit, clock, person.
    """

    t: np.ndarray
    x: np.ndarray
    source: str
    format: str
    frames: np.ndarray
    synthetic: bool = False
    known: KnownDimensions = KnownDimensions()
    confidence: np.ndarray | None = None
    orientations: np.ndarray | None = None
    up: str | None = None
    evidence: tuple[str, ...] = ()


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
        uncertainty: (6,) standard deviation per axis of each point's error before smoothing, m, as estimated from the
            recording itself; None where it was not.
        wobble: the noise of the bones' lengths (`holding.wobble`) before they were restored, m; None where x shows it.
        notes: sentences on what cleaning found and chose: axes, jumps, smoothing.
        orientations: (N, 2, 4) of left and right hand, unit quaternions w x y z in the frame of x, not smoothed; NaN
            throughout for a hand without; None where neither has any.
    """

    t: np.ndarray
    x: np.ndarray
    source: str
    synthetic: bool = False
    repairs: dict[str, int] = field(default_factory=dict)
    known: KnownDimensions = KnownDimensions()
    uncertainty: np.ndarray | None = None
    wobble: float | None = None
    notes: tuple[str, ...] = ()
    orientations: np.ndarray | None = None

    @property
    def rate_hz(self) -> float:
        """Samples a second."""
        return float((len(self.t) - 1) / (self.t[-1] - self.t[0]))

    @property
    def duration_s(self) -> float:
        """Length, s."""
        return float(self.t[-1] - self.t[0])


def as_recording(demonstration: Demonstration) -> Recording:
    """A clean motion as a recording, to be written or read again: z up, in metres and seconds."""
    return Recording(
        t=demonstration.t,
        x=demonstration.x,
        source=demonstration.source,
        format="cleaned",
        frames=np.arange(len(demonstration.t)),
        synthetic=demonstration.synthetic,
        known=demonstration.known,
        orientations=demonstration.orientations,
        up="z",
        evidence=demonstration.notes,
    )
