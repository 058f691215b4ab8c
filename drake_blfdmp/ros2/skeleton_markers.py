"""The six points and five links as markers that any ROS 2 viewer draws."""

import numpy as np

from drake_blfdmp.link_state import JOINT_COLOUR, link_colours, rgb
from drake_blfdmp.ros2.cdr import CdrTemplate
from drake_blfdmp.ros2.messages import Lines, Sphere, markers_template
from drake_blfdmp.skeleton import HANDS, LINKS, POINTS

_DIAMETER, _BONE, _BETWEEN_HANDS = 0.054, 0.036, 0.018  # m, as in the Meshcat scene; what is no bone is thinner.
_BONES = [k for k in range(len(LINKS)) if k != HANDS]
_ORDER = [*_BONES, HANDS]
_ENDS = np.array([(LINKS[k].a, LINKS[k].b) for k in _ORDER]).ravel()


def skeleton_template(frame_id: str) -> CdrTemplate:
    """A visualization_msgs/msg/MarkerArray in the frame of the points, whose numbers `skeleton_numbers` makes."""
    spheres = [Sphere(name, 0, _DIAMETER, (*rgb(JOINT_COLOUR), 1.0)) for name in POINTS]
    lines = [Lines("bones", 0, _BONE, len(_BONES)), Lines("hands", 0, _BETWEEN_HANDS, 1)]
    return markers_template(frame_id, spheres, lines)


def skeleton_numbers(rows: np.ndarray) -> np.ndarray:
    """What stands in the messages of N instants.

    Args:
        rows: (N, 23): the points (18, m, in the order of `skeleton.POINTS`), rounded to single precision as poses are,
            then the margins (5) by which the links are coloured (`link_state`).
    """
    n = len(rows)
    points = rows[:, :18].astype(np.float32).reshape(n, len(POINTS), 3)
    colours = np.ones((n, len(LINKS), 2, 4))  # Of both ends.
    colours[..., :3] = link_colours(rows[:, 18:])[:, _ORDER, None]
    return np.hstack([part.reshape(n, -1) for part in (points, points[:, _ENDS], colours)])
