"""The palms' distance and force in worlds that are not as believed, with the loop around them open and closed."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from drake_blfdmp.viewing import style

LOOKS: dict[str, dict[str, Any]] = {
    "open": {"color": style.VERMILLION, "linewidth": 1.0, "linestyle": (0, (4, 1.2)), "label": "loop open"},
    "closed": {"color": style.BLUE, "linewidth": 1.3, "label": "loop closed"},
}


@dataclass(frozen=True)
class Series:
    """One run on N samples: t in s, offset from the band's middle and its half width in m, force in N, tempo."""

    t: np.ndarray
    offset: np.ndarray
    half_width: np.ndarray
    force: np.ndarray
    tempo: np.ndarray


@style.styled
def bands(
    runs: Mapping[str, Mapping[str, Series]], windows: Mapping[str, tuple[float, float]], wanted_force: float
) -> Figure:
    """A column a world: offset of the palms' distance in the hands' band above, their least force below.

    Args:
        runs: world to loop to series.
        windows: world to the times to show, s.
        wanted_force: of the plan, N.
    """
    figure = Figure(figsize=(style.PAGE, 3.6))
    axes = figure.subplots(2, len(runs), sharex="col", sharey="row", squeeze=False)
    for column, (world, loops) in enumerate(runs.items()):
        above, below = axes[:, column]
        for loop, series in loops.items():
            shown = (series.t >= windows[world][0]) & (series.t <= windows[world][1])
            t, half = series.t[shown], 1e3 * series.half_width[shown]
            if loop == "closed":
                above.fill_between(t, -half, half, **style.BAND)
            above.plot(t, 1e3 * series.offset[shown], **LOOKS[loop])
            below.plot(t, series.force[shown].min(axis=1), **LOOKS[loop])
        below.axhline(wanted_force, **style.PLANNED)
        above.set_title(world)
        below.set_xlim(*windows[world])
        below.set_xlabel("time (s)")
    axes[0, 0].set_ylim(-25.0, 25.0)
    axes[1, 0].set_ylim(bottom=0.0)
    axes[0, 0].set_ylabel("effective distance,\noff the middle (mm)")
    axes[1, 0].set_ylabel("lesser palm's\nforce (N)")
    style.legend_above(figure, axes[0, 0], columns=3)
    figure.align_ylabels(axes[:, 0])
    return figure


@style.styled
def tempos(series: Mapping[str, Series], errors: Mapping[str, np.ndarray], window: Sequence[float]) -> Figure:
    """Tracking error of the palms' middle above, tempo of the skill's clock below, with the loop closed.

    Args:
        series: world to series.
        errors: world to tracking error (N,), m.
        window: of time, s.
    """
    figure = Figure(figsize=(style.COLUMN, 3.0))
    above, below = figure.subplots(2, 1, sharex=True)
    looks = (style.BLUE, style.VERMILLION, style.GREEN, style.PURPLE)
    for colour, (world, one) in zip(looks, series.items(), strict=False):
        above.plot(one.t, 1e3 * errors[world], color=colour, linewidth=1.2, label=world)
        below.plot(one.t, one.tempo, color=colour, linewidth=1.2)
    above.set_ylabel("palms' middle off\nits place (mm)")
    below.set_ylabel("tempo")
    below.set_ylim(0.0, 1.05)
    below.set_xlim(*window)
    below.set_xlabel("time (s)")
    style.legend_above(figure, above, columns=2)
    figure.align_ylabels([above, below])
    return figure
