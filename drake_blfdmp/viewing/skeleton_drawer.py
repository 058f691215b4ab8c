"""The person's skeleton in Meshcat, as a ghost beside or over the robots, coloured by how far each link is in its band.

A Meshcat recording keeps transforms and properties but neither new objects nor colours. So everything is made up front:
each link as three rods of unit length, one a colour, of which one is visible; their length is the animated `scale` of
the group they are in.
"""

# pyright: reportArgumentType=false, reportCallIssue=false
# (Drake's own type stubs state array types that no array has.)

import numpy as np
from numpy.typing import ArrayLike
from pydrake.geometry import Cylinder, Meshcat, Rgba, Sphere
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.systems.framework import Context, DiagramBuilder, LeafSystem, OutputPort

from drake_blfdmp.errors import BlfDmpError
from drake_blfdmp.link_state import COLOURS, INSIDE, JOINT_COLOUR, NEAR, NEAR_MARGIN, OUTSIDE, classify, rgb
from drake_blfdmp.skeleton import HANDS, LINKS, POINTS, WRISTS
from drake_blfdmp.viewing import band_limits, person_shape
from drake_blfdmp.viewing.looks import (
    BAND_LEGEND,
    BODY,
    BODY_OPACITY,
    LEGEND,
    LONGEST_LEGS,
    PERSON_LEGEND,
    ROD_RADIUS,
    SHORTEST_LEGS,
)

# What says how a ghost looks goes with it, for those who draw one.
__all__ = [
    "BAND_LEGEND",
    "INSIDE",
    "LEGEND",
    "NEAR",
    "OUTSIDE",
    "PERSON_LEGEND",
    "SkeletonDrawer",
    "SkeletonGhost",
    "classify",
    "rod_pose",
]

_LEFT_SHOULDER, _RIGHT_SHOULDER = POINTS.index("left_shoulder"), POINTS.index("right_shoulder")
_SHORTEST = 1e-6  # A rod of length zero has no direction and a singular matrix, m.


def rod_pose(start: np.ndarray, end: np.ndarray) -> tuple[RigidTransform, float]:
    """Pose X_WR and length (m) of a rod along its own z axis whose ends are `start` and `end` (3,), m, in W."""
    along = end - start
    length = float(np.linalg.norm(along))
    if length < _SHORTEST:
        return RigidTransform((start + end) / 2), _SHORTEST
    return RigidTransform(RotationMatrix.MakeFromOneVector(along, 2), (start + end) / 2), length


def _rgba(colour: str, alpha: float) -> Rgba:
    return Rgba(*rgb(colour), alpha)


class SkeletonGhost:
    """Six points, five links, the person they belong to and the hands' band, under one path of a Meshcat scene."""

    def __init__(
        self,
        meshcat: Meshcat,
        *,
        path: str = "/skeleton",
        radius: float = ROD_RADIUS,
        opacity: float = BODY_OPACITY,
        near_margin: float = NEAR_MARGIN,
    ):
        """Makes all objects; call it before `meshcat.StartRecording`.

        Args:
            meshcat: the scene.
            path: where in the scene's tree.
            radius: of the links' rods, m.
            opacity: of the person's body, 0 to 1; points and links are solid.
            near_margin: margins below this are drawn as near; in the unit of the margins.

        Raises:
            BlfDmpError: a number is out of range.
        """
        if not (radius > 0 and 0 < opacity <= 1 and near_margin >= 0):
            raise BlfDmpError(
                f"skeleton {path}: radius {radius}, opacity {opacity}, near_margin {near_margin} must be "
                "above 0, in (0, 1] and not negative; change the one that is not"
            )
        self._meshcat, self._path, self._near = meshcat, path.rstrip("/"), near_margin
        for name in POINTS:
            meshcat.SetObject(f"{self._path}/{name}", Sphere(1.5 * radius), _rgba(JOINT_COLOUR, 1.0))
        for link in LINKS:
            # What is no bone is drawn thinner.
            size = 0.5 * radius if link.name == LINKS[HANDS].name else radius
            for state, colour in COLOURS.items():
                rod = f"{self._path}/{link.name}/rods/{state}"
                meshcat.SetObject(rod, Cylinder(size, 1.0), _rgba(colour, 1.0))
                meshcat.SetProperty(rod, "visible", False)
        for name, (vertices, faces) in (("body", person_shape.body()), ("legs/shape", person_shape.legs())):
            side = Meshcat.SideOfFaceToRender.kFrontSide
            meshcat.SetTriangleMesh(f"{self._path}/{name}", vertices, faces, _rgba(BODY, opacity), side=side)
        self._band = band_limits.HandsBand(meshcat, f"{self._path}/band")

    def draw(
        self, points: ArrayLike, margin: ArrayLike, time: float | None = None, hands_band: ArrayLike | None = None
    ) -> None:
        """Moves the skeleton; does nothing when a point is not finite, as then it was not seen.

        Args:
            points: (6, 3) or (18,) in the order of `skeleton.POINTS`, m, in the world frame.
            margin: (5,) in the order of `skeleton.LINKS`, how far each link is inside its band: positive inside, 0 at
                an edge, negative outside.
            time: s; with it, what is drawn enters a running recording.
            hands_band: (2,) lower and upper limit of the hands' distance, m; None draws no band.
        """
        points = np.asarray(points, dtype=float).reshape(len(POINTS), 3)
        if not np.isfinite(points).all():
            return
        for name, point in zip(POINTS, points, strict=True):
            self._meshcat.SetTransform(f"{self._path}/{name}", RigidTransform(point), time)
        for link, drawn in zip(LINKS, classify(margin, self._near), strict=True):
            # The pose belongs to the group and the scale to the rods inside, for the two do not commute.
            pose, length = rod_pose(points[link.a], points[link.b])
            self._meshcat.SetTransform(f"{self._path}/{link.name}", pose, time)
            self._meshcat.SetProperty(f"{self._path}/{link.name}/rods", "scale", [1.0, 1.0, length], time)
            for state in COLOURS:
                rod = f"{self._path}/{link.name}/rods/{state}"
                self._meshcat.SetProperty(rod, "visible", state == drawn, time)
        self._draw_person(points[_LEFT_SHOULDER], points[_RIGHT_SHOULDER], time)
        if hands_band is not None:
            lower, upper = np.asarray(hands_band, dtype=float)
            self._band.draw(*points[WRISTS], float(lower), float(upper), time)

    def set_visible(self, visible: bool) -> None:
        """Shows or hides the whole skeleton at once, outside any recording."""
        self._meshcat.SetProperty(self._path, "visible", visible)

    def _draw_person(self, left: np.ndarray, right: np.ndarray, time: float | None) -> None:
        """The body, upright below the shoulders and turned as they are, and its legs, as long as reach the floor."""
        middle = (left + right) / 2
        across = right - left
        level = float(np.hypot(across[0], across[1]))
        yaw = float(np.arctan2(across[1], across[0])) if level > _SHORTEST else 0.0
        turn = RotationMatrix.MakeZRotation(yaw)
        self._meshcat.SetTransform(f"{self._path}/body", RigidTransform(turn, middle), time)
        hip = float(middle[2]) - person_shape.SHOULDER_ABOVE_HIP
        share = hip / person_shape.LEG
        # Where the floor is not that of a person who stands, legs would be stilts or stumps.
        self._meshcat.SetProperty(f"{self._path}/legs", "visible", SHORTEST_LEGS < share < LONGEST_LEGS, time)
        self._meshcat.SetTransform(f"{self._path}/legs", RigidTransform(turn, [middle[0], middle[1], 0.0]), time)
        self._meshcat.SetProperty(f"{self._path}/legs/shape", "scale", [1.0, 1.0, max(share, _SHORTEST)], time)


class SkeletonDrawer(LeafSystem):
    """Draws a skeleton in Meshcat at a fixed rate.

    .. pydrake_system::

        name: SkeletonDrawer
        input_ports:
        - points
        - margin (optional)
        - bands (optional)

    `points` (18) is in the order of `skeleton.POINTS`, m, in the world frame. `margin` (5) says how far each link is
    inside its band (positive inside, negative outside); left unconnected, all links are drawn as inside. `bands` (30),
    as from DistanceBands, lets the band of the hands' distance be drawn.
    """

    def __init__(self, ghost: SkeletonGhost, *, publish_period: float = 1 / 32):
        """Draws `ghost` every `publish_period` seconds, and at every forced publish.

        Raises:
            BlfDmpError: the period is not above 0.
        """
        super().__init__()
        if not publish_period > 0:
            raise BlfDmpError(f"SkeletonDrawer: publish_period {publish_period} s must be above 0; use 1/32, say")
        self._ghost = ghost
        self._points_input = self.DeclareVectorInputPort("points", 3 * len(POINTS))
        self._margin_input = self.DeclareVectorInputPort("margin", len(LINKS))
        self._bands_input = self.DeclareVectorInputPort("bands", 6 * len(LINKS))
        self.DeclarePeriodicPublishEvent(period_sec=publish_period, offset_sec=0.0, publish=self._draw)
        self.DeclareForcedPublishEvent(self._draw)

    @staticmethod
    def AddToBuilder(
        builder: DiagramBuilder,
        points_port: OutputPort,
        ghost: SkeletonGhost,
        *,
        margin_port: OutputPort | None = None,
        bands_port: OutputPort | None = None,
        publish_period: float = 1 / 32,
    ) -> "SkeletonDrawer":
        """Adds a drawer of `ghost`, connects it to points (18), margins (5) and bands (30), and returns it."""
        system = SkeletonDrawer(ghost, publish_period=publish_period)
        builder.AddSystem(system)
        builder.Connect(points_port, system.GetInputPort("points"))
        if margin_port is not None:
            builder.Connect(margin_port, system.GetInputPort("margin"))
        if bands_port is not None:
            builder.Connect(bands_port, system.GetInputPort("bands"))
        return system

    def _draw(self, context: Context) -> None:
        unconnected = not self._margin_input.HasValue(context)
        margin = np.full(len(LINKS), np.inf) if unconnected else self._margin_input.Eval(context)
        band = None
        if self._bands_input.HasValue(context):
            band = self._bands_input.Eval(context).reshape(6, len(LINKS))[:2, HANDS]
        self._ghost.draw(self._points_input.Eval(context), margin, context.get_time(), band)
