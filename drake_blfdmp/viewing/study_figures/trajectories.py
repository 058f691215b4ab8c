"""Paths and skeletons of the original and the modified movement primitives (Fig. 6).

Points are (N, 6, 3), m, in the person's torso frame: x to the right, y forward, z up.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from drake_blfdmp.skeleton import LINKS, POINTS
from drake_blfdmp.viewing import style
from drake_blfdmp.viewing.study_figures.looks import BROKEN, MODIFIED, ORIGINAL, RECORDED

_MARKERS = {"shoulder": "s", "elbow": "D", "wrist": "o"}
_VIEWS = ((0, 2, "x, to the right (m)", "z, up (m)"), (0, 1, "x, to the right (m)", "y, forward (m)"))


def _marker_handles() -> list[Line2D]:
    look: dict[str, Any] = {"linestyle": "none", "color": style.DARK, "markersize": 3.6, "markeredgewidth": 0.7}
    return [Line2D([], [], marker=marker, label=kind, **look) for kind, marker in _MARKERS.items()]


def _mark_points(axis: Axes, points: np.ndarray, view: tuple, colour: str, filling: str, size: float = 3.2) -> None:
    """A marker at every point of one skeleton (6, 3), its shape telling shoulder, elbow or wrist."""
    for index, name in enumerate(POINTS):
        axis.plot(
            points[index, view[0]],
            points[index, view[1]],
            marker=_MARKERS[name.rpartition("_")[2]],
            markersize=size,
            markerfacecolor=filling,
            markeredgecolor=colour,
            markeredgewidth=0.7,
            linestyle="none",
            zorder=5,
        )


@style.styled
def paths(recorded: np.ndarray, original: np.ndarray, modified: np.ndarray) -> Figure:
    """Paths of the six points from behind and from above (Fig. 6a); markers stand at the modified ones' ends."""
    series = ((recorded, RECORDED), (original, ORIGINAL), (modified, MODIFIED))
    spans = [style.finite_range(*(points[..., axis] for points, _ in series), pad=0.06) for axis in range(3)]
    tallest = max(spans[axis][1] - spans[axis][0] for axis in (1, 2))
    for axis in (1, 2):  # Panels of one size.
        middle = 0.5 * sum(spans[axis])
        spans[axis] = (middle - 0.5 * tallest, middle + 0.5 * tallest)
    scale = (0.5 * style.PAGE - 0.6) / (spans[0][1] - spans[0][0])
    figure = Figure(figsize=(style.PAGE, scale * tallest + 0.85))
    axes = figure.subplots(1, 2)
    for axis, view, title in zip(axes, _VIEWS, ("from behind", "from above"), strict=True):
        for points, look in series:
            for point in range(len(POINTS)):
                axis.plot(points[:, point, view[0]], points[:, point, view[1]], **look)
        _mark_points(axis, modified[0], view, style.DARK, "white")
        _mark_points(axis, modified[-1], view, style.DARK, style.DARK)
        axis.set(title=title, xlabel=view[2], ylabel=view[3], aspect="equal")
        axis.set(xlim=spans[view[0]], ylim=spans[view[1]])
    handles = [Line2D([], [], **look) for _, look in series] + _marker_handles()
    look: dict[str, Any] = {"linestyle": "none", "marker": "o", "color": style.DARK, "markersize": 3.6}
    handles.append(Line2D([], [], fillstyle="none", markeredgewidth=0.7, label="open: start", **look))
    handles.append(Line2D([], [], label="filled: end", **look))
    figure.legend(handles=handles, loc="outside upper center", ncols=8, columnspacing=0.9, handlelength=1.7)
    return figure


@style.styled
def skeletons(
    instants: Sequence[tuple[str, float]], original: np.ndarray, modified: np.ndarray, broken: np.ndarray
) -> Figure:
    """Both skeletons at some instants, from behind and from above (Fig. 6b).

    Args:
        instants: K names and times, s.
        original, modified: (K, 6, 3) m.
        broken: (K, 5) bool: links of the original that are drawn as violations.
    """
    both = np.concatenate([original, modified])
    spans = [style.finite_range(both[..., axis], pad=0.12) for axis in range(3)]
    width, deep, tall = (high - low for low, high in spans)
    scale = (style.PAGE - 0.65) / len(instants) / width - 0.2
    figure = Figure(figsize=(style.PAGE, scale * (deep + tall) + 1.2))
    axes = figure.subplots(2, len(instants), sharex=True, sharey="row", squeeze=False, height_ratios=(tall, deep))
    for column, (name, time) in enumerate(instants):
        for row, view in enumerate(_VIEWS):
            axis = axes[row, column]
            for index, link in enumerate(LINKS):
                ends = [link.a, link.b]
                look = BROKEN if broken[column, index] else ORIGINAL
                axis.plot(original[column, ends, view[0]], original[column, ends, view[1]], **look, zorder=2)
                axis.plot(modified[column, ends, view[0]], modified[column, ends, view[1]], **MODIFIED, zorder=3)
            _mark_points(axis, original[column], view, style.VERMILLION, "white", 4.4)
            _mark_points(axis, modified[column], view, style.BLUE, style.BLUE, 2.4)
            axis.set(xlim=spans[view[0]], ylim=spans[view[1]], aspect="equal")
        axes[0, column].set_title(f"{name}\n{time:.2f} s", pad=3)
        axes[1, column].set_xlabel("x (m)")
    axes[0, 0].set_ylabel("z, up (m)")
    axes[1, 0].set_ylabel("y, forward (m)")
    handles = [Line2D([], [], **look) for look in (ORIGINAL, BROKEN, MODIFIED)] + _marker_handles()
    figure.legend(handles=handles, loc="outside upper center", ncols=6, columnspacing=1.1)
    return figure
