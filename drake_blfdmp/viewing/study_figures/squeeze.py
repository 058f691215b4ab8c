"""How pads deform, and the least squeeze that holds a box."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from drake_blfdmp.viewing import style

LOOKS: tuple[dict[str, Any], ...] = (
    {"color": style.BLUE, "marker": "o", "linestyle": "-"},
    {"color": style.VERMILLION, "marker": "s", "linestyle": (0, (4, 1.2))},
    {"color": style.GREEN, "marker": "D", "linestyle": (0, (1, 1))},
)
"""One after the other: of moduli, and of predictions."""


@style.styled
def deformation(
    force: np.ndarray,
    measured: Mapping[float, np.ndarray],
    fine: np.ndarray,
    estimate: Mapping[float, np.ndarray],
    chosen: float,
) -> Figure:
    """Deformation over force, markers, with its estimate, lines.

    Args:
        force: (N,) N.
        measured: modulus in Pa to (N,) m.
        fine: (K,) N.
        estimate: modulus in Pa to (K,) m.
        chosen: force that the main job presses with, N.
    """
    figure = Figure(figsize=(style.COLUMN, 2.5))
    axis = figure.subplots()
    for look, (modulus, depth) in zip(LOOKS, measured.items(), strict=False):
        axis.plot(fine, 1e3 * estimate[modulus], color=look["color"], linestyle=look["linestyle"], linewidth=1.0)
        axis.plot(force, 1e3 * depth, linestyle="none", marker=look["marker"], markersize=3.5, color=look["color"])
        # A line for the legend alone, with both looks.
        axis.plot([], [], linewidth=1.0, markersize=3.5, label=_modulus(modulus), **look)
    axis.axvline(chosen, **style.PLANNED)
    axis.annotate(
        f"default {chosen:g} N", (chosen, 0.03), xycoords=axis.get_xaxis_transform(), xytext=(-3, 0),
        textcoords="offset points", ha="right", va="bottom", fontsize=6.5, color=style.DARK,
    )  # fmt: skip
    axis.set(xlabel="squeeze (N)", ylabel="deformation of each pad (mm)", xscale="log", yscale="log")
    axis.set_xticks([10, 20, 50, 100], ["10", "20", "50", "100"])
    axis.set_xticks([], minor=True)
    axis.yaxis.set_major_formatter(lambda value, _: f"{value:g}")
    style.legend_above(figure, axis, len(measured))
    return figure


@style.styled
def least_forces(panels: Mapping[str, tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]], largest: float) -> Figure:
    """The least force over mass and friction, with measured over estimated below it.

    Args:
        panels: title to masses (M,), kg, coefficients (F,), and the least force, N, and the ratio, both (M, F).
        largest: force of a palm that the arms plan with at most, N; cells above it are framed.
    """
    figure = Figure(figsize=(style.PAGE, 2.9))
    axes = np.atleast_1d(figure.subplots(1, len(panels), sharey=True))
    top = max(float(np.nanmax(panel[2])) for panel in panels.values())
    shades = None
    for axis, (title, (masses, frictions, least, ratio)) in zip(axes, panels.items(), strict=True):
        shades = axis.imshow(least, cmap="Blues", vmin=0.0, vmax=top, aspect="auto", origin="lower")
        for row, column in np.ndindex(least.shape):
            _cell(axis, column, row, least[row, column], ratio[row, column], largest, top)
        axis.set_xticks(range(len(frictions)), [f"{value:g}" for value in frictions])
        axis.set_yticks(range(len(masses)), [f"{value:g}" for value in masses])
        axis.set(title=title, xlabel="friction of box and pad")
        axis.grid(visible=False)
        axis.tick_params(length=0)
    axes[0].set_ylabel("mass (kg)")
    if shades is not None:
        figure.colorbar(shades, ax=axes, label="least squeeze (N)", pad=0.01, aspect=26)
    return figure


@style.styled
def aside(
    offset: np.ndarray, least: np.ndarray, fine: np.ndarray, predicted: Mapping[str, np.ndarray], weight: float
) -> Figure:
    """How many times harder the palms must press when the box's centre lies aside of their axis.

    Args:
        offset: (N,) m. least: (N,) N.
        fine: (K,) m. predicted: name to factors (K,).
        weight: the least force without an offset that friction predicts, N.
    """
    figure = Figure(figsize=(style.COLUMN, 2.5))
    axis = figure.subplots()
    for look, (name, factor) in zip(LOOKS, predicted.items(), strict=False):
        axis.plot(1e3 * fine, factor, color=look["color"], linestyle=look["linestyle"], linewidth=1.2, label=name)
    axis.plot(1e3 * offset, least / weight, "o", markersize=4, color=style.DARK, zorder=4, label="simulated")
    axis.set(xlabel="centre of mass aside by (mm)", ylabel="least squeeze, times m g/(2 μ)")
    axis.set_ylim(bottom=0.95)
    axis.legend(loc="upper left")
    return figure


def _cell(axis: Axes, column: int, row: int, least: float, ratio: float, largest: float, top: float) -> None:
    """Numbers and, above `largest`, a frame."""
    if not np.isfinite(least):
        return
    colour = "white" if least > 0.6 * top else style.DARK
    axis.text(column, row + 0.14, f"{least:.3g}", ha="center", va="center", fontsize=7, color=colour)
    axis.text(column, row - 0.24, f"{ratio:.3f}", ha="center", va="center", fontsize=5, color=colour)
    if least > largest:
        frame = Rectangle((column - 0.46, row - 0.44), 0.92, 0.88, fill=False)
        frame.set(edgecolor=style.VERMILLION, linewidth=1.6, linestyle=(0, (3, 1)))
        axis.add_patch(frame)


def _modulus(value: float) -> str:
    return f"{1e-6 * value:g} MPa" if value >= 1e6 else f"{1e-3 * value:g} kPa"
