"""Which unit a file's clock counts in: what is stated, else what makes it run like a sensor."""

from typing import NamedTuple

import numpy as np

SECONDS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "100ns": 1e-7, "ns": 1e-9}
"""Seconds per unit of time. The sixth unit, "frames", has no fixed length."""

USUAL_RATE_HZ = 30.0
"""Of depth cameras; taken for files that count frames, or have no clock at all, and do not say how fast."""


class Clock(NamedTuple):
    """Times (N,) in s, and a sentence on how they were found."""

    t: np.ndarray
    evidence: str


def find_clock(
    t: np.ndarray | None,
    frames: np.ndarray,
    *,
    stated_unit: str | None = None,
    stated_hz: float | None = None,
    time_unit: str | None = None,
    rate_hz: float | None = None,
) -> Clock:
    """Times in seconds.

    Args:
        t: (N,) finite, the file's clock, or None.
        frames: (N,) frame numbers, counted where there is no clock.
        stated_unit: what the file or its format says: a key of SECONDS, or "frames".
        stated_hz: the frame rate that the file or its format says.
        time_unit: the user's, before all else.
        rate_hz: the user's frame rate; the file's clock is then left aside and frames are counted.
    """
    if rate_hz is not None:
        return Clock(frames / rate_hz, f"clock: {rate_hz:g} frames a second, as set")
    if t is None or (time_unit or stated_unit) == "frames":
        counted = frames if t is None else t
        rate = stated_hz or USUAL_RATE_HZ
        why = "by its format" if stated_hz else "assumed (the file does not say; set the rate where it is another)"
        return Clock(counted / rate, f"clock: frame numbers at {rate:g} a second, {why}")
    step = _median_step(t)
    unit = time_unit or stated_unit
    if unit is None and _counts_frames(t):
        rate = stated_hz or USUAL_RATE_HZ
        why = "" if stated_hz else ", assumed (set the rate where it is another)"
        return Clock(
            t / rate, f"clock: whole numbers in steps of {step:g} are frame numbers, at {rate:g} a second{why}"
        )
    if unit is None:
        unit = "s" if step == 0.0 else min(SECONDS, key=lambda u: abs(np.log(step * SECONDS[u] * USUAL_RATE_HZ)))
        why = f"for its median step of {step:g} then means {_rate(step * SECONDS[unit])}"
    else:
        why = f"{'as set' if time_unit else 'as the file or its format says'}, {_rate(step * SECONDS[unit])}"
    return Clock(t * SECONDS[unit], f"clock: {'units of 100 ns' if unit == '100ns' else unit}, {why}")


def _median_step(t: np.ndarray) -> float:
    steps = np.abs(np.diff(t))
    steps = steps[steps > 0.0]
    return float(np.median(steps)) if len(steps) else 0.0


def _counts_frames(t: np.ndarray) -> bool:
    """Whole numbers that often step by one or two: no sensor's clock ticks so in any unit of time."""
    if not np.all(t == np.round(t)):
        return False
    steps = np.abs(np.diff(t))
    steps = steps[steps > 0.0]
    return len(steps) > 0 and float(np.quantile(steps, 0.2)) <= 2.0


def _rate(step_s: float) -> str:
    return f"{1.0 / step_s:.3g} samples a second" if step_s > 0.0 else "one single time"
