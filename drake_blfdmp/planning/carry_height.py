"""How high a box is carried: as high as asked for, and never below the table it is over."""

from dataclasses import replace

import numpy as np

from drake_blfdmp.demonstration.timing import TaskMotion
from drake_blfdmp.planning.box_path import ROOM
from drake_blfdmp.planning.task import Raised
from drake_blfdmp.skill.profiles import softly_at_least

BLEND = 0.006
"""Height, m, over which a way that would sink too low is led to the least height."""

SLOPE = 0.2
"""So steeply the least height rises with the distance over the ground from where the box stands, at first."""

NEAR = 0.005
"""Over the first so many m, of that distance, it hardly rises: hands that close push a box a little."""

NOTED = 0.003
"""A change of the height, m, that is worth making, and a note."""


def carried(motion: TaskMotion) -> tuple[int, int]:
    """Indices of the first and the last sample between the end of the grasp and the release."""
    first, last = (np.searchsorted(motion.t, motion.events[name]) for name in ("grasp_end", "release"))
    return int(first), int(min(last, len(motion.t) - 1))


def hands_middle(motion: TaskMotion) -> np.ndarray:
    """The middle between the hands (N, 3), m."""
    return 0.5 * (motion.x[:, 2] + motion.x[:, 5])


def rise(middle) -> float:
    """How far a way (N, 3) rises above its start, m."""
    return float(middle[:, 2].max() - middle[0, 2])


def RaisedToLift(motion: TaskMotion, least: float) -> tuple[TaskMotion, float]:
    """The motion whose hands' middle rises, while the box is carried, by at least `least`, m.

    Returns:
        The motion, and by how much it was raised where it was raised most, m.
    """
    first, last = carried(motion)
    z = hands_middle(motion)[:, 2]
    if rise(hands_middle(motion)[first : last + 1]) >= least:
        return motion, 0.0
    window = motion.events["grasp_end"], motion.events["release"]
    raised = Raised(motion, 1.0, window)
    bump = (hands_middle(raised)[:, 2] - z)[first : last + 1]
    inside = bump > 0.5
    height = float(np.min((z[first] + least - z[first : last + 1][inside]) / bump[inside]))
    return Raised(motion, height, window), height


def height_lacking(middle) -> np.ndarray:
    """How much a carried box's way must be raised so that it nowhere sinks below where it stands: (N,), m.

    Up to its highest point it keeps to the height of its start, from there on to that of its end: and above either the
    farther it is from there over the ground, up to `ROOM`.

    Args:
        middle: (N, 3) the way of the hands' middle in W from where the box is taken to where it is put down, m.

    Returns:
        0 at both ends, and twice continuously differentiable where the way is; 0 all along where the way has no highest
        point clear above both ends.
    """
    middle = np.asarray(middle)
    z, top = middle[:, 2], int(np.argmax(middle[:, 2]))
    if z[top] - max(z[0], z[-1]) < ROOM + 2.0 * BLEND:
        return np.zeros(len(z))
    end = np.where((np.arange(len(z)) <= top)[:, None], middle[0], middle[-1])
    away = np.linalg.norm((middle - end)[:, :2], axis=-1)
    rise = SLOPE * (np.hypot(away, NEAR) - NEAR)
    above = z - end[:, 2] - ROOM * (1.0 - np.exp(-rise / ROOM))
    # The ends stay where they are; what is well above is then lower by what the blend rounds there.
    return softly_at_least(above, 0.0, BLEND) - above - softly_at_least(0.0, 0.0, BLEND)


def KeptUp(motion: TaskMotion, t, middle, scale: float) -> tuple[TaskMotion, float]:
    """The motion with all points raised by what its rolled-out way lacks in height (`height_lacking`).

    A person's noise, and what the law makes of it, then neither presses the box into a table nor drags it along.

    Args:
        t: (N,) of the way, s.
        middle: (N, 3) the way in W, m.
        scale: of the motion in W.

    Returns:
        The motion, and by how much the way was raised where it was raised most, m; where that is not worth a note
        (`NOTED`), the motion as it was and 0.
    """
    lacking = height_lacking(middle)
    if lacking.max() <= NOTED:
        return motion, 0.0
    change = np.interp(motion.t, t, lacking) / scale
    return replace(motion, x=motion.x + change[:, None, None] * np.array([0.0, 0.0, 1.0])), float(lacking.max())
