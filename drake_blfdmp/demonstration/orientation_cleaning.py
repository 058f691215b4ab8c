"""Cleaning of the hands' orientations: unit length, one sign, no outliers, no gaps, the demonstration's clock."""

from typing import NamedTuple

import numpy as np

from drake_blfdmp.quaternions import angle_between, continuous, interpolated, normalised

OUTLIER = np.deg2rad(20.0)
"""rad from the running median of `_WINDOW` samples, above which an orientation is an outlier: no wrist turns so."""

LEAST_SEEN = 0.5
"""Share of the samples with an orientation below which a hand's are left out."""

_WINDOW = 7
_STILL = 1e-12  # 1 - |cosine| of half the angle to the first one; 3e-6 rad.
_SIDES = ("left", "right")


class CleanOrientations(NamedTuple):
    """Orientations (M, 2, 4) on the clock, NaN throughout for a hand without; None for two such; the outliers' number.

    `notes` are sentences on what was left out.
    """

    q: np.ndarray | None
    removed: int
    notes: tuple[str, ...]


def has_orientation(q: np.ndarray) -> np.ndarray:
    """Which samples (N, 2) of orientations (N, 2, 4) hold a rotation."""
    return np.asarray(np.isfinite(normalised(q)).all(axis=-1))


def turning_orientations(q: np.ndarray) -> np.ndarray | None:
    """Orientations (N, 2, 4) as unit quaternions, NaN where missing; None where no hand's ever changes.

    Formats that have a place for an orientation are mostly written with the same one in it all along.
    """
    unit = normalised(q)
    for hand in range(2):
        own = unit[np.isfinite(unit[:, hand]).all(axis=-1), hand]
        if len(own) and np.all(np.abs(own @ own[0]) > 1.0 - _STILL):
            unit[:, hand] = np.nan
    return unit if np.isfinite(unit).any() else None


def describe_orientations(q: np.ndarray | None) -> str:
    """A sentence on a recording's orientations; empty where it has none."""
    if q is None:
        return ""
    left, right = 100 * has_orientation(q).mean(axis=0)
    return f"hand orientations: left in {left:.0f} %, right in {right:.0f} % of the frames"


def clean_orientations(t: np.ndarray, q: np.ndarray, clock: np.ndarray, max_gap_s: float) -> CleanOrientations:
    """Repair orientations and bring them to another clock.

    Args:
        t: (N,) increasing, s.
        q: (N, 2, 4) of left and right hand, w x y z of any length and sign; NaN or zeros where missing.
        clock: (M,) s, within t.
        max_gap_s: the longest time without one that is filled.
    """
    out = np.full((len(clock), 2, 4), np.nan)
    removed, notes = 0, []
    for hand, side in enumerate(_SIDES):
        seen = has_orientation(q[:, hand])
        if not seen.any():
            continue
        own = continuous(normalised(q[seen, hand]))
        good = _near_their_median(own)
        removed += int((~good).sum())
        own, times = own[good], t[seen][good]
        gap = np.diff(np.concatenate([[clock[0]], np.clip(times, clock[0], clock[-1]), [clock[-1]]])).max()
        if good.sum() < LEAST_SEEN * len(t) or gap > max_gap_s:
            notes.append(
                f"orientations of the {side} hand left out: in {100 * good.sum() / len(t):.0f} % of the frames, "
                f"longest gap {gap:.2f} s"
            )
            continue
        out[:, hand] = continuous(interpolated(times, own, clock))
    return CleanOrientations(out if np.isfinite(out).any() else None, removed, tuple(notes))


def _near_their_median(q: np.ndarray) -> np.ndarray:
    """Which of (N, 4) orientations with continuous signs lie near the running median: (N,) bool."""
    if len(q) < _WINDOW:
        return np.ones(len(q), dtype=bool)
    # Signs are continuous but for outliers, which may turn the signs of all that follow: so each window is on its own.
    half = _WINDOW // 2
    padded = np.pad(q, ((half, half), (0, 0)), mode="edge")
    windows = np.lib.stride_tricks.sliding_window_view(padded, _WINDOW, axis=0)  # (N, 4, window)
    centre = windows[:, :, half : half + 1]
    sides = np.where(np.sum(windows * centre, axis=1, keepdims=True) < 0.0, -1.0, 1.0)
    typical = normalised(np.median(windows * sides, axis=-1))
    return angle_between(typical, q) <= OUTLIER
