"""What stands in a file, before anybody has said what its units and its clock are."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Body:
    """One person's points as they stand in a file, in the file's own units.

    Attributes:
        x: (N, 6, 3) in the order of `skeleton.POINTS`; NaN where missing.
        frames: (N,) the file's own frame numbers (int), or the number from 0 of the row, message or entry.
        t: (N,) the file's clock, finite; None where the file has none.
        confidence: (N, 6) 0 not seen, 0.5 guessed, 1 tracked; None where the file says nothing.
        orientations: (N, 2, 4) of left and right hand, or of what they hold, quaternions w x y z of any length; NaN or
            zeros where missing; None where the file has none.
    """

    x: np.ndarray
    frames: np.ndarray
    t: np.ndarray | None = None
    confidence: np.ndarray | None = None
    orientations: np.ndarray | None = None


@dataclass(frozen=True)
class RawRecording:
    """What a reader hands over. It states only what the file or its format says; the rest is inferred afterwards.

    Attributes:
        bodies: the person's id in the file -> the person; at least one.
        unit: "m", "cm" or "mm" where the file or its format says so.
        time_unit: a key of `clock.SECONDS`, or "frames" where `t` counts frames; None where nothing says so.
        clock_hz: frames a second, where the file or its format says so; used when there is no other clock.
        up: the axis that points up ("z", "y", "-y", ...), where the file or its format says so.
        empty_frames: frames of the file that hold no person.
        synthetic: the file says that no person was recorded.
        notes: further sentences for people, such as how the points were found.
    """

    bodies: Mapping[str, Body]
    unit: str | None = None
    time_unit: str | None = None
    clock_hz: float | None = None
    up: str | None = None
    empty_frames: int = 0
    synthetic: bool = False
    notes: tuple[str, ...] = ()


def one_body(
    x: np.ndarray,
    frames: np.ndarray | None = None,
    t: np.ndarray | None = None,
    confidence: np.ndarray | None = None,
    orientations: np.ndarray | None = None,
    **stated,
) -> RawRecording:
    """The recording of a file that knows of one person only; `stated` are further fields of RawRecording."""
    frames = np.arange(len(x)) if frames is None else frames
    return RawRecording({"0": Body(x, frames, t, confidence, orientations)}, **stated)
