"""A recording in, a clean demonstration out; every repair is counted, every choice said, and the hopeless refused."""

from dataclasses import dataclass, field, replace

import numpy as np

from drake_blfdmp.demonstration.bones import estimate_bone_lengths
from drake_blfdmp.demonstration.demonstration import Demonstration, Recording
from drake_blfdmp.demonstration.depth_lookup import describe_depths, is_depth_lookup, redo_depths
from drake_blfdmp.demonstration.gaps import fill_and_resample, require_short_gaps, uniform_clock, whole_ends
from drake_blfdmp.demonstration.holding import wobble
from drake_blfdmp.demonstration.jumps import describe_jumps, find_jumps, speed_jumps
from drake_blfdmp.demonstration.orientation_cleaning import clean_orientations
from drake_blfdmp.demonstration.repeats import in_order, without_repeats
from drake_blfdmp.demonstration.screening import (
    checked_arrays,
    require_frames,
    require_metres,
    require_motion,
    require_points,
    require_running_clock,
    require_sides,
)
from drake_blfdmp.demonstration.skeleton_fit import restore_lengths, scale_bones
from drake_blfdmp.demonstration.smoothing_choice import METHODS, apply_smoothing, choose_smoothing, describe_smoothing
from drake_blfdmp.demonstration.swaps import describe_swaps, swap_back
from drake_blfdmp.demonstration.uncertainty import SensorError, estimate_error
from drake_blfdmp.demonstration.upright import AXES, rotation_to_z_up, up_axis
from drake_blfdmp.errors import RecordingError
from drake_blfdmp.quaternions import from_matrix, multiply
from drake_blfdmp.skeleton import POINTS, WRISTS

__all__ = ["CleaningOptions", "clean"]

_MOVED_M = 1e-3  # How far a restored point is moved to be counted.


@dataclass(frozen=True)
class CleaningOptions:
    """How to clean: limits, and which of the steps are taken.

    Attributes:
        max_gap_s: the longest time without a point that is filled, s; longer ones are refused.
        up: the file's axis that points up, one of x, -x, y, -y, z, -z; None finds it.
        rate_hz: the demonstration's clock; None takes the median rate, times a whole number where it is below 30 Hz.
        speed_limit: m/s above which a point may have jumped.
        interpolation: "pchip" or "linear".
        sort_frames: puts frames in the order of time; else a late one is refused.
        drop_repeats: leaves out equal skeletons that follow each other; of two at one time one goes in any case.
        least_confidence: points of which the sensor says less are missing: 0 none, 0.25 those it did not see, 0.75
            also those it guessed.
        undo_swaps: gives points that stand under each other's names their own.
        redo_depths: moves elbows and wrists along the camera's rays where a depth image hid them; None does so where
            the recording looks like a depth image's (`depth_lookup.is_depth_lookup`).
        remove_jumps: replaces points that jump or make a bone impossible.
        smoothing: None; "auto", method and bandwidth by the data; or one of "butterworth", "spline", "wiener".
        restore_bones: gives the arms' bones their lengths: those known beforehand, or else the estimated ones.
        restore_hold: gives the hands the box's width while they hold it; only with restore_bones.
    """

    max_gap_s: float = 1.5
    up: str | None = None
    rate_hz: float | None = None
    speed_limit: float = 5.0
    interpolation: str = "pchip"
    sort_frames: bool = True
    drop_repeats: bool = True
    least_confidence: float = 0.25
    undo_swaps: bool = True
    redo_depths: bool | None = None
    remove_jumps: bool = True
    smoothing: str | None = None
    restore_bones: bool = False
    restore_hold: bool = False


@dataclass
class _Work:
    """What the steps hand on: t (N,) s, x (N, 6, 3) m, frames (N,), good (N, 6) bool, and the log of the repairs.

    `orientations` are the hands' (N, 2, 4), or None.
    """

    t: np.ndarray
    x: np.ndarray
    frames: np.ndarray
    good: np.ndarray
    orientations: np.ndarray | None = None
    repairs: dict[str, int] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)

    def keep(self, rows: np.ndarray | slice) -> None:
        self.t, self.x, self.frames, self.good = self.t[rows], self.x[rows], self.frames[rows], self.good[rows]
        self.orientations = None if self.orientations is None else self.orientations[rows]


def clean(recording: Recording, options: CleaningOptions = CleaningOptions()) -> Demonstration:
    """Repairs a recording and puts it upright on a uniform clock.

    Returns:
        The demonstration, z up, not smoothed unless asked for. `repairs` counts frames (out_of_order_frames,
        repeated_frames, empty_frames, trimmed_frames, resampled_frames) and points of frames (low_confidence_removed,
        swaps_undone, depths_redone, jumps_removed, missing_samples_filled, points_smoothed, points_restored); `notes`
        says in sentences what was found and chosen.

    Raises:
        RecordingError: too short, too slow, gaps too long, not in metres, left and right swapped, or nothing moves.
    """
    where = recording.source
    _check_options(where, options)
    work = _read(recording, options)
    _order(where, work, options)
    _repair_points(recording, work, options)
    _trim(where, work)
    clock = _resample(where, work, options)
    require_motion(where, work.x)
    up = _up(where, recording, work, options)
    to_z_up = rotation_to_z_up(up)
    x = work.x @ to_z_up.T
    require_sides(where, x)
    error = estimate_error(x, recording.known)
    demonstration = Demonstration(
        t=clock - clock[0],
        x=x,
        source=where,
        synthetic=recording.synthetic,
        known=recording.known,
        uncertainty=error.per_point,
        orientations=None if work.orientations is None else multiply(from_matrix(to_z_up), work.orientations),
    )
    x = _refine(demonstration, error, work, options)
    # Bones that were given their lengths no longer tell how the hands' distance errs.
    noise = wobble(demonstration.x) if options.restore_bones else None
    return replace(demonstration, x=x, wobble=noise, repairs=work.repairs, notes=tuple(work.notes))


def _check_options(where: str, options: CleaningOptions) -> None:
    if options.interpolation not in ("pchip", "linear"):
        raise RecordingError(f"{where}: interpolation is '{options.interpolation}'; give pchip or linear")
    for name, choices in (("up", AXES), ("smoothing", ("auto", *METHODS))):
        value = getattr(options, name)
        if value is not None and value not in choices:
            raise RecordingError(f"{where}: {name} is '{value}'; give one of {', '.join(choices)}")
    for name in ("max_gap_s", "speed_limit", "rate_hz"):
        value = getattr(options, name)
        if value is not None and not 0.0 < value < np.inf:
            raise RecordingError(f"{where}: {name} is {value}; give a positive number")
    if not 0.0 <= options.least_confidence <= 1.0:
        raise RecordingError(f"{where}: least_confidence is {options.least_confidence}; give a number from 0 to 1")
    if options.restore_hold and not options.restore_bones:
        raise RecordingError(f"{where}: restore_hold works on restored bones; set restore_bones too")


def _read(recording: Recording, options: CleaningOptions) -> _Work:
    """The recording's arrays; a point is NaN where it was not seen, or the sensor says so."""
    where = recording.source
    t, x, frames = checked_arrays(recording)
    x = np.where(np.any(x != 0.0, axis=-1, keepdims=True), x, np.nan)  # How a Kinect writes a joint it does not see.
    work = _Work(t, x, frames, np.ones(x.shape[:2], dtype=bool))
    if recording.orientations is not None:
        work.orientations = np.asarray(recording.orientations, float)
        if work.orientations.shape != (len(t), 2, 4):
            raise RecordingError(
                f"{where}: orientations are {work.orientations.shape}, expected {(len(t), 2, 4)}; give one a hand"
            )
    seen = np.isfinite(x).all(axis=-1)
    doubted = np.zeros_like(seen)
    if recording.confidence is not None:
        confidence = np.asarray(recording.confidence, float)
        if confidence.shape != seen.shape:
            raise RecordingError(
                f"{where}: confidence is {confidence.shape}, points are {seen.shape}; give one a point"
            )
        doubted = seen & ~(confidence >= options.least_confidence) if options.least_confidence > 0.0 else doubted
    work.repairs["low_confidence_removed"] = int(doubted.sum())
    work.x = np.where(doubted[..., None], np.nan, x)
    require_points(where, work.x)
    if np.ptp(t) <= 0.0:
        raise RecordingError(f"{where}: every sample has the time {t[0]:g} s; record with a running clock")
    return work


def _order(where: str, work: _Work, options: CleaningOptions) -> None:
    """One skeleton for each time, in the order of time."""
    order, late = in_order(where, work.t, work.frames)
    if late and not options.sort_frames:
        row = int(np.argmax(np.less(work.t, np.maximum.accumulate(work.t))))
        raise RecordingError(f"{where}: frame {work.frames[row]} comes late; sort the frames, or allow sort_frames")
    work.repairs["out_of_order_frames"] = late
    work.keep(order)
    keep = without_repeats(work.t, work.x, equal_too=options.drop_repeats)
    work.repairs["repeated_frames"] = int(len(keep) - keep.sum())
    work.keep(keep)
    require_frames(where, len(work.t))


def _repair_points(recording: Recording, work: _Work, options: CleaningOptions) -> None:
    """Swaps, depths and jumps; `good` says which points are left to be used."""
    where, t = recording.source, work.t
    moved = np.zeros(work.good.shape, dtype=bool)
    if options.undo_swaps:
        work.x, moved = swap_back(t, work.x, options.speed_limit)
    work.repairs["swaps_undone"] = int(moved.sum())
    if moved.any():
        work.notes.append(describe_swaps(moved, work.frames))
        if work.orientations is not None:  # Whose they are nobody knows.
            work.orientations = np.where(moved[:, WRISTS, None], np.nan, work.orientations)
    missing = np.isnan(work.x).any(axis=-1)
    work.repairs["empty_frames"] = int(missing.all(axis=1).sum())
    jumps, moved = np.zeros(missing.shape, dtype=bool), np.zeros(missing.shape, dtype=bool)
    if _has_looked_up_depths(recording, work, options):
        if options.remove_jumps:  # First: a point that leaves its ray for a moment tells nothing of depths.
            jumps = np.stack([speed_jumps(t, work.x[:, i], options.speed_limit) for i in range(len(POINTS))], axis=-1)
        points = np.where(jumps[..., None], np.nan, work.x)
        points, moved = redo_depths(t, points, recording.known.upper_arm, recording.known.forearm)
        work.x = np.where(moved[..., None], points, work.x)
        work.notes.append(describe_depths(moved))
    work.repairs["depths_redone"] = int(moved.sum())
    require_metres(where, work.x)
    if options.remove_jumps:
        jumps = (jumps | find_jumps(t, work.x, options.speed_limit)) & ~missing
    work.repairs["jumps_removed"] = int(jumps.sum())
    if jumps.any():
        work.notes.append(describe_jumps(jumps, work.frames))
    work.good = ~missing & ~jumps


def _has_looked_up_depths(recording: Recording, work: _Work, options: CleaningOptions) -> bool:
    if options.redo_depths is not None:
        return options.redo_depths
    return is_depth_lookup(np.asarray(recording.x, float), options.up or _found_up(work.x, recording))


def _trim(where: str, work: _Work) -> None:
    """From the first to the last frame with all points."""
    count = len(work.t)
    first, last = whole_ends(where, work.good)
    work.keep(slice(first, last + 1))
    work.repairs["trimmed_frames"] = count - len(work.t)
    if work.repairs["trimmed_frames"]:
        work.notes.append(f"ends without all points trimmed: frames {work.frames[0]} to {work.frames[-1]} are left")
    require_frames(where, len(work.t))


def _resample(where: str, work: _Work, options: CleaningOptions) -> np.ndarray:
    """Fills the gaps; returns the uniform clock."""
    require_running_clock(where, work.t, work.frames)
    require_short_gaps(where, work.t, work.frames, work.good, options.max_gap_s)
    work.repairs["missing_samples_filled"] = int(np.isnan(work.x).any(axis=-1).sum())
    clock, rate = uniform_clock(where, work.t, options.rate_hz)
    if work.orientations is not None:
        cleaned = clean_orientations(work.t, work.orientations, clock, options.max_gap_s)
        work.orientations, work.repairs["orientations_removed"] = cleaned.q, cleaned.removed
        work.notes += cleaned.notes
    work.x, work.repairs["resampled_frames"] = fill_and_resample(
        work.t, work.x, work.good, clock, rate, options.interpolation
    )
    return clock


def _found_up(x: np.ndarray, recording: Recording) -> str | None:
    if recording.up is not None and recording.up not in AXES:
        raise RecordingError(
            f"{recording.source}: the file's up axis is '{recording.up}'; give one of {', '.join(AXES)}"
        )
    whole = x[np.isfinite(x).all(axis=(1, 2))]
    return up_axis(whole, recording.up) if len(whole) else recording.up


def _up(where: str, recording: Recording, work: _Work, options: CleaningOptions) -> str:
    up = options.up or _found_up(work.x, recording)
    if up is None:
        raise RecordingError(f"{where}: the arms do not tell which axis points up; say so with up ({', '.join(AXES)})")
    source = "as set" if options.up else "as the file says" if up == recording.up else "as the arms hang"
    work.notes.insert(0, f"up: the file's {up} axis, {source}")
    return up


def _refine(demonstration: Demonstration, error: SensorError, work: _Work, options: CleaningOptions) -> np.ndarray:
    """The steps that change every point a little: smoothing, and the lengths that are known to be constant."""
    x = demonstration.x
    millimetres = ", ".join(f"{name} {1e3 * s:.1f}" for name, s in zip(POINTS, error.per_point, strict=True))
    work.notes.append(f"uncertainty per axis, mm: {millimetres}")
    work.repairs["points_smoothed"] = work.repairs["points_restored"] = 0
    bones = measured = estimate_bone_lengths(x)
    if options.restore_bones:
        known = demonstration.known
        bones = (known.upper_arm or measured[0], known.forearm or measured[1])
        x = scale_bones(x, measured, bones)
    if options.smoothing is not None:
        methods = METHODS if options.smoothing == "auto" else (options.smoothing,)
        chosen = choose_smoothing(x, demonstration.rate_hz, error, methods)
        smoothed = apply_smoothing(demonstration.t, x, chosen)
        work.repairs["points_smoothed"] = int(np.any(smoothed != x, axis=-1).sum())
        work.notes.append(describe_smoothing(chosen, error))
        x = smoothed
    if options.restore_bones:
        before = demonstration.x if options.smoothing is None else x
        x, said = restore_lengths(demonstration, x, bones, error, hold=options.restore_hold)
        work.repairs["points_restored"] = int((np.linalg.norm(x - before, axis=-1) > _MOVED_M).sum())
        work.notes.append(said)
    return x
