"""What the box stands on before and after, and how the motion is shifted so that both ends have room.

A person who walks from a shelf to a table does, seen from the torso, both in nearly the same place. The arms stand. So:
ends at nearly the same height are brought to exactly the same height and share one table; ends at different heights
get a table each, and where the two would overlap the place of release is moved forward or back until they do not,
while the box is above both.
"""

from dataclasses import dataclass

import numpy as np

from drake_blfdmp.robot.box import BoxParameters, TableParameters

LEVEL_WITHIN = 0.06
"""Ends whose heights differ by less than this, m, share a table."""

RIM = 0.03
"""Width of the table's rim around the box, m."""

GAP = 0.02
"""Distance kept between the box and the other table's edge, and height at which it passes above it, m."""


@dataclass(frozen=True)
class Ends:
    """The middle of the hands at the grasp and at the release, and its highest point between them, m in W."""

    grasp: np.ndarray
    release: np.ndarray
    top: float


@dataclass(frozen=True)
class Shift:
    """How the motion must change.

    Attributes:
        release: (3,) displacement of the release, m in W.
        raise_by: additional height in the middle of the carry, m in W.
        sentence: why, for people; empty when nothing changes.
    """

    release: np.ndarray
    raise_by: float
    sentence: str


def half_extent_y(box: BoxParameters, yaw: float) -> float:
    """Half the box's extent along W's y axis at a yaw, m."""
    return 0.5 * (box.depth * abs(np.cos(yaw)) + box.width * abs(np.sin(yaw)))


def ShiftForSupports(ends: Ends, box: BoxParameters, yaws: tuple[float, float], same_level: bool) -> Shift:
    """The shift that makes room for the tables.

    Args:
        same_level: the ends share one table.
    """
    rise = float(ends.release[2] - ends.grasp[2])
    if same_level:
        sentence = (
            f"release moved by {-1000 * rise:+.0f} mm in height, on to the table of the grasp"
            if abs(rise) > 5e-4
            else ""
        )
        return Shift(np.array([0.0, 0.0, -rise]), 0.0, sentence)
    # The higher table is the farther one: the arms reach over the lower one, never under a table.
    side = 1.0 if rise > 0 else -1.0
    needed = half_extent_y(box, yaws[0]) + half_extent_y(box, yaws[1]) + RIM + GAP
    forward = side * max(0.0, needed - side * (ends.release[1] - ends.grasp[1]))
    higher = max(ends.grasp[2], ends.release[2])
    lift = max(0.0, 2.0 * GAP - (ends.top - higher))
    parts = []
    if forward:
        parts.append(
            f"release moved {1000 * abs(forward):.0f} mm {'forward' if forward > 0 else 'back'} to a table of its own"
        )
    if lift:
        parts.append(RaiseSentence(lift))
    return Shift(np.array([0.0, forward, 0.0]), lift, ", ".join(parts))


def RaiseSentence(lift: float, more: bool = False) -> str:
    """What raising the middle of a carry, m, is for, for people; `more` where it has been raised before."""
    return f"carry raised by {1000 * lift:.0f} mm {'more ' if more else ''}to clear the higher table"


def MakeSupports(X_start, X_goal, box: BoxParameters, same_level: bool) -> list[TableParameters]:
    """One table under both ends, or one under each.

    Args:
        X_start, X_goal: (3,) positions of the box's centre at both ends, m in W, and its yaw as a fourth number.
    """
    corners = []
    for x, y, _, yaw in (X_start, X_goal):
        reach_x = 0.5 * (box.width * abs(np.cos(yaw)) + box.depth * abs(np.sin(yaw)))
        reach_y = half_extent_y(box, yaw)
        corners.append(np.array([[x - reach_x, y - reach_y], [x + reach_x, y + reach_y]]))
    if same_level:
        low, high = np.min([c[0] for c in corners], axis=0), np.max([c[1] for c in corners], axis=0)
        # The slab stays inside the box's sides, out of the way of hands that reach down along them.
        top = X_start[2] - 0.5 * box.height
        return [_table("table", low, high, top)]
    return [
        _table(name, corner[0], corner[1], end[2] - 0.5 * box.height)
        for name, corner, end in zip(("table", "shelf"), corners, (X_start, X_goal), strict=True)
    ]


def _table(name: str, low, high, top: float) -> TableParameters:
    middle, size = 0.5 * (low + high), high - low + RIM * np.array([0.0, 1.0])
    return TableParameters(
        name=name,
        top_center=(float(middle[0]), float(middle[1]), float(top)),
        size=(float(size[0]), float(size[1])),
    )
