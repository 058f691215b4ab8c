"""What no cleaning can mend: recordings too short, too slow, of half a person, or in no length a body has."""

import numpy as np

from drake_blfdmp.demonstration.bones import FOREARMS, PLAUSIBLE_BONE, UPPER_ARMS, link_lengths
from drake_blfdmp.demonstration.demonstration import Recording
from drake_blfdmp.demonstration.upright import sidedness
from drake_blfdmp.errors import RecordingError
from drake_blfdmp.skeleton import POINTS

MIN_FRAMES = 10
MIN_DURATION_S = 1.0
MIN_RATE_HZ = 4.0
_SWAPPED = -0.08  # m of `sidedness`; real recordings measure -0.07 (half of it Kinect confusion) to 0.41.
_LEAST_MOTION = 0.01  # m.
_FARTHEST = 1e6  # m: nothing farther was measured, and squares lose their digits.
_LONGEST_S = 1e10  # Three hundred years; clocks since 1970 fit.
_LEAST_STEP_S = 1e-6


def checked_arrays(recording: Recording) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A recording's t (N,), x (N, 6, 3) and frames (N,) as arrays that fit each other; points not finite are NaN.

    Raises:
        RecordingError: their shapes do not fit, there are too few, or a time or coordinate is no measurement.
    """
    where = recording.source
    t, x, frames = np.asarray(recording.t, float), np.asarray(recording.x, float), np.asarray(recording.frames)
    if t.ndim != 1 or x.shape != (len(t), len(POINTS), 3) or frames.shape != t.shape:
        raise RecordingError(
            f"{where}: times {t.shape}, points {x.shape} and frame numbers {frames.shape} do not fit; "
            f"give (N,), (N, {len(POINTS)}, 3) and (N,)"
        )
    require_frames(where, len(t))
    wrong = ~(np.abs(t) <= _LONGEST_S)
    if wrong.any():
        row = int(np.argmax(wrong))
        raise RecordingError(f"{where}: frame {frames[row]} has the time {t[row]:g} s; check the time stamps")
    x = np.where(np.isfinite(x).all(axis=-1, keepdims=True), x, np.nan)
    wrong = np.abs(x) > _FARTHEST
    if wrong.any():
        row, point, axis = (int(i) for i in np.argwhere(wrong)[0])
        raise RecordingError(
            f"{where}: at frame {frames[row]} {POINTS[point]} is at {x[row, point, axis]:.3g} m; "
            "check --unit and the file"
        )
    return t, x, frames


def require_frames(where: str, count: int) -> None:
    """Refuses fewer than MIN_FRAMES."""
    if count < MIN_FRAMES:
        raise RecordingError(
            f"{where}: a {count}-frame recording, a skill needs at least {MIN_FRAMES} different frames; "
            "record the whole motion"
        )


def require_points(where: str, x: np.ndarray) -> None:
    """Refuses (N, 6, 3) in which a point is never seen."""
    for index, point in enumerate(POINTS):
        if not np.isfinite(x[:, index]).all(axis=-1).any():
            raise RecordingError(f"{where}: {point} is missing in every frame; map it to another joint with --joints")


def require_metres(where: str, x: np.ndarray) -> None:
    """Refuses (N, 6, 3) whose arms are not as long as a person's in metres; says which unit would be."""
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


def require_running_clock(where: str, t: np.ndarray, frames: np.ndarray) -> None:
    """Refuses strictly increasing times (N,), s, of a recording that is too short, too slow or unevenly stamped."""
    if t[-1] - t[0] < MIN_DURATION_S - 1e-9:
        raise RecordingError(
            f"{where}: lasts {t[-1] - t[0]:.2f} s, a skill needs at least {MIN_DURATION_S:g} s; record the whole motion"
        )
    steps = np.diff(t)
    if steps.min() < _LEAST_STEP_S:
        row = int(np.argmin(steps))
        raise RecordingError(
            f"{where}: frames {frames[row]} and {frames[row + 1]} are {steps[row]:.1e} s apart; check the time stamps"
        )
    rate = 1.0 / float(np.median(steps))
    most = max(rate, (len(t) - 1) / float(t[-1] - t[0]))  # The mean: sensors that skip frames come in bursts.
    if most < MIN_RATE_HZ:
        raise RecordingError(
            f"{where}: {most:.2g} samples a second, at least {MIN_RATE_HZ:g} are needed; check the clock"
        )


def require_motion(where: str, x: np.ndarray) -> None:
    """Refuses (N, 6, 3) in which no point moves."""
    if np.ptp(x, axis=0).max() < _LEAST_MOTION:
        raise RecordingError(f"{where}: nobody moves (all points within 1 cm); record a motion")


def require_sides(where: str, x: np.ndarray) -> None:
    """Refuses (N, 6, 3), z up, in which left and right are exchanged."""
    side, share = sidedness(x)
    if side < _SWAPPED and share > 0.6:
        raise RecordingError(
            f"{where}: the hands are {-side:.2f} m behind the shoulders, left and right are swapped; "
            "swap them with --joints"
        )
