"""From columns to people: clocks written as words, frame numbers, confidence, and whose row is whose."""

from collections.abc import Sequence
from datetime import UTC, datetime, time
from pathlib import Path

import numpy as np

from drake_blfdmp.demonstration.formats.confidence import confidence_of_word
from drake_blfdmp.demonstration.formats.tables.tables import Columns, Words, count_frames, whole_numbers
from drake_blfdmp.demonstration.formats.text import number_or_nan
from drake_blfdmp.demonstration.raw_recording import Body
from drake_blfdmp.errors import RecordingError

_NOBODY = frozenset({"", "-1", "nan", "none", "null", "na"})


def clock_values(path: Path, table: Columns, column: int | None, name: str) -> tuple[np.ndarray | None, str | None]:
    """(N,) times and their unit, where the way they are written tells it; None where the column is empty or absent.

    Raises:
        RecordingError: a word that is neither a number nor a time of day or date in ISO 8601.
    """
    if column is None:
        return None, None
    if column in table.numbers:
        t = table.numbers[column]
        return (None if np.isnan(t).all() else t), None
    words = table.words[column]
    seconds = np.full(len(words.known), np.nan)
    for index, word in enumerate(words.known):
        try:
            seconds[index] = _seconds(word)
        except ValueError:
            line = table.lines[int(np.argmax(words.index == index))]
            raise RecordingError(
                f"{path}: line {line}, column {name}: {word[:40]!r} is no number and no time; repair it"
            ) from None
    return seconds[words.index], "s"


def frame_values(path: Path, table: Columns, column: int | None, name: str) -> np.ndarray | None:
    """(N,) frame numbers as int; None where the column is absent, holds words, or fractions, which count no frames.

    Raises:
        RecordingError: one is missing or too large.
    """
    if column is None or column not in table.numbers:
        return None
    values = table.numbers[column]
    if np.any(np.isfinite(values) & (values != np.round(values))):
        return None
    return whole_numbers(path, values, table.lines, name)


def confidence_values(table: Columns, columns: Sequence[int | None]) -> np.ndarray:
    """(N, C) the numbers, or the numbers that words stand for; NaN where nothing is said."""
    values = np.full((len(table.lines), len(columns)), np.nan)
    for index, column in enumerate(columns):
        if column in table.numbers:
            values[:, index] = table.numbers[column]
        elif column in table.words:
            words = table.words[column]
            values[:, index] = np.array([_number_of(word) for word in words.known] or [np.nan])[words.index]
    return values


def split_people(
    words: Words | None,
    x: np.ndarray,
    t: np.ndarray | None,
    frames: np.ndarray | None,
    confidence: np.ndarray | None,
    orientations: np.ndarray | None = None,
) -> tuple[dict[str, Body], int]:
    """Each person's rows, and the number of rows that hold nobody.

    Args:
        words: each row's person; None where there is one only. A different one in nearly every row names no person.
        x: (N, 6, 3).
        t: (N,) or None.
        frames: (N,) or None, which counts the rows, or the different times where several people share them.
        confidence: (N, 6) or None.
        orientations: (N, 2, 4) or None.
    """
    if words is None or (len(words.known) > 1 and 2 * len(words.known) > len(words.index)):
        words = Words(np.zeros(len(x), dtype=int), ["0"])
    names = np.array(words.known, dtype=object)[words.index] if len(x) else np.empty(0, dtype=object)
    people = list(dict.fromkeys(words.known))
    nobody = np.isnan(x).all(axis=(1, 2)) & np.array([name.lower() in _NOBODY for name in names], dtype=bool)
    if frames is None and t is not None and len(people) > 1:
        frames = np.cumsum(np.r_[False, np.diff(t) != 0.0])
    bodies: dict[str, Body] = {}
    for person in people:
        rows = (names == person) & ~nobody
        if rows.any() or len(x) == 0:
            count = int(rows.sum())
            bodies[person or "?"] = Body(
                x[rows],
                np.arange(count) if frames is None else frames[rows],
                None if t is None else t[rows],
                None if confidence is None else confidence[rows],
                None if orientations is None else orientations[rows],
            )
    return bodies, int(nobody.sum())


def _number_of(word: str) -> float:
    try:
        return number_or_nan(word) if word else np.nan
    except ValueError:
        return confidence_of_word(word)


def _seconds(word: str) -> float:
    """Seconds of a date since 1970, or of a time since midnight."""
    if not word:
        return np.nan
    try:
        return number_or_nan(word)
    except ValueError:
        pass
    word = word.replace("/", "-")
    try:
        moment = datetime.fromisoformat(word)
    except ValueError:
        day = time.fromisoformat(word)
        return day.hour * 3600 + day.minute * 60 + day.second + day.microsecond * 1e-6
    return (moment if moment.tzinfo else moment.replace(tzinfo=UTC)).timestamp()


def leading_columns(
    table: Columns, columns: Sequence[int]
) -> tuple[np.ndarray | None, np.ndarray | None, Words | None]:
    """What nameless columns before the joints hold: (times, frame numbers, people), None for each that is absent.

    Args:
        table: has `columns` as numbers, and as words where there are two.
        columns: none, one or two.
    """
    t = frames = person = None
    for column in columns:
        values = table.numbers[column]
        if len(columns) == 2 and person is None and _names_people(values, table.words[column]):
            person = table.words[column]
        elif frames is None and count_frames(values):
            frames = values.astype(int)
        elif t is None:
            t = values
    return t, frames, person


def _names_people(values: np.ndarray, words: Words) -> bool:
    """A few whole numbers, each of them in many rows."""
    few = len(words.known) <= 10 and 3 * len(words.known) <= len(values)
    return few and bool(np.all(values == np.round(values)))
