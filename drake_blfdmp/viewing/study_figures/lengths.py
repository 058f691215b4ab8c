"""Lengths of the arms' bones over time, in the paper's bands and the opened funnels (Figs. 8 and 9)."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from drake_blfdmp.skeleton import LINKS
from drake_blfdmp.viewing import style
from drake_blfdmp.viewing.study_figures.looks import RECORDED

ARMS = {"left arm": (1, 0), "right arm": (3, 4)}
"""Forearm and upper arm of either arm, indices into `skeleton.LINKS`."""

_FUNNEL = style.PLANNED | {"linewidth": 0.7, "zorder": 2, "label": "opened funnel"}
_BONES = {"forearm": (style.BLUE, "-"), "upper arm": (style.PURPLE, (0, (4, 1.2)))}


def _bone_kind(link: int) -> str:
    return LINKS[link].name.split("_", 1)[1].replace("_", " ")


@style.styled
def arm_lengths(
    t: np.ndarray,
    lengths: np.ndarray,
    funnel: np.ndarray,
    paper: np.ndarray,
    *,
    recorded: np.ndarray | None = None,
    start: tuple[float, int] | None = None,
) -> Figure:
    """Elbow-wrist and elbow-shoulder distances of both arms (Figs. 8 and 9), in the paper's bands and opened funnels.

    Args:
        t: (N,) s.
        lengths: (N, 5) m.
        funnel, paper: (N, 2, 5) lower and upper of the opened bands and of those that (13) prints, m.
        recorded: (N, 5) m.
        start: samples a second and a number of samples: shows twice as many, with a line there.
    """
    figure = Figure(figsize=(style.PAGE, 2.5))
    axes = figure.subplots(1, 2, sharey=True)
    rate, limit = start or (1.0, 0)
    shown = t * rate <= 2 * limit if start else np.full(len(t), True)
    clock = (t * rate)[shown]
    for axis, (title, links) in zip(axes, ARMS.items(), strict=True):
        grey = None if recorded is None else recorded[shown]
        _draw_lengths(axis, clock, lengths[shown], funnel[shown], paper[shown], grey, links)
        axis.set_title(title)
        style.finish_time_axis(axis, clock)
        if start:
            axis.axvline(limit, color=style.DARK, linewidth=0.8, linestyle=(0, (1, 2)))
            axis.set_xlabel(f"samples of the recording ({rate:g} Hz)")
    axes[0].set_ylabel("distance between\njoints (m)")
    _lengths_legend(figure, recorded is not None)
    return figure


def _draw_lengths(axis: Axes, t, lengths, funnel, paper, recorded, links: Sequence[int]) -> None:
    """One arm: recorded, the paper's bands, the opened funnel's edges, the lengths."""
    for link in links:
        colour, line = _BONES[_bone_kind(link)]
        if recorded is not None:
            axis.plot(t, recorded[:, link], **RECORDED | {"linestyle": line, "zorder": 1.5})
        axis.fill_between(t, paper[:, 0, link], paper[:, 1, link], facecolor=colour, alpha=0.2, linewidth=0)
        for edge in (0, 1):
            axis.plot(t, funnel[:, edge, link], **_FUNNEL | {"color": colour})
        axis.plot(t, lengths[:, link], color=colour, linestyle=line, linewidth=1.4, zorder=3)


def _lengths_legend(figure: Figure, recorded: bool) -> None:
    handles: list[Any] = [
        Line2D([], [], color=colour, linestyle=line, linewidth=1.4, label=label)
        for (colour, line), label in zip(
            _BONES.values(), ("elbow to wrist, $d_e$", "elbow to shoulder, $d_s$"), strict=True
        )
    ]
    handles.append(Patch(facecolor=style.DARK, alpha=0.2, linewidth=0, label="band (13)"))
    handles.append(Line2D([], [], **_FUNNEL))
    if recorded:
        handles.append(Line2D([], [], **RECORDED))
    figure.legend(handles=handles, loc="outside upper center", ncols=len(handles), columnspacing=1.2)
