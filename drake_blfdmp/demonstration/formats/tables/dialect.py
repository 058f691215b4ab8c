"""How a line of text is cut into cells: separators, quotation marks, decimal commas."""

import csv
import re
from typing import NamedTuple

COMMENTS = ("#", "%", "//")
"""What a line that is none of a table's begins with."""

_SEPARATORS = (";", "\t", ",")
_MAX_NAMES, _MAX_NAME = 10_000, 200  # Names in a line, letters in a name.
_DECIMAL_COMMA = re.compile(r"[-+]?\d*,\d+(e[-+]?\d+)?", re.I)


class Dialect(NamedTuple):
    """What stands between cells (None: blanks, any number of them), and whether 1,5 is one and a half."""

    separator: str | None
    decimal_comma: bool = False

    def split(self, line: str) -> list[str]:
        """The cells of a line, quotation marks removed.

        Raises:
            csv.Error: quotation marks that do not match.
        """
        if '"' in line:
            cells = next(csv.reader([line], delimiter=self.separator or " ", skipinitialspace=True), [])
            cells = [cell for cell in cells if cell] if self.separator is None else cells
        else:
            cells = line.split(self.separator)
        return [cell.replace(",", ".") for cell in cells] if self.decimal_comma else cells

    def row(self, line: str) -> list[str]:
        """The cells of a line, without an empty last one; none where quotation marks do not match."""
        try:
            cells = self.split(line)
        except csv.Error:
            return []
        return cells[:-1] if cells and not cells[-1].strip() else cells


def split_names(line: str) -> list[str]:
    """The cells of a line of names, printable, cut to a sane length; empty ones at the end are dropped.

    Empty for a line of more cells than any table has.
    """
    separator = max(_SEPARATORS, key=line.count)
    if line.count(separator) >= _MAX_NAMES:
        return []
    try:
        cells = Dialect(separator if separator in line else None).split(line)
    except csv.Error:
        return []
    cells = ["".join(filter(str.isprintable, cell.strip()[:_MAX_NAME])).strip() for cell in cells[: _MAX_NAMES + 1]]
    while cells and not cells[-1]:
        cells.pop()
    return cells if len(cells) <= _MAX_NAMES else []


def find_dialect(line: str, *widths: int) -> Dialect:
    """How a row is written, preferably so that it has one of `widths` cells."""
    candidates = [Dialect(separator) for separator in _SEPARATORS if separator in line]
    candidates += [Dialect(None)] if line.split()[1:] or not candidates else []
    if "," in line:
        # "1,5;2,5" and "1,5 2,5": commas that stand within numbers.
        candidates = [
            Dialect(separator, True)
            for separator, _ in candidates
            if separator != "," and _has_decimal_commas(line.split(separator))
        ] + candidates
    fitting = (dialect for dialect in candidates if len(dialect.row(line)) in widths)
    return next(fitting, candidates[0])


def _has_decimal_commas(cells: list[str]) -> bool:
    used = [cell.strip() for cell in cells if "," in cell]
    return bool(used) and all(_DECIMAL_COMMA.fullmatch(cell) for cell in used)
