"""Readers of recordings: one file a format, one registry, one way in (`read_recording`)."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from drake_blfdmp.demonstration.demonstration import Recording
from drake_blfdmp.demonstration.formats.kinect_v1_rows import KinectV1Rows
from drake_blfdmp.demonstration.formats.recording_format import HEAD_BYTES, ReadOptions, RecordingFormat
from drake_blfdmp.demonstration.formats.trc import Trc
from drake_blfdmp.demonstration.formats.wide_csv import WideCsv
from drake_blfdmp.errors import RecordingError

# Asked in this order: TRC before CSV, since a TRC without its header lines is also a table with a header.
FORMATS: dict[str, RecordingFormat] = {reader.name: reader for reader in (Trc(), KinectV1Rows(), WideCsv())}

__all__ = ["FORMATS", "ReadOptions", "RecordingFormat", "read_recording"]


def read_recording(
    path: str | Path,
    *,
    format: str | None = None,
    frames: tuple[int, int] | None = None,
    joints: Mapping[str, str | Sequence[str]] | None = None,
    unit: str | None = None,
) -> Recording:
    """Reads a recording of both arms, in metres and seconds, as it stands in the file.

    Args:
        path: the file.
        format: a name in `FORMATS`; None finds it from the content.
        frames: first and last of the file's own frame numbers (the row's number from 0 where it has none), inclusive.
        joints: point of `skeleton.POINTS` -> the file's joint or marker (or three column names), where the guess fails.
        unit: "m", "cm" or "mm", overriding the file's own.

    Raises:
        RecordingError: the file is missing, no file, empty, of no known format, or does not hold the two arms.
    """
    path = Path(path)
    head = _read_head(path)
    options = ReadOptions(frames=frames, joints=joints, unit=unit)
    known = ", ".join(FORMATS)
    if format is not None and format not in FORMATS:
        raise RecordingError(f"{path}: unknown format '{format}'; known are {known}")
    reader = FORMATS[format] if format is not None else next((f for f in FORMATS.values() if f.sniff(head)), None)
    if reader is None:
        try:
            head[: head.rfind(b"\n") + 1].decode("utf-8")
            binary = b"\0" in head
        except UnicodeDecodeError:
            binary = True
        what = "binary data or text that is not UTF-8" if binary else "text of no known format"
        raise RecordingError(f"{path}: {what}; known formats are {known}")
    try:
        return reader.read(path, options)
    except OSError as error:
        raise RecordingError(f"{path}: cannot be read ({error.strerror or error}); check the file") from None


def _read_head(path: Path) -> bytes:
    try:
        if path.is_dir():
            raise RecordingError(f"{path}: is a directory; give the recording's file")
        if not path.exists():
            raise RecordingError(f"{path}: no such file; check the path")
        if not path.is_file():
            raise RecordingError(f"{path}: is no regular file; give the recording's file")
        with path.open("rb") as file:
            head = file.read(HEAD_BYTES)
    except (OSError, ValueError) as error:
        raise RecordingError(
            f"{path}: cannot be read ({getattr(error, 'strerror', None) or error}); check the file"
        ) from None
    if not head.strip():
        raise RecordingError(f"{path}: is empty; give the recording's file")
    return head
