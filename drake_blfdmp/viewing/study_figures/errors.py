"""Errors per axis of the original and the modified movement primitives over time (Fig. 7)."""

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure

from drake_blfdmp.viewing import style
from drake_blfdmp.viewing.study_figures.looks import MODIFIED, ORIGINAL


@style.styled
def axis_errors(
    t: np.ndarray,
    original: Mapping[str, np.ndarray],
    modified: Mapping[str, np.ndarray],
    half_width: float,
    events: Sequence[tuple[str, float]],
) -> Figure:
    """Errors per axis of some points over time (Fig. 7).

    Args:
        t: (N,) s.
        original, modified: point -> errors (N, 3), m; a row of panels each.
        half_width: m, of the band that is shaded.
        events: (name, s).
    """
    span = (float(t[0]), float(t[-1]))
    room = style.event_label_height(events, span) / 72.0
    figure = Figure(figsize=(style.PAGE, 1.25 * len(original) + 0.75 + room))
    axes = figure.subplots(len(original), 3, sharex=True, sharey=True, squeeze=False)
    for row, name in enumerate(original):
        for column, direction in enumerate(("x, to the right", "y, forward", "z, up")):
            axis = axes[row, column]
            axis.axhspan(-half_width, half_width, **style.BAND | {"label": f"±{half_width:g} m"})
            axis.plot(t, original[name][:, column], **ORIGINAL)
            axis.plot(t, modified[name][:, column], **MODIFIED)
            if row == 0:
                axis.set_title(direction, pad=4 + 72.0 * room)
        axes[row, 0].set_ylabel(f"error of the\n{name} (m)")
    for column in range(3):
        style.mark_events(axes[:, column], events, span)
        style.finish_time_axis(axes[-1, column], t)
    axes[0, 0].set_ylim(style.finite_range(*original.values(), *modified.values()))
    style.legend_above(figure, axes[0, 0], columns=3)
    return figure
