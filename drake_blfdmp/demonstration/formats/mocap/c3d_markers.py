"""C3D, the binary marker files of optical motion capture (Vicon, Qualisys, OptiTrack, PhaseSpace, ...).

Read with the package `c3d` (extra `c3d`): Intel, DEC and MIPS numbers, integers and floats. A residual below zero means
that the marker is lost. Of several people, told apart by prefixes ("Anna:LSHO", "Ben:LSHO"), each becomes a body.

Format: https://www.c3d.org/HTML/default.htm
"""

import math
import mmap
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from drake_blfdmp.demonstration.formats.mocap.marker_pairs import between, find_pairs
from drake_blfdmp.demonstration.formats.point_names import guess, resolve
from drake_blfdmp.demonstration.formats.recording_format import Joints
from drake_blfdmp.demonstration.formats.text import MAX_FILE_BYTES
from drake_blfdmp.demonstration.raw_recording import Body, RawRecording
from drake_blfdmp.errors import RecordingError
from drake_blfdmp.skeleton import POINTS

_MAGIC = 0x50  # The second byte.
_LAST_BLOCK = 31  # Of where the parameters begin, usually 2; bytes from 32 on are text.
_PROCESSORS = (84, 85, 86)
_UNITS = {"m": "m", "meters": "m", "cm": "cm", "centimeters": "cm", "mm": "mm", "millimeters": "mm"}
_MAX_LABELS = 255  # Of one parameter, all of them empty.
_MAX_NUMBERS = 60_000_000  # 0.5 GB.


class _Markers(NamedTuple):
    """Labels, positions (N, markers, 3) with NaN where lost, and what the parameters say."""

    labels: list[str]
    x: np.ndarray
    first_frame: int
    promised: int
    unit: str | None
    rate_hz: float | None
    up: str | None


class C3dMarkers:
    """Reader of C3D files; `joints` names markers."""

    name = "c3d"

    def sniff(self, head: bytes) -> bool:
        """Whether the header points to a section of parameters that begins like one."""
        if len(head) < 512 or head[1] != _MAGIC or not 2 <= head[0] <= _LAST_BLOCK:
            return False
        start = 512 * (head[0] - 1)
        return len(head) < start + 4 or head[start + 3] in _PROCESSORS

    def read(self, path: Path, joints: Joints | None) -> RawRecording:
        """Reads the file; frames by the file's own numbers at POINT:RATE.

        Raises:
            RecordingError: no package `c3d`, a damaged file, no markers of such names, or no frames.
        """
        try:
            import c3d
        except ImportError:
            raise RecordingError(f"{path}: C3D needs the package c3d: pip install 'drake_blfdmp[c3d]'") from None
        if path.stat().st_size > MAX_FILE_BYTES:
            raise RecordingError(f"{path}: larger than {MAX_FILE_BYTES >> 30} GB; cut the recording into shorter files")

        class Reader(c3d.Reader):
            def _check_metadata(self):
                """Files often contradict themselves here (header against parameters); the parameters count."""

        markers: _Markers | None = None
        reason = ""
        with warnings.catch_warnings(), np.errstate(all="ignore"), path.open("rb") as file:
            warnings.simplefilter("ignore")
            try:
                with mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as mapped:
                    markers = _read_markers(path, Reader(mapped))
            except RecordingError:
                raise
            except Exception as error:  # The package raises whatever damaged bytes bring about.
                reason = " ".join(f"{type(error).__name__}: {error}".split())[:120]
        if markers is None:
            raise RecordingError(f"{path}: damaged C3D ({reason}); export it again")
        return _recording(path, markers, joints)


def _read_markers(path: Path, reader: Any) -> _Markers:
    used = int(reader.point_used)
    promised = int(reader.last_frame) - int(reader.first_frame) + 1
    if used == 0 or promised <= 0:
        raise RecordingError(f"{path}: C3D with {used} markers and {max(promised, 0)} frames; export the markers, too")
    labels = _labels(path, reader)[:used]
    rows: list[np.ndarray] = []
    for _, points, _ in reader.read_frames(copy=False):
        if (len(rows) + 1) * points.shape[0] * 3 > _MAX_NUMBERS:
            raise RecordingError(f"{path}: more than {len(rows)} frames of {used} markers; cut it into shorter files")
        rows.append(np.where(points[:, 3:4] < 0.0, np.nan, points[:, :3]))
    x = np.array(rows, float).reshape(-1, used, 3)
    x[np.all(x == 0.0, axis=-1)] = np.nan  # Some writers put the origin for a lost marker.
    rate = float(reader.point_rate)
    return _Markers(
        labels,
        x[:, : len(labels)],
        int(reader.first_frame),
        promised,
        _UNITS.get(_text(reader, "POINT:UNITS").lower()),
        rate if 0.0 < rate < 1e5 else None,
        _up(_text(reader, "POINT:Y_SCREEN")),
    )


def _labels(path: Path, reader: Any) -> list[str]:
    """POINT:LABELS, LABELS2, ... of 255 labels each; made unique, since unnamed markers may share one."""
    labels: list[str] = []
    for number in ("", *range(2, 258)):
        parameter = reader.get(f"POINT:LABELS{number}")
        if parameter is None:
            break
        # A dimension has a byte, and there may be 255: the package would make as many labels as they promise.
        promised = math.prod(parameter.dimensions[1:])
        if promised > max(len(parameter.bytes), _MAX_LABELS):
            raise RecordingError(
                f"{path}: damaged C3D (POINT:LABELS{number} of {' x '.join(map(str, parameter.dimensions[:6]))} "
                f"characters holds {len(parameter.bytes)}); export it again"
            )
        labels += [" ".join(str(label).replace("\0", " ").split()) for label in parameter.string_array]
    seen: set[str] = set()
    for index, label in enumerate(labels):
        labels[index] = label if label and label not in seen else f"{label}#{index}"
        seen.add(label)
    return labels


def _text(reader: Any, name: str) -> str:
    parameter = reader.get(name)
    return "" if parameter is None else parameter.string_value.replace("\0", " ").strip()


def _up(y_screen: str) -> str | None:
    """The axis that a viewer draws upwards."""
    axis = y_screen.lower().lstrip("+")
    return axis if axis in ("x", "-x", "y", "-y", "z", "-z") else None


def _recording(path: Path, markers: _Markers, joints: Joints | None) -> RawRecording:
    frames = markers.first_frame + np.arange(len(markers.x))
    bodies: dict[str, Body] = {}
    notes: list[str] = []
    for person, labels in _people(markers.labels, joints).items():
        pairs = {point: pair for point, pair in find_pairs(labels).items() if point not in (joints or {})}
        chosen = resolve(str(path), labels, {**{point: pair[0] for point, pair in pairs.items()}, **(joints or {})})
        columns = []
        for point in POINTS:
            if not isinstance(chosen[point], str):
                raise RecordingError(f"{path}: a marker has one name for its three numbers; give {point} one name")
            pair = pairs.get(point)
            both = [markers.x[:, markers.labels.index(name)] for name in pair or (str(chosen[point]),)]
            columns.append(between(*both) if len(both) == 2 else both[0])
        bodies[person] = Body(np.stack(columns, axis=1), frames)
        if pairs:
            notes.append("joints: " + ", ".join(f"{p} between {a} and {b}" for p, (a, b) in sorted(pairs.items())))
    if len(frames) < markers.promised:
        notes.append(f"the header promises {markers.promised} frames, the file holds {len(frames)}")
    return RawRecording(
        bodies, unit=markers.unit, clock_hz=markers.rate_hz, up=markers.up, notes=tuple(dict.fromkeys(notes))
    )


def _people(labels: Sequence[str], joints: Joints | None) -> dict[str, list[str]]:
    """Person -> labels: by the prefixes under which all six points stand, else everything is one person's."""
    groups: dict[str, list[str]] = {}
    for label in labels:
        groups.setdefault(label.rpartition(":")[0], []).append(label)
    whole = {
        prefix or "0": group
        for prefix, group in groups.items()
        if len({*guess(group), *find_pairs(group)}) == len(POINTS)
    }
    return whole if len(whole) > 1 and not joints else {"0": list(labels)}
