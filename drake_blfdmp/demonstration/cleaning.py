"""A recording in, a clean demonstration out; every repair is counted, what cannot be repaired is refused."""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import PchipInterpolator

from drake_blfdmp.demonstration.bones import FOREARMS, UPPER_ARMS, link_lengths
from drake_blfdmp.demonstration.demonstration import Demonstration, Recording
from drake_blfdmp.demonstration.formats import FORMATS
from drake_blfdmp.demonstration.jumps import find_jumps
from drake_blfdmp.demonstration.upright import AXES, rotation_to_z_up, sidedness, up_axis
from drake_blfdmp.errors import RecordingError
from drake_blfdmp.skeleton import POINTS

MIN_FRAMES = 10
MIN_DURATION_S = 1.0
MIN_RATE_HZ = 4.0
PLAUSIBLE_BONE = (0.1, 0.6)  # m, children to giants.
_LONGEST_REPEAT = 3  # Frames; a longer run of equal skeletons is a synthetic person at rest.
_SWAPPED = -0.08  # m of `sidedness`; real recordings measure -0.07 (half of it Kinect confusion) to 0.41.


@dataclass(frozen=True)
class CleaningOptions:
    """How to clean.

    Attributes:
        max_gap_s: the longest time without a point that is filled, s.
        up: the file's axis that points up, one of x, -x, y, -y, z, -z; None finds it.
        rate_hz: the demonstration's clock; None takes the median rate, times a whole number where it is below 30 Hz.
        speed_limit: m/s above which a point may have jumped.
        interpolation: "pchip" or "linear".
    """

    max_gap_s: float = 1.5
    up: str | None = None
    rate_hz: float | None = None
    speed_limit: float = 5.0
    interpolation: str = "pchip"


def clean(recording: Recording, options: CleaningOptions = CleaningOptions()) -> Demonstration:
    """Repairs a recording and puts it upright on a uniform clock.

    Returns:
        The demonstration, z up, not smoothed. `repairs` counts frames (repeated_frames, out_of_order_frames,
        trimmed_frames, resampled_frames) and points of frames (missing_samples_filled, jumps_removed).

    Raises:
        RecordingError: too short, too slow, gaps too long, not in metres, left and right swapped, or nothing moves.
    """
    where = recording.source
    _check_options(where, options)
    t, x, frames = np.asarray(recording.t, float), np.asarray(recording.x, float), np.asarray(recording.frames)
    _require_frames(where, len(t))
    _require_points(where, x)
    if np.ptp(t) <= 0.0:
        raise RecordingError(f"{where}: every sample has the time {t[0]:g} s; record with a running clock")

    x = np.where(np.any(x != 0.0, axis=-1, keepdims=True), x, np.nan)  # How a Kinect writes a joint it does not see.
    repairs: dict[str, int] = {}
    order, repairs["out_of_order_frames"] = _in_order(where, t, frames)
    t, x, frames = t[order], x[order], frames[order]
    keep = _without_repeats(t, x)
    repairs["repeated_frames"] = int(len(t) - keep.sum())
    t, x, frames = t[keep], x[keep], frames[keep]
    _require_frames(where, len(t))

    _require_metres(where, x)
    missing = np.asarray(np.isnan(x).any(axis=-1))
    jumps = find_jumps(t, x, options.speed_limit) & ~missing
    repairs["jumps_removed"] = int(jumps.sum())
    good = ~missing & ~jumps
    first, last = _whole_ends(where, good)
    repairs["trimmed_frames"] = int(len(t) - (last - first + 1))
    kept = slice(first, last + 1)
    t, x, frames, missing, good = t[kept], x[kept], frames[kept], missing[kept], good[kept]
    _require_frames(where, len(t))
    if t[-1] - t[0] < MIN_DURATION_S - 1e-9:
        raise RecordingError(
            f"{where}: lasts {t[-1] - t[0]:.2f} s, a skill needs at least {MIN_DURATION_S:g} s; record the whole motion"
        )
    rate = 1.0 / float(np.median(np.diff(t)))
    most = max(rate, (len(t) - 1) / float(t[-1] - t[0]))  # The mean: sensors that skip frames come in bursts.
    if most < MIN_RATE_HZ:
        raise RecordingError(
            f"{where}: {most:.2g} samples a second, at least {MIN_RATE_HZ:g} are needed; check the clock"
        )
    _require_short_gaps(where, t, frames, good, options.max_gap_s)
    repairs["missing_samples_filled"] = int(missing.sum())

    clock, x, repairs["resampled_frames"] = _resample(t, x, good, rate, options)
    if np.ptp(x, axis=0).max() < 0.01:
        raise RecordingError(f"{where}: nobody moves (all points within 1 cm); record a motion")
    x = x @ _rotation(where, recording, x, options).T
    side, share = sidedness(x)
    if side < _SWAPPED and share > 0.6:
        raise RecordingError(
            f"{where}: the hands are {-side:.2f} m behind the shoulders, left and right are swapped; "
            "swap them with --joints"
        )
    return Demonstration(
        t=clock - clock[0], x=x, source=where, synthetic=recording.synthetic, repairs=repairs, known=recording.known
    )


def _check_options(where: str, options: CleaningOptions) -> None:
    if options.up is not None and options.up not in AXES:
        raise RecordingError(f"{where}: up is '{options.up}'; give one of {', '.join(AXES)}")
    if options.interpolation not in ("pchip", "linear"):
        raise RecordingError(f"{where}: interpolation is '{options.interpolation}'; give pchip or linear")
    for name in ("max_gap_s", "speed_limit", "rate_hz"):
        value = getattr(options, name)
        if value is not None and not 0.0 < value < np.inf:
            raise RecordingError(f"{where}: {name} is {value}; give a positive number")


def _require_frames(where: str, count: int) -> None:
    if count < MIN_FRAMES:
        raise RecordingError(
            f"{where}: a {count}-frame recording, a skill needs at least {MIN_FRAMES} different frames; "
            "record the whole motion"
        )


def _require_points(where: str, x: np.ndarray) -> None:
    for index, point in enumerate(POINTS):
        if not np.isfinite(x[:, index]).all(axis=-1).any():
            raise RecordingError(f"{where}: {point} is missing in every frame; map it to another joint with --joints")


def _require_metres(where: str, x: np.ndarray) -> None:
    lengths = link_lengths(x)
    for name, pair in (("upper arm", UPPER_ARMS), ("forearm", FOREARMS)):
        both = lengths[:, pair]
        if not np.isfinite(both).any():
            raise RecordingError(f"{where}: no frame shows both ends of an {name}; map the joints with --joints")
        measured = float(np.nanmedian(both))
        if PLAUSIBLE_BONE[0] <= measured <= PLAUSIBLE_BONE[1]:
            continue
        scale = {"mm": 1e-3, "cm": 1e-2, "m": 1e3}  # Read in metres; or, for "m", metres read as millimetres.
        unit = next((u for u, s in scale.items() if PLAUSIBLE_BONE[0] <= measured * s <= PLAUSIBLE_BONE[1]), None)
        what = f"try --unit {unit}" if unit else "check --unit and --joints"
        raise RecordingError(
            f"{where}: the {name} measures {measured:.3g} m, "
            f"expected {PLAUSIBLE_BONE[0]:g} to {PLAUSIBLE_BONE[1]:g} m; {what}"
        )


def _in_order(where: str, t: np.ndarray, frames: np.ndarray) -> tuple[np.ndarray, int]:
    """The order that makes t run forward, and how many frames came late."""
    late = np.less(t, np.maximum.accumulate(t))
    if late.mean() > 0.2:
        raise RecordingError(
            f"{where}: time runs backwards at frame {frames[int(np.argmax(late))]} and does not recover; "
            "cut one take with --frames"
        )
    return np.argsort(t, kind="stable"), int(late.sum())


def _without_repeats(t: np.ndarray, x: np.ndarray) -> np.ndarray:
    """(N,) bool: of samples with one time the one nearest to the last kept, of a short run of equal ones the first."""
    keep = np.zeros(len(t), dtype=bool)
    flat = x.reshape(len(x), -1)
    previous = None
    for group in np.split(np.arange(len(t)), np.flatnonzero(np.diff(t) > 0.0) + 1):
        best = group[0]
        if len(group) > 1:
            missing = np.isnan(flat[group]).sum(axis=1)
            distance = np.zeros(len(group))
            if previous is not None:
                distance = np.nan_to_num(np.abs(flat[group] - flat[previous])).sum(axis=1)
            best = group[np.lexsort((distance, missing))[0]]
        keep[best] = True
        previous = best
    kept = np.flatnonzero(keep)
    flat = flat[kept]
    equal = np.logical_or(flat[1:] == flat[:-1], np.isnan(flat[1:]) & np.isnan(flat[:-1])).all(axis=1)
    same = np.r_[False, equal & np.isfinite(flat[1:]).any(axis=1)]
    for run in np.split(kept, np.flatnonzero(~same)[1:]):
        if len(run) <= _LONGEST_REPEAT:
            keep[run[1:]] = False
    return keep


def _whole_ends(where: str, good: np.ndarray) -> tuple[int, int]:
    """First and last frame with all six points; outside them there is nothing to interpolate to."""
    whole = np.flatnonzero(good.all(axis=1))
    if len(whole) == 0:
        worst = POINTS[int(np.argmin(good.mean(axis=0)))]
        raise RecordingError(f"{where}: no frame has all six points, {worst} is seen least; map it with --joints")
    return int(whole[0]), int(whole[-1])


def _require_short_gaps(where: str, t: np.ndarray, frames: np.ndarray, good: np.ndarray, max_gap_s: float) -> None:
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


def _resample(
    t: np.ndarray, x: np.ndarray, good: np.ndarray, rate: float, options: CleaningOptions
) -> tuple[np.ndarray, np.ndarray, int]:
    """Fills the gaps and moves to a uniform clock; also counts the instants at which nothing was recorded."""
    target = options.rate_hz or rate * max(1.0, np.ceil(30.0 / rate - 0.1))
    span = t[-1] - t[0]
    whole = np.round(span * target) / span  # Rounded time stamps (0.008333) drift against their own median step.
    if options.rate_hz is None and abs(whole / target - 1.0) < 0.005:
        target = whole
    clock = t[0] + np.arange(int(np.floor(span * target + 1e-3)) + 1) / target
    clock[-1] = min(clock[-1], t[-1])
    nearest = np.clip(np.searchsorted(t, clock), 1, len(t) - 1)
    nearest -= clock - t[nearest - 1] < t[nearest] - clock
    on_sample = np.abs(clock - t[nearest]) < 0.01 / target
    out = np.empty((len(clock), len(POINTS), 3))
    for index in range(len(POINTS)):
        seen = good[:, index]
        if options.interpolation == "linear":
            out[:, index] = np.stack([np.interp(clock, t[seen], x[seen, index, axis]) for axis in range(3)], axis=-1)
        else:
            out[:, index] = PchipInterpolator(t[seen], x[seen, index])(clock)
        exact = on_sample & seen[nearest]
        out[exact, index] = x[nearest[exact], index]
    return clock, out, int((~on_sample).sum())


def _rotation(where: str, recording: Recording, x: np.ndarray, options: CleaningOptions) -> np.ndarray:
    reader = FORMATS.get(recording.format)
    up = options.up or up_axis(x, reader.up if reader else None)
    if up is None:
        raise RecordingError(f"{where}: the arms do not tell which axis points up; say so with up ({', '.join(AXES)})")
    return rotation_to_z_up(up)
