"""What the paper does not say of its law: trials on one axis, the links' turns, and the lagged reading's growth."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from drake_blfdmp.skeleton import LINKS
from drake_blfdmp.viewing import style
from drake_blfdmp.viewing.law_style import LAW_LOOKS

DOTTED, DASHED = (0, (1, 1)), (0, (4, 1.2))

_SHORT = {"upper_arm": "upper", "forearm": "fore"}


@dataclass(frozen=True)
class Trial:
    """A trial on one axis: (N,) times, s, coordinate and signed distance from the middle of the band, m."""

    t: np.ndarray
    x: np.ndarray
    error: np.ndarray
    half_width: float


@style.styled
def facts(
    share: np.ndarray,
    rates: Mapping[str, np.ndarray],
    moving: Mapping[str, Trial],
    goals: Mapping[str, Trial],
    own_goal: float,
    lagged: Trial,
    signs: Mapping[str, Trial],
    angles: Mapping[str, np.ndarray],
) -> Figure:
    """One panel a fact, and the sign of z_1.

    Args:
        share: (M,) z_2 by its largest.
        rates: label -> V' there (M,), 1/s.
        moving, goals, signs: label -> trial; the first of two is drawn dashed, except in `goals` and `signs`.
        own_goal: m.
        lagged: the lagged reading's trial.
        angles: "demonstrated", "default", "published" -> largest turn of each link (5,), rad.
    """
    figure = Figure(figsize=(style.PAGE, 4.4))
    axes = figure.subplots(2, 3)
    one, two, three, four, five, six = axes.flat
    for (label, values), colour, line in zip(rates.items(), (style.VERMILLION, style.BLUE), (DASHED, "-"), strict=True):
        one.plot(share, 1e4 * values, color=colour, linestyle=line, label=label)
    one.set(title="1: $\\dot V$ on $z_1 - mid = z_2/2$", xlabel="$z_2$ (share of its largest)")
    one.set(ylabel="$\\dot V$ ($10^{-4}$/s)")
    one.legend()
    _errors(two, moving, ((style.VERMILLION, DASHED), (style.BLUE, "-")), 0.2)
    two.set_title("2: moving band, 0.1 sin 3t m")
    for (label, run), colour, line in zip(
        goals.items(), (style.BLUE, style.VERMILLION, style.GREEN), ("-", DASHED, DOTTED), strict=True
    ):
        three.plot(run.t, run.x, color=colour, linestyle=line, label=label)
    three.axhline(own_goal, **style.LIMIT)
    three.annotate("own goal", (0.05, own_goal - 0.003), va="top", fontsize=6.5, color=style.VERMILLION)
    three.set(title="3a: the goal has cancelled", xlabel="time (s)", ylabel="own coordinate (m)")
    three.set(xlim=(0.0, 3.0), ylim=(-0.31, -0.12))
    three.legend(loc="center right")
    _errors(four, {}, (), _end(lagged))
    four.plot(lagged.t, 1e3 * lagged.error, **LAW_LOOKS["published_lagged"] | {"marker": ".", "markersize": 3})
    four.set_title("3b: lagged, constant band")
    four.locator_params(axis="x", nbins=4)
    _errors(five, signs, ((style.BLUE, "-"), (style.VERMILLION, DASHED)), 0.2)
    five.set_title("sign of $z_1$")
    _turns(six, angles)
    six.set_title("4: largest turn of the links")
    return figure


def _end(trial: Trial) -> float:
    """A sample and a half after the band is first left, s."""
    outside = np.abs(trial.error) >= trial.half_width
    k = int(np.argmax(outside)) if np.any(outside) else len(trial.t) - 1
    return float(trial.t[k] + 1.5 * (trial.t[1] - trial.t[0]))


def _errors(axis: Axes, runs: Mapping[str, Trial], looks: tuple, end: float) -> None:
    """Errors of some trials in their band of 10 mm."""
    axis.axhspan(-10, 10, **style.BAND | {"label": None})
    for (label, run), (colour, line) in zip(runs.items(), looks, strict=True):
        axis.plot(run.t, 1e3 * run.error, color=colour, linestyle=line, label=label)
    axis.set(xlabel="time (s)", ylabel="off the middle (mm)", ylim=(-25, 25), xlim=(0.0, end))
    if runs:
        axis.legend(loc="lower right")


def _turns(axis: Axes, angles: Mapping[str, np.ndarray]) -> None:
    place = np.arange(len(LINKS))
    looks = ((style.LIGHT, ""), (style.BLUE, "///"), (LAW_LOOKS["published"]["color"], ""))
    for i, ((name, values), (colour, hatch)) in enumerate(zip(angles.items(), looks, strict=True)):
        look = {"color": colour, "hatch": hatch, "edgecolor": "white", "linewidth": 0}
        axis.bar(place + 0.27 * (i - 1), np.degrees(values), 0.25, label=name, **look)
    axis.set(ylabel="angle (°)", ylim=(0, 165))
    axis.grid(visible=False, axis="x")
    names = [link.name.split("_", 1) for link in LINKS]
    axis.set_xticks(place, ["\n".join((side, *(_SHORT[bone] for bone in rest))) for side, *rest in names], fontsize=6)
    axis.legend(loc="upper right")


@style.styled
def growth(change: Mapping[float, np.ndarray], predicted: Mapping[float, float]) -> Figure:
    """How the lagged law's sample-to-sample difference grows.

    Args:
        change: step, s -> |a_k - a_(k-1)| (N,), m/s^2.
        predicted: step, s -> growth a sample.
    """
    figure = Figure(figsize=(style.COLUMN, 2.3))
    axis = figure.subplots()
    for (h, values), colour, marker in zip(change.items(), (style.BLUE, style.VERMILLION), "os", strict=True):
        k = np.arange(len(values))
        look = {"color": colour, "marker": marker, "markersize": 3, "linestyle": "none", "markevery": 3}
        axis.semilogy(k, values / values[0], **look, label=f"{1e3 * h:g} ms, measured")
        axis.semilogy(k, predicted[h] ** k, color=colour, linestyle=DASHED, label=f"|z| = {predicted[h]:.4f}")
    axis.set(xlabel="sample", ylabel="$|a_k - a_{k-1}|$ by the first shown")
    style.legend_above(figure, axis, columns=2)
    return figure
