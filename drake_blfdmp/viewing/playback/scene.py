"""A Meshcat scene as a list of its commands, and of what moves in it: kept here, drawn by the page.

Nothing is sent anywhere: the page holds the commands and hands them to Meshcat's viewer when it is opened. So a page
that is written and one that is served are the same.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
from meshcat import geometry
from meshcat.commands import SetObject
from meshcat.path import Path as MeshcatPath

from drake_blfdmp.viewing.playback.animation import Tracks
from drake_blfdmp.viewing.playback.poses import continuous, quaternions

_STILL = 1e-6  # What moves less, in m or 1, does not move.
_AROUND = 28
_FRONT, _BOTH = 0, 2  # Sides of a face that are drawn, as three.js numbers them.
_TURN = np.array([[1.0, 0, 0, 0], [0, 0, -1.0, 0], [0, 1.0, 0, 0], [0, 0, 0, 1.0]])  # y to z.


class ZCylinder(geometry.Cylinder):
    """A cylinder along z, as everywhere but in three.js."""

    def __init__(self, radius: float, length: float):
        super().__init__(length, radius)
        self.radialSegments = _AROUND

    def intrinsic_transform(self) -> np.ndarray:
        """Turns it; a cylinder is the same from both ends, so either sense will do."""
        return _TURN


class ZCone(geometry.Cylinder):
    """A cone about y, tip up, for `Scene.add` to stand up: see `CONE_POSE`."""

    def __init__(self, radius: float, length: float):
        super().__init__(length, radiusTop=0.0, radiusBottom=radius)
        self.radialSegments = _AROUND


CONE_POSE = _TURN
"""Pose of a ZCone whose tip is to point along z."""


class Scene:
    """Objects, poses, properties, and what of them changes.

    Paths are Meshcat's, with `/` between names. Poses are in the frame of the path above.
    """

    def __init__(self):
        self.commands: list[dict[str, Any]] = []
        self.tracks = Tracks()
        self._count = 0

    def add(
        self,
        path: str,
        shape: geometry.Geometry,
        colour: tuple[float, ...] | str,
        *,
        opacity: float = 1.0,
        both_sides: bool = False,
        in_front: bool = False,
    ) -> None:
        """Adds a shape.

        Args:
            path: where in the tree.
            shape: one of meshcat's geometries.
            colour: red green blue in [0, 1], or CSS `#rrggbb`.
            opacity: 0 to 1.
            both_sides: whether faces are seen from inside, as of open meshes.
            in_front: whether it is seen through whatever hides it; it casts no shadow then.
        """
        material = geometry.MeshPhongMaterial(
            color=_hex(colour),
            opacity=float(opacity),
            transparent=bool(opacity < 1.0 or in_front),
            depthTest=not in_front,
            side=_BOTH if both_sides else _FRONT,
            shininess=25,
        )
        self._object(path, geometry.Mesh(shape, material))
        if in_front:
            self.set(f"{path}/<object>", "renderOrder", 1)
            self.set(f"{path}/<object>", "castShadow", False)
            self.set(f"{path}/<object>", "receiveShadow", False)

    def add_lines(self, path: str, start: np.ndarray, end: np.ndarray, colour: str) -> None:
        """Adds segments from start (N, 3) to end (N, 3), m."""
        points = np.stack([start, end], axis=1).reshape(-1, 3).astype(np.float32)
        shape = geometry.PointsGeometry(points.T)
        self._object(path, geometry.LineSegments(shape, geometry.LineBasicMaterial(color=_hex(colour))))

    def set(self, path: str, name: str, value: Any) -> None:
        """Sets a property once."""
        self.commands.append({"type": "set_property", "path": path, "property": name, "value": value})

    def place(self, path: str, X: np.ndarray) -> None:
        """Sets a pose (4, 4) once; it may scale."""
        self.commands.append({"type": "set_transform", "path": path, "matrix": np.asarray(X).T.ravel().tolist()})

    def move(self, path: str, times: np.ndarray, X: np.ndarray) -> None:
        """Poses (F, 4, 4) at times (F,), s; (1, 4, 4), or poses that are all the same, do not move."""
        still = np.abs(X - X[:1]).max() < _STILL
        self.place(path, X[0])
        if still:
            return
        position, quaternion = X[:, :3, 3], continuous(quaternions(X))
        if np.ptp(position, axis=0).max() >= _STILL:
            self.tracks.add(path, "position", "vector3", times, position)
        if np.ptp(quaternion, axis=0).max() >= _STILL:
            self.tracks.add(path, "quaternion", "quaternion", times, quaternion)

    def stretch(self, path: str, times: np.ndarray, scale: np.ndarray) -> None:
        """Scales (F, 3) at times (F,), s."""
        self.set(path, "scale", np.asarray(scale[0]).tolist())
        if np.ptp(scale, axis=0).max() >= _STILL:
            self.tracks.add(path, "scale", "vector3", times, scale)

    def show(self, path: str, times: np.ndarray, visible: np.ndarray) -> None:
        """Whether it is seen, (F,) at times (F,), s; from each time to the next."""
        visible = np.asarray(visible, dtype=bool)
        if visible.any() != visible.all():
            change = np.flatnonzero(np.diff(visible, prepend=~visible[0]))
            self.tracks.add_switch(path, "visible", times[change], visible[change])
        self.set(path, "visible", bool(visible[0]))

    def _object(self, path: str, made: geometry.Object) -> None:
        # Meshcat's own identifiers tell the time and the machine; these are the same for the same scene.
        for part in (made, made.geometry, made.material):
            self._count += 1
            part.uuid = f"{self._count:08x}"
        self.commands.append({**SetObject(made, path=MeshcatPath(())).lower(), "path": path})


def _hex(colour: tuple[float, ...] | str) -> int:
    if isinstance(colour, str):
        return int(colour[1:], 16)
    red, green, blue = (round(255 * min(max(part, 0.0), 1.0)) for part in colour[:3])
    return (red << 16) + (green << 8) + blue


def blended(colour: tuple[float, ...], other: tuple[float, ...], share: float) -> tuple[float, ...]:
    """Red green blue, `share` of the way to another colour."""
    return tuple((1.0 - share) * a + share * b for a, b in zip(colour[:3], other[:3], strict=True))


Legend = Mapping[str, str]
"""Text -> CSS colour of the swatch beside it."""
