"""What the names above a table's columns mean: joints and axes, the clock, frame numbers, people, confidence."""

import re
from collections.abc import Sequence
from typing import NamedTuple

from drake_blfdmp.demonstration.formats.point_names import listed, normalise
from drake_blfdmp.demonstration.formats.recording_format import Joints
from drake_blfdmp.errors import RecordingError

_TIME_UNITS = {
    "s": "s", "sec": "s", "secs": "s", "second": "s", "seconds": "s",
    "ms": "ms", "msec": "ms", "msecs": "ms", "millis": "ms",
    "millisec": "ms", "millisecond": "ms", "milliseconds": "ms",
    "us": "us", "usec": "us", "usecs": "us", "micros": "us",
    "microsec": "us", "microsecond": "us", "microseconds": "us",
    "ns": "ns", "nsec": "ns", "nsecs": "ns", "nanos": "ns", "nanosec": "ns", "nanosecond": "ns", "nanoseconds": "ns",
    "100ns": "100ns", "ticks": "100ns",
}  # fmt: skip
_TIME_NAMES = (
    "time", "timestamp", "timestamps", "t", "elapsed", "elapsedtime", "relativetime", "frametime", "clock",
    "stamp", "datetime", "unixtime", "epoch", "",
)  # fmt: skip
_FRAME_NAMES = (
    "frame", "frames", "frameid", "framenumber", "frameno", "framenr", "framenum", "frameindex", "frameidx",
    "framecount", "index", "idx", "sample", "samplenumber", "sampleid", "fr",
)  # fmt: skip
_BODY_NAMES = (
    "bodyid", "body", "trackingid", "trackid", "bodytrackingid", "personid", "person", "playerid", "player", "userid",
    "user", "skeletonid", "skeleton", "subjectid", "subject", "actor", "bodyindex", "personindex", "bodynumber",
)  # fmt: skip

_JOINT_NAMES = (
    "joint", "jointname", "jointtype", "jointid", "jointindex", "jointnumber", "jointidx", "jointno",
    "marker", "markername", "markerid", "keypoint", "keypointname", "keypointid",
    "landmark", "landmarkname", "landmarkid", "landmarkindex",
    "bodypart", "part", "point", "pointname", "node", "name", "label", "type", "id",
)  # fmt: skip
_POSITIONS = ("", "position", "pos", "p", "joint", "jointposition", "t", "translation", "location", "world", "camera")

_UNIT = r"(?:[\s_.]*[\[(]?(?P<unit>mm|cm|m)[\])]?)?"
_AXIS_LAST = re.compile(rf"(?P<stem>.+?)[\s_.:/\-\[(]*(?P<axis>[xyz])[\])]?{_UNIT}", re.I)
_AXIS_FIRST = re.compile(r"(?P<axis>[xyz])[\s_.:/\-]+(?P<stem>.+?)(?:[\s_.]*[\[(](?P<unit>mm|cm|m)[\])])?", re.I)
_CONFIDENCE_WORD = (
    r"(?:tracking[\s_]?|joint[\s_]?)?(?:confidence(?:[\s_]?level)?|conf|score|visibility|state|status|tracked|likelihood"
    r"|quality)"
)
_CONFIDENCE_LAST = re.compile(rf"(?P<stem>.+?)(?:[\s_.:/\-\[(]*{_CONFIDENCE_WORD}|[\s_.:/\-\[(]+[cs])[\])]?", re.I)
_CONFIDENCE_FIRST = re.compile(rf"{_CONFIDENCE_WORD}[\s_.:/\-]+(?P<stem>.+)", re.I)


_QUATERNION = re.compile(
    r"(?P<stem>.+?)[\s_.:/\-\[(]*(?:(?:q|quat|quaternion|rot|rotation|orient|orientation|ori)[\s_.:/\-\[(]*(?P<axis>[wxyz])"
    r"|(?P<first>[wxyz])[\s_.:/\-]*quat(?:ernion)?)[\])]?",
    re.I,
)


class JointColumns(NamedTuple):
    """A joint's columns x, y and z, and the unit that their names state."""

    columns: tuple[int, int, int]
    unit: str | None


def plain(name: str) -> str:
    """Lower-case letters and digits only."""
    return re.sub(r"[^a-z0-9]", "", name.lower())


def quaternions_of(names: Sequence[str]) -> dict[str, tuple[int, int, int, int]]:
    """Normalised name of a joint -> its columns w, x, y and z, for the joints that have all four of a quaternion."""
    found: dict[str, dict[str, int]] = {}
    for column, name in enumerate(names):
        match = _QUATERNION.fullmatch(name)
        if match:
            axis = (match["axis"] or match["first"]).lower()
            found.setdefault(normalise(match["stem"]), {}).setdefault(axis, column)
    return {stem: (axes["w"], axes["x"], axes["y"], axes["z"]) for stem, axes in found.items() if len(axes) == 4}


def joints_of(names: Sequence[str]) -> dict[str, JointColumns]:
    """Stem -> its three columns, for the stems that have all of x, y and z."""
    found: dict[str, dict[str, int]] = {}
    units: dict[str, str | None] = {}
    turns = {column for columns in quaternions_of(names).values() for column in columns}
    for column, name in enumerate(names):
        if column in turns:
            continue
        match = _AXIS_LAST.fullmatch(name) or _AXIS_FIRST.fullmatch(name)
        if match:
            found.setdefault(match["stem"], {}).setdefault(match["axis"].lower(), column)
            units.setdefault(match["stem"], match["unit"] and match["unit"].lower())
    return {
        stem: JointColumns((axes["x"], axes["y"], axes["z"]), units[stem])
        for stem, axes in found.items()
        if len(axes) == 3
    }


def confidence_columns(names: Sequence[str]) -> dict[str, int]:
    """Normalised name of a joint -> the column that says how well it is seen."""
    found: dict[str, int] = {}
    for column, name in enumerate(names):
        match = _CONFIDENCE_FIRST.fullmatch(name) or _CONFIDENCE_LAST.fullmatch(name)
        if match:
            found.setdefault(normalise(match["stem"]), column)
    return found


def confidence_column(names: Sequence[str]) -> int | None:
    """The column that says how well a row's one joint is seen."""
    matches = (re.fullmatch(rf"(?:{_CONFIDENCE_WORD}|c)", name, re.I) for name in names)
    return next((column for column, match in enumerate(matches) if match), None)


def joint_column(names: Sequence[str]) -> int | None:
    """The column that says which joint a row is of."""
    return _first(names, _JOINT_NAMES)


def position_columns(names: Sequence[str]) -> JointColumns | None:
    """Columns x, y and z of a row's one joint: `x`, `pos_x`, `PositionX`, `x (mm)`, `x_position`."""
    turned = [re.sub(r"^([xyz])[\s_.\-]+(pos|position|coord|coordinate)$", r"\1", name, flags=re.I) for name in names]
    found = {plain(stem): columns for stem, columns in joints_of([f"_ {name}" for name in turned]).items()}
    return next((found[stem] for stem in _POSITIONS if stem in found), None)


def frame_column(names: Sequence[str]) -> int | None:
    """The column of frame numbers."""
    return _first(names, _FRAME_NAMES)


def body_column(names: Sequence[str]) -> int | None:
    """The column that says whose row it is."""
    return _first(names, _BODY_NAMES)


def time_column(where: str, names: Sequence[str], joints: Joints | None) -> tuple[int | None, str | None]:
    """The time column and the unit its name states; None where there is none.

    Raises:
        RecordingError: `joints` names a time column that the file does not have.
    """
    override = (joints or {}).get("time")
    candidates: list[tuple[int, int, str | None]] = []
    for column, name in enumerate(names):
        spaced = re.sub(r"(?<=[a-z])(?=[A-Z])", "_", name.replace("µ", "u").replace("μ", "u"))
        words = [word for word in re.split(r"[^a-z0-9]+", spaced.lower()) if word]
        unit = _TIME_UNITS.get(words[-1]) if words else None
        stem = "".join(words[:-1] if unit else words)
        if name == override:
            return column, unit
        if words and stem in _TIME_NAMES:
            candidates.append((_TIME_NAMES.index(stem), column, unit))
        elif stem.endswith(("timestamp", "time")):
            candidates.append((len(_TIME_NAMES), column, unit))
    if override is not None:
        raise RecordingError(f"{where}: no column '{override}' for time; the file has {listed(names)}")
    if not candidates:
        return None, None
    _, column, unit = min(candidates, key=lambda candidate: candidate[:2])
    return column, unit


def _first(names: Sequence[str], wanted: Sequence[str]) -> int | None:
    known = [plain(name) for name in names]
    return next((known.index(name) for name in wanted if name in known), None)
