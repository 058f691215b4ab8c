"""Where in the plane of gains and rate the sampled law leaves its bands, and what is enforced."""

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

from drake_blfdmp.viewing import style

BOUNDS = (
    style.COUPLED | {"label": "enforced: above this line"},
    style.PLANNED | {"label": "linear (Jury) bound"},
)
"""Looks of the two curves of `regions`."""


@style.styled
def regions(
    shares: Mapping[str, np.ndarray],
    totals: Sequence[float],
    rates: Sequence[float],
    fine: np.ndarray,
    slowest: Mapping[str, np.ndarray],
) -> Figure:
    """Share of problems that leave a band over gains and rate, with what is enforced and the linear bound.

    Args:
        shares: family of gains to (R, T) percent; NaN where unknown.
        totals: (T,) k_1 + k_2, 1/s; rates: (R,) Hz; both rising.
        fine: (K,) k_1 + k_2, 1/s, at which the bounds are drawn.
        slowest: family to (2, K) the lowest rate that is enforced, and that of the linear bound, Hz.
    """
    figure = Figure(figsize=(style.PAGE, 3.3))
    axes = figure.subplots(1, len(shares), sharey=True)
    columns, rows = np.arange(len(totals)), np.arange(len(rates))
    at = np.interp(np.log(fine), np.log(totals), columns)
    shades = None
    for axis, (family, share) in zip(axes, shares.items(), strict=True):
        shades = axis.pcolormesh(columns, rows, share, cmap="Oranges", vmin=0.0, vmax=100.0, rasterized=True)
        for row, column in np.ndindex(share.shape):
            value = share[row, column]
            if value > 0.0:
                text = f"{value:.0f}" if value >= 1.0 else f"{value:.1f}"
                colour = "white" if value > 60.0 else style.DARK
                axis.text(column, row, text, ha="center", va="center", fontsize=5.5, color=colour)
        for look, rate in zip(BOUNDS, slowest[family], strict=True):
            axis.plot(at, np.interp(np.log(rate), np.log(rates), rows, left=np.nan, right=np.nan), **look)
        axis.set(title=family.replace("k_1", "$k_1$").replace("k_2", "$k_2$"), xlabel="$k_1 + k_2$ (1/s)")
        axis.set(xlim=(-0.5, len(totals) - 0.5), ylim=(-0.5, len(rates) - 0.5))
        axis.grid(visible=False)
        axis.xaxis.set(major_locator=FixedLocator(columns.tolist()), minor_locator=NullLocator())
        axis.yaxis.set(major_locator=FixedLocator(rows.tolist()), minor_locator=NullLocator())
        axis.xaxis.set_major_formatter(FuncFormatter(lambda _, i: f"{totals[i]:.3g}" if i is not None else ""))
        axis.yaxis.set_major_formatter(FuncFormatter(lambda _, i: f"{rates[i]:g}" if i is not None else ""))
    axes[0].set_ylabel("rate (Hz)")
    if shades is not None:
        figure.colorbar(shades, ax=axes, label="problems that leave a band (%)", pad=0.01, aspect=28)
    style.legend_above(figure, axes[0], 2)
    return figure
