"""A block of a table's rows as arrays: quickly where the rows are regular, else row by row.

NumPy's C reader takes whole blocks of regular rows; a block that it refuses is read again row by row, which repairs
what may be repaired (quotation marks, words for missing numbers) and names the line where nothing may.
"""

import csv
from collections.abc import Callable, Sequence
from itertools import compress
from operator import methodcaller
from pathlib import Path
from typing import NamedTuple

import numpy as np

from drake_blfdmp.demonstration.formats.tables.dialect import Dialect
from drake_blfdmp.demonstration.formats.text import number_or_nan
from drake_blfdmp.errors import RecordingError


class Shape(NamedTuple):
    """What is wanted of a table: see `tables.read_columns`."""

    dialect: Dialect
    width: int
    numbers: Sequence[int]
    words: Sequence[int]
    names: Sequence[str]
    short_rows: bool
    keep: Callable[[str], bool] | None


class Block(NamedTuple):
    """The numbers (k, C) of the rows kept, every column of words of all n rows, and which rows are kept, (n,)."""

    numbers: np.ndarray
    words: list[list[str]]
    kept: np.ndarray


def fast_block(rows: list[str], shape: Shape) -> Block | None:
    """The rows by NumPy's reader; None where they are not all regular."""
    separator = shape.dialect.separator
    lines = _regular(rows, shape)
    if lines is None:
        return None
    words = [[line.split(separator, column + 1)[column] for line in lines] for column in shape.words]
    kept = _kept(len(lines), words, shape)
    wanted = lines if shape.keep is None else list(compress(lines, kept))
    if not wanted:
        return Block(np.empty((0, len(shape.numbers))), words, kept)
    try:
        numbers = np.loadtxt(wanted, delimiter=separator, usecols=list(shape.numbers), comments=None, ndmin=2)
    except ValueError:
        return None
    return Block(numbers, words, kept) if len(numbers) == len(wanted) else None


def slow_block(path: Path, line_numbers: list[int], rows: list[str], shape: Shape) -> Block:
    """The rows one by one.

    Raises:
        RecordingError: a row of another width, a cell that is no number, or quotation marks that do not match.
    """
    cells = [_cells(path, number, line, shape) for number, line in zip(line_numbers, rows, strict=True)]
    words = [[row[column] for row in cells] for column in shape.words]
    kept = _kept(len(rows), words, shape)
    numbers = np.empty((int(kept.sum()), len(shape.numbers)))
    for index, row in enumerate(np.flatnonzero(kept)):
        for place, column in enumerate(shape.numbers):
            try:
                numbers[index, place] = number_or_nan(cells[row][column])
            except ValueError:
                name = shape.names[column] if column < len(shape.names) and shape.names[column] else column + 1
                raise RecordingError(
                    f"{path}: line {line_numbers[row]}, column {name}: {cells[row][column][:40]!r} is no number; "
                    "repair it"
                ) from None
    return Block(numbers, words, kept)


def _kept(count: int, words: list[list[str]], shape: Shape) -> np.ndarray:
    if shape.keep is None:
        return np.ones(count, dtype=bool)
    return np.fromiter(map(shape.keep, words[0]), dtype=bool, count=count)


def _regular(rows: list[str], shape: Shape) -> list[str] | None:
    """The rows with points for decimal commas and nan for empty cells; None where one has another number of cells."""
    (separator, decimal_comma), width = shape.dialect, shape.width
    text = "\n".join(rows)
    if '"' in text:
        return None
    if decimal_comma:
        text = text.replace(",", ".")
    if separator is None:
        return text.split("\n") if np.all(_blank_separated_widths(text) == width) else None
    if shape.short_rows:
        text = "\n".join(line + separator * (width - 1 - line.count(separator)) for line in text.split("\n"))
    cells = {count + 1 for count in set(map(methodcaller("count", separator), text.split("\n")))}
    if not cells <= {width, width + 1}:
        return None
    if width + 1 in cells and any(row.count(separator) == width and _last(row, separator) for row in rows):
        return None
    return _fill_empty(text, separator).split("\n")


def _last(row: str, separator: str) -> str:
    return row[row.rindex(separator) + 1 :].strip()


def _fill_empty(text: str, separator: str) -> str:
    """Empty cells become nan, except in the first column."""
    if separator * 2 in text:
        filled = f"{separator}nan{separator}"
        text = text.replace(separator * 2, filled).replace(separator * 2, filled)
    if separator + "\n" in text:
        text = text.replace(separator + "\n", separator + "nan\n")
    return text + "nan" if text.endswith(separator) else text


def _blank_separated_widths(text: str) -> np.ndarray:
    """The number of cells of every line."""
    data = np.frombuffer(("\n" + text).encode(), dtype=np.uint8)
    end = data == ord("\n")
    gap = end | (data == ord(" ")) | (data == ord("\t"))
    starts = np.flatnonzero(gap[:-1] & ~gap[1:])
    line = np.searchsorted(np.flatnonzero(end), starts, side="right") - 1
    return np.bincount(line, minlength=int(end.sum()))


def _cells(path: Path, number: int, line: str, shape: Shape) -> list[str]:
    try:
        cells = shape.dialect.split(line)
    except csv.Error as error:
        raise RecordingError(f"{path}: line {number}: {error}; repair its quotation marks") from None
    if len(cells) < shape.width and shape.short_rows:
        cells += [""] * (shape.width - len(cells))
    if len(cells) < shape.width or any(cell.strip() for cell in cells[shape.width :]):
        raise RecordingError(
            f"{path}: line {number} has {len(cells)} columns, expected {shape.width}; repair or remove the line"
        )
    return cells
