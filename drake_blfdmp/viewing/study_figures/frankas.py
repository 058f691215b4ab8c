"""Two Frankas carrying the box (Fig. 11): stills of person, skill and robots, and the arms' swivel angles."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from drake_blfdmp.viewing import rendering, robot_figures, solids, stills, style

LOOKS: dict[str, dict[str, Any]] = {
    "swivel": {"color": style.BLUE, "linewidth": 1.5, "label": "swivel, put right"},
    "none": {"color": style.PURPLE, "linewidth": 1.1, "linestyle": (0, (1, 1)), "label": "none"},
    "published": {"color": style.VERMILLION, "linewidth": 1.1, "linestyle": (0, (4, 1.2)), "label": "(18) as printed"},
}
"""Of every redundancy resolution in `robot.redundancy.REDUNDANCIES`."""

CAMERA = rendering.Camera(np.array([0.7, 3.1, 1.5]), np.array([0.0, 0.25, 0.75]))


@dataclass(frozen=True)
class Instants:
    """Person, skill and robots at K instants, in W.

    Attributes:
        names: of the instants.
        person, skill: (K, 6, 3) in the order of `skeleton.POINTS`, m.
        person_inside, skill_inside: (K, 5) bool: whether each link is inside its band.
        solids: S bodies of the robots' scene.
        poses: (K, S, 3, 4) of these.
    """

    names: Sequence[str]
    person: np.ndarray
    skill: np.ndarray
    person_inside: np.ndarray
    skill_inside: np.ndarray
    solids: Sequence[solids.Solid | rendering.Triangles]
    poses: np.ndarray


@style.styled
def pictures(shown: Instants, pixels: int) -> Figure:
    """Person, skill and robots at the same instants, from the same place, at one scale; `pixels` wide each."""
    shapes = [solids.solid_triangles(solid) for solid in shown.solids]
    scenes = {
        "person": [stills.skeleton(*one) for one in zip(shown.person, shown.person_inside, strict=True)],
        "skill": [stills.skeleton(*one) for one in zip(shown.skill, shown.skill_inside, strict=True)],
        "two Pandas": [solids.posed(shapes, poses) for poses in shown.poses],
    }
    left, right, bottom, top = rendering.window_of(scenes["two Pandas"], CAMERA)
    _, _, low, high = rendering.window_of(scenes["person"] + scenes["skill"], CAMERA)
    heights = {"person": (low, high), "skill": (low, high), "two Pandas": (bottom, top)}
    rows = {
        name: [rendering.picture(scene, CAMERA, (left, right, *heights[name]), pixels) for scene in row]
        for name, row in scenes.items()
    }
    titles = [f"({letter}) {name}" for letter, name in zip("abcdefg", shown.names, strict=False)]
    return stills.strip(rows, titles, stills.LEGEND)


@dataclass(frozen=True)
class Swivels:
    """Of one run and both arms, on N samples: the swivel angle that is asked, what it is off by, rad; the elbows', m.

    `error` is robot minus person, without jumps of a whole turn. All are (N, 2).
    """

    asked: np.ndarray
    error: np.ndarray
    elbow_off: np.ndarray


@style.styled
def swivel_angles(t: np.ndarray, runs: Mapping[str, Swivels], events: Sequence[tuple[str, float]]) -> Figure:
    """Swivel angles of both arms and what the elbows are off by, for every redundancy resolution.

    Args:
        t: (N,) s.
        runs: resolution to its run; what is asked is the same in all.
        events: (name, s).
    """
    figure = Figure(figsize=(style.PAGE, 3.3))
    axes = figure.subplots(2, 2, sharex=True, sharey="row")
    first, span = next(iter(runs.values())), (float(t[0]), float(t[-1]))
    some = slice(None, None, max(1, len(t) // 500))  # As many points as a page resolves.
    for arm, name in enumerate(("left arm", "right arm")):
        for setting, run in runs.items():
            asked = robot_figures.unwrap_known(run.asked[:, arm])
            axes[0, arm].plot(t[some], np.degrees(asked + run.error[:, arm])[some], **LOOKS[setting])
            axes[1, arm].plot(t[some], 1e3 * run.elbow_off[some, arm], **LOOKS[setting])
        asked = robot_figures.unwrap_known(first.asked[:, arm])
        axes[0, arm].plot(t[some], np.degrees(asked)[some], **style.PLANNED, label="person, mirrored")
        axes[0, arm].set_title(name, pad=style.event_label_height(events, span))
        style.finish_time_axis(axes[1, arm], t)
        style.mark_events(axes[:, arm], events, span)
    axes[0, 0].set_ylabel("swivel (deg)")
    axes[1, 0].set_ylabel("elbow off\nits place (mm)")
    style.legend_above(figure, axes[0, 0], columns=4)
    figure.align_ylabels(axes[:, 0])
    return figure
