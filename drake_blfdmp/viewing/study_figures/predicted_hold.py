"""What palms and motors bear while a box is carried, as predicted and as simulated."""

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from drake_blfdmp.viewing import style

ROWS = {
    "force": "force (N)",
    "centre_x": "pressure's centre\nalong x (mm)",
    "centre_y": "along y (mm)",
    "effort": "most loaded motor\n(% of its limit)",
}
"""What is drawn of each palm or arm, and its axis."""


MARKERS = ("o", "x")
"""Of each prediction."""


@style.styled
def predicted_hold(
    t: np.ndarray,
    simulated: Mapping[str, np.ndarray],
    predicted: Mapping[str, tuple[np.ndarray, Mapping[str, np.ndarray]]],
) -> Figure:
    """A row for each of `ROWS`, both arms in it.

    Args:
        t: (N,) s.
        simulated: of each row (N, 2), left and right.
        predicted: what it is called by -> times (M,), s, and the same at those (M, 2); two at most.
    """
    figure = Figure(figsize=(style.COLUMN, 5.0))
    axes = figure.subplots(len(ROWS), 1, sharex=True)
    for axis, (name, label) in zip(axes, ROWS.items(), strict=True):
        for arm, look in enumerate((style.LEFT, style.RIGHT)):
            axis.plot(t, simulated[name][:, arm], **{**look, "label": f"{look['label']}, simulated"})
            for marker, (called, (at, rows)) in zip(MARKERS, predicted.items(), strict=False):
                axis.plot(
                    at, rows[name][:, arm], linestyle="none", marker=marker, markersize=3.0, markerfacecolor="white",
                    color=look["color"], label=f"predicted, {called}",
                )  # fmt: skip
        axis.set_ylabel(label)
    style.finish_time_axis(axes[-1], t)
    style.legend_above(figure, axes[0], 2)
    figure.align_ylabels(axes)
    return figure
