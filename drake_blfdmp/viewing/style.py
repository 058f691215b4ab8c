"""One look for every figure: palette, sizes, and helpers that dress axes. No pyplot, so no global state.

Colours are those of Okabe and Ito, "Color Universal Design" (2008), which stay apart for colour-blind readers; line
styles differ as well, so that figures survive printing in grey.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import wraps
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

BLUE, VERMILLION, GREEN, PURPLE = "#0072B2", "#D55E00", "#009E73", "#B0548D"
LIGHT, DARK = "#ABABAB", "#333333"

COUPLED: dict[str, Any] = {"color": BLUE, "linewidth": 1.4, "label": "coupled"}
UNCOUPLED: dict[str, Any] = {"color": VERMILLION, "linewidth": 1.1, "linestyle": (0, (4, 1.2)), "label": "uncoupled"}
DEMONSTRATED: dict[str, Any] = {"color": LIGHT, "linewidth": 0.7, "label": "demonstrated"}
BAND: dict[str, Any] = {"facecolor": GREEN, "alpha": 0.22, "linewidth": 0, "label": "band"}
BAND_EDGE: dict[str, Any] = {"color": GREEN, "linewidth": 0.7}
PLANNED: dict[str, Any] = {"color": DARK, "linewidth": 0.9, "linestyle": (0, (4, 2)), "zorder": 3}
LIMIT: dict[str, Any] = {"color": VERMILLION, "linewidth": 0.9, "linestyle": (0, (6, 1.5, 1, 1.5))}
LEFT: dict[str, Any] = {"color": BLUE, "linewidth": 1.3, "label": "left palm"}
RIGHT: dict[str, Any] = {"color": VERMILLION, "linewidth": 1.1, "linestyle": (0, (4, 1.2)), "label": "right palm"}

COLUMN, PAGE = 3.5, 7.16  # Widths of one and of two columns of a printed page, inches.
DPI = 220
_EVENT_SIZE, _EVENT_SLANT = 6.5, 35.0  # Points, degrees.

_RC: Mapping[str, Any] = {
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],
    "font.size": 7.5,
    "axes.titlesize": 8,
    "axes.labelsize": 7.5,
    "xtick.labelsize": 7,
    "ytick.labelsize": 7,
    "legend.fontsize": 7,
    "legend.frameon": False,
    "legend.handlelength": 2.4,
    "axes.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#E4E4E4",
    "grid.linewidth": 0.5,
    "axes.axisbelow": True,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "figure.facecolor": "white",
    "savefig.facecolor": "white",
    "figure.constrained_layout.use": True,
    "path.simplify": False,
    "svg.hashsalt": "drake_blfdmp",  # An SVG's identifiers are random without one.
}


def _look() -> dict[Any, Any]:
    """All of matplotlib's defaults but the backend, under this module's: a person's own matplotlibrc has no say."""
    return {key: value for key, value in matplotlib.rcParamsDefault.items() if key != "backend"} | dict(_RC)


DRAWINGS: dict[str, Callable[..., Figure]] = {}
"""Module and name of every function that `styled` has decorated so far, to the function."""


def styled(make: Callable[..., Figure]) -> Callable[..., Figure]:
    """Decorates a function that returns a Figure, so that whatever it draws has this module's look."""

    @wraps(make)
    def wrapper(*args: Any, **kwargs: Any) -> Figure:
        with matplotlib.rc_context(_look()):
            return make(*args, **kwargs)

    DRAWINGS[f"{make.__module__}.{make.__qualname__}"] = wrapper
    return wrapper


def save(figure: Figure, path: Path) -> Path:
    """Writes `figure` to `path`, and returns that, with bytes that depend on the data and matplotlib alone.

    An SVG where the path ends in .svg, letters drawn as outlines so that it needs no font; a PNG otherwise.
    """
    vector = path.suffix.lower() == ".svg"
    unsigned = {"Creator": None, "Date": None} if vector else {"Software": None}
    with matplotlib.rc_context(_look()):
        figure.savefig(path, dpi=DPI, format="svg" if vector else "png", metadata=unsigned)
    return path


def merge_events(
    events: Sequence[tuple[str, float]], span: tuple[float, float], least_gap: float = 0.06
) -> list[tuple[str, float]]:
    """Events inside `span` in time's order; those nearer than `least_gap` of the span share one label.

    Args:
        events: (name, time in s).
        span: first and last time shown, s.
        least_gap: room one label needs, as a fraction of the span.

    Returns: (label, time in s of the first event under the label).
    """
    first, last = span
    merged: list[tuple[str, float]] = []
    for name, time in sorted(events, key=lambda event: event[1]):
        if not first <= time <= last:
            continue
        if merged and time - merged[-1][1] < least_gap * (last - first):
            merged[-1] = (f"{merged[-1][0]}, {name}", merged[-1][1])
        else:
            merged.append((name, time))
    return merged


def event_label_height(events: Sequence[tuple[str, float]], span: tuple[float, float]) -> float:
    """Room, in points, that the slanted names of `mark_events` take above their axes."""
    longest = max((len(name) for name, _ in merge_events(events, span)), default=0)
    return 4.0 + _EVENT_SIZE * (0.62 * longest + 0.8) * float(np.sin(np.radians(_EVENT_SLANT))) if longest else 4.0


def mark_events(
    axes: Sequence[Axes] | np.ndarray, events: Sequence[tuple[str, float]], span: tuple[float, float]
) -> None:
    """Thin vertical lines at `events` (name, s) through all `axes`, named above the first of them."""
    for axis in axes:
        for _, time in events:
            if span[0] <= time <= span[1]:
                axis.axvline(time, color=DARK, linewidth=0.5, linestyle=(0, (1, 2)), zorder=1)
    for name, time in merge_events(events, span):
        axes[0].annotate(
            name.replace("_", " "),
            (time, 1.0),
            xycoords=axes[0].get_xaxis_transform(),
            xytext=(0, 2),
            textcoords="offset points",
            rotation=_EVENT_SLANT,
            rotation_mode="anchor",
            ha="left",
            va="bottom",
            fontsize=_EVENT_SIZE,
            color=DARK,
        )


def finish_time_axis(axis: Axes, t: np.ndarray) -> None:
    """Labels the time axis and ends it with the data; `t` is (N,) in s."""
    axis.set_xlabel("time (s)")
    axis.set_xlim(float(t[0]), float(t[-1]))


def legend_above(figure: Figure, axis: Axes, columns: int) -> None:
    """One legend for the whole figure, outside the axes, so that it never hides data."""
    handles, labels = axis.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=columns, columnspacing=1.4)


def finite_range(*arrays: np.ndarray, pad: float = 0.08) -> tuple[float, float]:
    """Least and greatest finite value of all arrays (same unit), widened by `pad` of their spread."""
    values = np.concatenate([np.ravel(array) for array in arrays])
    values = values[np.isfinite(values)]
    if not values.size:
        return 0.0, 1.0
    low, high = float(values.min()), float(values.max())
    margin = pad * (high - low) if high > low else max(abs(low), 1.0) * pad
    return low - margin, high + margin
