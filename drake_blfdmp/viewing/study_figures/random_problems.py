"""How often, how closely and when laws leave their bands on random problems.

A run is named by its law, or by its law, a comma and what is different.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter

from drake_blfdmp.skeleton import HANDS
from drake_blfdmp.viewing import style
from drake_blfdmp.viewing.law_style import LAW_LOOKS


def look(name: str) -> dict[str, Any]:
    """Colour, line and label of a run: its law's, dotted and by its own name where it is a law's second run."""
    law = name.split(",")[0]
    own = {} if name == law else {"label": name, "linestyle": (0, (1, 1))}
    return {**LAW_LOOKS[law], **own}


@style.styled
def shares(results: Mapping[str, tuple[int, int, float, float]]) -> Figure:
    """Shares of problems in which a band was left, with their intervals; of none, only how many it may be.

    Args:
        results: run to count, trials, and the lower and upper end of the share's interval.
    """
    figure = Figure(figsize=(style.COLUMN, 0.24 * len(results) + 0.75))
    axis = figure.subplots()
    floor = 100.0 * min(upper for *_, upper in results.values()) / 4.0
    for row, (name, (count, trials, *interval)) in enumerate(results.items()):
        colour = look(name)["color"]
        lower, upper, share = 100.0 * interval[0], 100.0 * interval[1], 100.0 * (count / trials)
        if count:
            axis.plot([lower, upper], [row, row], color=colour, linewidth=1.4)
            axis.plot(share, row, "o", color=colour, markersize=4)
        else:
            axis.annotate("", (floor, row), (upper, row), arrowprops={"arrowstyle": "->", "color": colour})
            axis.plot(upper, row, "|", color=colour, markersize=7, markeredgewidth=1.4)
        right = share > 3.0
        axis.annotate(
            f"{count} of {trials}",
            (lower if right and count else upper, row),
            xytext=(-7 if right else 6, 0),
            textcoords="offset points",
            ha="right" if right else "left",
            va="center",
            fontsize=6.5,
        )
    axis.set_yticks(range(len(results)), [look(name)["label"] for name in results])
    axis.set(xscale="log", xlim=(floor, 140.0), ylim=(len(results) - 0.4, -0.6))
    axis.set_xlabel("problems in which a band is left (%)")
    axis.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.grid(axis="y", visible=False)
    return figure


@style.styled
def least_margins(least: np.ndarray) -> Figure:
    """Histogram of the least margins (P, 5) of the default law, bones and hands."""
    figure = Figure(figsize=(style.COLUMN, 2.1))
    axis = figure.subplots()
    edges = np.linspace(min(0.0, float(least.min())), max(0.25, float(np.quantile(least, 0.999))), 61)
    groups = {
        "bones, least of four": (np.delete(least, HANDS, axis=1).min(axis=1), style.BLUE, "-"),
        "hands": (least[:, HANDS], style.VERMILLION, (0, (4, 1.2))),
    }
    for name, (values, colour, line) in groups.items():
        axis.hist(values, bins=list(edges), histtype="step", color=colour, linestyle=line, linewidth=1.2, label=name)
    axis.axvline(0.0, **style.LIMIT)
    axis.annotate("edge of the band", (0.0, 0.5), xycoords=axis.get_xaxis_transform(), xytext=(4, 0),
                  textcoords="offset points", rotation=90, va="center", fontsize=6.5, color=style.DARK)  # fmt: skip
    axis.set(yscale="log", xlabel="least margin 1 - |ξ| of a problem", ylabel="problems", ylim=(0.7, None))
    style.legend_above(figure, axis, 2)
    return figure


@style.styled
def first_times(relative: Mapping[str, np.ndarray]) -> Figure:
    """Share of problems that have left a band by a time; `relative` name to (P,) first time over tau, inf: never."""
    figure = Figure(figsize=(style.COLUMN, 2.6))
    axis = figure.subplots()
    for name, times in relative.items():
        reached = np.sort(times[np.isfinite(times)])
        steps = np.concatenate([[5e-4], reached, [1.0]])
        share = np.concatenate([[0.0], np.arange(1, len(reached) + 1), [len(reached)]]) * 100.0 / len(times)
        axis.plot(steps, share, drawstyle="steps-post", **look(name))
    axis.set(xscale="log", xlim=(5e-4, 1.0), ylim=(-3, 103))
    axis.set(xlabel="time over duration", ylabel="problems that left a band (%)")
    style.legend_above(figure, axis, 2)
    return figure
