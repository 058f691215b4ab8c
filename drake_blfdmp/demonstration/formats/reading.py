"""The registry of formats, and the way from a path to a `Recording`."""

from pathlib import Path

from drake_blfdmp.demonstration.demonstration import Recording
from drake_blfdmp.demonstration.formats.documents.azure_json import AzureJson
from drake_blfdmp.demonstration.formats.documents.keypoint_json import KeypointJson
from drake_blfdmp.demonstration.formats.documents.skeleton_json import SkeletonJson
from drake_blfdmp.demonstration.formats.interpretation import ReadOptions, check_options, interpret
from drake_blfdmp.demonstration.formats.mocap.bvh import Bvh
from drake_blfdmp.demonstration.formats.mocap.c3d_markers import C3dMarkers
from drake_blfdmp.demonstration.formats.mocap.omomo_pt import OmomoPt
from drake_blfdmp.demonstration.formats.recording_format import HEAD_BYTES, Joints, RecordingFormat
from drake_blfdmp.demonstration.formats.ros.mcap_bag import McapBag
from drake_blfdmp.demonstration.formats.ros.rosbag1 import RosBag1
from drake_blfdmp.demonstration.formats.ros.rosbag2 import RosBag2
from drake_blfdmp.demonstration.formats.tables.joint_rows import AZURE_KINECT_ROWS, KINECT_V1_ROWS, KINECT_V2_ROWS
from drake_blfdmp.demonstration.formats.tables.long_csv import LongCsv
from drake_blfdmp.demonstration.formats.tables.motive_csv import MotiveCsv
from drake_blfdmp.demonstration.formats.tables.ntu_skeleton import NtuSkeleton
from drake_blfdmp.demonstration.formats.tables.points18 import Points18
from drake_blfdmp.demonstration.formats.tables.trc import Trc
from drake_blfdmp.demonstration.formats.tables.wide_csv import WideCsv
from drake_blfdmp.errors import RecordingError

# Asked in this order: what has a signature first, tables last, for nearly all text could be one; of these the ones with
# a header first, which tells more than the number of columns.
FORMATS: dict[str, RecordingFormat] = {
    reader.name: reader
    for reader in (
        RosBag1(),
        RosBag2(),
        McapBag(),
        C3dMarkers(),
        OmomoPt(),
        Bvh(),
        AzureJson(),
        SkeletonJson(),
        KeypointJson(),
        Trc(),
        MotiveCsv(),
        NtuSkeleton(),
        LongCsv(),
        WideCsv(),
        KINECT_V1_ROWS,
        KINECT_V2_ROWS,
        AZURE_KINECT_ROWS,
        Points18(),
    )
}

_BAG_INDEX = "metadata.yaml"  # A ROS 2 bag is a directory with this file in it.


def read_recording(
    path: str | Path,
    *,
    format: str | None = None,
    frames: tuple[int, int] | None = None,
    joints: Joints | None = None,
    unit: str | None = None,
    time_unit: str | None = None,
    rate_hz: float | None = None,
    body: str | None = None,
) -> Recording:
    """Reads a recording of both arms, in metres and seconds, as it stands in the file.

    Args:
        path: the file, or the directory of a ROS 2 bag.
        format: a name in `FORMATS`; None finds it from the content.
        frames, joints, unit, time_unit, rate_hz, body: see `ReadOptions`.

    Raises:
        RecordingError: the file is missing, no file, empty, of no known format, or does not hold the two arms.
    """
    path = Path(path)
    head = _read_head(path)
    options = ReadOptions(frames, joints, unit, time_unit, rate_hz, body)
    check_options(path, options)
    known = ", ".join(FORMATS)
    if format is not None and format not in FORMATS:
        raise RecordingError(f"{path}: unknown format '{format}'; known are {known}")
    reader = FORMATS[format] if format is not None else next((f for f in FORMATS.values() if f.sniff(head)), None)
    if reader is None:
        raise RecordingError(f"{path}: {_what(head)}; known formats are {known}")
    try:
        raw = reader.read(path, joints)
    except OSError as error:
        raise RecordingError(f"{path}: cannot be read ({error.strerror or error}); check the file") from None
    except (MemoryError, RecursionError) as error:
        raise RecordingError(f"{path}: too large or too deeply nested ({type(error).__name__}); cut it") from None
    return interpret(path, reader.name, raw, options)


def _what(head: bytes) -> str:
    """What a file of no known format is."""
    try:
        head[: head.rfind(b"\n") + 1].decode("utf-8")
        binary = b"\0" in head
    except UnicodeDecodeError:
        binary = True
    return "binary data or text that is not UTF-8, of no known format" if binary else "text of no known format"


def _read_head(path: Path) -> bytes:
    try:
        file = path / _BAG_INDEX if path.is_dir() else path
        if path.is_dir() and not file.is_file():
            raise RecordingError(f"{path}: is a directory; give the recording's file")
        if not file.exists():
            raise RecordingError(f"{path}: no such file; check the path")
        if not file.is_file():
            raise RecordingError(f"{path}: is no regular file; give the recording's file")
        with file.open("rb") as opened:
            head = opened.read(HEAD_BYTES)
    except (OSError, ValueError) as error:
        raise RecordingError(
            f"{path}: cannot be read ({getattr(error, 'strerror', None) or error}); check the file"
        ) from None
    if not head.strip():
        raise RecordingError(f"{path}: is empty; give the recording's file")
    return head
