"""A recording's health as one figure: lengths, hands, clock and points."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from drake_blfdmp.demonstration.bones import link_lengths
from drake_blfdmp.demonstration.health import Examined
from drake_blfdmp.skeleton import HANDS, POINTS
from drake_blfdmp.viewing import style

_BONES = (("upper arms", (0, 4), style.BLUE), ("forearms", (1, 3), style.PURPLE))
_SIDES = (("left", "-"), ("right", (0, (4, 1.2))))


@style.styled
def health_figure(examined: Examined) -> Figure:
    """Raw bone lengths, hands' distance with the held interval, steps of the clock, and what is seen of each point."""
    figure = Figure(figsize=(style.PAGE, 4.6))
    axes = figure.subplots(2, 2)
    recording = examined.recording
    order = np.argsort(recording.t, kind="stable")
    t = recording.t[order] - recording.t.min()
    lengths = link_lengths(recording.x[order])
    _draw_bones(axes[0, 0], t, lengths)
    _draw_hands(axes[0, 1], t, lengths[:, HANDS], examined)
    _draw_clock(axes[1, 0], recording.t, examined)
    _draw_points(axes[1, 1], examined)
    return figure


def _draw_bones(axis: Axes, t: np.ndarray, lengths: np.ndarray) -> None:
    for name, pair, colour in _BONES:
        for link, (side, dashes) in zip(pair, _SIDES, strict=True):
            axis.plot(t, lengths[:, link], color=colour, linestyle=dashes, linewidth=0.9, label=f"{side} {name[:-1]}")
    finite = lengths[:, [0, 1, 3, 4]]
    finite = finite[np.isfinite(finite)]
    if len(finite):
        # One marker swap must not flatten all the rest; what is cut off is in the table.
        most = min(float(finite.max()), 2.5 * float(np.median(finite)))
        axis.set_ylim(max(0.0, 0.9 * float(finite.min())), 1.05 * most)
    axis.set(xlabel="time (s)", ylabel="length (m)")
    _head(axis, "bones as recorded", columns=2)


def _draw_hands(axis: Axes, t: np.ndarray, distance: np.ndarray, examined: Examined) -> None:
    axis.plot(t, distance, **(style.DEMONSTRATED | {"label": "as recorded", "linewidth": 1.0}))
    demonstration, holding = examined.demonstration, examined.holding
    if demonstration is not None:
        axis.plot(demonstration.t, link_lengths(demonstration.x)[:, HANDS], color=style.BLUE, label="cleaned")
    if holding is not None:
        axis.axvspan(holding.start_s, holding.end_s, **(style.BAND | {"label": "held in both hands"}))
        span = [holding.start_s, holding.end_s]
        width = f"box, {holding.hand_distance:.3f} m"
        axis.plot(span, 2 * [holding.hand_distance], **(style.PLANNED | {"label": width}))
    axis.set(xlabel="time (s)", ylabel="distance (m)")
    _head(axis, "from hand to hand", columns=2)


def _draw_clock(axis: Axes, t: np.ndarray, examined: Examined) -> None:
    steps = np.diff(t)
    clock = examined.health.clock
    axis.plot(1000.0 * steps, color=style.BLUE, linewidth=0.6, marker=".", markersize=2, label="from sample to sample")
    if clock.rate_hz is not None:
        step = 1000.0 / clock.rate_hz
        axis.axhline(step, **(style.PLANNED | {"label": f"median, {clock.rate_hz:.1f} Hz"}))
        # From zero, so that the rounding of time stamps does not look like jitter.
        axis.set_ylim(min(0.0, 1000.0 * float(steps.min())), max(2.0 * step, 1050.0 * float(steps.max())))
    axis.set(xlabel="sample", ylabel="step (ms)")
    title = f"clock: {clock.dropped} dropped, {clock.repeated} repeated, {clock.out_of_order} late"
    _head(axis, title, columns=2)


def _draw_points(axis: Axes, examined: Examined) -> None:
    points = examined.health.points
    rows = np.arange(len(POINTS))[::-1]
    guessed = np.array([points[name].guessed or 0.0 for name in POINTS])
    seen = np.array([points[name].seen for name in POINTS])
    sure = np.clip(seen - guessed, 0.0, 1.0)
    axis.barh(rows, 100 * sure, color=style.GREEN, label="seen")
    if guessed.any():
        axis.barh(rows, 100 * (seen - sure), left=100 * sure, color=style.LIGHT, hatch="///", label="guessed")
    if (seen < 1.0).any():
        axis.barh(rows, 100 * (1 - seen), left=100 * seen, color=style.VERMILLION, hatch="xxx", label="missing")
    for row, name in zip(rows, POINTS, strict=True):
        noise = points[name].noise_m
        if noise is not None:
            axis.text(101, row, f"{1000 * noise:.1f} mm", va="center", fontsize=6.5)
    axis.set_yticks(rows, [name.replace("_", " ") for name in POINTS])
    axis.set(xlim=(0, 100), xlabel="share of the frames (%)")
    axis.grid(False)
    noisy = any(points[name].noise_m is not None for name in POINTS)
    _head(axis, "points, and their noise" if noisy else "points", columns=3)


def _head(axis: Axes, title: str, columns: int) -> None:
    """The title, and the legend between it and the axes, where it hides no data."""
    axis.set_title(
        title, loc="left", fontweight="bold", pad=9 + 10 * -(-len(axis.get_legend_handles_labels()[0]) // columns)
    )
    axis.legend(ncols=columns, loc="lower left", bbox_to_anchor=(0.0, 0.99), borderaxespad=0.3, columnspacing=1.2)
