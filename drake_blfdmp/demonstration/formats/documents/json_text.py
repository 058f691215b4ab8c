"""JSON that may be anything: bounded memory, one-line errors with their place, and the slips of common writers."""

import gc
import json
import re
from pathlib import Path
from typing import Any

import numpy as np

from drake_blfdmp.demonstration.formats.text import MAX_FILE_BYTES, number_or_nan
from drake_blfdmp.errors import RecordingError

_MAX_PARSED_BYTES = 700 << 20  # What the parsed document may take in memory.
_BYTES_OF = {b"[": 88, b"{": 240, b",": 40, b":": 60}  # What CPython spends on each, with room to spare.

_BEGINNING = re.compile(rb'(?:\xef\xbb\xbf)?\s*(?:\{\s*["}]|\[\s*[\[\]{"\dn-])')
_BARE_NAN = re.compile(r"(?<=[\[,:\s])-?nan(?:\([^)\"]{0,20}\))?(?=[\s,\]}])")  # As C's printf writes it.


def looks_like_json(head: bytes) -> bool:
    """Whether a file's first bytes begin a JSON object or array."""
    return b"\0" not in head and _BEGINNING.match(head) is not None


def load_json(path: Path) -> Any:
    """The document; of a file with one JSON object a line, the list of them.

    `NaN`, `Infinity` and C's `nan` are read as numbers; of equal keys in one object the last counts.

    Raises:
        RecordingError: no JSON (with line and column), not UTF-8, too deeply nested, or too large for the memory.
    """
    size = path.stat().st_size
    if size > MAX_FILE_BYTES:
        raise RecordingError(f"{path}: larger than {MAX_FILE_BYTES >> 30} GB; cut the recording into shorter files")
    data = path.read_bytes()
    letter = 1 if data.isascii() else 4  # Bytes of the text in memory.
    parsed = (1 + letter) * size + sum(data.count(sign) * spent for sign, spent in _BYTES_OF.items())
    if parsed > _MAX_PARSED_BYTES:
        raise RecordingError(
            f"{path}: {size >> 20} MB of JSON would take {parsed >> 20} MB of memory; "
            "cut the recording into shorter files"
        )
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise RecordingError(f"{path}: line {line} is not UTF-8 text; save the file as UTF-8") from None
    del data
    collecting = gc.isenabled()
    gc.disable()  # Parsing makes millions of lists and no garbage; looking through them takes as long as parsing.
    try:
        return _parse(text)
    except json.JSONDecodeError as error:
        raise RecordingError(
            f"{path}: line {error.lineno}, column {error.colno}: no JSON ({error.msg}); "
            "the file is cut off or damaged, export it again"
        ) from None
    except RecursionError:
        raise RecordingError(f"{path}: nested too deeply to be a recording; give the recording's own file") from None
    except ValueError:  # The one that is no JSONDecodeError: an integer of more digits than Python converts.
        raise RecordingError(f"{path}: holds an integer of thousands of digits; export the file again") from None
    finally:
        if collecting:
            gc.enable()


def _parse(text: str) -> Any:
    try:
        return json.loads(text)
    except json.JSONDecodeError as error:
        first = error
    if first.msg == "Extra data":
        return _json_lines(text)
    if _BARE_NAN.search(text):
        return json.loads(_BARE_NAN.sub("NaN", text))
    raise first


def _json_lines(text: str) -> list[Any]:
    decoder = json.JSONDecoder()
    following = re.compile(r"[^\s,]")
    documents: list[Any] = []
    position = 0
    while (found := following.search(text, position)) is not None:
        document, position = decoder.raw_decode(text, found.start())
        documents.append(document)
    return documents


def number(value: Any) -> float:
    """A JSON value as a number, NaN for null and for texts that stand for a missing one.

    Raises:
        ValueError: any other text, list or object, or an integer beyond every float.
    """
    if value is None:
        return np.nan
    if isinstance(value, str):
        return number_or_nan(value)
    try:
        return float(value)
    except (TypeError, OverflowError):
        raise ValueError from None
