"""Which of a file's names mean the six points: the spellings of Kinect, mocap and pose-estimation tools."""

import re
import unicodedata
from collections.abc import Iterable, Mapping, Sequence
from itertools import product

from drake_blfdmp.errors import RecordingError
from drake_blfdmp.skeleton import POINTS

# "sol", "sag", "omuz", "dirsek", "bilek" are Turkish. The order is a rank: of two matching names the earlier one wins.
_SIDES = {"left": ("left", "l", "lft", "sol"), "right": ("right", "r", "rgt", "sag")}
_PARTS = {
    "shoulder": ("shoulder", "sho", "shld", "omuz", "acromion", "acr", "shouldertop", "upperarm"),
    "elbow": ("elbow", "elb", "dirsek", "elbowout", "forearm", "lowerarm"),
    "wrist": ("wrist", "wri", "wrst", "bilek", "wra", "wrb", "wristout", "wristin"),
}


def _aliases() -> dict[str, tuple[str, int]]:
    table: dict[str, tuple[str, int]] = {}
    for (side, side_names), (part, part_names) in product(_SIDES.items(), _PARTS.items()):
        for rank, (part_name, side_name) in enumerate(product(part_names, side_names)):
            for alias in (side_name + part_name, part_name + side_name):
                table.setdefault(alias, (f"{side}_{part}", rank))
    return table


_ALIASES = _aliases()


def normalise(name: str) -> str:
    """Lower case, no accents, letters and digits only, no subject prefix ("Anna:LSHO") and no word "joint"."""
    plain = unicodedata.normalize("NFKD", name.rsplit(":", 1)[-1])
    plain = re.sub(r"[^a-z0-9]", "", plain.lower())
    return re.sub(r"^(jointtype|joint|marker|skeleton|body)|(joint|marker|position|pos)$", "", plain) or plain


def guess(names: Iterable[str]) -> dict[str, str]:
    """Point -> the name in the file that means it, for the points that have one."""
    best: dict[str, tuple[int, str]] = {}
    for name in names:
        point, rank = _ALIASES.get(normalise(name), (None, 0))
        if point is not None and (point not in best or rank < best[point][0]):
            best[point] = (rank, name)
    return {point: name for point, (_, name) in best.items()}


def resolve(
    where: str, names: Sequence[str], joints: Mapping[str, str | Sequence[str]] | None
) -> dict[str, str | Sequence[str]]:
    """Point -> name in the file (or three column names, passed through), for all six points.

    Args:
        where: the file, for messages.
        names: the file's names of joints or markers.
        joints: overrides of the guess; a name may differ from the file's in case.

    Raises:
        RecordingError: an unknown point in `joints`, a name the file does not have, or a point nothing stands for.
    """
    joints = {key: value for key, value in (joints or {}).items() if key != "time"}
    for key in joints:
        if key not in POINTS:
            raise RecordingError(f"{where}: joints names an unknown point '{key}'; the points are {', '.join(POINTS)}")
    chosen: dict[str, str | Sequence[str]] = dict(guess(names))
    by_lower = {name.lower(): name for name in reversed(names)}
    for point, value in joints.items():
        if isinstance(value, str):
            if value not in names and value.lower() not in by_lower:
                raise RecordingError(f"{where}: no joint '{value}' for {point}; the file has {listed(names)}")
            chosen[point] = value if value in names else by_lower[value.lower()]
        else:
            chosen[point] = tuple(value)
    missing = [point for point in POINTS if point not in chosen]
    if missing:
        raise RecordingError(
            f"{where}: nothing is named like {', '.join(missing)}; name it with joints, the file has {listed(names)}"
        )
    return chosen


def listed(names: Sequence[str], most: int = 40) -> str:
    """Names for a message, one line however many there are."""
    printable = ("".join(filter(str.isprintable, name[:61])) for name in names[:most])
    shown = ", ".join(name if len(name) <= 60 else name[:57] + "..." for name in printable)
    return (shown or "no names") + (f" and {len(names) - most} more" if len(names) > most else "")
