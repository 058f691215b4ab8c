"""A table's columns as arrays, missing cells as NaN."""

from collections import defaultdict
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from drake_blfdmp.demonstration.formats.tables.dialect import COMMENTS, Dialect
from drake_blfdmp.demonstration.formats.tables.table_blocks import Shape, fast_block, slow_block
from drake_blfdmp.demonstration.formats.text import kept_lines, text_blocks
from drake_blfdmp.errors import RecordingError

_MAX_CELLS = 1 << 24  # Of those wanted; 128 MB, of which some copies are made later.


class Words(NamedTuple):
    """A column of words: (N,) the index of each row's word in `known`, whose words have no blanks around."""

    index: np.ndarray
    known: list[str]


class Columns(NamedTuple):
    """Some columns of a table.

    Attributes:
        numbers: column -> (N,), NaN where missing.
        words: column -> words.
        lines: (N,) the rows' line numbers.
    """

    numbers: dict[int, np.ndarray]
    words: dict[int, Words]
    lines: np.ndarray


def read_columns(
    path: Path,
    dialect: Dialect,
    width: int,
    numbers: Sequence[int],
    words: Sequence[int] = (),
    *,
    first_line: int = 1,
    names: Sequence[str] = (),
    short_rows: bool = False,
    skip_empty: bool = True,
    keep: Callable[[str], bool] | None = None,
) -> Columns:
    """Some columns of a table's rows.

    Args:
        path: the file.
        dialect: how its rows are written.
        width: cells a row; more are allowed only where they are empty.
        numbers: the columns of numbers wanted.
        words: the columns of words wanted.
        first_line: of the first row.
        names: of the columns, for messages.
        short_rows: cells may be missing at a row's end.
        skip_empty: rows of empty cells are no rows.
        keep: whether a row is wanted with this cell in the first column of words; all are without. The words of
            the other rows are still among those known.

    Raises:
        RecordingError: a row of another width, a cell that is no number, too many rows; or as `text_blocks`.
    """
    vocabularies: list[defaultdict[str, int]] = [_counting() for _ in words]
    values: list[np.ndarray] = [np.empty((0, len(numbers)))]
    codes: list[list[np.ndarray]] = [[np.empty(0, dtype=int)] for _ in words]
    lines: list[np.ndarray] = [np.empty(0, dtype=int)]
    blank = " \t" + (dialect.separator or "") if skip_empty else " \t"
    count = 0
    shape = Shape(dialect, width, numbers, words, names, short_rows, keep)
    for first, text in text_blocks(path, first_line):
        line_numbers, rows = kept_lines(first, text, blank, COMMENTS)
        if not rows:
            continue
        block = fast_block(rows, shape) or slow_block(path, line_numbers, rows, shape)
        count += len(block.numbers)
        if count * (len(numbers) + len(words)) > _MAX_CELLS:
            raise RecordingError(f"{path}: more than {count} rows; cut the recording into shorter files")
        values.append(block.numbers)
        lines.append(np.array(line_numbers)[block.kept])
        for code, vocabulary, column in zip(codes, vocabularies, block.words, strict=True):
            code.append(np.fromiter(map(vocabulary.__getitem__, column), dtype=int, count=len(column))[block.kept])
    return Columns(
        dict(zip(numbers, np.concatenate(values).T, strict=True)),
        {
            column: Words(np.concatenate(code), [word.strip() for word in vocabulary])
            for column, code, vocabulary in zip(words, codes, vocabularies, strict=True)
        },
        np.concatenate(lines),
    )


def whole_numbers(path: Path, values: np.ndarray, lines: np.ndarray, name: str) -> np.ndarray:
    """A column of frame numbers as (N,) int.

    Raises:
        RecordingError: one that is missing or larger than any counter.
    """
    bad = ~(np.abs(values) < 2.0**53)
    if bad.any():
        line = lines[int(np.argmax(bad))]
        raise RecordingError(f"{path}: line {line}, column {name}: no whole number; repair or remove the line")
    return values.astype(int)


def count_frames(values: np.ndarray) -> bool:
    """Whether a nameless column counts the frames of a 30 Hz sensor: whole numbers that step by a few.

    In milliseconds, the coarsest unit in which sensors count whole numbers, such a sensor steps by 33.
    """
    if len(values) == 0 or not np.all(np.abs(values) < 2.0**53) or not np.all(values == np.round(values)):
        return False
    steps = np.abs(np.diff(values))
    steps = steps[steps > 0.0]
    return len(steps) == 0 or float(np.median(steps)) < 16.0


def _counting() -> defaultdict[str, int]:
    """A dict that gives every new key the next number."""
    counting: defaultdict[str, int] = defaultdict()
    counting.default_factory = counting.__len__
    return counting
