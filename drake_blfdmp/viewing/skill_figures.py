"""Figures of the skill itself, in the person's torso frame: what the coupling does to six points and five links."""

from typing import Any, Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from drake_blfdmp.recording.run_log import RunLog
from drake_blfdmp.skeleton import HANDS, LINKS, POINTS
from drake_blfdmp.viewing import style

_PANELS = (  # Title, links shown together (indices into LINKS).
    ("left arm", (0, 1)),
    ("hands", (HANDS,)),
    ("right arm", (4, 3)),
)
_LINK_COLOURS = {"upper arm": style.BLUE, "forearm": style.PURPLE, "hands": style.GREEN}
_DESIRED: dict[str, Any] = style.PLANNED | {"linewidth": 0.7, "zorder": 1.8}
_MARKERS = {"shoulder": "s", "elbow": "D", "wrist": "o"}
_POINT_LOOKS: dict[str, dict[str, Any]] = {
    "shoulder": {"color": style.BLUE, "linestyle": (0, (1, 1))},
    "elbow": {"color": style.VERMILLION, "linestyle": (0, (4, 1.2))},
    "wrist": {"color": style.GREEN, "linestyle": "-"},
}
_LINK_STYLES = {"upper arm": "-", "forearm": (0, (5, 1)), "hands": "-"}


def lengths(points: np.ndarray) -> np.ndarray:
    """Lengths (..., 5) of the links between `points` (..., 6, 3), in m."""
    a, b = [link.a for link in LINKS], [link.b for link in LINKS]
    return np.linalg.norm(points[..., b, :] - points[..., a, :], axis=-1)


@style.styled
def link_lengths(log: RunLog) -> Figure:
    """The five links' lengths over their bands, without coupling and with it (the paper's Figs. 8 and 9)."""
    figure = Figure(figsize=(style.PAGE, 3.6))
    axes = figure.subplots(2, 3, sharex=True)
    rows = (("uncoupled", lengths(log.uncoupled)), ("coupled", lengths(log.position)))
    for row, (name, length) in enumerate(rows):
        for column, (title, links) in enumerate(_PANELS):
            axis = axes[row, column]
            for link in links:
                _plot_link(axis, log, length, link)
            if name == "uncoupled":
                axis.set_title(title, pad=4)
                shown = (length, lengths(log.demonstrated), log.lower, log.upper)
            else:
                style.finish_time_axis(axis, log.t)
                shown = (length, log.lower, log.upper)
            axis.set_ylim(style.finite_range(*(values[:, links] for values in shown)))
        axes[row, 0].set_ylabel(f"{name}\nlength (m)")
    for column, (_, links) in enumerate(_PANELS):
        demonstrated = lengths(log.demonstrated)[:, links]
        axes[0, column].plot(log.t, demonstrated, **style.DEMONSTRATED, zorder=1.5)
    _link_legend(figure, axes)
    return figure


def _plot_link(axis: Axes, log: RunLog, length: np.ndarray, link: int) -> None:
    """One link's band, middle and length; `length` is (N, 5) in m."""
    kind = LINKS[link].name.removeprefix("left_").removeprefix("right_").replace("_", " ")
    colour = _LINK_COLOURS[kind]
    axis.fill_between(log.t, log.lower[:, link], log.upper[:, link], facecolor=colour, alpha=0.2, linewidth=0)
    axis.plot(log.t, log.desired[:, link], **_DESIRED)
    axis.plot(log.t, length[:, link], color=colour, linestyle=_LINK_STYLES[kind], linewidth=1.3, label=kind)


def _link_legend(figure: Figure, axes: np.ndarray) -> None:
    """Each link kind once, then what bands, dashes and dots mean."""
    upper, forearm = axes[1, 0].get_lines()[1], axes[1, 0].get_lines()[3]
    hands = axes[1, 1].get_lines()[1]
    desired = axes[1, 0].get_lines()[0]
    demonstrated = axes[0, 0].get_lines()[-1]
    band = Patch(facecolor=style.DARK, alpha=0.2, linewidth=0)
    figure.legend(
        [upper, forearm, hands, band, desired, demonstrated],
        ["upper arm", "forearm", "hands", "band", "desired", "demonstrated"],
        loc="outside upper center",
        ncols=6,
        columnspacing=1.4,
    )


@style.styled
def hands_distance(log: RunLog) -> Figure:
    """Distance between the hands in its band, and its offset from the band's middle (the paper's Fig. 10)."""
    figure = Figure(figsize=(style.COLUMN, 3.6))
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
    lower, upper, desired = log.lower[:, HANDS], log.upper[:, HANDS], log.desired[:, HANDS]
    coupled, uncoupled = lengths(log.position)[:, HANDS], lengths(log.uncoupled)[:, HANDS]
    above.plot(log.t, lengths(log.demonstrated)[:, HANDS], **style.DEMONSTRATED)
    above.plot(log.t, uncoupled, **style.UNCOUPLED)
    above.plot(log.t, coupled, **style.COUPLED)
    above.plot(log.t, desired, **style.PLANNED, label="desired")
    above.fill_between(log.t, lower, upper, **style.BAND)
    above.set_ylabel("distance between\nhands (m)")

    middle = (lower + upper) / 2
    millimetres = 1000.0
    below.fill_between(log.t, (lower - middle) * millimetres, (upper - middle) * millimetres, **style.BAND)
    for edge in (lower, upper):
        below.plot(log.t, (edge - middle) * millimetres, **style.BAND_EDGE)
    offset = (coupled - middle) * millimetres
    below.plot(log.t, (uncoupled - middle) * millimetres, **style.UNCOUPLED)
    below.plot(log.t, offset, **style.COUPLED)
    # The uncoupled offset may be many times the band's width; the band and the coupled line decide what is shown.
    below.set_ylim(style.finite_range(offset, (upper - middle) * millimetres, (lower - middle) * millimetres, pad=0.25))
    below.set_ylabel("offset from\nmiddle (mm)")
    style.finish_time_axis(below, log.t)
    style.mark_events((above, below), log.events, (log.t[0], log.t[-1]))
    style.legend_above(figure, above, columns=3)
    figure.align_ylabels([above, below])
    return figure


@style.styled
def paths(log: RunLog) -> Figure:
    """Paths of the six points from behind and from the side, with the skeleton at both ends (the paper's Fig. 6)."""
    left, right = range(3), range(3, 6)
    views = (  # Title, points, horizontal axis of the torso frame and its label.
        ("both arms, from behind", (*left, *right), 0, "x, to the right (m)"),
        ("left arm, side view", left, 1, "y, forward (m)"),
        ("right arm, side view", right, 1, "y, forward (m)"),
    )
    series = (
        (log.demonstrated, style.DEMONSTRATED),
        (log.uncoupled, style.UNCOUPLED),
        (log.position, style.COUPLED),
    )
    everything = (log.demonstrated, log.uncoupled, log.position)
    height = style.finite_range(*(points[..., 2] for points in everything), pad=0.05)
    spans = [
        style.finite_range(*(points[:, list(shown), axis] for points in everything), pad=0.05)
        for _, shown, axis, _ in views
    ]
    forward = (min(spans[1][0], spans[2][0]), max(spans[1][1], spans[2][1]))
    spans = [spans[0], forward, forward]
    widths = [high - low for low, high in spans]
    scale = (style.PAGE - 1.1) / sum(widths)
    figure = Figure(figsize=(style.PAGE, float(np.clip(scale * (height[1] - height[0]) + 1.0, 2.2, 7.0))))
    axes = figure.subplots(1, 3, sharey=True, width_ratios=widths)
    for axis, (title, shown, horizontal, label), span in zip(axes, views, spans, strict=True):
        for points, look in series:
            for point in shown:
                axis.plot(points[:, point, horizontal], points[:, point, 2], **look)
        _draw_skeletons(axis, log.position, list(shown), horizontal)
        axis.set(title=title, xlabel=label, xlim=span, ylim=height, aspect="equal")
    axes[0].set_ylabel("z, up (m)")
    _path_legend(figure)
    return figure


def _path_legend(figure: Figure) -> None:
    """Series by line, kinds of point by marker, start and end by the marker's filling."""
    look: dict[str, Any] = {"linestyle": "none", "color": style.DARK, "markersize": 3.6, "markeredgewidth": 0.7}
    handles = [Line2D([], [], **series) for series in (style.DEMONSTRATED, style.UNCOUPLED, style.COUPLED)]
    handles += [Line2D([], [], marker=marker, label=kind, **look) for kind, marker in _MARKERS.items()]
    fillings: tuple[tuple[Literal["none", "full"], str], ...] = (("none", "open: start"), ("full", "filled: end"))
    handles += [Line2D([], [], marker="o", fillstyle=filling, label=label, **look) for filling, label in fillings]
    figure.legend(handles=handles, loc="outside upper center", ncols=8, columnspacing=0.9, handlelength=1.7)


def _draw_skeletons(axis: Axes, position: np.ndarray, shown: list[int], horizontal: int) -> None:
    """The chain of links at the first (open markers) and the last (filled) sample of `position` (N, 6, 3)."""
    for points, filling in ((position[0], "white"), (position[-1], style.DARK)):
        for link in LINKS:
            if link.a in shown and link.b in shown:
                ends = points[[link.a, link.b]]
                axis.plot(ends[:, horizontal], ends[:, 2], color=style.DARK, linewidth=0.6, alpha=0.6, zorder=4)
        for point in shown:
            axis.plot(
                points[point, horizontal],
                points[point, 2],
                marker=_MARKERS[POINTS[point].rpartition("_")[2]],
                markersize=3.6,
                markerfacecolor=filling,
                markeredgecolor=style.DARK,
                markeredgewidth=0.7,
                linestyle="none",
                zorder=5,
            )


@style.styled
def spread(log: RunLog, sigma: np.ndarray) -> Figure:
    """The mean of several recordings with one standard deviation to either side; `sigma` is (N, 6, 3), m."""
    figure = Figure(figsize=(style.PAGE, 3.6))
    axes = figure.subplots(2, 3, sharex=True)
    labels = ("x, to the right (m)", "y, forward (m)", "z, up (m)")
    for row, arm in enumerate(("left", "right")):
        for column, label in enumerate(labels):
            axis = axes[row, column]
            for kind, look in _POINT_LOOKS.items():
                point = POINTS.index(f"{arm}_{kind}")
                mean, width = log.demonstrated[:, point, column], sigma[:, point, column]
                axis.fill_between(log.t, mean - width, mean + width, facecolor=look["color"], alpha=0.22, linewidth=0)
                axis.plot(log.t, mean, linewidth=1.2, label=kind, **look)
            if row == 1:
                style.finish_time_axis(axis, log.t)
            axis.set_ylabel(f"{arm} arm\n{label}" if column == 0 else label)
    for column in (1, 2):  # To the front and upwards both arms do alike; sideways they mirror each other.
        edges = [log.demonstrated[..., column] + sign * sigma[..., column] for sign in (-1.0, 1.0)]
        for axis in axes[:, column]:
            axis.set_ylim(style.finite_range(*edges))
    handles, names = axes[0, 0].get_legend_handles_labels()
    band = Patch(facecolor=style.DARK, alpha=0.22, linewidth=0)
    figure.legend(
        [*handles, band], [*names, "one standard deviation to either side"], loc="outside upper center", ncols=4
    )
    return figure
