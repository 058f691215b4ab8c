"""What stands around: floor with a grid of half metres, light, background; and from where one looks."""

from dataclasses import dataclass

import numpy as np

from drake_blfdmp.viewing import looks
from drake_blfdmp.viewing.playback.bounds import Bounds
from drake_blfdmp.viewing.playback.poses import translation
from drake_blfdmp.viewing.playback.scene import Scene, ZCylinder

FLOOR_RADIUS = 2.75
"""At least, m."""

_THICKNESS, _GRID_STEP = 0.02, 0.5  # m
_FLOOR, _LINES = "#FFFFFF", "#9EA8B5"
_SPOT = "/Lights/SpotLight"
_FROM = np.array([0.80, -0.90, 0.55])  # Towards the camera, from a robot that faces x.
_SHARE = 0.92  # Of the picture that what is drawn fills.


@dataclass(frozen=True)
class View:
    """Camera and target, (3,) m in W, and the angles that a window of any shape shows at least, upright and across."""

    camera: np.ndarray
    target: np.ndarray
    field_of_view: tuple[float, float] = looks.FIELD_OF_VIEW

    @property
    def right(self) -> np.ndarray:
        """(3,) unit, level: what is to the right in the picture."""
        ahead = (self.target - self.camera)[:2]
        ahead = ahead / np.linalg.norm(ahead)
        return np.array([ahead[1], -ahead[0], 0.0])


def run_view() -> View:
    """The view of a run's scene: arms, box and person."""
    return View(np.array(looks.CAMERA_IN_WORLD), np.array(looks.TARGET_IN_WORLD))


def view_of(
    bounds: Bounds, towards: np.ndarray | None = None, field_of_view: tuple[float, float] = looks.FIELD_OF_VIEW
) -> View:
    """A view that shows everything in `bounds`; `towards` points from it to the camera."""
    direction = _FROM if towards is None else towards
    direction = direction / np.linalg.norm(direction)
    half_up, half_across = np.tan(np.radians(field_of_view) / 2) * _SHARE
    target = bounds.middle
    ahead = -direction
    right = np.cross(ahead, [0.0, 0.0, 1.0])
    right = right / np.linalg.norm(right)
    up = np.cross(right, ahead)
    corners = (np.zeros((1, 3)) if bounds.empty else bounds.corners()) - target
    # Every corner inside the angle of view: its distance from the axis at most so much of its depth.
    off = np.maximum(np.abs(corners @ right) / half_across, np.abs(corners @ up) / half_up)
    distance = max(float(np.max(off - corners @ ahead)), 0.5)
    # The control bar lies over the lowest tenth of the picture.
    down = 0.08 * half_up * distance * up
    return View(target - down + distance * direction, target - down, field_of_view)


def add_surroundings(scene: Scene, bounds: Bounds) -> None:
    """Lays the floor below everything, at z = 0 where that is so, and sets light and background."""
    for name, value in (("top_color", [0.96, 0.97, 0.99]), ("bottom_color", [0.78, 0.81, 0.85])):
        scene.set("/Background", name, value)
    for name in ("/Grid", "/Axes"):
        scene.set(name, "visible", False)
    reach = 0.0 if bounds.empty else float(np.linalg.norm((bounds.high - bounds.low)[:2])) / 2
    radius = max(FLOOR_RADIUS, _GRID_STEP * np.ceil((1.1 * reach + 0.5) / _GRID_STEP) + 0.25)
    step = _GRID_STEP * max(1.0, np.ceil(radius / 10.0))
    x, y = np.round(bounds.middle[:2] / step) * step
    z = 0.0 if bounds.empty else min(0.0, float(bounds.low[2]))
    z = 0.0 if z > -0.05 else z
    # The floor lies 1 mm below, so that feet and tables stand on it.
    scene.add("/stage/floor", ZCylinder(float(radius), _THICKNESS), _FLOOR)
    scene.set("/stage/floor/<object>", "castShadow", False)
    scene.place("/stage/floor", translation([x, y, z - 0.001 - _THICKNESS / 2]))
    count = int(radius / step)
    offset = step * np.arange(-count, count + 1)
    half = np.sqrt(radius**2 - offset**2)
    start = np.concatenate([np.stack([offset, -half], axis=-1), np.stack([-half, offset], axis=-1)])
    end = np.concatenate([np.stack([offset, half], axis=-1), np.stack([half, offset], axis=-1)])
    start, end = (np.column_stack([ends + np.array([x, y]), np.full(len(ends), z)]) for ends in (start, end))
    scene.add_lines("/stage/grid", start, end, _LINES)
    # One light casts shadows; the others fill.
    for name, intensity in (("AmbientLight", 0.62), ("FillLight", 0.10)):
        scene.set(f"/Lights/{name}/<object>", "intensity", intensity)
    for name in ("PointLightNegativeX", "PointLightPositiveX"):
        scene.set(f"/Lights/{name}/<object>", "intensity", 0.10)
    scene.set(_SPOT, "visible", True)
    for name, value in (("castShadow", True), ("intensity", 0.45), ("angle", 0.9), ("penumbra", 0.5)):
        scene.set(f"{_SPOT}/<object>", name, value)
    away = np.array([1.35, 2.9, 2.4]) * max(1.0, bounds.radius)
    scene.set(f"{_SPOT}/<object>", "position", (np.array([x, y, 0.0]) + away).tolist())
