"""Which person and which point a frame's or marker's name means: "left_elbow_2" is person 2's left elbow."""

import re
import unicodedata
from collections.abc import Iterable
from functools import lru_cache
from typing import NamedTuple

from drake_blfdmp.demonstration.formats.point_names import guess
from drake_blfdmp.skeleton import POINTS

_WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+")
_MOST_WORDS = 12
_HANDS = {
    **dict.fromkeys(("lefthand", "handleft", "lhand", "handl"), "left_wrist"),
    **dict.fromkeys(("righthand", "handright", "rhand", "handr"), "right_wrist"),
}
"""OpenNI, NiTE and Xsens frames know no wrists; a hand stands for one where there is none."""


class NamedPoint(NamedTuple):
    """A point of `skeleton.POINTS`, the rest of the name, and whether a hand stands for the wrist."""

    point: str
    rest: str
    hand: bool


@lru_cache(maxsize=65536)
def named_point(name: str) -> NamedPoint | None:
    """The point a name means by its longest run of words that means one; None where it means none."""
    plain = unicodedata.normalize("NFKD", name[:200])
    words = _WORD.findall("".join(c for c in plain if not unicodedata.combining(c)))
    if len(words) > _MOST_WORDS:
        return None
    for length in range(len(words), 0, -1):
        for start in range(len(words) - length + 1):
            joined = "".join(words[start : start + length]).lower()
            point = next(iter(guess([joined])), None) or _HANDS.get(joined)
            if point is not None:
                rest = " ".join(words[:start] + words[start + length :])
                return NamedPoint(point, rest, joined in _HANDS)
    return None


def named_bodies(names: Iterable[str]) -> dict[str, dict[str, str]]:
    """Rest of the names -> point -> name, of the persons who have all six points."""
    found: dict[str, dict[str, tuple[bool, int, str]]] = {}
    for order, name in enumerate(names):
        meant = named_point(name)
        if meant is not None:
            points = found.setdefault(meant.rest, {})
            points[meant.point] = min(points.get(meant.point, (True, order, name)), (meant.hand, order, name))
    return {
        rest: {point: points[point][2] for point in POINTS}
        for rest, points in found.items()
        if len(points) == len(POINTS)
    }


def hand_note(chosen: Iterable[str]) -> tuple[str, ...]:
    """A sentence where hands stand for wrists."""
    used = [name for name in chosen if (meant := named_point(name)) is not None and meant.hand]
    return (f"wrists: {', '.join(used)} stand for them",) if used else ()
