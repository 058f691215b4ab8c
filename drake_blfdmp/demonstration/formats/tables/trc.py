"""TRC marker tables of motion capture (OpenSim, Motive, Qualisys, Vicon), with or without the usual header lines.

A line `Frame# Time name name ...` (tabs) names the markers, three columns each; a line of labels X1 Y1 Z1 follows; the
lines above, where they exist, hold pairs of keys and values, of which `Units` and `DataRate` matter here. An empty cell
is a marker the cameras lost. Millimetres unless `Units` says otherwise; z up from some tools, y up from others.
"""

import re
from collections.abc import Iterable
from itertools import islice
from pathlib import Path
from typing import NamedTuple

import numpy as np

from drake_blfdmp.demonstration.formats.point_names import resolve
from drake_blfdmp.demonstration.formats.recording_format import Joints
from drake_blfdmp.demonstration.formats.tables.dialect import Dialect, find_dialect, split_names
from drake_blfdmp.demonstration.formats.tables.table_names import joints_of
from drake_blfdmp.demonstration.formats.tables.table_rows import clock_values
from drake_blfdmp.demonstration.formats.tables.tables import read_columns, whole_numbers
from drake_blfdmp.demonstration.formats.text import head_lines, is_digits, numbered_lines
from drake_blfdmp.demonstration.raw_recording import RawRecording, one_body
from drake_blfdmp.errors import RecordingError
from drake_blfdmp.skeleton import POINTS

_HEADER_LINES = 12  # The names stand in the fourth line or, without the usual header, in the first.
_LABEL = re.compile(r"[xyz]\d*", re.I)
_UNITS = {
    "m": "m", "meter": "m", "meters": "m", "metre": "m", "metres": "m",
    "cm": "cm", "centimeters": "cm", "centimetres": "cm",
    "mm": "mm", "millimeter": "mm", "millimeters": "mm", "millimetre": "mm", "millimetres": "mm",
}  # fmt: skip


class _Header(NamedTuple):
    """What stands above the rows: markers' names and first columns, cells before them, the number of the first row."""

    markers: dict[str, int]
    leading: int
    width: int
    dialect: Dialect
    first_row: int
    unit: str
    rate_hz: float | None


class Trc:
    """Reader of TRC files; `joints` names markers."""

    name = "trc"

    def sniff(self, head: bytes) -> bool:
        """Whether a line of names is among the first lines."""
        return _read_header(enumerate(head_lines(head), 1)) is not None

    def read(self, path: Path, joints: Joints | None) -> RawRecording:
        """Reads the file; time from the Time column, else by the data rate; frame numbers from Frame#.

        Raises:
            RecordingError: no line of names, a marker that is not there, a row with too many cells or a cell that is
                no number.
        """
        header = _read_header(numbered_lines(path))
        if header is None:
            raise RecordingError(
                f"{path}: no line begins with Frame# and Time; add the line of marker names or give another format"
            )
        chosen = resolve(str(path), list(header.markers), joints)
        columns: list[int] = []
        for point in POINTS:
            name = chosen[point]
            if not isinstance(name, str):
                raise RecordingError(f"{path}: a TRC marker has one name for its three columns; give {point} one name")
            columns += range(header.markers[name], header.markers[name] + 3)
        leading = list(range(header.leading))
        table = read_columns(
            path,
            header.dialect,
            header.width,
            [*leading, *columns],
            first_line=header.first_row,
            names=("Frame#", "Time")[: header.leading],
            short_rows=header.dialect.separator is not None,  # Writers drop the tabs after the last marker seen.
        )
        x = np.stack([table.numbers[column] for column in columns], axis=-1).reshape(-1, len(POINTS), 3)
        frames = whole_numbers(path, table.numbers[0], table.lines, "Frame#")
        t, _ = clock_values(path, table, 1 if header.leading == 2 else None, "Time")
        return one_body(x, frames, t, unit=header.unit, time_unit="s", clock_hz=header.rate_hz)


def _read_header(lines: Iterable[tuple[int, str]]) -> _Header | None:
    """None where no line names markers."""
    head = list(islice(lines, _HEADER_LINES))
    unit, rate = "mm", None
    titled = False
    keys: list[str] = []
    for index, (number, line) in enumerate(head):
        cells = split_names(line)
        first = cells[0].lower() if cells else ""
        titled = titled or first == "pathfiletype"
        if (first == "frame#" or (first == "frame" and titled)) and not joints_of(cells):
            return _with_rows(cells, number, head[index + 1 :], unit, rate)
        known = dict(zip(keys, cells, strict=False))
        unit = _UNITS.get(known.get("units", "").lower(), unit)
        said = known.get("datarate", "")
        rate = float(said) if is_digits(said) and 0.0 < float(said) < 1e5 else rate
        keys = [cell.lower() for cell in cells]
    return None


def _with_rows(names: list[str], line: int, below: list[tuple[int, str]], unit: str, rate: float | None) -> _Header:
    """The header whose line of names, number `line`, is followed by the lines `below`."""
    leading = 2 if len(names) > 1 and names[1].lower().startswith("time") else 1
    places = [place for place, name in enumerate(names) if name and place >= leading]
    if any((place - leading) % 3 for place in places):
        # One cell a name, not three.
        markers = {names[place]: leading + 3 * order for order, place in reversed(list(enumerate(places)))}
    else:
        markers = {names[place]: place for place in reversed(places)}
    width = max(markers.values(), default=leading) + 3
    labels = split_names(below[0][1]) if below else []
    if labels and not is_digits(labels[0]):
        width = max(width, leading + sum(_LABEL.fullmatch(label) is not None for label in labels))
        line, below = below[0][0], below[1:]
    dialect = find_dialect(below[0][1] if below else "\t", width)
    return _Header(markers, leading, width, dialect, line + 1, unit, rate)
