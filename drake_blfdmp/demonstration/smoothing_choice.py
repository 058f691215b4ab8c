"""Which smoothing a recording wants: method and bandwidth by an unbiased estimate of the error that is left.

Cross-validation takes what it cannot predict from the neighbours for noise, so an error that is slow passes for motion
and is kept: it fails for skeleton trackers. But the bones tell how large and how slow the error is (`uncertainty`),
and then Stein's estimate (Ann. Statist. 9, 1981; Mallows' C_p for correlated errors) gives the mean square error of
any linear filter without the truth. In the basis of the DCT-II, where a zero-phase filter is a gain H at each
frequency, with P the squared coefficient of what was measured and S the expected one of the error, it is

    risk = sum (1 - H)^2 (P - S) + H^2 S        motion that is lost, and error that is left

Compared are a Butterworth filter run both ways, a
cubic smoothing spline (which is also what a Kalman smoother of a randomly accelerated point gives; on a uniform clock a
gain of the DCT: Garcia, Comput. Stat. Data Anal. 54, 2010), and the Wiener filter of a smooth motion (Matern 5/2) in
this very error.
"""

from dataclasses import dataclass

import numpy as np
from scipy.fft import dct, idct

from drake_blfdmp.demonstration.smoothing import smooth
from drake_blfdmp.demonstration.uncertainty import SensorError
from drake_blfdmp.skeleton import ELBOWS, SHOULDERS, WRISTS

METHODS = ("butterworth", "spline", "wiener")
KINDS = {"shoulders": SHOULDERS, "elbows": ELBOWS, "wrists": WRISTS}

_CUTOFFS_HZ = np.geomspace(0.3, 15.0, 35)
_WIENER_CORNERS_HZ = np.geomspace(0.1, 2.0, 8)
_WIENER_SIZES = np.geomspace(0.003, 1.0, 12)  # m, standard deviation of the motion.
_MOST_OF_RATE = 0.45  # Half the rate is the most that a filter can have.
_WORTH = 0.98  # Of the error, root mean square: a smoothing that leaves more is not worth its while.


@dataclass(frozen=True)
class Smoothing:
    """How the points of one kind are smoothed.

    Attributes:
        method: one of METHODS, or "none".
        bandwidth_hz: where the gain falls to one half; infinite for "none".
        gain: (N,) of each DCT-II coefficient.
        error_m: estimated standard deviation of the error that is left, per axis.
    """

    method: str
    bandwidth_hz: float
    gain: np.ndarray
    error_m: float


def choose_smoothing(
    x: np.ndarray, rate_hz: float, error: SensorError, methods: tuple[str, ...] = METHODS
) -> dict[str, Smoothing]:
    """The best smoothing for shoulders, elbows and wrists each.

    Args:
        x: (N, 6, 3) m on a uniform clock, unsmoothed.
        rate_hz: of the clock.
        error: of x.
        methods: to choose from.

    Returns:
        Name of KINDS -> choice; "none" where nothing is gained.
    """
    f = np.arange(len(x)) * rate_hz / (2.0 * len(x))
    chosen = {}
    for index, (kind, points) in enumerate(KINDS.items()):
        measured, _ = _without_line(x[:, points].reshape(len(x), -1))
        power = np.mean(np.square(dct(measured, axis=0, norm="ortho")), axis=1)
        noise = error.spectrum[index]
        raw = float(np.mean(noise))
        best = Smoothing("none", np.inf, np.ones(len(x)), float(np.sqrt(raw)))
        least = _WORTH**2 * raw
        for method in methods:
            for gain in _gains(method, f, noise, rate_hz):
                lost, left = np.mean((1.0 - gain) ** 2 * (power - noise)), np.mean(gain**2 * noise)
                if lost + left < least:
                    least = float(lost + left)
                    # What is lost cannot be negative, but by chance its estimate can.
                    error_m = float(np.sqrt(left + max(lost, 0.0)))
                    best = Smoothing(method, _bandwidth(f, gain), gain, error_m)
        chosen[kind] = best
    return chosen


def apply_smoothing(t: np.ndarray, x: np.ndarray, chosen: dict[str, Smoothing]) -> np.ndarray:
    """Smooths (N, 6, 3) points at (N,) uniform times, s, as `choose_smoothing` chose."""
    out = x.copy()
    for kind, points in KINDS.items():
        if chosen[kind].method != "none":
            filtered = _butterworth if chosen[kind].method == "butterworth" else _by_gain
            out[:, points] = filtered(t, x[:, points], chosen[kind])
    return out


def describe_smoothing(chosen: dict[str, Smoothing], error: SensorError) -> str:
    """A sentence on what was chosen, and what it is estimated to gain."""
    parts = []
    for index, (kind, choice) in enumerate(chosen.items()):
        before = 1e3 * float(np.sqrt(np.mean(error.spectrum[index])))
        if choice.method == "none":
            parts.append(f"{kind} none (error {before:.1f} mm)")
        else:
            after = f"({before:.1f} to {1e3 * choice.error_m:.1f} mm)"
            parts.append(f"{kind} {choice.method} {choice.bandwidth_hz:.2g} Hz {after}")
    return f"smoothing by the least estimated error an axis: {', '.join(parts)}"


def _gains(method: str, f: np.ndarray, noise: np.ndarray, rate_hz: float) -> list[np.ndarray]:
    """Gains (N,) at frequencies f (N,), Hz, of a method's whole range of bandwidths."""
    if method == "wiener":
        return [
            signal / (signal + np.maximum(noise, 1e-30))
            for corner in _WIENER_CORNERS_HZ
            for signal in _motion_spectra(f, corner)
        ]
    order = {"butterworth": 8, "spline": 4}[method]
    return [1.0 / (1.0 + (f / cutoff) ** order) for cutoff in _CUTOFFS_HZ if cutoff < _MOST_OF_RATE * rate_hz]


def _motion_spectra(f: np.ndarray, corner_hz: float) -> list[np.ndarray]:
    shape = (1.0 + (f / corner_hz) ** 2) ** -3
    return [size**2 * shape / np.mean(shape) for size in _WIENER_SIZES]


def _bandwidth(f: np.ndarray, gain: np.ndarray) -> float:
    below = np.flatnonzero(gain < 0.5)
    return float(f[below[0]]) if len(below) else float("inf")


def _without_line(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(N, K) columns less the line through their ends, and that line; a basis of cosines then holds the rest well."""
    share = np.linspace(0.0, 1.0, len(values))[:, None]
    few = max(1, len(values) // 50)
    line = values[:few].mean(axis=0) + share * (values[-few:].mean(axis=0) - values[:few].mean(axis=0))
    return values - line, line


def _butterworth(t: np.ndarray, x: np.ndarray, choice: Smoothing) -> np.ndarray:
    return smooth(t, x, choice.bandwidth_hz)


def _by_gain(t: np.ndarray, x: np.ndarray, choice: Smoothing) -> np.ndarray:
    rest, line = _without_line(x.reshape(len(x), -1))
    kept = idct(choice.gain[:, None] * dct(rest, axis=0, norm="ortho"), axis=0, norm="ortho")
    return (line + np.asarray(kept)).reshape(x.shape)
