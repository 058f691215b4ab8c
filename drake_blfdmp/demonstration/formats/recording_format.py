"""What every reader of a file format offers, and the last step all of them share."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np

from drake_blfdmp.demonstration.demonstration import Recording
from drake_blfdmp.errors import RecordingError

METRES_PER_UNIT = {"m": 1.0, "cm": 0.01, "mm": 0.001}
HEAD_BYTES = 256 * 1024  # What `sniff` gets to see of a file.


@dataclass(frozen=True)
class ReadOptions:
    """What the person who reads a file knows better than the reader.

    Attributes:
        frames: first and last of the file's own frame numbers, both included; None reads all.
        joints: point of `skeleton.POINTS` (or "time") -> the file's name for it, or three column names.
        unit: "m", "cm" or "mm", overriding the file's or the format's own.
    """

    frames: tuple[int, int] | None = None
    joints: Mapping[str, str | Sequence[str]] | None = None
    unit: str | None = None


class RecordingFormat(Protocol):
    """A reader of one file format; add an instance to `formats.FORMATS` to make it known."""

    @property
    def name(self) -> str:
        """What `Recording.format` and `read_recording(format=)` call it."""
        ...

    @property
    def up(self) -> str | None:
        """The axis that points up by the format's definition ("y", "-y", "z"), None where files differ."""
        ...

    def sniff(self, head: bytes) -> bool:
        """Whether a file that begins with `head` (at most HEAD_BYTES) is of this format; must not raise."""
        ...

    def read(self, path: Path, options: ReadOptions) -> Recording:
        """Reads the file; raises RecordingError."""
        ...


def assemble(
    path: Path,
    format_name: str,
    options: ReadOptions,
    t: np.ndarray,
    x: np.ndarray,
    frames: np.ndarray,
    file_unit: str = "m",
) -> Recording:
    """Selects `options.frames`, converts to metres and makes the Recording.

    Args:
        path: the file, for messages and `Recording.source`.
        format_name: the reader's name.
        options: as given to the reader.
        t: (N,) s.
        x: (N, 6, 3) in `options.unit`, or else in `file_unit`; NaN (or infinite) where missing.
        frames: (N,) frame numbers.
        file_unit: the unit the file or its format states.

    Raises:
        RecordingError: unknown unit, no samples, or none with a frame number in the range.
    """
    unit = options.unit or file_unit
    if unit not in METRES_PER_UNIT:
        raise RecordingError(f"{path}: unknown unit '{unit}'; give one of {', '.join(METRES_PER_UNIT)}")
    if len(t) == 0:
        raise RecordingError(f"{path}: holds a header but no samples; export the recording again")
    if options.frames is not None:
        first, last = options.frames
        keep = (frames >= first) & (frames <= last)
        if not keep.any():
            raise RecordingError(
                f"{path}: no frame lies in {first}:{last}; the file has frames {frames.min()} to {frames.max()}"
            )
        t, x, frames = t[keep], x[keep], frames[keep]
    x = np.where(np.isfinite(x), x, np.nan) * METRES_PER_UNIT[unit]
    return Recording(t=t, x=x, source=str(path), format=format_name, frames=frames)
