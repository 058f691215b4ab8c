"""TRC marker tables of motion capture, with or without the usual header lines.

A line `Frame# Time name name ...` (tabs) names the markers, three columns each; the lines above it, where they
exist, hold pairs of keys and values of which only `Units` matters here. An empty cell is a marker the cameras lost.
Millimetres unless `Units` says otherwise.
"""

from pathlib import Path

import numpy as np

from drake_blfdmp.demonstration.demonstration import Recording
from drake_blfdmp.demonstration.formats.point_names import resolve
from drake_blfdmp.demonstration.formats.recording_format import METRES_PER_UNIT, ReadOptions, assemble
from drake_blfdmp.demonstration.formats.text import head_lines, is_number, number_or_nan, numbered_lines
from drake_blfdmp.errors import RecordingError
from drake_blfdmp.skeleton import POINTS

_HEADER_LINES = 10  # The names stand in the fourth line or, without the usual header, in the first.


class Trc:
    """Reader of TRC files; `joints` names markers."""

    name = "trc"
    up = None  # Vicon exports z up, OpenSim y up.

    def sniff(self, head: bytes) -> bool:
        """Whether a line of names is among the first lines."""
        return any(_is_names(line) for line in head_lines(head)[:_HEADER_LINES])

    def read(self, path: Path, options: ReadOptions) -> Recording:
        """Reads the file; time from the Time column, frame numbers from Frame#.

        Raises:
            RecordingError: no line of names, a marker that is not there, a row with too many cells or a cell that is
                no number.
        """
        unit, markers, separator, lines = _read_header(path)
        chosen = resolve(str(path), markers, options.joints)
        wanted: list[int] = []
        for point in POINTS:
            name = chosen[point]
            if not isinstance(name, str):
                raise RecordingError(f"{path}: a TRC marker has one name for its three columns; give {point} one name")
            column = 2 + 3 * markers.index(name)
            wanted += [column, column + 1, column + 2]
        columns = 2 + 3 * len(markers)
        frames: list[int] = []
        times: list[float] = []
        rows: list[list[float]] = []
        for number, line in lines:
            cells = line.split(separator)
            if not frames and not is_number(cells[0].strip() or "?"):
                continue  # The labels X1 Y1 Z1.
            if any(cell.strip() for cell in cells[columns:]) or len(cells) < 2:
                raise RecordingError(
                    f"{path}: line {number} has {len(cells)} columns, expected {columns} "
                    f"(Frame#, Time and {len(markers)} markers x, y, z); repair or remove the line"
                )
            cells += [""] * (columns - len(cells))  # Writers drop the tabs after the last marker seen.
            try:
                frames.append(int(float(cells[0])))
                times.append(float(cells[1]))
                rows.append([number_or_nan(cells[column]) for column in wanted])
            except (ValueError, OverflowError):
                raise RecordingError(
                    f"{path}: line {number} holds a cell that is no number; repair or remove it"
                ) from None
        x = np.array(rows, dtype=float).reshape(-1, len(POINTS), 3)
        t = np.array(times, dtype=float)
        if not np.isfinite(t).all():
            raise RecordingError(
                f"{path}: frame {frames[int(np.argmin(np.isfinite(t)))]} has no time; repair or remove it"
            )
        return assemble(path, self.name, options, t, x, np.array(frames, dtype=int), unit)


def _is_names(line: str) -> bool:
    cells = line.split("\t") if "\t" in line else line.split()
    return len(cells) > 2 and cells[0].strip().lower() in ("frame#", "frame") and cells[1].strip().lower() == "time"


def _read_header(path: Path):
    """The unit, the markers' names, the separator, and the iterator over the remaining numbered lines."""
    lines = numbered_lines(path)
    unit = "mm"
    keys: list[str] = []
    for number, line in lines:
        if _is_names(line):
            separator = "\t" if "\t" in line else None
            markers = [cell.strip() for cell in line.split(separator)[2:] if cell.strip()]
            return unit, markers, separator, lines
        cells = [cell.strip() for cell in line.split("\t")]
        if "units" in keys and len(cells) > keys.index("units"):
            stated = cells[keys.index("units")].lower()
            unit = stated if stated in METRES_PER_UNIT else unit
        keys = [cell.lower() for cell in cells]
        if number > _HEADER_LINES:
            break
    raise RecordingError(
        f"{path}: no line begins with Frame# and Time; add the line of marker names or give another format"
    )
