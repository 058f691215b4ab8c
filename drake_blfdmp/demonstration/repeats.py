"""Frames that came late or twice: the order of time, and one skeleton for each time."""

import numpy as np

from drake_blfdmp.errors import RecordingError

_MOST_LATE = 0.2  # Share of frames; more is no shuffling but two takes in one file.
_LONGEST_REPEAT = 3  # Frames; a longer run of equal skeletons is a synthetic person at rest.


def in_order(where: str, t: np.ndarray, frames: np.ndarray) -> tuple[np.ndarray, int]:
    """The order that makes time run forward, and how many frames came late.

    Args:
        where: the recording, for messages.
        t: (N,) s.
        frames: (N,) frame numbers.

    Returns:
        (N,) indices; frames of one time keep their order.

    Raises:
        RecordingError: time runs backwards for good.
    """
    late = np.less(t, np.maximum.accumulate(t))
    if late.mean() > _MOST_LATE:
        raise RecordingError(
            f"{where}: time runs backwards at frame {frames[int(np.argmax(late))]} and does not recover; "
            "cut one take with --frames"
        )
    return np.argsort(t, kind="stable"), int(late.sum())


def without_repeats(t: np.ndarray, x: np.ndarray, *, equal_too: bool = True) -> np.ndarray:
    """Of samples with one time the one nearest to the last kept, of a short run of equal ones the first.

    Args:
        t: (N,) not decreasing, s.
        x: (N, 6, 3) m; NaN where missing.
        equal_too: also leaves out equal skeletons at different times, which a sensor delivered twice.

    Returns:
        (N,) bool, which samples to keep.
    """
    keep = np.ones(len(t), dtype=bool)
    flat = x.reshape(len(x), -1)
    same_time = np.r_[False, np.diff(t) == 0.0]
    starts = np.flatnonzero(~same_time)
    for start, stop in zip(starts, np.r_[starts[1:], len(t)], strict=True) if same_time.any() else ():
        if stop - start == 1:
            continue
        group = np.arange(start, stop)
        distance = np.zeros(len(group))
        if start > 0:
            previous = start - 1
            while not keep[previous]:
                previous -= 1
            distance = np.nan_to_num(np.abs(flat[group] - flat[previous])).sum(axis=1)
        keep[group] = False
        keep[group[np.lexsort((distance, np.isnan(flat[group]).sum(axis=1)))[0]]] = True
    if not equal_too:
        return keep
    kept = np.flatnonzero(keep)
    flat = flat[kept]
    equal = np.logical_or(flat[1:] == flat[:-1], np.isnan(flat[1:]) & np.isnan(flat[:-1])).all(axis=1)
    same = np.r_[False, equal & np.isfinite(flat[1:]).any(axis=1)]
    starts = np.flatnonzero(~same)
    run = np.diff(np.r_[starts, len(kept)])
    keep[kept[same & np.repeat(run <= _LONGEST_REPEAT, run)]] = False
    return keep
