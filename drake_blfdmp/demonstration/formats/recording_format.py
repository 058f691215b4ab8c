"""What every reader of a file format offers."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Protocol

from drake_blfdmp.demonstration.raw_recording import RawRecording

HEAD_BYTES = 256 * 1024  # What `sniff` gets to see of a file.

Joints = Mapping[str, str | Sequence[str]]
"""Point of `skeleton.POINTS` (or "time") -> the file's name for it, or three column names."""


class RecordingFormat(Protocol):
    """A reader of one file format; add an instance to `formats.FORMATS` to make it known."""

    @property
    def name(self) -> str:
        """What `Recording.format` and `read_recording(format=)` call it."""
        ...

    def sniff(self, head: bytes) -> bool:
        """Whether a file that begins with `head` (at most HEAD_BYTES) is of this format; must not raise.

        Of a directory that is a ROS 2 bag, `head` is the beginning of its metadata.yaml.
        """
        ...

    def read(self, path: Path, joints: Joints | None) -> RawRecording:
        """Reads the file.

        Raises:
            RecordingError: what is wrong, with the file and the place (line, frame, message, joint), and what to do.
        """
        ...
