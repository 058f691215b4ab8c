"""The six points of both arms and the five links between them, in the order used everywhere.

The links form one chain, left shoulder to right shoulder, so neighbours share exactly one point.
"""

from typing import NamedTuple

import numpy as np

POINTS = (
    "left_shoulder",
    "left_elbow",
    "left_wrist",
    "right_shoulder",
    "right_elbow",
    "right_wrist",
)


class Link(NamedTuple):
    """A link from point `a` to point `b` (indices into `POINTS`)."""

    name: str
    a: int
    b: int


LINKS = (
    Link("left_upper_arm", 0, 1),
    Link("left_forearm", 1, 2),
    Link("hands", 2, 5),
    Link("right_forearm", 5, 4),
    Link("right_upper_arm", 4, 3),
)

SHOULDERS, ELBOWS, WRISTS = np.array([0, 3]), np.array([1, 4]), np.array([2, 5])  # Of POINTS, left and right.

HANDS = 2  # The index in LINKS of the link between the hands.
