"""Times without a point: which are short enough to be filled, and the uniform clock that fills them."""

import numpy as np
from scipy.interpolate import PchipInterpolator

from drake_blfdmp.errors import RecordingError
from drake_blfdmp.skeleton import POINTS

_LEAST_RATE_HZ = 30.0  # Slower recordings get a whole multiple of their rate.
_MOST_SAMPLES = 100  # Of the clock for each of the recording, and as many at least.


def whole_ends(where: str, good: np.ndarray) -> tuple[int, int]:
    """First and last sample with all six points; outside them there is nothing to interpolate to.

    Args:
        where: the recording, for messages.
        good: (N, 6) bool, which points are seen.

    Raises:
        RecordingError: no sample has all points.
    """
    whole = np.flatnonzero(good.all(axis=1))
    if len(whole) == 0:
        worst = POINTS[int(np.argmin(good.mean(axis=0)))]
        raise RecordingError(f"{where}: no frame has all six points, {worst} is seen least; map it with --joints")
    return int(whole[0]), int(whole[-1])


def require_short_gaps(where: str, t: np.ndarray, frames: np.ndarray, good: np.ndarray, max_gap_s: float) -> None:
    """Refuses what would have to be invented.

    Args:
        where: the recording, for messages.
        t: (N,) increasing, s.
        frames: (N,) frame numbers.
        good: (N, 6) bool, which points are seen; all at the first and the last sample.
        max_gap_s: the longest time without a point, s.

    Raises:
        RecordingError: a gap is longer; names point and frames.
    """
    for index, point in enumerate(POINTS):
        seen = np.flatnonzero(good[:, index])
        gaps = np.diff(t[seen])
        worst = int(np.argmax(gaps))
        if gaps[worst] > max_gap_s:
            before, after = frames[seen[worst]], frames[seen[worst + 1]]
            raise RecordingError(
                f"{where}: {point} is missing between frames {before} and {after} ({gaps[worst]:.2f} s, at most "
                f"{max_gap_s:g} s are filled); cut the recording with --frames"
            )


def uniform_clock(where: str, t: np.ndarray, rate_hz: float | None) -> tuple[np.ndarray, float]:
    """A uniform clock over a recording.

    Args:
        where: the recording, for messages.
        t: (N,) increasing, s.
        rate_hz: samples a second; None takes the median rate, times a whole number where it is below 30 Hz.

    Returns:
        (M,) s, from t[0]; and the clock's rate, Hz.

    Raises:
        RecordingError: the time stamps are so uneven that nothing but interpolation would be left.
    """
    rate = 1.0 / float(np.median(np.diff(t)))
    target = rate_hz or rate * max(1.0, np.ceil(_LEAST_RATE_HZ / rate - 0.1))
    span = t[-1] - t[0]
    if not span * target <= _MOST_SAMPLES * (len(t) + _MOST_SAMPLES):
        raise RecordingError(
            f"{where}: a clock of {target:.3g} Hz over {span:.3g} s is no clock for {len(t)} frames; "
            "check the time stamps"
        )
    whole = np.round(span * target) / span  # Rounded time stamps (0.008333) drift against their own median step.
    if rate_hz is None and abs(whole / target - 1.0) < 0.005:
        target = whole
    clock = t[0] + np.arange(int(np.floor(span * target + 1e-3)) + 1) / target
    clock[-1] = min(clock[-1], t[-1])
    return clock, float(target)


def fill_and_resample(
    t: np.ndarray, x: np.ndarray, good: np.ndarray, clock: np.ndarray, rate_hz: float, interpolation: str
) -> tuple[np.ndarray, int]:
    """Fills the gaps and moves to another clock; samples that are seen at an instant of it stay exactly as they are.

    Args:
        t: (N,) increasing, s.
        x: (N, 6, 3) m.
        good: (N, 6) bool, which points are seen; two or more of each.
        clock: (M,) s, within t.
        rate_hz: of the clock.
        interpolation: "pchip" or "linear".

    Returns:
        (M, 6, 3) m, and at how many instants nothing was recorded.
    """
    nearest = np.clip(np.searchsorted(t, clock), 1, len(t) - 1)
    nearest -= clock - t[nearest - 1] < t[nearest] - clock
    on_sample = np.abs(clock - t[nearest]) < 0.01 / rate_hz
    out = np.empty((len(clock), len(POINTS), 3))
    for index in range(len(POINTS)):
        seen = good[:, index]
        if interpolation == "linear":
            out[:, index] = np.stack([np.interp(clock, t[seen], x[seen, index, axis]) for axis in range(3)], axis=-1)
        else:
            out[:, index] = PchipInterpolator(t[seen], x[seen, index])(clock)
        exact = on_sample & seen[nearest]
        out[exact, index] = x[nearest[exact], index]
    return out, int((~on_sample).sum())
