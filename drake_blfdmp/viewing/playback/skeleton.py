"""The person of a run in the scene: skeleton, body and the hands' band, from /points, /margin and /link_lengths.

It looks as `skeleton_drawer` draws it: a link is three rods of unit length, one a colour, of which one is seen.
"""

from collections.abc import Mapping

import numpy as np
from meshcat import geometry

from drake_blfdmp import link_state
from drake_blfdmp.skeleton import HANDS, LINKS, POINTS, SHOULDERS, WRISTS
from drake_blfdmp.viewing import looks, person_shape
from drake_blfdmp.viewing.playback.bounds import Bounds
from drake_blfdmp.viewing.playback.frames import FrameTree
from drake_blfdmp.viewing.playback.poses import about, translation, z_along
from drake_blfdmp.viewing.playback.reading import Played
from drake_blfdmp.viewing.playback.robots import Tint
from drake_blfdmp.viewing.playback.scene import Legend, Scene, ZCylinder, blended

GHOST_AT = np.array([0.95, -0.1, 1.4])
"""Where the shoulders' middle starts in files without the frame `person`, m in W: beside the arms."""

FRAME = "person"
_SHORTEST = 1e-6  # m
_TINTED = 0.4  # Share of a file's colour in the body of its person.


def points_in_world(played: Played) -> np.ndarray | None:
    """The six points (F, 6, 3), m in W; None where the file has none, or not finite ones."""
    elements = played.vectors.get("points", {})
    names = [f"{point}_{axis}" for point in POINTS for axis in "xyz"]
    if not all(name in elements for name in names):
        return None
    points = np.stack([elements[name] for name in names], axis=-1).reshape(-1, len(POINTS), 3)
    if FRAME in played.frames:
        X = _person(played.frames)
        return np.einsum("fij,fpj->fpi", X[:, :3, :3], points) + X[:, None, :3, 3]
    return points + (GHOST_AT - points[0, SHOULDERS].mean(axis=0))


def _person(frames: FrameTree) -> np.ndarray:
    return frames.pose(FRAME)


def margins(played: Played) -> np.ndarray | None:
    """How far each link is inside its band, (F, 5), 1 in its middle and 0 at an edge; None where it is not known."""
    names = [link.name for link in LINKS]
    given = played.vectors.get("margin", {})
    if all(name in given for name in names):
        return np.stack([given[name] for name in names], axis=-1)
    lengths = played.vectors.get("link_lengths", {})
    if not all(f"{name}{end}" in lengths for name in names for end in ("", "_lower", "_upper")):
        return None
    length, lower, upper = (
        np.stack([lengths[name + end] for name in names], axis=-1) for end in ("", "_lower", "_upper")
    )
    return 1.0 - np.abs((length - (lower + upper) / 2) / np.maximum((upper - lower) / 2, _SHORTEST))


def hands_band(vectors: Mapping[str, Mapping[str, np.ndarray]]) -> np.ndarray | None:
    """Lower and upper limit (F, 2) of the hands' distance, m; None where it is not known."""
    hands = LINKS[HANDS].name
    for topic in ("link_lengths", "bands"):
        elements = vectors.get(topic, {})
        if f"{hands}_lower" in elements and f"{hands}_upper" in elements:
            return np.stack([elements[f"{hands}_lower"], elements[f"{hands}_upper"]], axis=-1)
    return None


def draw_person(
    scene: Scene,
    path: str,
    played: Played,
    times: np.ndarray,
    *,
    tint: Tint | None = None,
    bounds: Bounds | None = None,
) -> dict[str, str]:
    """Draws what the file has of the person; returns the legend of what is drawn."""
    points, legend = points_in_world(played), {}
    if points is None:
        return legend
    opacity = 1.0 if tint is None else tint.opacity
    for number, name in enumerate(POINTS):
        scene.add(f"{path}/{name}", geometry.Sphere(1.5 * looks.ROD_RADIUS), link_state.JOINT_COLOUR, opacity=opacity)
        scene.move(f"{path}/{name}", times, translation(points[:, number]))
    margin = margins(played)
    legend |= _links(scene, path, points, margin, times, opacity)
    band = hands_band(played.vectors)
    if band is not None:
        legend |= _sleeves(scene, f"{path}/band", points[:, WRISTS], band, times)
    legend |= _body(scene, path, points[:, SHOULDERS], times, tint)
    if bounds is not None:
        bounds.include(points[:: max(1, len(points) // 50)], 0.1)
        middle = points[:, SHOULDERS].mean(axis=1)
        bounds.include(middle + np.array([0.0, 0.0, 0.37]), 0.05)
        bounds.include(middle * [1.0, 1.0, 0.0], 0.1)
    return legend


def _links(
    scene: Scene, path: str, points: np.ndarray, margin: np.ndarray | None, times: np.ndarray, opacity: float
) -> Legend:
    for number, link in enumerate(LINKS):
        here = f"{path}/{link.name}"
        along = points[:, link.b] - points[:, link.a]
        length = np.maximum(np.linalg.norm(along, axis=-1), _SHORTEST)
        X = z_along(along)
        X[:, :3, 3] = (points[:, link.a] + points[:, link.b]) / 2
        scene.move(here, times, X)
        # The pose belongs to the group and the scale to the rods inside, for the two do not commute.
        scene.stretch(f"{here}/rods", times, np.stack([np.ones_like(length), np.ones_like(length), length], axis=-1))
        # What is no bone is drawn thinner.
        radius = 0.5 * looks.ROD_RADIUS if number == HANDS else looks.ROD_RADIUS
        if margin is None:
            scene.add(f"{here}/rods/unknown", ZCylinder(radius, 1.0), link_state.JOINT_COLOUR, opacity=opacity)
            continue
        states = np.array(link_state.classify(margin[:, number], link_state.NEAR_MARGIN))
        for state, colour in link_state.COLOURS.items():
            if (states == state).any():
                scene.add(f"{here}/rods/{state}", ZCylinder(radius, 1.0), colour, opacity=opacity)
                scene.show(f"{here}/rods/{state}", times, states == state)
    return {} if margin is None else looks.LEGEND


def _sleeves(scene: Scene, path: str, wrists: np.ndarray, band: np.ndarray, times: np.ndarray) -> Legend:
    """Where the band lets each hand be: from half the lower to half the upper limit from the middle of both."""
    along = wrists[:, 1] - wrists[:, 0]
    X = z_along(along)
    X[:, :3, 3] = wrists.mean(axis=1)
    scene.move(path, times, X)
    length = np.maximum((band[:, 1] - band[:, 0]) / 2, 1e-4)
    for side, sign in (("left", -1.0), ("right", 1.0)):
        offset = np.zeros((len(times), 3))
        offset[:, 2] = sign * band.sum(axis=-1) / 4
        scene.move(f"{path}/{side}", times, translation(offset))
        sleeve = f"{path}/{side}/sleeve"
        scene.add(sleeve, ZCylinder(looks.BAND_RADIUS, 1.0), looks.BAND_COLOUR, opacity=looks.BAND_OPACITY)
        scene.stretch(sleeve, times, np.stack([np.ones_like(length), np.ones_like(length), length], axis=-1))
    return looks.BAND_LEGEND


def _body(scene: Scene, path: str, shoulders: np.ndarray, times: np.ndarray, tint: Tint | None) -> Legend:
    """The body, upright below the shoulders and turned as they are, and its legs, as long as reach the floor."""
    colour = looks.BODY if tint is None else blended(link_state.rgb(looks.BODY), link_state.rgb(tint.colour), _TINTED)
    opacity = looks.BODY_OPACITY * (1.0 if tint is None else tint.opacity)
    for name, (vertices, faces) in (("body", person_shape.body()), ("legs/shape", person_shape.legs())):
        shape = geometry.TriangularMeshGeometry(vertices.T, faces.T)
        scene.add(f"{path}/{name}", shape, colour, opacity=opacity)
    middle, across = shoulders.mean(axis=1), shoulders[:, 1] - shoulders[:, 0]
    turn = about([0.0, 0.0, 1.0], np.arctan2(across[:, 1], across[:, 0]))
    scene.move(f"{path}/body", times, translation(middle) @ turn)
    share = (middle[:, 2] - person_shape.SHOULDER_ABOVE_HIP) / person_shape.LEG
    scene.show(f"{path}/legs", times, (share > looks.SHORTEST_LEGS) & (share < looks.LONGEST_LEGS))
    scene.move(f"{path}/legs", times, translation(middle * [1.0, 1.0, 0.0]) @ turn)
    one = np.ones_like(share)
    scene.stretch(f"{path}/legs/shape", times, np.stack([one, one, np.maximum(share, _SHORTEST)], axis=-1))
    return looks.PERSON_LEGEND
