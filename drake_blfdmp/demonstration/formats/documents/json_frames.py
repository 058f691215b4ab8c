"""Where a JSON document keeps its frames, and what it says about them: times, numbers, rate, units."""

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from drake_blfdmp.demonstration.formats.documents.json_text import number
from drake_blfdmp.demonstration.formats.recording_format import Joints
from drake_blfdmp.demonstration.formats.tables.table_names import frame_column, plain, time_column
from drake_blfdmp.demonstration.upright import AXES
from drake_blfdmp.errors import RecordingError

_LISTS = ("frames", "skeletons", "skeletonframes", "bodyframes", "poses", "samples", "sequence", "recording", "data")
_HEADERS = ("header", "metadata", "meta", "info")
_LEVELS = 4  # Objects around the list of frames.

_UNITS = {
    "s": "s", "sec": "s", "secs": "s", "second": "s", "seconds": "s",
    "ms": "ms", "msec": "ms", "msecs": "ms", "millis": "ms", "milliseconds": "ms",
    "us": "us", "usec": "us", "usecs": "us", "micros": "us", "microseconds": "us",
    "ns": "ns", "nsec": "ns", "nsecs": "ns", "nanos": "ns", "nanoseconds": "ns", "ticks": "100ns",
}  # fmt: skip
_UNITS = {"m": "m", "meter": "m", "metre": "m", "cm": "cm", "centimeter": "cm", "centimetre": "cm",
          "mm": "mm", "millimeter": "mm", "millimetre": "mm"}  # fmt: skip
_RATES = ("fps", "framerate", "rate", "ratehz", "hz", "frameratehz", "samplerate", "samplingrate", "framespersecond")


class Frames(NamedTuple):
    """The frames, and the document's other entries."""

    frames: Sequence[Any]
    about: Mapping[str, Any]


def find_frames(path: Path, document: Any, columns: Callable[[Mapping], int]) -> Frames:
    """The list of frames.

    Args:
        path: the file, for messages.
        document: from `load_json`.
        columns: how many frames an object holds that keeps one series a joint; 0 for any other object.

    Raises:
        RecordingError: nothing in the document is a list of frames.
    """
    about: dict[str, Any] = {}
    node = document
    for _ in range(_LEVELS):
        if isinstance(node, list):
            return Frames(node, about)
        if not isinstance(node, dict):
            break
        for header in (entry for key, entry in node.items() if plain(key) in _HEADERS and isinstance(entry, dict)):
            about.update(header)
        about.update((key, entry) for key, entry in node.items() if not isinstance(entry, dict))
        count = columns(node)
        if count:
            return Frames(_transposed(node, about, count), about)
        if len(node) > 1 and all(isinstance(entry, list | dict) for entry in node.values()) and numbered(node):
            return Frames([node[key] for key in sorted(node, key=_trailing_number)], about)
        node = _inner(node)
    raise RecordingError(f"{path}: JSON without a list of frames; give one object or array for each frame")


def _inner(node: Mapping[str, Any]) -> Any:
    """The entry most like a list of frames."""
    entries = {plain(key): entry for key, entry in node.items()}
    held = [
        entry
        for entry in entries.values()
        if isinstance(entry, list) and any(isinstance(frame, list | dict) for frame in entry)
    ]
    for name in _LISTS:
        if isinstance(entries.get(name), list | dict):
            return entries[name]
    objects = [entry for entry in entries.values() if isinstance(entry, dict)]
    return max(held, key=len) if held else max(objects, key=len) if objects else None


def _transposed(node: Mapping[str, Any], about: Mapping[str, Any], count: int) -> list[dict[str, Any]]:
    """One object a frame, of one list a joint (and the lists of times beside and around them)."""
    around = {key: entry for key, entry in about.items() if time_column("", [key], None)[0] is not None}
    columns = {
        key: entry for key, entry in {**around, **node}.items() if isinstance(entry, list) and len(entry) == count
    }
    return [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]


def numbered(keys: Iterable[str]) -> bool:
    """Whether keys number what they hold: "0", "1" or "frame_0001", ..."""
    return all(re.search(r"\d$", key) for key in keys)


def _trailing_number(key: str) -> tuple[str, int]:
    digits = re.search(r"\d{1,18}$", key)
    return (key[: digits.start()], int(digits[0])) if digits else (key, 0)


def frame_numbers(frames: Sequence[Any]) -> np.ndarray:
    """(N,) the frames' own numbers, or the number from 0 where one has none."""
    first = next((frame for frame in frames if isinstance(frame, dict)), {})
    names = [*first]
    column = frame_column(names)
    key = None if column is None else names[column]
    own: list[int] = []
    for frame in frames if key is not None else ():
        value = frame.get(key) if isinstance(frame, dict) else None
        if isinstance(value, str) and value.isdecimal() and len(value) < 16:
            value = int(value)
        if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) < 2**53:
            own = []
            break
        own.append(int(value))
    return np.array(own) if own else np.arange(len(frames))


def frame_times(path: Path, frames: Sequence[Any], joints: Joints | None) -> tuple[np.ndarray | None, str | None]:
    """(N,) the file's clock and its unit where its name or its form states one; (None, None) where there is none.

    Args:
        path: the file, for messages.
        frames: from `find_frames`.
        joints: its "time" is the user's name for the entry that is the time.

    Raises:
        RecordingError: a frame without a time although others have one, or with one that is no number.
    """
    keys, unit = _time_keys(path, next((frame for frame in frames if isinstance(frame, dict)), {}), joints)
    if not keys:
        return None, None
    times = np.empty(len(frames))
    for index, frame in enumerate(frames):
        value: Any = frame
        for key in keys:
            value = value.get(key) if isinstance(value, dict) else None
        try:
            times[index], stated = _time(value)
            unit = unit or stated
        except (ValueError, OverflowError):
            times[index] = np.nan
        if frame and not np.isfinite(times[index]):
            raise RecordingError(
                f"{path}: frame {index}: {'.'.join(keys)[:60]!r} is no time; repair or remove the frame"
            )
    return times, unit


def _time_keys(path: Path, frame: Mapping[str, Any], joints: Joints | None) -> tuple[tuple[str, ...], str | None]:
    """The keys, outer first, that lead to a frame's time, and the unit that the last one states."""
    for outer, entry in frame.items():
        if plain(outer) in _HEADERS and isinstance(entry, dict):
            names = [*entry]
            column, unit = time_column(str(path), names, None)
            if column is not None:
                return (outer, names[column]), unit
    names = [*frame]
    column, unit = time_column(str(path), names, joints)
    return ((), None) if column is None else ((names[column],), unit)


def _time(value: Any) -> tuple[float, str | None]:
    """A time and the unit that its form tells: a number, a date, or ROS's seconds and nanoseconds."""
    if isinstance(value, dict):
        parts = {plain(key): entry for key, entry in value.items()}
        seconds = next((parts[key] for key in ("sec", "secs", "seconds") if key in parts), None)
        rest = next((parts[key] for key in ("nanosec", "nsec", "nsecs", "nanoseconds") if key in parts), 0)
        return number(seconds) + 1e-9 * number(rest), "s"
    if isinstance(value, str) and ":" in value:
        date = datetime.fromisoformat(value)
        return (date if date.tzinfo else date.replace(tzinfo=UTC)).timestamp(), "s"
    return number(value), None


def stated_fields(about: Mapping[str, Any]) -> dict[str, Any]:
    """What the document itself says, as fields of RawRecording: unit, time_unit, clock_hz, up."""
    about = {plain(key): entry for key, entry in about.items()}
    fields: dict[str, Any] = {}
    for key in ("unit", "units", "lengthunit", "lengthunits", "positionunit"):
        if isinstance(about.get(key), str):
            fields.setdefault("unit", _UNITS.get(about[key].strip().lower().rstrip("s") or "s"))
    if isinstance(about.get("timeunit"), str):
        fields["time_unit"] = time_column("", [f"time_{about['timeunit']}"], None)[1]
    rates = [about[key] for key in _RATES if isinstance(about.get(key), int | float)]
    if rates and 0.0 < rates[0] < 1e5:
        fields["clock_hz"] = float(rates[0])
    for key in ("up", "upaxis"):
        if isinstance(about.get(key), str) and about[key].strip().lower().lstrip("+") in AXES:
            fields["up"] = about[key].strip().lower().lstrip("+")
    return {key: value for key, value in fields.items() if value is not None}


def stated_names(about: Mapping[str, Any], count: int) -> list[str] | None:
    """The document's own list of `count` names of joints, where it has one."""
    for entry in about.values():
        if isinstance(entry, list) and len(entry) == count > 0 and all(isinstance(name, str) for name in entry):
            return entry
    return None
