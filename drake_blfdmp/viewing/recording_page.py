"""A recording as an animated Meshcat page: the skeleton as recorded, grey, and the cleaned one over it."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
from pydrake.geometry import Box, Meshcat, Rgba
from pydrake.math import RigidTransform, RotationMatrix

from drake_blfdmp.demonstration.bones import BONES, link_lengths
from drake_blfdmp.demonstration.health import Examined
from drake_blfdmp.errors import RecordingError
from drake_blfdmp.robot.box_look import BOX_COLOR
from drake_blfdmp.skeleton import WRISTS
from drake_blfdmp.viewing.meshcat_scene import set_scene_camera, write_scene_html
from drake_blfdmp.viewing.skeleton_drawer import INSIDE, LEGEND, NEAR, OUTSIDE, SkeletonGhost
from drake_blfdmp.viewing.stage import add_stage

_FRAMES_HZ = 24.0
_MOST_FRAMES = 1500  # Keeps the page at a few MB; longer recordings are shown with fewer frames a second.
_NEAR, _OUTSIDE = 0.10, 0.25  # Deviation of a bone from its median that is marked, as a share of it.
_BOX_HEIGHT, _BOX_DEPTH = 0.20, 0.20  # m; the recording knows the width alone.
_DISTANCE, _AWAY = 2.7, 1.4  # m from the person to the camera: so much, and this share of what the motion spans.

_STATES = {INSIDE: "at its usual length", NEAR: f"{100 * _NEAR:.0f} % off", OUTSIDE: f"{100 * _OUTSIDE:.0f} % off"}


def write_recording_page(
    examined: Examined, path: Path, meshcat: Meshcat, progress: Callable[[str, float], None] = lambda what, share: None
) -> Path:
    """Writes the cleaned recording as one page that opens offline, bones coloured by how far they are off.

    The person is put with the shoulders' middle over the origin at the start, and stays as recorded otherwise.

    Raises:
        RecordingError: cleaning refused the recording, so there is nothing to animate.
        BlfDmpError: the page cannot be written.
    """
    demonstration = examined.demonstration
    if demonstration is None:
        raise RecordingError(f"{examined.health.source}: no page: {examined.health.reasons[0]}")
    step = max(1, round(demonstration.rate_hz / _FRAMES_HZ), -(-len(demonstration.t) // _MOST_FRAMES))
    t, x = demonstration.t[::step], demonstration.x[::step].copy()
    x[..., :2] -= x[0, [0, 3], :2].mean(axis=0)
    x[..., 2] -= x[..., 2].min() - 0.05 if x[..., 2].min() < 0.0 else 0.0  # A camera's origin is not on the floor.
    meshcat.Delete()
    ghost = SkeletonGhost(meshcat, near_margin=_OUTSIDE - _NEAR)
    add_stage(meshcat)
    holding = examined.holding
    if holding is not None:
        shape = Box(max(holding.hand_distance, 0.02), _BOX_DEPTH, _BOX_HEIGHT)
        meshcat.SetObject("/box", shape, Rgba(*BOX_COLOR[:3], 0.75))
    set_scene_camera(meshcat, *_camera(x))
    margin = _margins(link_lengths(x))
    meshcat.StartRecording(frames_per_second=demonstration.rate_hz / step, set_visualizations_while_recording=True)
    for k, now in enumerate(t):
        ghost.draw(x[k], margin[k], float(now))
        if holding is not None:
            meshcat.SetTransform("/box", _box_pose(x[k]), float(now))
            meshcat.SetProperty("/box", "visible", bool(holding.start_s <= now <= holding.end_s), float(now))
        if k % 100 == 0:
            progress("drawing the recording", k / len(t))
    progress("drawing the recording", 1.0)
    legend = {f"bone {_STATES[state]}": colour for state, colour in zip(_STATES, LEGEND.values(), strict=True)}
    title = f"{Path(examined.health.source).name}: {'held in both hands' if holding else 'nothing held'}"
    return write_scene_html(meshcat, path, title=title, legend=legend)


def _camera(x: np.ndarray) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Where to look from and to, m in W: from the front, a little from the right and from above."""
    low, high = x.min(axis=(0, 1)), x.max(axis=(0, 1))
    target = (low + high) / 2.0 - [0.0, 0.0, 0.1]  # Arms are the upper half of what is seen.
    across = (x[:, 3] - x[:, 0]).mean(axis=0)[:2]
    across = across / max(float(np.linalg.norm(across)), 1e-6)
    direction = np.append(np.array([-across[1], across[0]]) + 0.5 * across, 0.4)
    camera = target + (_DISTANCE + _AWAY * float(np.linalg.norm(high - low))) * direction / np.linalg.norm(direction)
    return tuple(camera), tuple(target)


def _margins(lengths: np.ndarray) -> np.ndarray:
    """(N, 5) how far each bone is inside the deviation that is marked as outside; the hands' distance always is."""
    off = np.abs(lengths / np.median(lengths, axis=0) - 1.0)
    margin = np.full(lengths.shape, np.inf)
    margin[:, BONES] = _OUTSIDE - off[:, BONES]
    return margin


def _box_pose(points: np.ndarray) -> RigidTransform:
    """X_WB of a box between the wrists, its width along the line between them and as upright as that allows."""
    left, right = points[WRISTS]
    x_axis = (right - left) / max(float(np.linalg.norm(right - left)), 1e-6)
    y_axis = np.cross([0.0, 0.0, 1.0], x_axis)
    if np.linalg.norm(y_axis) < 1e-3:
        return RigidTransform(RotationMatrix.MakeFromOneVector(x_axis, 0), (left + right) / 2)
    y_axis /= np.linalg.norm(y_axis)
    rotation = RotationMatrix(np.column_stack([x_axis, y_axis, np.cross(x_axis, y_axis)]))
    return RigidTransform(rotation, (left + right) / 2)
