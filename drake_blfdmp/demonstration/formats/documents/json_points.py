"""One joint in JSON, in the ways writers put it: [x, y, z], {"x", "y", "z"}, with or without a confidence, or null."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from drake_blfdmp.demonstration.formats.confidence import confidence_of_word
from drake_blfdmp.demonstration.formats.documents.json_text import number
from drake_blfdmp.demonstration.formats.point_names import resolve
from drake_blfdmp.demonstration.formats.recording_format import Joints
from drake_blfdmp.demonstration.formats.tables.table_names import plain
from drake_blfdmp.errors import RecordingError
from drake_blfdmp.skeleton import POINTS

_POSITIONS = ("position", "pos", "xyz", "coordinates", "coords", "location", "point", "translation", "position3d")
_CONFIDENCES = (
    "confidence", "score", "visibility", "presence", "likelihood", "probability", "conf", "prob",
    "trackingstate", "confidencelevel", "state", "tracked", "visible",
)  # fmt: skip

NOWHERE = (np.nan, np.nan, np.nan)


def is_missing(value: Any) -> bool:
    """Whether a joint's entry says that there is none."""
    return value is None or (isinstance(value, list | dict) and not value)


def is_point(value: Any) -> bool:
    """Whether a joint's entry looks like three coordinates (pixels have two)."""
    if isinstance(value, list):
        return len(value) >= 3 and not isinstance(value[0], list | dict)
    return isinstance(value, dict) and (_coordinates(value) is not None or _position(value) is not None)


def read_point(value: Any) -> tuple[Sequence[float], float]:
    """The coordinates and the confidence as it stands in the file (NaN where it does not).

    Raises:
        ValueError: with the reason, such as "holds 2 numbers, expected x, y, z".
    """
    if is_missing(value):
        return NOWHERE, np.nan
    if isinstance(value, list):
        if len(value) < 3:
            raise ValueError(f"holds {len(value)} numbers, expected x, y, z")
        return _numbers(value[:3]), _confidence(value[3]) if len(value) == 4 else np.nan
    if isinstance(value, dict):
        said = _get(value, _CONFIDENCES)
        coordinates = _coordinates(value)
        if coordinates is not None:
            return _numbers(coordinates), _confidence(said)
        position = _position(value)
        if position is not None:
            x, inner = read_point(position)
            return x, inner if said is None else _confidence(said)
        if not any(plain(key) in _POSITIONS for key in value):
            raise ValueError("has no x, y and z")
        return NOWHERE, _confidence(said)
    raise ValueError("is no x, y, z")


def one_name_each(path: Path, names: Sequence[str], joints: Joints | None) -> list[str]:
    """The names of the six points, in the order of `skeleton.POINTS`.

    Raises:
        RecordingError: as `point_names.resolve`, or `joints` gives a point three names.
    """
    chosen = resolve(str(path), names, joints)
    for point, name in chosen.items():
        if not isinstance(name, str):
            raise RecordingError(f"{path}: a joint has one name for its three numbers; give {point} one name")
    return [str(chosen[point]) for point in POINTS]


def _coordinates(value: Mapping[str, Any]) -> list[Any] | None:
    for x, y, z in ("xyz", "XYZ"):
        if x in value and y in value and z in value:
            return [value[x], value[y], value[z]]
    return None


def _position(value: Mapping[str, Any]) -> Any:
    found = _get(value, _POSITIONS)
    return found if is_point(found) else None


def _get(value: Mapping[str, Any], names: Sequence[str]) -> Any:
    """The first of the names' values, None where there is none."""
    for name in names:
        if name in value:
            return value[name]
    by_plain = {plain(key): entry for key, entry in value.items()}
    return next((by_plain[name] for name in names if name in by_plain), None)


def _numbers(values: Sequence[Any]) -> tuple[float, ...]:
    try:
        return tuple([value if type(value) is float else number(value) for value in values])
    except ValueError:
        raise ValueError("holds what is no number") from None


def _confidence(value: Any) -> float:
    """As a number; NaN for what says nothing."""
    if isinstance(value, str):
        said = confidence_of_word(value)
        if not np.isnan(said):
            return said
    try:
        return number(value)
    except ValueError:
        return np.nan
