"""What stands around the arms in Meshcat: a round floor with a grid of half metres, and light that casts shadows."""

# pyright: reportArgumentType=false, reportCallIssue=false
# (Drake's own type stubs state array types that no array has.)

import numpy as np
from pydrake.geometry import Cylinder, Meshcat, Rgba
from pydrake.math import RigidTransform

FLOOR_RADIUS = 2.75
"""m"""

_PATH = "/stage"
_THICKNESS, _GRID_STEP = 0.02, 0.5  # m
_FLOOR, _LINES = Rgba(1.0, 1.0, 1.0, 1.0), Rgba(0.62, 0.66, 0.71, 1.0)
_SPOT = "/Lights/SpotLight"


def add_stage(meshcat: Meshcat, middle: tuple[float, float] = (0.0, 0.0)) -> None:
    """Lays the floor at z = 0 about `middle` (x, y, m in W) and turns the lights on.

    Meshcat's own grid is hidden for it. The floor lies 1 mm below z = 0, so that feet and tables stand on it.
    """
    meshcat.SetProperty("/Grid", "visible", False)
    x, y = middle
    meshcat.SetObject(f"{_PATH}/floor", Cylinder(FLOOR_RADIUS, _THICKNESS), _FLOOR)
    meshcat.SetTransform(f"{_PATH}/floor", RigidTransform([x, y, -0.001 - _THICKNESS / 2]))
    count = int(FLOOR_RADIUS / _GRID_STEP)
    offset = _GRID_STEP * np.arange(-count, count + 1)
    half = np.sqrt(FLOOR_RADIUS**2 - offset**2)
    start = np.concatenate([np.stack([offset, -half], axis=-1), np.stack([-half, offset], axis=-1)])
    end = np.concatenate([np.stack([offset, half], axis=-1), np.stack([half, offset], axis=-1)])
    # The grid's lines go through the floor's middle; where they are in W is of no use to anyone.
    start, end = (np.column_stack([ends + np.array(middle), np.zeros(len(ends))]).T for ends in (start, end))
    meshcat.SetLineSegments(f"{_PATH}/grid", start, end, 1.0, _LINES)
    # The others are Meshcat's lights without shadows; they fill, and so are dimmed for the one that casts them.
    for name, intensity in (("AmbientLight", 1.1), ("FillLight", 0.5)):
        meshcat.SetProperty(f"/Lights/{name}/<object>", "intensity", intensity)
    for name in ("PointLightNegativeX", "PointLightPositiveX"):
        meshcat.SetProperty(f"/Lights/{name}/<object>", "intensity", 3.0)
    meshcat.SetProperty(_SPOT, "visible", True)
    meshcat.SetProperty(f"{_SPOT}/<object>", "castShadow", True)
    meshcat.SetProperty(
        f"{_SPOT}/<object>", "shadow.normalBias", 0.02
    )  # Less, and surfaces shade themselves in stripes.
    for side in ("width", "height"):
        meshcat.SetProperty(f"{_SPOT}/<object>", f"shadow.mapSize.{side}", 2048)
    meshcat.SetProperty(f"{_SPOT}/<object>", "position", [1.8, 3.0, 2.2])
    meshcat.SetProperty(f"{_SPOT}/<object>", "intensity", 22.0)
