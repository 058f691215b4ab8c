"""Two Frankas carrying the box (Fig. 11): stills of person, skill and robots, and the arms' swivel angles."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from drake_blfdmp.planning.plan import Plan
from drake_blfdmp.recording.run_log import RunLog
from drake_blfdmp.skill.geometry import link_lengths
from drake_blfdmp.viewing import rendering, robot_figures, stills, style

LOOKS: dict[str, dict[str, Any]] = {
    "swivel": {"color": style.BLUE, "linewidth": 1.5, "label": "swivel, put right"},
    "none": {"color": style.PURPLE, "linewidth": 1.1, "linestyle": (0, (1, 1)), "label": "none"},
    "published": {"color": style.VERMILLION, "linewidth": 1.1, "linestyle": (0, (4, 1.2)), "label": "(18) as printed"},
}
"""Of every redundancy resolution in `robot.redundancy.REDUNDANCIES`."""

CAMERA = rendering.Camera(np.array([0.7, 3.1, 1.5]), np.array([0.0, 0.25, 0.75]))


def pictures(plan: Plan, log: RunLog, times: Mapping[str, float], pixels: int) -> Figure:
    """Person, skill and robots at the same instants, from the same place, at one scale.

    Args:
        times: phase to s.
        pixels: width of a picture.
    """
    scene, scenes = stills.PlannedScene(plan), {"person": [], "skill": [], "two Pandas": []}
    for k in np.minimum(np.searchsorted(log.t, list(times.values())), len(log.t) - 1):
        for name, points in (("person", log.demonstrated[k]), ("skill", log.position[k])):
            lengths = link_lengths(points)
            inside = (log.lower[k] < lengths) & (lengths < log.upper[k])
            scenes[name].append(stills.skeleton(plan.retarget.point(points), inside))
        scenes["two Pandas"].append(scene.at(log.q[k], None if log.box is None else log.box[k]))
    left, right, bottom, top = rendering.window_of(scenes["two Pandas"], CAMERA)
    _, _, low, high = rendering.window_of(scenes["person"] + scenes["skill"], CAMERA)
    heights = {"person": (low, high), "skill": (low, high), "two Pandas": (bottom, top)}
    rows = {
        name: [rendering.picture(shown, CAMERA, (left, right, *heights[name]), pixels) for shown in row]
        for name, row in scenes.items()
    }
    titles = [f"({letter}) {name}" for letter, name in zip("abcdefg", times, strict=False)]
    return stills.strip(rows, titles, stills.LEGEND)


@style.styled
def swivel_angles(
    logs: Mapping[str, RunLog], errors: Mapping[str, np.ndarray], elbow_off: Mapping[str, np.ndarray]
) -> Figure:
    """Swivel angles of both arms and what the elbows are off by, for every redundancy resolution.

    Args:
        logs: resolution to its run; what is asked is the same in all.
        errors: resolution to robot minus person (N, 2), rad, without jumps of a whole turn.
        elbow_off: resolution to (N, 2) m.
    """
    figure = Figure(figsize=(style.PAGE, 3.3))
    axes = figure.subplots(2, 2, sharex=True, sharey="row")
    first = next(iter(logs.values()))
    some = slice(None, None, max(1, len(first.t) // 500))  # As many points as a page resolves.
    for arm, name in enumerate(("left arm", "right arm")):
        for setting, log in logs.items():
            asked = robot_figures.unwrap_known(log.swivel_desired[:, arm])
            axes[0, arm].plot(log.t[some], np.degrees(asked + errors[setting][:, arm])[some], **LOOKS[setting])
            axes[1, arm].plot(log.t[some], 1e3 * elbow_off[setting][some, arm], **LOOKS[setting])
        asked = robot_figures.unwrap_known(first.swivel_desired[:, arm])
        axes[0, arm].plot(first.t[some], np.degrees(asked)[some], **style.PLANNED, label="person, mirrored")
        axes[0, arm].set_title(name, pad=style.event_label_height(first.events, (first.t[0], first.t[-1])))
        style.finish_time_axis(axes[1, arm], first.t)
        style.mark_events(axes[:, arm], first.events, (first.t[0], first.t[-1]))
    axes[0, 0].set_ylabel("swivel (deg)")
    axes[1, 0].set_ylabel("elbow off\nits place (mm)")
    style.legend_above(figure, axes[0, 0], columns=4)
    figure.align_ylabels(axes[:, 0])
    return figure
