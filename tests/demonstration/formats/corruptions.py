"""Files as accidents make them, from a good one: a name, and what happens to its bytes."""

import re
from collections.abc import Callable

import numpy as np

_NUMBER = re.compile(rb"(?<![\w.])-?\d+\.\d+(?:[eE][+-]?\d+)?")  # With a point: a coordinate or a time.


def _numbers(replace: Callable[[int, bytes], bytes]) -> Callable[[bytes], bytes]:
    """Every number of a text goes through `replace(index, text)`; of a binary file, every eighth byte on from the
    middle."""

    def corrupt(data: bytes) -> bytes:
        if _is_binary(data):
            changed = np.frombuffer(data, np.uint8).copy()
            changed[len(data) // 2 :: 8] = np.frombuffer(replace(7, b"1.5")[:1] or b"\0", np.uint8)[0]
            return changed.tobytes()
        count = iter(range(10**9))
        return _NUMBER.sub(lambda match: replace(next(count), match.group()), data)

    return corrupt


def _is_binary(data: bytes) -> bool:
    return b"\0" in data[:4096]


def _lines(change: Callable[[list[bytes]], list[bytes]]) -> Callable[[bytes], bytes]:
    """`change` of the lines of a text, or of pieces of 64 bytes of a binary file."""

    def corrupt(data: bytes) -> bytes:
        if _is_binary(data):
            return b"".join(change([data[i : i + 64] for i in range(0, len(data), 64)]))
        return b"\n".join(change(data.split(b"\n")))

    return corrupt


def _noise(data: bytes, share: float) -> bytes:
    random = np.random.default_rng(len(data))
    changed = np.frombuffer(data, np.uint8).copy()
    hit = random.random(len(changed)) < share
    changed[hit] = random.integers(0, 256, hit.sum())
    return changed.tobytes()


def _middle(lines: list[bytes]) -> int:
    return len(lines) // 2


CORRUPTIONS: dict[str, Callable[[bytes], bytes]] = {
    "empty": lambda data: b"",
    "one byte": lambda data: data[:1],
    "cut in the header": lambda data: data[: min(40, len(data) // 3)],
    "cut in the middle": lambda data: data[: len(data) // 2],
    "cut before the last byte": lambda data: data[:-1],
    "cut in the last number": lambda data: data[:-9],
    "beginning lost": lambda data: data[len(data) // 3 :],
    "one byte per mille junk": lambda data: _noise(data, 0.001),
    "five per cent junk": lambda data: _noise(data, 0.05),
    "all junk": lambda data: _noise(data, 1.0),
    "zeros in the middle": lambda data: data[: len(data) // 2] + bytes(500) + data[len(data) // 2 :],
    "not UTF-8": lambda data: data[: len(data) // 2] + b"\xff\xfe\xe9" + data[len(data) // 2 :],
    "UTF-16": lambda data: data.decode("latin-1").encode("utf-16"),
    "nan": _numbers(lambda i, text: b"nan" if i % 7 == 3 else text),
    "all nan": _numbers(lambda i, text: b"NaN"),
    "inf": _numbers(lambda i, text: b"-inf" if i % 50 == 20 else text),
    "huge": _numbers(lambda i, text: b"1e308" if i % 40 == 20 else text),
    "too many digits": _numbers(lambda i, text: b"9" * 5000 if i == 30 else text),
    "words": _numbers(lambda i, text: b"oops" if i == 25 else text),
    "zeros": _numbers(lambda i, text: b"0.0"),
    "all the same": _numbers(lambda i, text: b"1.5"),
    "negative": _numbers(lambda i, text: b"-" + text.lstrip(b"-")),
    "mixed units": lambda data: _halves(data, b"%.6f"),
    "decimal commas": _numbers(lambda i, text: text.replace(b".", b",")),
    "line lost": _lines(lambda lines: lines[: _middle(lines)] + lines[_middle(lines) + 1 :]),
    "line twice": _lines(lambda lines: lines[: _middle(lines)] + lines[_middle(lines) - 1 :]),
    "half a line": _lines(
        lambda lines: [line[: len(line) // 2] if k == _middle(lines) else line for k, line in enumerate(lines)]
    ),
    "two lines joined": _lines(
        lambda lines: [*lines[: _middle(lines)], b"".join(lines[_middle(lines) :][:2]), *lines[_middle(lines) + 2 :]]
    ),
    "backwards": _lines(lambda lines: lines[:3] + lines[3:][::-1]),
    "shuffled": _lines(
        lambda lines: [lines[k] for k in np.random.default_rng(0).permutation(len(lines))],
    ),
    "no header": _lines(lambda lines: lines[1:]),
    "header only": _lines(lambda lines: lines[:2]),
    "twice": lambda data: data + data,
    "a very long line": lambda data: data[: len(data) // 2] + b"7 " * 2_000_000 + data[len(data) // 2 :],
    "deeply nested": lambda data: b"[" * 100_000 + data,
}
"""Name -> what happens to a file's bytes."""


def _halves(data: bytes, form: bytes) -> bytes:
    """The second half of a text's numbers a thousand times as large."""
    total = len(_NUMBER.findall(data)) if not _is_binary(data) else 0
    return _numbers(lambda i, text: form % (1000.0 * float(text)) if i > total // 2 else text)(data)
