"""Measuring errors of the points and spreads of the bones' lengths (Fig. 2)."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from drake_blfdmp.viewing import style

KIND_LOOKS: dict[str, dict[str, Any]] = {
    "shoulders": {"color": style.GREEN, "linestyle": (0, (1, 1)), "marker": "s"},
    "elbows": {"color": style.PURPLE, "linestyle": (0, (4, 1.2)), "marker": "D"},
    "hands": {"color": style.BLUE, "linestyle": "-", "marker": "o"},
}
"""Kinds of point, as in `evaluation.studies.noise_metrics.KINDS`."""


@style.styled
def position_errors(
    t: np.ndarray,
    errors: Mapping[str, Mapping[str, np.ndarray]],
    held: tuple[float, float],
    all_errors: Mapping[str, np.ndarray],
) -> Figure:
    """Position errors over one take, an arm a panel, and their distribution over all takes (Fig. 2).

    Args:
        t: (N,) s.
        errors: arm -> kind -> (N,) m.
        held: when the box hides the hands, s.
        all_errors: kind -> (M,) m.
    """
    figure = Figure(figsize=(style.PAGE, 2.9))
    grid = figure.add_gridspec(2, 2, width_ratios=(1.7, 1.0))
    left = figure.add_subplot(grid[0, 0])
    panels = [left, figure.add_subplot(grid[1, 0], sharex=left, sharey=left)]
    for axis, (arm, series) in zip(panels, errors.items(), strict=True):
        axis.axvspan(*held, color=style.LIGHT, alpha=0.3, linewidth=0, label="box held")
        for kind, values in series.items():
            axis.plot(t, 1e3 * values, linewidth=1.1, label=kind, **KIND_LOOKS[kind] | {"marker": "none"})
        axis.set_ylabel(f"{arm}\nerror (mm)")
    style.finish_time_axis(panels[1], t)
    left.tick_params(labelbottom=False)
    left.set_ylim(bottom=0.0)
    right = figure.add_subplot(grid[:, 1])
    for kind, values in all_errors.items():
        ordered = 1e3 * np.sort(values)
        share = np.arange(1, len(ordered) + 1) / len(ordered)
        right.plot(ordered, share, linewidth=1.3, **KIND_LOOKS[kind] | {"marker": "none"})
    right.set(xlabel="error (mm)", ylabel="share of samples below", ylim=(0.0, 1.0))
    right.set_xlim(0.0, 1e3 * max(float(np.percentile(values, 99.5)) for values in all_errors.values()))
    style.legend_above(figure, left, columns=4)
    return figure


@style.styled
def length_spreads(names: Sequence[str], spreads: Mapping[str, np.ndarray], jitter: np.ndarray) -> Figure:
    """Spread of lengths and jitter, a row a recording; thick lines: one standard deviation, thin ones: the whole range.

    Args:
        names: K recordings, the first on top.
        spreads: length -> (K, 4) mean, standard deviation, least, greatest, m; NaN where unknown.
        jitter: (K, 3) of shoulders, elbows and hands, m; NaN where unknown.
    """
    figure = Figure(figsize=(style.PAGE, 0.3 * len(names) + 1.0))
    axes = figure.subplots(1, len(spreads) + 1, sharey=True)
    rows = np.arange(len(names))
    for axis, (title, values) in zip(axes, spreads.items(), strict=False):
        mean, std, least, greatest = values.T
        axis.hlines(rows, least, greatest, color=style.BLUE, linewidth=0.8)
        axis.hlines(rows, mean - std, mean + std, color=style.BLUE, linewidth=3.2)
        axis.plot(mean, rows, linestyle="none", marker="|", color=style.DARK, markersize=6, markeredgewidth=0.8)
        axis.set(title=title, xlabel="length (m)")
    for column, (kind, look) in enumerate(KIND_LOOKS.items()):
        axes[-1].plot(
            1e3 * jitter[:, column], rows, label=kind, markersize=3.4, **look | {"linestyle": "none"}, clip_on=False
        )
    axes[-1].set(title="jitter", xlabel="per axis (mm)", xscale="log", xlim=(0.02, 20.0))
    axes[-1].xaxis.set_major_formatter("{x:g}")
    axes[0].set(yticks=rows, yticklabels=names, ylim=(len(names) - 0.5, -0.5))
    handles, labels = axes[-1].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper right", ncols=3, columnspacing=0.8, handletextpad=0.1)
    return figure
