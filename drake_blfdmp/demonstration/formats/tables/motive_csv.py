"""Tables of OptiTrack Motive (`Format Version,1.2x,...`): markers, rigid bodies and the bones of a skeleton.

Below the first line of keys and values stand rows Type, Name, ID (and Parent), then a row of properties (Position,
Rotation), then a row of axes that begins with Frame and Time, then the rows of numbers. A bone's position is its
proximal joint: that of the upper arm is the shoulder, of the forearm the elbow, of the hand the wrist. Y is up unless
the export was told otherwise.
"""

from collections.abc import Iterable, Mapping, Sequence
from itertools import islice
from pathlib import Path
from typing import NamedTuple

import numpy as np

from drake_blfdmp.demonstration.formats.bone_names import guess_bones
from drake_blfdmp.demonstration.formats.point_names import resolve
from drake_blfdmp.demonstration.formats.recording_format import Joints
from drake_blfdmp.demonstration.formats.tables.dialect import find_dialect, split_names
from drake_blfdmp.demonstration.formats.tables.table_rows import clock_values
from drake_blfdmp.demonstration.formats.tables.tables import read_columns, whole_numbers
from drake_blfdmp.demonstration.formats.text import head_lines, is_digits, numbered_lines
from drake_blfdmp.demonstration.raw_recording import Body, RawRecording
from drake_blfdmp.errors import RecordingError
from drake_blfdmp.skeleton import POINTS

_HEADER_LINES = 14
_UNITS = {
    "meters": "m",
    "metres": "m",
    "centimeters": "cm",
    "centimetres": "cm",
    "millimeters": "mm",
    "millimetres": "mm",
}


class _Header(NamedTuple):
    """Objects' first position columns by type and name, and what the first line says."""

    bones: dict[str, int]
    others: dict[str, int]
    width: int
    axes_line: int
    unit: str | None
    rate_hz: float | None


class MotiveCsv:
    """Reader of Motive's CSV export; `joints` names bones, rigid bodies or markers."""

    name = "motive_csv"

    def sniff(self, head: bytes) -> bool:
        """Whether the first line begins with `Format Version` and the name of the take."""
        first = split_names(next(iter(head_lines(head)), ""))
        return len(first) >= 3 and first[0].lower() == "format version" and "take name" in map(str.lower, first)

    def read(self, path: Path, joints: Joints | None) -> RawRecording:
        """Reads the file; bones before rigid bodies and markers, one person per skeleton.

        Raises:
            RecordingError: a header that is not whole, a point that nothing stands for, or a broken row.
        """
        header = _read_header(path, numbered_lines(path))
        people = _people(path, header, joints)
        columns = dict.fromkeys(column + axis for points in people.values() for column in points for axis in range(3))
        sample = next((line for _, line in numbered_lines(path, header.axes_line + 1)), ",")
        table = read_columns(
            path,
            find_dialect(sample, header.width),
            header.width,
            [0, 1, *columns],
            first_line=header.axes_line + 1,
            names=("Frame", "Time"),
            short_rows=True,
        )
        frames = whole_numbers(path, table.numbers[0], table.lines, "Frame")
        t, _ = clock_values(path, table, 1, "Time")
        bodies = {}
        for name, points in people.items():
            axes = [table.numbers[column + axis] for column in points for axis in range(3)]
            bodies[name] = Body(np.stack(axes, axis=-1).reshape(-1, len(POINTS), 3), frames, t)
        return RawRecording(bodies, unit=header.unit, time_unit="s", clock_hz=header.rate_hz, up="y")


def _read_header(path: Path, lines: Iterable[tuple[int, str]]) -> _Header:
    said: Mapping[str, str] = {}
    types: Sequence[str] = ()
    names: Sequence[str] = ()
    properties: Sequence[str] = ()
    for number, line in islice(lines, _HEADER_LINES):
        cells = split_names(line)
        if not said:
            said = dict(zip([cell.lower() for cell in cells[::2]], cells[1::2], strict=False))
        title = next((cell.lower() for cell in cells[:2] if cell), "")
        if title == "type":
            types = cells
        elif title == "name":
            names = cells
        elif title == "frame":
            return _with_objects(cells, types, names, properties, number, said)
        else:
            properties = cells
    raise RecordingError(f"{path}: no line begins with Frame below the lines Type and Name; export the take again")


def _with_objects(
    axes: Sequence[str],
    types: Sequence[str],
    names: Sequence[str],
    properties: Sequence[str],
    line: int,
    said: Mapping[str, str],
) -> _Header:
    bones: dict[str, int] = {}
    others: dict[str, int] = {}
    whole = min(len(names), len(properties), len(axes) - 2)
    for column in range(2, whole):
        if properties[column].lower() == "position" and [axis.upper() for axis in axes[column : column + 3]] == list(
            "XYZ"
        ):
            kind = types[column].lower() if column < len(types) else ""
            (bones if kind in ("bone", "skeleton", "skeleton bone") else others).setdefault(names[column], column)
    rate = next((said[key] for key in ("export frame rate", "capture frame rate") if is_digits(said.get(key, ""))), "0")
    return _Header(
        bones,
        others,
        len(axes),
        line,
        _UNITS.get(said.get("length units", "").lower()),
        float(rate) if 0.0 < float(rate) < 1e5 else None,
    )


def _people(path: Path, header: _Header, joints: Joints | None) -> dict[str, list[int]]:
    """Person -> the first column of each point."""
    objects = {**header.others, **header.bones}
    skeletons: dict[str, list[str]] = {}
    for name in header.bones:
        skeletons.setdefault(name.rpartition(":")[0] or "0", []).append(name)
    whole = {person: points for person, names in skeletons.items() if len(points := guess_bones(names)) == len(POINTS)}
    if whole and not set(joints or {}) & set(POINTS):
        return {person: [header.bones[points[point]] for point in POINTS] for person, points in whole.items()}
    named = next(iter(whole.values()), {})
    chosen = resolve(str(path), list(objects), {**named, **(joints or {})})
    columns: list[int] = []
    for point in POINTS:
        name = chosen[point]
        if not isinstance(name, str):
            raise RecordingError(f"{path}: an object of Motive has one name for its columns; give {point} one name")
        columns.append(objects[name])
    return {"0": columns}
