"""Several recordings of one task on one clock: time maps, weighted mean, spread.

Two people, or one person twice, do a task at speeds that differ and vary. Averaged by the clock, one still lifts while
the other carries. So each recording i gets a time map h_i from a common clock u to its own, as in curve registration,

    h_i(u) = b_i + integral of exp(w_i) from the grasp to u,   w_i a cubic spline,

which is smooth and runs forward whatever w_i is. Aligned velocities are the recorded ones times exp(w_i), without the
steps of dynamic time warping. The maps begin at the landmarks grasp and release and are refined by the motion: seen
through its map, the middle between a recording's hands and their distance shall be the mean's, up to an offset and a
positive factor on each axis, since another person's table is higher and another person's lift longer. A sensor's
error is slow, so samples count as independent only once in its correlation time; between them, even speeds and the
landmarks, which are themselves found with an error, each map is the most probable one. Approach and retreat have no
landmark at their far ends, which follow from the motion. Last, the common clock is made the mean of all clocks: the
weighted mean of h_i(u) is u.

Source: Ramsay and Li, "Curve registration", J. R. Statist. Soc. B 60, 1998.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.integrate import cumulative_trapezoid
from scipy.interpolate import BSpline, make_interp_spline
from scipy.optimize import least_squares

from drake_blfdmp.demonstration.bones import link_lengths
from drake_blfdmp.demonstration.demonstration import Demonstration
from drake_blfdmp.demonstration.holding import Holding
from drake_blfdmp.demonstration.smoothing import smooth
from drake_blfdmp.skeleton import HANDS, WRISTS

_GRID_HZ = 30.0
_KNOT_S = 0.5  # Between the knots of w: a person's speed changes no faster.
_MOST_KNOTS = 60  # Longer recordings get coarser maps.
_SPEED, _SPEED_CHANGE = 0.5, 0.2  # Standard deviations of w, and of its change from knot to knot.
_LANDMARK_S = 0.2  # Standard deviation of a landmark; 0.17 s for the virtual Kinect.
_CORRELATION_S = 0.8  # Integral time scale of a sensor's slow error.
_LEAST_ERROR = 5e-4  # m; no two motions are more alike.
_ROUNDS = 6  # Of maps and mean in turn.
_MARGIN_S = 1.0  # Kept outside approach and retreat for the smoothing that comes later.


@dataclass(frozen=True)
class Alignment:
    """Where n recordings stand at every time of one clock.

    Attributes:
        t: (N,) the common clock, uniform from 0, s.
        recorded: (n, N) the time in each recording, s: smooth, increasing; the weighted mean is t and a constant.
        start_s, end_s: grasp and release on the common clock, the weighted means of the recordings' own, s.
        agreement: (n,) how much of the others' mean motion of the hands each recording has too, from 0 to 1.
    """

    t: np.ndarray
    recorded: np.ndarray
    start_s: float
    end_s: float
    agreement: np.ndarray

    def shown(self, demonstrations: Sequence[Demonstration], cutoff_hz: float | None = None) -> np.ndarray:
        """The recordings' points at the common times (n, N, 6, 3), m; a cut-off smooths them on their own clocks."""
        out = []
        for one, times in zip(demonstrations, self.recorded, strict=True):
            x = one.x if cutoff_hz is None else smooth(one.t, one.x, cutoff_hz)
            out.append(make_interp_spline(one.t, x, k=3)(np.clip(times, one.t[0], one.t[-1])))
        return np.array(out)


def weighted_mean(x: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """The mean (...) of n motions (n, ...) with weights (n,) of any positive sum."""
    return np.average(x, axis=0, weights=weights)


def weighted_spread(x: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Standard deviation (...) over n >= 2 motions (n, ...), in their unit; for equal weights the one with n - 1.

    With weights of sum 1, sum_i w_i (x_i - mean)^2 has the expectation (1 - sum_i w_i^2) sigma^2 for independent x_i.
    """
    weights = np.asarray(weights, dtype=float) / np.sum(weights)
    squares = np.average((x - weighted_mean(x, weights)) ** 2, axis=0, weights=weights)
    return np.sqrt(squares / (1.0 - np.sum(weights**2)))


def align(
    demonstrations: Sequence[Demonstration],
    holdings: Sequence[Holding],
    weights: np.ndarray,
    *,
    lead_s: float,
    trail_s: float,
    cutoff_hz: float = 1.2,
) -> Alignment:
    """Align n >= 2 recordings.

    Args:
        demonstrations: cleaned, not smoothed, all in torso frames or all in one world frame.
        holdings: each one's held interval.
        weights: (n,) positive; their sum does not matter.
        lead_s, trail_s: how much before the grasp and after the release is needed, s; where a recording has less, all
            have less.
        cutoff_hz: of the smoothing of what is compared.

    Raises:
        RecordingError: a recording is too slow or too short for the smoothing.
    """
    weights = np.asarray(weights, dtype=float) / np.sum(weights)
    lengths = np.array([holding.end_s - holding.start_s for holding in holdings])
    held = float(weights @ lengths)
    # Who holds the box longer is taken to be slower before and after it, too, until the motion tells.
    slower = lengths / held
    before = np.array([holding.start_s for holding in holdings]) / slower
    after = np.array([one.duration_s - h.end_s for one, h in zip(demonstrations, holdings, strict=True)]) / slower
    first, last = -min(lead_s + _MARGIN_S, before.min()), held + min(trail_s + _MARGIN_S, after.min())
    u = np.linspace(first, last, max(16, round((last - first) * _GRID_HZ) + 1))
    counted = (u >= -lead_s - 1e-9) & (u <= held + trail_s + 1e-9)
    fits = [
        _TimeMap(u, counted, _features(one, cutoff_hz), holding, held)
        for one, holding in zip(demonstrations, holdings, strict=True)
    ]
    for _ in range(_ROUNDS):
        mean = weighted_mean(np.array([fit.shown() for fit in fits]), weights)
        misfits = np.array([_misfit(mean, fit.shown()) for fit in fits])
        error = np.maximum(np.sqrt(np.mean(misfits**2, axis=(0, 1))), _LEAST_ERROR)
        for fit in fits:
            fit.refine(mean, error)
    agreement = _agreement(np.array([fit.shown()[:, :3] for fit in fits]), weights)
    return _on_the_mean_clock(demonstrations, holdings, weights, u, np.array([fit.times() for fit in fits]), agreement)


class _TimeMap:
    """One recording's map h: its parameters (b, the spline coefficients of w) and how they are found."""

    def __init__(self, u: np.ndarray, counted: np.ndarray, features: Callable, holding: Holding, held: float):
        """The even map through the landmarks.

        Args:
            u: (N,) the common clock, 0 at the grasp and `held` at the release, s.
            counted: (N,) which samples of it are compared.
            features: (...) recorded times to (..., 4), m.
        """
        self._u, self._counted, self._features, self._held = u, counted, features, held
        self._landmarks = np.array([holding.start_s, holding.end_s])
        knots = np.linspace(u[0], u[-1], int(np.clip(round(np.ptp(u) / _KNOT_S), 4, _MOST_KNOTS)))
        knots = np.concatenate([np.full(3, knots[0]), knots, np.full(3, knots[-1])])
        self._basis = BSpline.design_matrix(u, knots, 3).toarray()
        self._even = float(np.log((holding.end_s - holding.start_s) / held))
        self._parameters = np.append(holding.start_s, np.full(self._basis.shape[1], self._even))

    def times(self, parameters: np.ndarray | None = None) -> np.ndarray:
        """H(u) (N,), s."""
        parameters = self._parameters if parameters is None else parameters
        run = cumulative_trapezoid(np.exp(self._basis @ parameters[1:]), self._u, initial=0.0)
        return parameters[0] + run - np.interp(0.0, self._u, run)

    def shown(self) -> np.ndarray:
        """The features at the compared times: (M, 4), m."""
        return self._features(self.times()[self._counted])

    def refine(self, mean: np.ndarray, error: np.ndarray) -> None:
        """The most probable map, given the mean's features (M, 4) and the standard deviations (4,) around them, m."""
        share = np.sqrt(np.minimum(1.0, (self._u[1] - self._u[0]) / _CORRELATION_S))

        def deviations(parameters):
            times = self.times(parameters)
            w = parameters[1:] - self._even
            return np.concatenate(
                [
                    np.ravel(share * _misfit(mean, self._features(times[self._counted])) / error),
                    (np.interp([0.0, self._held], self._u, times) - self._landmarks) / _LANDMARK_S,
                    w / _SPEED,
                    np.diff(w) / _SPEED_CHANGE,
                ]
            )

        self._parameters = least_squares(deviations, self._parameters, x_scale="jac", max_nfev=30).x


def _features(demonstration: Demonstration, cutoff_hz: float) -> Callable[[np.ndarray], np.ndarray]:
    """Middle between the hands and their distance, smooth: from recorded times (...) to (..., 4), m."""
    x = smooth(demonstration.t, demonstration.x, cutoff_hz)
    values = np.column_stack([x[:, WRISTS].mean(axis=1), link_lengths(x)[:, HANDS]])
    spline = make_interp_spline(demonstration.t, values, k=3)
    return lambda times: spline(np.clip(times, demonstration.t[0], demonstration.t[-1]))


def _misfit(mean: np.ndarray, values: np.ndarray) -> np.ndarray:
    """What is left of the mean's features (M, K), m, when the values (M, K), moved and stretched, are taken away."""
    mean, values = mean - mean.mean(axis=0), values - values.mean(axis=0)
    factor = np.sum(mean * values, axis=0) / np.maximum(np.sum(values**2, axis=0), 1e-12)
    return mean - np.maximum(factor, 0.0) * values


def _agreement(middles: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Share (n,) of the others' mean motion (n, M, 3) that each has too, whatever its place and its size."""
    out = []
    for i, own in enumerate(middles):
        others = weighted_mean(np.delete(middles, i, axis=0), np.delete(weights, i))
        moved = float(np.sum((others - others.mean(axis=0)) ** 2))
        out.append(1.0 - float(np.sum(_misfit(others, own) ** 2)) / max(moved, 1e-12))
    return np.array(out)


def _on_the_mean_clock(
    demonstrations: Sequence[Demonstration],
    holdings: Sequence[Holding],
    weights: np.ndarray,
    u: np.ndarray,
    maps: np.ndarray,
    agreement: np.ndarray,
) -> Alignment:
    """The alignment with the weighted mean of the maps (n, N) as its clock, where every recording has samples."""
    ends = np.array([one.duration_s for one in demonstrations])[:, None]
    inside = np.flatnonzero(np.all((maps >= -1e-9) & (maps <= ends + 1e-9), axis=0))
    clock = weights @ maps
    rate = max(one.rate_hz for one in demonstrations)
    first, last = clock[inside[0]], clock[inside[-1]]
    t = np.arange(int((last - first) * rate + 1e-6) + 1) / rate
    recorded = make_interp_spline(clock, maps, k=3, axis=1)(first + t)
    marks = [
        np.array([np.interp(mark, times, t) for mark, times in zip(which, recorded, strict=True)])
        for which in ([h.start_s for h in holdings], [h.end_s for h in holdings])
    ]
    return Alignment(t, recorded, float(weights @ marks[0]), float(weights @ marks[1]), agreement)
