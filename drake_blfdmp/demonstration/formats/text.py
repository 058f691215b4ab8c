"""Reading text that may be anything: bounded lines, one-line errors, missing cells as NaN."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from drake_blfdmp.errors import RecordingError

MAX_LINE_BYTES = 1 << 20
MAX_FILE_BYTES = 1 << 30

_MISSING = frozenset({"", "-", "nan", "na", "n/a", "null", "none", "inf", "-inf", "+inf"})


def head_lines(head: bytes) -> list[str]:
    """The non-blank lines of a file's first bytes; empty where these are not UTF-8 text."""
    if b"\0" in head:
        return []
    cut = head.rfind(b"\n")  # The head may end within a character or a number.
    try:
        text = (head[: cut + 1] if cut >= 0 else head).decode("utf-8-sig")
    except UnicodeDecodeError:
        return []
    return [line for line in text.splitlines() if line.strip()]


def numbered_lines(path: Path) -> Iterator[tuple[int, str]]:
    """Yields (number from 1, line without its end) of the non-blank lines.

    Raises:
        RecordingError: a file or a line too long to be a recording, or bytes that are not UTF-8 text.
    """
    if path.stat().st_size > MAX_FILE_BYTES:
        raise RecordingError(f"{path}: larger than {MAX_FILE_BYTES >> 30} GB; cut the recording into shorter files")
    with path.open("rb") as file:
        number = 0
        while raw := file.readline(MAX_LINE_BYTES + 1):
            number += 1
            if len(raw) > MAX_LINE_BYTES:
                raise RecordingError(
                    f"{path}: line {number} is longer than {MAX_LINE_BYTES >> 20} MB; "
                    "this is no table with one sample a line"
                )
            try:
                line = raw.decode("utf-8-sig" if number == 1 else "utf-8")
            except UnicodeDecodeError:
                raise RecordingError(f"{path}: line {number} is not UTF-8 text; save the file as UTF-8") from None
            if "\0" in line:
                raise RecordingError(f"{path}: line {number} holds binary data; give the recording as text")
            if line.strip():
                yield number, line.rstrip("\r\n")


def number_or_nan(cell: str) -> float:
    """A cell's number, NaN where it is empty or says so; raises ValueError for any other text."""
    try:
        value = float(cell)
    except ValueError:
        if cell.strip().lower() in _MISSING:
            return np.nan
        raise
    return value if np.isfinite(value) else np.nan


def is_number(cell: str) -> bool:
    """Whether a cell holds a number or stands for a missing one."""
    try:
        number_or_nan(cell)
    except ValueError:
        return False
    return True
