"""A robot's links in the scene."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from meshcat import geometry

from drake_blfdmp.link_state import rgb
from drake_blfdmp.viewing.playback.bounds import Bounds
from drake_blfdmp.viewing.playback.meshes import NoMeshError, find_mesh, mesh_geometry
from drake_blfdmp.viewing.playback.poses import translation
from drake_blfdmp.viewing.playback.reading import Model
from drake_blfdmp.viewing.playback.scene import Scene, ZCylinder, blended
from drake_blfdmp.viewing.playback.urdf import Visual

_STILL = 1e-5
_UNKNOWN_MESH = 0.15  # Radius about a mesh's link that the camera keeps in sight, m.


@dataclass(frozen=True)
class Tint:
    """How one of several files differs in looks: CSS colour, share of it, opacity."""

    colour: str
    share: float = 0.45
    opacity: float = 0.5


def draw_robot(
    scene: Scene,
    path: str,
    model: Model,
    poses: Mapping[str, np.ndarray],
    times: np.ndarray,
    beside: Path,
    *,
    tint: Tint | None = None,
    standing: dict[str, np.ndarray] | None = None,
    bounds: Bounds | None = None,
) -> list[str]:
    """Draws every link that has shapes, and moves it.

    Args:
        scene: to draw in.
        path: above all of it.
        model: the robot.
        poses: of its links, from `link_poses`.
        times: (F,) s.
        beside: the recording's folder, for meshes named relative to it.
        tint: of one of several files drawn in one place.
        standing: link -> pose of what the first file shows and does not move; with a tint, what stands the same is not
            drawn again, and without one it is filled in.
        bounds: told of what is drawn.

    Returns: what is not drawn, a line each.
    """
    warnings: list[str] = []
    standing = {} if standing is None else standing
    for link, visuals in model.robot.links.items():
        X_WL = poses[link]
        if not visuals:
            continue
        still = np.abs(X_WL - X_WL[:1]).max() < _STILL
        if still and tint is None:
            standing[link] = X_WL[0]
        elif still and link in standing and np.abs(standing[link] - X_WL[0]).max() < _STILL:
            continue
        here = f"{path}/{_safe(link)}"
        scene.move(here, times, X_WL)
        for number, visual in enumerate(visuals):
            try:
                radius = _draw(scene, f"{here}/{number}", visual, beside, tint)
            except NoMeshError as error:
                warnings.append(f"link {link}: mesh {visual.mesh} is not drawn: {error}")
                continue
            if bounds is not None:
                step = max(1, len(X_WL) // 50)
                bounds.include((X_WL[::step] @ visual.X_LV)[:, :3, 3], radius)
    return warnings


def _safe(name: str) -> str:
    return name.replace("/", "_").replace("<", "_") or "_"


def _draw(scene: Scene, path: str, visual: Visual, beside: Path, tint: Tint | None) -> float:
    """Draws one shape; returns the radius of a ball around it, m."""
    colour, opacity = visual.colour[:3], visual.colour[3]
    if tint is not None:
        colour, opacity = blended(colour, rgb(tint.colour), tint.share), opacity * tint.opacity
    size, X = np.array(visual.size), visual.X_LV
    both = False
    if visual.kind == "box":
        # Box edges of zero, as a floor may have, give no normals.
        shape, radius = geometry.Box(np.maximum(size, 1e-5).tolist()), float(np.linalg.norm(size)) / 2
    elif visual.kind == "sphere":
        shape, radius = geometry.Sphere(float(size[0])), float(size[0])
    elif visual.kind == "mesh":
        shape, unit = mesh_geometry(find_mesh(visual.mesh, beside))
        X, radius, both = X @ np.diag([*(unit * size), 1.0]), _UNKNOWN_MESH, True
    else:
        shape, radius = ZCylinder(float(size[0]), float(size[1])), float(np.hypot(size[0], size[1] / 2))
    scene.add(path, shape, colour, opacity=opacity, both_sides=both)
    scene.place(path, X)
    if visual.kind == "capsule":
        for end, side in (("bottom", -0.5), ("top", 0.5)):
            scene.add(f"{path}/{end}", geometry.Sphere(float(size[0])), colour, opacity=opacity)
            scene.place(f"{path}/{end}", translation([0.0, 0.0, side * float(size[1])]))
        radius += float(size[0])
    return radius
