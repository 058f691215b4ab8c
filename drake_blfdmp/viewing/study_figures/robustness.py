"""How often laws carry out random tasks, what fails, and where in the ranges that is."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from drake_blfdmp.viewing import style
from drake_blfdmp.viewing.law_style import LAW_LOOKS

VERDICT_LOOKS: dict[str, dict[str, Any]] = {
    "success": {"color": style.BLUE, "marker": "o", "markersize": 2.6, "alpha": 0.7},
    "refused": {"color": style.LIGHT, "marker": "D", "markersize": 2.8},
    "failure": {"color": style.VERMILLION, "marker": "X", "markersize": 4.6, "zorder": 4},
    "crash": {"color": style.DARK, "marker": "P", "markersize": 4.6, "zorder": 5},
}

DRAWN = ("width_m", "mass_kg", "friction", "duration", "mass_scale", "friction_scale")
"""Of a task, what `where` shows besides the box's places."""

Interval = tuple[float, float, float]
"""A share with the lower and the upper end of its interval."""


@style.styled
def success(shares: Mapping[str, tuple[Interval, Interval, int]], target: float) -> Figure:
    """Of each law: success as `summary.json` has it (filled), and the box carried within every limit (open).

    Args:
        shares: law to both shares and the number of feasible tasks.
        target: share that the default law shall reach.
    """
    figure = Figure(figsize=(style.COLUMN, 0.42 * len(shares) + 0.9))
    axis = figure.subplots()
    for row, (law, (counted, carried, trials)) in enumerate(shares.items()):
        colour = LAW_LOOKS[law]["color"]
        for shift, (share, lower, upper), filled in ((-0.13, counted, True), (0.13, carried, False)):
            at = row + shift
            axis.plot([100.0 * lower, 100.0 * upper], [at, at], color=colour, linewidth=1.4 if filled else 0.8)
            face = colour if filled else "white"
            axis.plot(100.0 * share, at, "o", color=colour, markerfacecolor=face, markersize=4)
        axis.annotate(
            f"of {trials}", (1.0, row), xycoords=axis.get_yaxis_transform(), xytext=(4, 0),
            textcoords="offset points", va="center", fontsize=6.5, annotation_clip=False,
        )  # fmt: skip
    axis.axvline(100.0 * target, **style.PLANNED)
    axis.set_yticks(range(len(shares)), [LAW_LOOKS[law]["label"] for law in shares])
    axis.set(xlim=(-2, 102), ylim=(max(len(shares), 1) - 0.5, -0.5))
    axis.set_xlabel("feasible tasks (%), with 95 % intervals")
    axis.grid(axis="y", visible=False)
    marks = [
        Line2D([], [], color=style.DARK, marker="o", markerfacecolor=face, markersize=4, linewidth=width, label=label)
        for face, width, label in ((style.DARK, 1.4, "success"), ("white", 0.8, "box carried within all limits"))
    ]
    figure.legend(handles=marks, loc="outside upper center", ncols=2)
    return figure


@style.styled
def failures(counts: Mapping[str, Mapping[str, int]], tasks: Mapping[str, int]) -> Figure:
    """Share of feasible tasks that fail, by first class, law beside law.

    Args:
        counts: law to classes to numbers. tasks: law to how many feasible tasks it was tried on.
    """
    names = list(dict.fromkeys(name for found in counts.values() for name in found))
    figure = Figure(figsize=(style.COLUMN, 0.3 * max(len(names), 1) + 1.0))
    axis = figure.subplots()
    height = 0.8 / max(len(counts), 1)
    for i, (law, found) in enumerate(counts.items()):
        look = LAW_LOOKS[law]
        share = [100.0 * found.get(name, 0) / max(tasks[law], 1) for name in names]
        at = np.arange(len(names)) - 0.4 + (i + 0.5) * height
        axis.barh(at, share, height=0.9 * height, color=look["color"], label=look["label"])
        for y, value in zip(at, share, strict=True):
            if value:
                axis.annotate(f"{value:.3g}", (value, y), xytext=(2, 0), textcoords="offset points", va="center",
                              fontsize=5.5)  # fmt: skip
    axis.set_yticks(range(len(names)), names)
    axis.set(xlabel="feasible tasks that fail (%)", ylim=(len(names) - 0.5, -0.5) if names else (0.5, -0.5))
    axis.set_xlim(left=0.0)
    axis.grid(axis="y", visible=False)
    style.legend_above(figure, axis, 2)
    return figure


@style.styled
def where(tasks: Mapping[str, np.ndarray], verdicts: Sequence[str], ends: Mapping[str, np.ndarray]) -> Figure:
    """Each of N tasks of the default law by its verdict, over what is drawn.

    Args:
        tasks: each of `DRAWN` to (N,).
        verdicts: N of `VERDICT_LOOKS`.
        ends: "start_m" and "goal_m" to (N, 3) in W; NaN where nothing was planned.
    """
    figure = Figure(figsize=(style.PAGE, 4.4))
    axes = figure.subplots(2, 3)
    found = np.array(verdicts)
    panels = (
        (tasks["mass_kg"], tasks["friction"], "mass (kg)", "friction"),
        (tasks["width_m"], tasks["duration"], "width (m)", "duration, over the person's"),
        (tasks["mass_scale"], tasks["friction_scale"], "mass, true over believed", "friction, true over believed"),
        (ends["start_m"][:, 0], ends["start_m"][:, 1], "start x (m)", "start y (m)"),
        (ends["goal_m"][:, 0], ends["goal_m"][:, 1], "goal x (m)", "goal y (m)"),
        (ends["start_m"][:, 2], ends["goal_m"][:, 2], "start z (m)", "goal z (m)"),
    )
    for axis, (x, y, across, up) in zip(axes.flat, panels, strict=True):
        _by_verdict(axis, x, y, found)
        axis.set(xlabel=across, ylabel=up)
        axis.xaxis.set_major_locator(MaxNLocator(5))
        axis.yaxis.set_major_locator(MaxNLocator(5))
    present = [name for name in VERDICT_LOOKS if (found == name).any()]
    marks = [
        Line2D([], [], linestyle="none", label=f"{name} ({np.sum(found == name)})", **VERDICT_LOOKS[name])
        for name in present
    ]
    figure.legend(handles=marks, loc="outside upper center", ncols=len(marks) or 1)
    return figure


def _by_verdict(axis: Axes, x: np.ndarray, y: np.ndarray, verdicts: np.ndarray) -> None:
    for name, look in VERDICT_LOOKS.items():
        chosen = verdicts == name
        axis.plot(x[chosen], y[chosen], linestyle="none", markeredgewidth=0, **look)


@style.styled
def accuracy(
    placement_m: Mapping[str, np.ndarray], tilt_deg: Mapping[str, np.ndarray], targets: Mapping[str, Any]
) -> Figure:
    """Share of runs that place the box at least so closely and tilt it at most so far.

    Args:
        placement_m, tilt_deg: law to (N,).
        targets: "placement_m" to (share, m) pairs, "tilt_deg" to degrees.
    """
    figure = Figure(figsize=(style.PAGE, 2.3))
    left, right = figure.subplots(1, 2, sharey=True)
    for axis, found, scale in ((left, placement_m, 1e3), (right, tilt_deg, 1.0)):
        for law, values in found.items():
            if len(values):
                ordered = scale * np.sort(values)
                share = 100.0 * np.arange(1, len(ordered) + 1) / len(ordered)
                axis.plot(
                    np.append(ordered[:1], ordered), np.append(0.0, share), drawstyle="steps-post", **LAW_LOOKS[law]
                )
        axis.set_xscale("log")
        axis.xaxis.set_major_formatter(lambda value, _: f"{value:g}")
    for share, value in targets["placement_m"]:
        left.plot(1e3 * value, 100.0 * share, marker="<", markersize=6, color=style.DARK, linestyle="none", zorder=6)
    right.axvline(targets["tilt_deg"], **style.PLANNED)
    left.set(xlabel="placement error (mm); triangles: targets", ylabel="runs (%)", ylim=(-3, 103))
    right.set(xlabel="greatest tilt (degrees); dashed: target")
    style.legend_above(figure, left, 4)
    return figure
