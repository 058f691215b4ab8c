"""Tables with a header: one row a sample, three columns a joint, in any order and with any other columns between.

Columns are a joint's name and an axis: `WristLeftX`, `left_wrist_x`, `LWrist.x`, `x_LWrist`, optionally with
a unit, `WristLeftX (mm)`. A time column is required, a frame column is used where there is one.
"""

import csv
import re
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from drake_blfdmp.demonstration.demonstration import Recording
from drake_blfdmp.demonstration.formats.point_names import listed, resolve
from drake_blfdmp.demonstration.formats.recording_format import METRES_PER_UNIT, ReadOptions, assemble
from drake_blfdmp.demonstration.formats.text import head_lines, is_number, number_or_nan, numbered_lines
from drake_blfdmp.errors import RecordingError
from drake_blfdmp.skeleton import POINTS

_SECONDS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "100ns": 1e-7, "ns": 1e-9}
_TIME_UNITS = {
    "s": "s", "sec": "s", "secs": "s", "second": "s", "seconds": "s",
    "ms": "ms", "msec": "ms", "millis": "ms", "millisecond": "ms", "milliseconds": "ms",
    "us": "us", "usec": "us", "microseconds": "us", "ns": "ns", "nsec": "ns", "nanoseconds": "ns",
}  # fmt: skip
_TIME_NAMES = ("time", "timestamp", "timestamps", "t", "elapsed", "elapsedtime", "frametime", "clock", "")
_FRAME_NAMES = ("frame", "frames", "frameid", "framenumber", "frameno", "framenr", "frameindex")
_USUAL_RATE_HZ = 30.0

_AXIS_LAST = re.compile(
    r"^(?P<stem>.+?)[\s_.:/\-\[(]*(?P<axis>[xyz])[\])]?(?:[\s_.]*[\[(]?(?P<unit>mm|cm|m)[\])]?)?$", re.I
)
_AXIS_FIRST = re.compile(r"^(?P<axis>[xyz])[\s_.:/\-]+(?P<stem>.+?)(?:[\s_.]*[\[(](?P<unit>mm|cm|m)[\])])?$", re.I)


class _Joint(NamedTuple):
    columns: tuple[int, int, int]
    unit: str | None


class WideCsv:
    """Reader of CSV (comma, semicolon or tab) with a header; `joints` names stems or columns, "time" a column."""

    name = "wide_csv"
    up = None

    def sniff(self, head: bytes) -> bool:
        """Whether the first line is a header over numbers; without a row below it, one that names joints' columns."""
        lines = [line for line in head_lines(head) if not line.startswith("#")]
        if not lines:
            return False
        delimiter = _delimiter(lines[0])
        header = lines[0].split(delimiter)
        if len(header) < 4 or any(_is_digits(cell) for cell in header):
            return False
        if len(lines) == 1:
            return bool(_joints_of([cell.strip().strip('"') for cell in header]))
        row = lines[1].split(delimiter)
        return sum(is_number(cell.strip().strip('"')) for cell in row) >= max(4, len(row) // 2)

    def read(self, path: Path, options: ReadOptions) -> Recording:
        """Reads the file.

        Raises:
            RecordingError: no time column, a joint that is not there, a row with other columns than the header has, or
                a cell that is no number.
        """
        lines = ((number, line) for number, line in numbered_lines(path) if not line.startswith("#"))
        _, first = next(lines, (0, ""))
        delimiter = _delimiter(first)
        header = [name.strip() for name in _split(path, 1, first, delimiter)]
        while header and not header[-1]:
            header.pop()  # A comma at the line's end.
        joints = _joints_of(header)
        time_column, time_unit = _find_time(path, header, options)
        frame_column = next((i for i, name in enumerate(header) if _plain(name) in _FRAME_NAMES), None)
        columns, stated_unit = _find_columns(path, header, joints, options)

        t: list[float] = []
        frames: list[int] = []
        rows: list[list[float]] = []
        for number, line in lines:
            cells = _split(path, number, line, delimiter)
            if len(cells) < len(header) or any(cell.strip() for cell in cells[len(header) :]):
                raise RecordingError(
                    f"{path}: line {number} has {len(cells)} columns, the header {len(header)}; "
                    "repair or remove the line"
                )
            column = time_column
            try:
                t.append(float(cells[time_column]))
                if not np.isfinite(t[-1]):
                    raise ValueError
                if frame_column is not None:
                    column = frame_column
                    frames.append(int(float(cells[frame_column])))
                sample = []
                for column in columns:
                    sample.append(number_or_nan(cells[column]))
                rows.append(sample)
            except (ValueError, OverflowError):
                raise RecordingError(
                    f"{path}: line {number}, column {header[column]}: '{cells[column][:40]}' is no number; repair it"
                ) from None
        seconds = np.array(t, dtype=float)
        seconds = seconds * _SECONDS[time_unit or _guess_time_unit(seconds)]
        numbers = np.array(frames, dtype=int) if frame_column is not None else np.arange(len(t))
        x = np.array(rows, dtype=float).reshape(-1, len(POINTS), 3)
        return assemble(path, self.name, options, seconds, x, numbers, stated_unit or "m")


def _delimiter(line: str) -> str:
    return max(",;\t", key=line.count)


def _split(path: Path, number: int, line: str, delimiter: str) -> list[str]:
    if '"' not in line:
        return line.split(delimiter)
    try:
        return next(csv.reader([line], delimiter=delimiter))
    except csv.Error as error:
        raise RecordingError(f"{path}: line {number}: {error}; repair its quotation marks") from None


def _is_digits(cell: str) -> bool:
    return bool(cell.strip()) and is_number(cell)


def _plain(name: str) -> str:
    return re.sub(r"[^a-z0-9]", "", name.lower())


def _joints_of(header: Sequence[str]) -> dict[str, _Joint]:
    """Stem -> its three columns, for the stems that have all of x, y and z."""
    found: dict[str, dict[str, int]] = {}
    units: dict[str, str | None] = {}
    for column, name in enumerate(header):
        match = _AXIS_LAST.match(name) or _AXIS_FIRST.match(name)
        if match:
            found.setdefault(match["stem"], {}).setdefault(match["axis"].lower(), column)
            units.setdefault(match["stem"], match["unit"] and match["unit"].lower())
    return {
        stem: _Joint((axes["x"], axes["y"], axes["z"]), units[stem]) for stem, axes in found.items() if len(axes) == 3
    }


def _find_columns(
    path: Path, header: Sequence[str], joints: dict[str, _Joint], options: ReadOptions
) -> tuple[list[int], str | None]:
    """The 18 columns in the order of POINTS, and the unit their names state."""
    chosen = resolve(str(path), list(joints), options.joints)
    columns: list[int] = []
    units: set[str | None] = set()
    for point in POINTS:
        name = chosen[point]
        if isinstance(name, str):
            columns += joints[name].columns
            units.add(joints[name].unit)
            continue
        absent = [column for column in name if column not in header]
        if len(name) != 3 or absent:
            raise RecordingError(
                f"{path}: {point} needs three columns, x, y and z, got {listed(list(name))}; "
                f"the file has {listed(header)}"
            )
        columns += [header.index(column) for column in name]
        units.add(None)
    units.discard(None)
    if len(units) > 1 and options.unit is None:
        raise RecordingError(f"{path}: columns in different units ({', '.join(sorted(map(str, units)))}); give unit")
    return columns, next(iter(units), None) if units <= set(METRES_PER_UNIT) else None


def _find_time(path: Path, header: Sequence[str], options: ReadOptions) -> tuple[int, str | None]:
    """The time column and the unit its name states."""
    override = (options.joints or {}).get("time")
    candidates: list[tuple[int, int, str | None]] = []
    for column, name in enumerate(header):
        words = [word for word in re.split(r"[^a-z0-9]+", re.sub(r"(?<=[a-z])(?=[A-Z])", "_", name).lower()) if word]
        unit = _TIME_UNITS.get(words[-1]) if words else None
        stem = "".join(words[:-1] if unit else words)
        if name == override:
            return column, unit
        if words and stem in _TIME_NAMES:
            candidates.append((_TIME_NAMES.index(stem), column, unit))
    if override is not None:
        raise RecordingError(f"{path}: no column '{override}' for time; the file has {listed(header)}")
    if not candidates:
        raise RecordingError(f"{path}: no time column; name one time_s or Timestamp, the file has {listed(header)}")
    _, column, unit = min(candidates, key=lambda candidate: candidate[:2])
    return column, unit


def _guess_time_unit(t: np.ndarray) -> str:
    """The unit in which the median step is nearest to a usual sensor's."""
    steps = np.abs(np.diff(t))
    steps = steps[steps > 0.0]
    if len(steps) == 0:
        return "s"
    step = float(np.median(steps))
    return min(_SECONDS, key=lambda unit: abs(np.log(step * _SECONDS[unit] * _USUAL_RATE_HZ)))
