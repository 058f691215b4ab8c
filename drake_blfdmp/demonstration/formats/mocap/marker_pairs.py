"""Joints that marker sets put between two markers: the wrist of Plug-in-Gait lies between LWRA and LWRB."""

from collections.abc import Sequence

import numpy as np

from drake_blfdmp.demonstration.formats.point_names import normalise

# Without side: Plug-in-Gait, then the styloids of ISB and CAST sets, inner and outer, thumb and little finger.
_WRISTS = (
    ("wra", "wrb"), ("rsp", "usp"), ("rad", "uln"), ("wrr", "wru"), ("iwr", "owr"), ("wts", "wps"),
    ("wristin", "wristout"), ("wristmed", "wristlat"), ("wristmedial", "wristlateral"),
)  # fmt: skip
_ELBOWS = (
    ("elb", "melb"), ("elb", "elbm"), ("elbl", "elbm"), ("lel", "mel"), ("ael", "pel"),
    ("elbowout", "elbowin"), ("elbowlat", "elbowmed"), ("elbowlateral", "elbowmedial"),
)  # fmt: skip
_SIDES = {"left": ("l", "left"), "right": ("r", "right")}
_LEAST_SHARE = 0.5  # Of the frames with either marker in which both must be seen.


def find_pairs(names: Sequence[str]) -> dict[str, tuple[str, str]]:
    """Point of `skeleton.POINTS` -> the two markers on either side of it, for the points that have such markers."""
    by_plain = {normalise(name): name for name in reversed(names)}
    found: dict[str, tuple[str, str]] = {}
    for part, pairs in (("wrist", _WRISTS), ("elbow", _ELBOWS)):
        for point, sides in ((f"{side}_{part}", spellings) for side, spellings in _SIDES.items()):
            for first, second in pairs:
                for a, b in ((s + first, s + second) for s in sides):
                    if a in by_plain and b in by_plain:
                        found.setdefault(point, (by_plain[a], by_plain[b]))
    return found


def between(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """The midpoint of two markers, (N, 3) each with NaN where lost; NaN where either is lost.

    Of a pair that is rarely seen whole it is the better marker alone: halves would jump by half a joint's width.
    """
    seen_a, seen_b = np.isfinite(a).all(axis=-1), np.isfinite(b).all(axis=-1)
    if (seen_a & seen_b).sum() < _LEAST_SHARE * (seen_a | seen_b).sum():
        return a if seen_a.sum() >= seen_b.sum() else b
    return (a + b) / 2.0
