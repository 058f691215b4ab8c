"""Serialised ROS messages in bulk: of messages with one structure, all numbers are taken out at once.

A message is walked over field by field once; the messages that equal it in every name, count and number of its
structure are then columns of bytes. What is walked over is therefore the number of different structures (a person
comes or goes), not of messages.
"""

from collections.abc import Callable, Iterator, Sequence
from typing import TypeVar

import numpy as np

from drake_blfdmp.ros2.cdr import CdrReader

_MOST_STRUCTURES = 32  # Of one length; from then on messages are walked over one by one.
_BLOCK = 1024
_T = TypeVar("_T")


class Ros1Reader(CdrReader):
    """The same walk over a ROS 1 message: no header, nothing aligned, strings without a closing NUL."""

    def __init__(self, data: bytes):
        super().__init__(b"\0\1\0\0")
        self._data = data
        self._at = 0

    def _take(self, size: int, align: int) -> int:
        return super()._take(size, 1)

    def string(self) -> str:
        length = self.uint32()
        start = self._read(length, 1)
        return self._data[start : start + length].decode()


def reader_of(message: bytes, cdr: bool) -> CdrReader:
    """The reader of a message's fields."""
    return CdrReader(message) if cdr else Ros1Reader(message)


def alike(
    messages: Sequence[bytes], walk: Callable[[bytes], tuple[_T, list[tuple[int, int]]]]
) -> Iterator[tuple[_T, np.ndarray, np.ndarray]]:
    """Yields (what `walk` found, numbers (n,) of the messages, their bytes (n, length)) for each structure.

    Args:
        messages: of one type.
        walk: message -> what stands where, and the (start, size) of the bytes of its structure.

    Raises:
        ValueError: from `walk`, with the message's number.
    """
    by_length: dict[int, list[int]] = {}
    for number, message in enumerate(messages):
        by_length.setdefault(len(message), []).append(number)
    for length, numbers in by_length.items():
        pending = np.array(numbers)
        raw = np.frombuffer(b"".join(messages[k] for k in numbers), np.uint8).reshape(len(numbers), length)
        structures = 0
        while len(pending):
            structures += 1
            try:
                found, spans = walk(messages[pending[0]])
            except ValueError as error:
                raise ValueError(f"message {pending[0]}: {error}") from None
            if structures > _MOST_STRUCTURES:
                yield found, pending[:1], raw[:1]
                pending, raw = pending[1:], raw[1:]
                continue
            same = _same_as_first(raw, spans)
            if same.all():
                yield found, pending, raw
                break
            yield found, pending[same], raw[same]
            pending, raw = pending[~same], raw[~same]


def _same_as_first(raw: np.ndarray, spans: Sequence[tuple[int, int]]) -> np.ndarray:
    """(n,) whether messages have the first one's bytes in all spans."""
    fixed = np.zeros(raw.shape[1], bool)
    for start, size in spans:
        fixed[start : start + size] = True
    wanted = raw[0, fixed]
    blocks = (raw[start : start + _BLOCK] for start in range(0, len(raw), _BLOCK))
    return np.concatenate([(block[:, fixed] == wanted).all(axis=1) for block in blocks])


def columns(raw: np.ndarray, start: int, count: int, dtype: str) -> np.ndarray:
    """(n, count) numbers of one type that stand from byte `start` on, as float64 or int64."""
    size = np.dtype(dtype).itemsize * count
    numbers = np.ascontiguousarray(raw[:, start : start + size]).view(dtype)
    return numbers.astype(np.int64 if np.dtype(dtype).kind in "iu" else float)


def stamps(raw: np.ndarray, start: int, cdr: bool) -> np.ndarray:
    """(n,) times in ns; ROS 1 counts seconds without a sign."""
    seconds = columns(raw, start, 1, "<i4" if cdr else "<u4")[:, 0]
    return seconds * 1_000_000_000 + columns(raw, start + 4, 1, "<u4")[:, 0]
