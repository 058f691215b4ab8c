"""Motions that were carried to other starts, goals, durations and boxes, with every law."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from drake_blfdmp.viewing import style
from drake_blfdmp.viewing.law_style import LAW_LOOKS

PANELS = {
    "bands left (% of problems)": ("left_percent", "linear", (-4, 104)),
    "hands' middle to goal at the end (m)": ("end_hands_mean_m", "log", (5e-6, 1.0)),
    "path to the uncoupled one (m)": ("path_mean_m", "log", (5e-3, 1.0)),
}
"""Of `overview`: label to column, scale and limits."""


@style.styled
def overview(rows: Mapping[tuple[str, str], Mapping[str, float]]) -> Figure:
    """Bands left, end errors and change of the path, a row a case, a marker a law.

    Args:
        rows: case and law to the columns that `PANELS` names; on a logarithmic axis what is not positive is not shown.
    """
    cases, laws = (list(dict.fromkeys(key[i] for key in rows)) for i in (0, 1))
    figure = Figure(figsize=(style.PAGE, 0.27 * len(cases) + 0.95))
    axes = figure.subplots(1, 3, sharey=True)
    for axis, (label, (column, scale, span)) in zip(axes, PANELS.items(), strict=True):
        for i, name in enumerate(laws):
            values = np.array([rows[case, name][column] for case in cases])
            shown = values > 0.0 if scale == "log" else np.isfinite(values)
            axis.plot(values[shown], (np.arange(len(cases)) + 0.22 * (i - 1))[shown], "osD"[i], markersize=4,
                      color=LAW_LOOKS[name]["color"], label=LAW_LOOKS[name]["label"])  # fmt: skip
        axis.set(xlabel=label, xscale=scale, xlim=span)
        axis.grid(axis="y", visible=False)
        for i in range(1, len(cases)):
            axis.axhline(i - 0.5, color="#E4E4E4", linewidth=0.5, zorder=0)
    axes[0].set_ylim(len(cases) - 0.5, -0.5)
    axes[0].set_yticks(range(len(cases)), cases)
    style.legend_above(figure, axes[0], 3)
    return figure


@dataclass(frozen=True)
class Curve:
    """A labelled series: t and values (N,)."""

    label: str
    t: np.ndarray
    values: np.ndarray


_THREE = ((style.BLUE, "-"), (style.VERMILLION, (0, (4, 1.2))), (style.GREEN, (0, (1, 1))))


@style.styled
def examples(goal: Curve, followers: Mapping[str, np.ndarray], distances: Mapping[str, Sequence[Curve]]) -> Figure:
    """The hands following a goal that moves in a circle, and their distance in other problems.

    Args:
        goal: x of the middle between the hands' goals, m over s.
        followers: law to x of the hands' middle (N,) at the same times, m.
        distances: two cases to at most three curves of the hands' distance, m over s.
    """
    figure = Figure(figsize=(style.PAGE, 2.5))
    left, *others = figure.subplots(1, 3)
    left.plot(goal.t, goal.values, **style.PLANNED | {"label": goal.label})
    for name, values in followers.items():
        left.plot(goal.t, values, **LAW_LOOKS[name])
    left.set(xlabel="time (s)", ylabel="hands' middle, x (m)", title="goal in a circle")
    left.legend(loc="best", fontsize=6)
    for axis, (case, curves) in zip(others, distances.items(), strict=True):
        for curve, (colour, line) in zip(curves, _THREE, strict=False):
            axis.plot(curve.t, curve.values, color=colour, linestyle=line, linewidth=1.2, label=curve.label)
        axis.set(xlabel="time (s)", title=case)
        axis.legend(loc="best", fontsize=6)
    others[0].set_ylabel("hands' distance (m)")
    others[-1].set_ylim(top=0.73)  # Room for the legend.
    return figure
