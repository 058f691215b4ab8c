"""Forces in the scene: an arrow at the origin of the frame that the wrench is in."""

from collections.abc import Mapping, Sequence

import numpy as np

from drake_blfdmp.viewing.playback.poses import translation, z_along
from drake_blfdmp.viewing.playback.reading import Played, Wrench
from drake_blfdmp.viewing.playback.scene import CONE_POSE, Scene, ZCone, ZCylinder

COLOUR = "#B0207A"
_LONGEST = 0.35  # Of an arrow, m.
_SHAFT, _HEAD = 0.010, 0.024  # Radii, m.
_HEAD_LENGTH = 0.06  # m
_UNSEEN = 0.01  # Of the largest force: shorter arrows are left away.


def metres_per_newton(wrenches: Sequence[Wrench]) -> float:
    """One scale for all arrows: a round number with which the longest is at most 0.35 m; 0 without any force."""
    largest = max((float(np.linalg.norm(w.force, axis=-1).max()) for w in wrenches), default=0.0)
    if largest <= 0.0:
        return 0.0
    exact = _LONGEST / largest
    power = 10.0 ** np.floor(np.log10(exact))
    return float(max(step * power for step in (1.0, 2.0, 5.0) if step * power <= exact * (1 + 1e-9)))


def draw_forces(
    scene: Scene,
    path: str,
    played: Played,
    links: Mapping[str, np.ndarray],
    times: np.ndarray,
    scale: float,
    opacity: float = 1.0,
) -> tuple[dict[str, str], list[str]]:
    """Draws the wrenches of a file.

    Args:
        scene: to draw in.
        path: above all of it.
        played: the file.
        links: poses of the robots' links, for frames that are not in /tf.
        times: (F,) s.
        scale: of the arrows, m per N.
        opacity: of the arrows, 0 to 1.

    Returns: the legend, and what is not drawn, a line each.
    """
    warnings: list[str] = []
    drawn = False
    for number, wrench in enumerate(played.wrenches):
        if wrench.frame in played.frames or wrench.frame in played.frames.roots:
            X_WF = played.frames.pose(wrench.frame)
        elif wrench.frame in links:
            X_WF = links[wrench.frame]
        else:
            warnings.append(f"{wrench.topic}: its frame '{wrench.frame}' is not in /tf; its force is not drawn")
            continue
        size = np.linalg.norm(wrench.force, axis=-1)
        length = scale * size
        seen = length > _UNSEEN * _LONGEST
        if not seen.any():
            continue
        here = f"{path}/{number}"
        scene.move(here, times, X_WF)
        scene.move(f"{here}/arrow", times, z_along(wrench.force))
        scene.show(f"{here}/arrow", times, seen)
        # The head keeps its size, but in arrows shorter than it.
        head = np.minimum(_HEAD_LENGTH, 0.6 * np.maximum(length, 1e-4))
        shaft = np.maximum(length - head, 1e-5)
        one = np.ones_like(length)
        scene.add(f"{here}/arrow/shaft/rod", ZCylinder(_SHAFT, 1.0), COLOUR, opacity=opacity, in_front=True)
        scene.place(f"{here}/arrow/shaft/rod", translation([0.0, 0.0, 0.5]))
        scene.stretch(f"{here}/arrow/shaft", times, np.stack([one, one, shaft], axis=-1))
        scene.move(f"{here}/arrow/head", times, translation(np.stack([0 * one, 0 * one, shaft], axis=-1)))
        scene.add(f"{here}/arrow/head/size/cone", ZCone(_HEAD, _HEAD_LENGTH), COLOUR, opacity=opacity, in_front=True)
        scene.place(f"{here}/arrow/head/size/cone", translation([0.0, 0.0, _HEAD_LENGTH / 2]) @ CONE_POSE)
        share = head / _HEAD_LENGTH
        scene.stretch(f"{here}/arrow/head/size", times, np.stack([share, share, share], axis=-1))
        drawn = True
    legend = {f"force, {0.1 / scale:g} N in 10 cm": COLOUR} if drawn else {}
    return legend, warnings
