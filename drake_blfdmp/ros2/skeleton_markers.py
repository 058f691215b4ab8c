"""The six points and five links as markers that any ROS 2 viewer draws."""

import numpy as np

from drake_blfdmp.link_state import COLOURS, JOINT_COLOUR, classify, rgb
from drake_blfdmp.ros2.messages import Lines, Sphere, markers_template
from drake_blfdmp.skeleton import HANDS, LINKS, POINTS

_DIAMETER, _BONE, _BETWEEN_HANDS = 0.054, 0.036, 0.018  # m, as in the Meshcat scene; what is no bone is thinner.
_BONES = [k for k in range(len(LINKS)) if k != HANDS]
_ENDS = np.array([(LINKS[k].a, LINKS[k].b) for k in (*_BONES, HANDS)]).ravel()
_RGBA = {state: (*rgb(colour), 1.0) for state, colour in COLOURS.items()}


class SkeletonMarkers:
    """Encodes a visualization_msgs/msg/MarkerArray: a sphere a point, the bones, and the line between the hands."""

    def __init__(self, frame_id: str):
        """In the frame of the points."""
        spheres = [Sphere(name, 0, _DIAMETER, (*rgb(JOINT_COLOUR), 1.0)) for name in POINTS]
        lines = [Lines("bones", 0, _BONE, len(_BONES)), Lines("hands", 0, _BETWEEN_HANDS, 1)]
        self._template = markers_template(frame_id, spheres, lines)

    def encode(self, t_ns: int, values: np.ndarray) -> bytes:
        """The message at one instant.

        Args:
            t_ns: ns.
            values: (23,) the points (18, m, in the order of `skeleton.POINTS`), rounded to single precision as poses
                are, then the margins (5) by which the links are coloured (`link_state`).
        """
        points = values[:18].astype(np.float32).reshape(len(POINTS), 3)
        states = classify(values[18:])
        colours = [_RGBA[states[k]] for k in (*_BONES, HANDS) for _ in range(2)]
        return self._template.encode(t_ns, np.vstack([points, points[_ENDS]]), np.array(colours))
