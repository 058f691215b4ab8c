"""What the box looks like: cardboard with edges, tape and a label on its front, so that tilt and yaw can be seen.

Illustration geometry alone; what it weighs and touches with is in `box`.
"""

import numpy as np
from pydrake.geometry import Box

from drake_blfdmp.robot.look import VisualPart

BOX_COLOR = (0.76, 0.57, 0.36, 1.0)
TAPE_COLOR = (0.90, 0.80, 0.60, 1.0)
EDGE_COLOR = (0.42, 0.29, 0.16, 1.0)
LABEL_COLOR = (0.97, 0.97, 0.95, 1.0)
MARK_COLOR = (0.13, 0.14, 0.16, 1.0)

_PROUD = 0.001  # Of one layer over the one below, m; less would flicker.


def BoxLook(size) -> list[VisualPart]:
    """What a box of size (3,), m, with its frame at its centre, looks like."""
    size = np.asarray(size, dtype=float)
    parts = []

    def add(part: str, extent, at=(0.0, 0.0, 0.0), color=MARK_COLOR, tilt: float = 0.0) -> None:
        parts.append(VisualPart(part, Box(*extent), tuple(at), color, tilt))

    add("visual", size, color=BOX_COLOR)
    # Round the middle, across the front, the top and the back.
    tape = size + 2 * np.array([-_PROUD, _PROUD, _PROUD])
    tape[0] = 0.16 * size[0]
    add("tape", tape, color=TAPE_COLOR)
    thick = 0.02 * float(size.min())
    for axis in range(3):
        others = [other for other in range(3) if other != axis]
        for i, signs in enumerate(((-1, -1), (-1, 1), (1, -1), (1, 1))):
            extent, at = np.full(3, thick), np.zeros(3)
            extent[axis] = size[axis] + 2 * _PROUD
            at[others] = np.array(signs) * (0.5 * size[others] + _PROUD - 0.5 * thick)
            add(f"edge_{'xyz'[axis]}{i}", extent, at, EDGE_COLOR)
    _add_label(add, size)
    return parts


def _add_label(add, size: np.ndarray) -> None:
    """A white label at the front's right with an arrow that points up, and a dark bar on the front's upper edge."""
    side = 0.62 * min(0.40 * size[0], size[2])
    x, y = 0.29 * size[0], 0.5 * size[1]

    def front(part: str, width: float, height: float, at_x: float, at_z: float, layer: int, **more) -> None:
        add(part, (width, 2 * _PROUD, height), (x + at_x, y + (layer - 1) * _PROUD + 0.5 * _PROUD, at_z), **more)

    front("label", side, 1.25 * side, 0.0, 0.0, 2, color=LABEL_COLOR)
    front("arrow_shaft", 0.13 * side, 0.62 * side, 0.0, -0.10 * side, 3)
    for hand, sign in (("left", -1.0), ("right", 1.0)):
        # Half of the arrow's head: a bar that leans inward, up to the tip.
        front(f"arrow_{hand}", 0.13 * side, 0.46 * side, sign * 0.14 * side, 0.16 * side, 3, tilt=-sign * np.pi / 4)
    front("arrow_base", 0.62 * side, 0.09 * side, 0.0, -0.48 * side, 3)
    bar = 0.07 * size[1]
    add("front_bar", (0.94 * size[0], bar, 2 * _PROUD), (0.0, y - 1.5 * bar, 0.5 * size[2] + 1.5 * _PROUD))
