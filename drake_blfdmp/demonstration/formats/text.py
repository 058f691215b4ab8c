"""Reading text that may be anything: bounded lines, one-line errors, missing cells as NaN."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from drake_blfdmp.errors import RecordingError

MAX_LINE_BYTES = 1 << 20
MAX_FILE_BYTES = 1 << 30

_BLOCK_BYTES = 1 << 22
_MISSING = frozenset({"", "-", "nan", "na", "n/a", "null", "none"})


def head_lines(head: bytes) -> list[str]:
    """The non-blank lines of a file's first bytes, up to the first that is not UTF-8 text."""
    cut = head.rfind(b"\n")  # The head may end within a character or a number.
    head = head[: cut + 1] if cut >= 0 else head
    try:
        text = head.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        text = head[: head.rfind(b"\n", 0, error.start) + 1].decode("utf-8-sig")
    if "\0" in text:
        text = text[: text.rfind("\n", 0, text.index("\0")) + 1]
    return [line for line in _unix(text).split("\n") if line.strip()]


def text_blocks(path: Path, first_line: int = 1) -> Iterator[tuple[int, str]]:
    r"""Yields (number of its first line from 1, whole lines) of some megabytes; every line end is a single "\n".

    Args:
        path: the file.
        first_line: lines before this one are read but not yielded.

    Raises:
        RecordingError: a file or a line too long to be a recording, or bytes that are not UTF-8 text.
    """
    if path.stat().st_size > MAX_FILE_BYTES:
        raise RecordingError(f"{path}: larger than {MAX_FILE_BYTES >> 30} GB; cut the recording into shorter files")
    with path.open("rb") as file:
        number = 1
        while raw := file.read(_BLOCK_BYTES):
            if not raw.endswith(b"\n"):
                raw += file.readline(MAX_LINE_BYTES + 1)
            text = _decoded(path, number, raw)
            _require_short_lines(path, number, text)
            following = number + text.count("\n")
            if first_line > number:
                skipped = min(first_line, following) - number
                text = text.split("\n", skipped)[-1]
                number += skipped
            if text:
                yield number, text
            number = following


def numbered_lines(path: Path, first_line: int = 1) -> Iterator[tuple[int, str]]:
    """Yields (number from 1, line without its end) of the non-blank lines from `first_line` on.

    Raises:
        RecordingError: as `text_blocks`.
    """
    for first, text in text_blocks(path, first_line):
        for number, line in enumerate(text.split("\n"), first):
            if line.strip():
                yield number, line


def number_or_nan(cell: str) -> float:
    """A cell's number, NaN where it is empty or says so; raises ValueError for any other text."""
    if cell.strip().lower() in _MISSING:
        return np.nan
    if "_" in cell:
        raise ValueError  # Python's own 1_000 is no number of other tools.
    return float(cell)


def kept_lines(first: int, text: str, blank: str = " \t", dropped: tuple[str, ...] = ()) -> tuple[list[int], list[str]]:
    """The numbers and the text of the lines that hold more than `blank` and do not begin with `dropped`.

    Args:
        first: the number of the first line.
        text: lines that each end with a line end, except perhaps the last.
        blank: characters.
        dropped: beginnings.
    """
    lines = text.split("\n")
    kept = [line for line in lines if line.strip(blank)]
    if any(start in text for start in dropped):
        kept = [line for line in kept if not line.startswith(dropped)]
    if len(kept) == len(lines) - 1 and not lines[-1]:
        return list(range(first, first + len(kept))), kept
    numbers = [number for number, line in enumerate(lines, first) if line.strip(blank) and not line.startswith(dropped)]
    return numbers, kept


def is_number(cell: str) -> bool:
    """Whether a cell holds a number or stands for a missing one."""
    try:
        number_or_nan(cell)
    except ValueError:
        return False
    return True


def is_digits(cell: str) -> bool:
    """Whether a cell holds a number indeed."""
    return is_number(cell) and not np.isnan(number_or_nan(cell))


def _unix(text: str) -> str:
    return text.replace("\r\n", "\n").replace("\r", "\n") if "\r" in text else text


def _decoded(path: Path, number: int, raw: bytes) -> str:
    try:
        text = raw.decode("utf-8-sig" if number == 1 else "utf-8")
    except UnicodeDecodeError as error:
        line = number + raw.count(b"\n", 0, error.start)
        raise RecordingError(f"{path}: line {line} is not UTF-8 text; save the file as UTF-8") from None
    if "\0" in text:
        line = number + text.count("\n", 0, text.index("\0"))
        raise RecordingError(f"{path}: line {line} holds binary data; give the recording as text")
    return _unix(text)


def _require_short_lines(path: Path, number: int, text: str) -> None:
    lengths = list(map(len, text.split("\n")))
    if max(lengths) > MAX_LINE_BYTES:
        raise RecordingError(
            f"{path}: line {number + lengths.index(max(lengths))} is longer than {MAX_LINE_BYTES >> 20} MB; "
            "this is no table with one sample a line"
        )
