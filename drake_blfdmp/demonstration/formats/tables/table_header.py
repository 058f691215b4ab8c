"""Where a table's header stands: below any preamble or comment, in one row or two, with or without a row of units."""

import re
from collections.abc import Callable, Iterable, Sequence
from itertools import islice
from typing import NamedTuple

from drake_blfdmp.demonstration.formats.tables.dialect import COMMENTS, Dialect, find_dialect, split_names
from drake_blfdmp.demonstration.formats.text import is_digits, is_number

_MOST_LINES = 80  # Within which the header must end.
_SAMPLE_ROWS = 20
_LEAST_COLUMNS = 4  # Of a table whose names mean nothing to us.
_COMMENT = re.compile(r"\s*(#|%|//)+\s*")
_AXIS = re.compile(r"([xyz])\d*(?:[\s_.]*[\[(]?(?:mm|cm|m)[\])]?)?", re.I)
_UNITS = re.compile(r"[\[(]?(mm|cm|m|s|ms|us|ns|sec|deg|rad|hz|-)?[\])]?", re.I)
_RATE_KEYS = ("frequency", "datarate", "framerate", "fps", "rate", "samplingrate", "samplerate")


class Header(NamedTuple):
    """What stands above a table.

    Attributes:
        names: one a column, with the axis for headers of two rows; "" where a column has none.
        line: the number of the header's last line.
        unit: of lengths, from a row of units.
        rate_hz: frames a second, from the lines above.
    """

    names: list[str]
    line: int
    unit: str | None = None
    rate_hz: float | None = None


def find_header(
    lines: Iterable[tuple[int, str]], accepts: Callable[[list[str]], bool], *, any_names: bool = False
) -> Header | None:
    """The first line, or pair of lines, whose names a reader accepts.

    Args:
        lines: numbered.
        accepts: whether a list of names is such a header.
        any_names: otherwise take the first line of words right above a row of numbers.
    """
    found: Header | None = None
    previous: list[str] = []
    previous_line = 0
    rate: float | None = None
    for number, line in islice(lines, _MOST_LINES):
        if found is not None and line.startswith(COMMENTS):
            continue
        cells = split_names(_COMMENT.sub("", line, count=1) if line.lstrip().startswith(COMMENTS) else line)
        if found is not None:
            units = {match[1].lower() for cell in cells if (match := _UNITS.fullmatch(cell)) and match[1]}
            if not units or not all(_UNITS.fullmatch(cell) for cell in cells):
                break
            lengths = units & {"mm", "cm", "m"}
            return found._replace(line=number, unit=lengths.pop() if len(lengths) == 1 else None)
        rate = _rate(previous, cells) or rate
        for names in (_two_rows(previous, cells), cells):
            if found is None and names and accepts(names):
                found = Header(names, number, rate_hz=rate)
        if found is None and any_names and len(previous) == len(cells) and _is_row(cells) and _is_words(previous):
            return Header(previous, previous_line, rate_hz=rate)
        previous, previous_line = ([] if line.startswith(COMMENTS) else cells), number
    return found


def first_rows(lines: Iterable[tuple[int, str]], width: int) -> tuple[Dialect, list[list[str]]]:
    """How the rows below a header are written, if possible as `width` cells, and the first ones' cells."""
    below = (line for _, line in lines if line.strip(" \t,;") and not line.startswith(COMMENTS))
    rows = list(islice(below, _SAMPLE_ROWS))
    dialects = [find_dialect(row, width) for row in rows] or [Dialect(",")]
    # Whole numbers do not show that 1,5 is one and a half.
    dialect = next((dialect for dialect in dialects if dialect.decimal_comma), dialects[0])
    return dialect, [dialect.row(row) for row in rows]


def columns_of_words(rows: Sequence[Sequence[str]], columns: Iterable[int]) -> set[int]:
    """Those of `columns` in which most cells that are not empty hold no numbers."""
    found: set[int] = set()
    for column in columns:
        said = [row[column] for row in rows if column < len(row) and row[column].strip()]
        if 2 * sum(map(is_number, said)) < len(said):
            found.add(column)
    return found


def _two_rows(above: Sequence[str], cells: Sequence[str]) -> list[str]:
    """Joints' names above axes, as in Vicon's tables; empty where `cells` are no axes."""
    axes = [_AXIS.fullmatch(cell) for cell in cells]
    if sum(axis is not None for axis in axes) < 3:
        return []
    first = next(column for column, axis in enumerate(axes) if axis)
    names: list[str] = []
    joint = ""
    for column, (cell, axis) in enumerate(zip(cells, axes, strict=True)):
        over = above[column] if column < len(above) else ""
        joint = over or joint
        if column < first:
            names.append(cell or over)
        else:
            names.append(f"{joint} {axis[1] if axis else cell}" if joint else cell)
    return names


def _is_row(cells: Sequence[str]) -> bool:
    return sum(map(is_digits, cells)) >= max(_LEAST_COLUMNS, len(cells) // 2) and all(map(is_number, cells[:2]))


def _is_words(cells: Sequence[str]) -> bool:
    return len(cells) >= _LEAST_COLUMNS and not any(map(is_digits, cells))


def _rate(previous: Sequence[str], cells: Sequence[str]) -> float | None:
    """Of `FREQUENCY 100` (Qualisys), or of the lines `Trajectories` and `120` (Vicon)."""
    value = ""
    if len(cells) >= 2 and re.sub(r"[^a-z]", "", cells[0].lower()) in _RATE_KEYS:
        value = cells[1]
    elif len(cells) == 1 and [cell.lower() for cell in previous[:1]] == ["trajectories"]:
        value = cells[0]
    return float(value) if is_digits(value) and 0.0 < float(value) < 1e5 else None
