"""The laws side by side: hands' distance (Fig. 10), iterative learning, all five links, Remark 2."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from drake_blfdmp.skeleton import HANDS, LINKS
from drake_blfdmp.skill.bands import Bands
from drake_blfdmp.viewing import style
from drake_blfdmp.viewing.law_style import GAMS_LEARNED, LAW_LOOKS
from drake_blfdmp.viewing.study_figures.looks import RECORDED

CLOSE = 0.014
"""m from d_j that the panels of what is left show."""

_FUNNEL = style.PLANNED | {"linewidth": 0.7, "linestyle": (0, (1, 1.2))}
_END: dict[str, Any] = {
    "color": style.DARK,
    "marker": "x",
    "markersize": 5,
    "markeredgewidth": 1.2,
    "label": "lagged leaves",
}


@dataclass(frozen=True)
class HandsBand:
    """What the hands' distance is to be on N samples, m.

    Attributes:
        desired: (N,) d_j.
        funnel, bounds: (N, 2) lower and upper, opened to the start, and as (20) prints them.
    """

    desired: np.ndarray
    funnel: np.ndarray
    bounds: np.ndarray

    @classmethod
    def of(cls, bands: Bands, t: np.ndarray) -> Self:
        """Of opened bands at t (N,), s."""
        funnel, bounds = (some.evaluate(t)[:, :2, HANDS] for some in (bands, bands.paper()))
        return cls(bands.desired(t)[0][:, HANDS], funnel, bounds)


@style.styled
def hand_distances(
    t: np.ndarray,
    recorded: np.ndarray,
    bands: Mapping[str, HandsBand],
    curves: Mapping[str, Mapping[str, np.ndarray]],
    learned: Mapping[str, np.ndarray],
    *,
    start: float,
    rate: float,
) -> Figure:
    """The hands' distance with every law, a case a row: all of it, its start, and what is left to d_j.

    Args:
        t: (N,) s.
        recorded: (N,) m.
        bands: title -> the case's band.
        curves: title -> law -> (N,) m, NaN where it has gone.
        learned: title -> (N,) m, Gams et al. after their learning.
        start: s, shown on its own, with the samples of a recording at `rate`, 1/s, above.
    """
    figure = Figure(figsize=(style.PAGE, 4.5))
    axes = figure.subplots(2, 3, width_ratios=(1.1, 1.0, 1.25))
    for row, (title, own) in enumerate(bands.items()):
        desired, funnel, bounds = own.desired, own.funnel, own.bounds
        for column, axis in enumerate(axes[row]):
            # The last column is in mm and relative to d_j, the others are in m.
            scale, base = (1e3, desired) if column == 2 else (1.0, np.zeros_like(desired))
            low, high = (scale * (bounds[:, edge] - base) for edge in (0, 1))
            axis.fill_between(t, low, high, **style.BAND | {"label": "bounds (20)"})
            for edge in (0, 1):
                axis.plot(t, scale * (funnel[:, edge] - base), **_FUNNEL | {"label": "" if edge else "opened funnel"})
            if column < 2:  # What no law holds is far off d_j most of the time.
                axis.plot(t, recorded, **RECORDED | {"zorder": 1.5})
            for name, lengths in curves[title].items():
                if column < 2 or name != "none":
                    axis.plot(t, scale * (lengths - base), **LAW_LOOKS[name])
            axis.plot(t, scale * (learned[title] - base), **GAMS_LEARNED)
        _frame(axes[row], t, start, rate)
        axes[row, 0].set_title(title)
        axes[row, 0].set_ylabel("hands' distance (m)")
        axes[row, 2].set_title("the same, off $d_j$")
        axes[row, 2].set_ylabel("off $d_j$ (mm)")
        _mark_leaving(axes[row, 1], t, funnel, curves[title].get("published_lagged"))
    for axis in axes[1]:
        axis.set_xlabel("time (s)")
    handles, _ = axes[0, 0].get_legend_handles_labels()
    handles.append(Line2D([], [], linestyle="none", **_END))
    figure.legend(handles=handles, loc="outside upper center", ncols=6, columnspacing=1.2, handlelength=2.2)
    return figure


def _frame(axes: np.ndarray, t: np.ndarray, start: float, rate: float) -> None:
    """The limits of a row, and the samples above its second panel."""
    for axis, end in zip(axes, (float(t[-1]), start, float(t[-1])), strict=True):
        axis.set_xlim(0.0, end)
    for axis in axes[:2]:
        axis.set_ylim(0.13, 0.52)
    axes[2].set_ylim(-1e3 * CLOSE, 1e3 * CLOSE)
    above = axes[1].secondary_xaxis("top", functions=(lambda s: s * rate, lambda k: k / rate))
    above.set_xlabel(f"samples $k$ ({rate:g} Hz)", fontsize=7)


def _mark_leaving(axis: Axes, t: np.ndarray, funnel: np.ndarray, lengths: np.ndarray | None) -> None:
    """A cross where these lengths leave the funnel for the first time."""
    if lengths is None:
        return
    outside = ~((lengths > funnel[:, 0]) & (lengths < funnel[:, 1]))
    if np.any(outside):
        k = int(np.argmax(outside))
        edge = funnel[k, int(np.nan_to_num(lengths[k], nan=np.inf) > funnel[k].mean())]
        axis.plot(t[k], edge, linestyle="none", zorder=6, **_END)


@style.styled
def learning(errors: Mapping[str, tuple[np.ndarray, np.ndarray]], settled: float) -> Figure:
    """RMS error an epoch: case -> of the whole motion, and from `settled`, s, on; (E,) m each."""
    figure = Figure(figsize=(style.COLUMN, 2.4))
    axis = figure.subplots()
    for (case, series), colour, marker in zip(errors.items(), (style.BLUE, style.VERMILLION), "os", strict=True):
        for values, line, part in zip(series, ("-", (0, (4, 1.2))), ("all", f"from {settled:g} s on"), strict=True):
            look = {"color": colour, "marker": marker, "linestyle": line, "markersize": 3, "linewidth": 1.1}
            axis.semilogy(np.arange(1, len(values) + 1), 1e3 * np.asarray(values), **look, label=f"{case}, {part}")
    axis.set(xlabel="epoch (the first is feedback alone)", ylabel="RMS of $d_d - d_a$ (mm)")
    axis.xaxis.set_major_locator(MaxNLocator(integer=True))
    style.legend_above(figure, axis, columns=2)
    return figure


@style.styled
def links_over_time(t: np.ndarray, lengths: Mapping[str, np.ndarray], bands: np.ndarray) -> Figure:
    """How far each link is from the middle of its opened band, by the half width.

    Args:
        t: (N,) s.
        lengths: law -> (N, 5) m.
        bands: (N, 2, 5) lower and upper, m.
    """
    figure = Figure(figsize=(style.PAGE, 3.6))
    axes = figure.subplots(2, 3, sharex=True, sharey=True)
    middle, half = 0.5 * (bands[:, 0] + bands[:, 1]), 0.5 * (bands[:, 1] - bands[:, 0])
    for i, (link, axis) in enumerate(zip(LINKS, axes.flat, strict=False)):
        axis.axhspan(-1, 1, **style.BAND | {"label": "opened band"})
        for name, values in lengths.items():
            axis.plot(t, (values[:, i] - middle[:, i]) / half[:, i], **LAW_LOOKS[name])
        axis.set(title=link.name.replace("_", " "), ylim=(-1.15, 1.15))
    axes[1, 2].set_visible(False)
    for axis in (axes[1, 0], axes[1, 1], axes[0, 2]):
        axis.tick_params(labelbottom=True)
        style.finish_time_axis(axis, t)
    for axis in axes[:, 0]:
        axis.set_ylabel("off the middle\n(half widths)")
    handles, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="center", bbox_to_anchor=(0.84, 0.25))
    return figure


@style.styled
def remark_2(t: np.ndarray, empty: Mapping[str, np.ndarray], widening: Mapping[str, np.ndarray]) -> Figure:
    """Axes without a common result, and the widening that Remark 2 needs there.

    Args:
        t: (N,) s.
        empty: law -> (N, 2, 3) where there is none; widening: the same, m.
    """
    figure = Figure(figsize=(style.COLUMN, 2.8))
    axes = figure.subplots(2, 1, sharex=True)
    counts = {name: values.sum(axis=(1, 2)) for name, values in empty.items()}
    for name, values in counts.items():
        axes[0].plot(t, values, drawstyle="steps-post", **LAW_LOOKS[name])
        axes[1].plot(t, 1e3 * widening[name].max(axis=(1, 2)), **LAW_LOOKS[name])
    most = max(int(values.max()) for values in counts.values())
    axes[0].set(ylabel="axes without a\ncommon result (of 6)", ylim=(-0.15, most + 0.5))
    axes[0].yaxis.set_major_locator(MaxNLocator(integer=True))
    axes[1].set(ylabel="hands' band\nwidened by (mm)", xlabel="time (s)")
    last = max(float(t[values > 0].max(initial=0.0)) for values in counts.values())
    axes[1].set_xlim(0.0, 1.1 * last + 0.1)
    style.legend_above(figure, axes[0], columns=2)
    return figure
