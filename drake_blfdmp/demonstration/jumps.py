"""Samples at which the sensor, not the person, jumped: markers swapped, joints behind the box, a second skeleton."""

from heapq import heappop, heappush

import numpy as np

from drake_blfdmp.demonstration.bones import BONES, length_jumps, link_lengths, robust_sigma
from drake_blfdmp.skeleton import POINTS

_AROUND = 5  # Samples on either side that make a piece's surroundings.
_SHORTEST_STAY_S = 0.5  # A point that stays this long where it jumped to is taken to be there.


def bone_jumps(x: np.ndarray) -> np.ndarray:
    """Points that make a bone impossibly long or short.

    A wrong elbow breaks both bones of its arm, a wrong shoulder or wrist only one; so beside a broken bone half of the
    deviation is enough for the other.

    Args:
        x: (N, 6, 3) m; NaN where missing.

    Returns:
        (N, 6) bool.
    """
    lengths = link_lengths(x)[:, BONES]
    broken, doubtful = length_jumps(lengths), length_jumps(lengths, least_share=0.125, sigmas=4.0)
    points = []
    for upper, lower in ((0, 1), (3, 2)):
        both = (broken[:, upper] & doubtful[:, lower]) | (doubtful[:, upper] & broken[:, lower])
        points += [broken[:, upper] & ~both, both, broken[:, lower] & ~both]
    return np.stack(points, axis=-1)


def speed_jumps(t: np.ndarray, p: np.ndarray, speed_limit: float, sigmas: float = 10.0) -> np.ndarray:
    """Samples of one point that lie on a short excursion which begins and ends faster than a person moves.

    The series is cut where the speed is above the limit; the shortest piece is taken out, its neighbours are
    joined where that makes them reachable, and so on until no short piece is left.

    Args:
        t: (N,) strictly increasing, s.
        p: (N, 3) m; NaN where missing.
        speed_limit: m/s; raised to the median speed plus `sigmas` robust standard deviations where that is more.
        sigmas: see there.

    Returns:
        (N,) bool; False where p is NaN.
    """
    jumps = np.zeros(len(t), dtype=bool)
    valid = np.flatnonzero(np.isfinite(p).all(axis=1))
    if len(valid) < 3:
        return jumps
    t, p = t[valid], p[valid]
    speed = np.linalg.norm(np.diff(p, axis=0), axis=1) / np.diff(t)
    limit = max(speed_limit, float(np.median(speed) + sigmas * robust_sigma(speed)))
    cuts = np.flatnonzero(speed > limit) + 1
    if len(cuts) == 0:
        return jumps
    # Of pieces of one length the one farthest from its surroundings goes first.
    first = np.r_[0, cuts]
    around = np.clip(first[:, None] + np.arange(-_AROUND, _AROUND + 1), 0, len(t) - 1)
    deviation = np.linalg.norm(p[first] - np.median(p[around], axis=1), axis=-1)
    pieces = _Pieces(t, first, np.r_[cuts - 1, len(t) - 1], deviation)
    while (removed := pieces.take_shortest()) is not None:
        first, last, before, after = removed
        jumps[valid[first : last + 1]] = True
        if before is None or after is None:
            continue
        distance = float(np.linalg.norm(p[pieces.first[after]] - p[pieces.last[before]]))
        if distance <= limit * (t[pieces.first[after]] - t[pieces.last[before]]):
            pieces.join(before, after)
    # A joined piece spans samples taken out before, which stay out.
    return jumps


class _Pieces:
    """Pieces of a series in a chain, of which the shortest is at hand: each costs the logarithm of their number."""

    def __init__(self, t: np.ndarray, first: np.ndarray, last: np.ndarray, deviation: np.ndarray):
        self.first, self.last = first.tolist(), last.tolist()  # Inclusive; lists, since single entries are read.
        self._t, self._deviation = t, deviation
        self._before: list[int | None] = [None, *range(len(first) - 1)]
        self._after: list[int | None] = [*range(1, len(first)), None]
        self._alive = [True] * len(first)
        self._left = len(first)
        self._queue: list[tuple[int, float, int, int]] = []
        for piece in range(len(first)):
            self._enter(piece)

    def _enter(self, piece: int) -> None:
        first, last = self.first[piece], self.last[piece]
        if self._t[last] - self._t[first] < _SHORTEST_STAY_S:
            heappush(self._queue, (last - first, -float(self._deviation[piece]), first, piece))

    def take_shortest(self) -> tuple[int, int, int | None, int | None] | None:
        """First and last sample of the piece that is taken out, and its neighbours; None where none is short."""
        while self._queue and self._left > 1:
            length, _, first, piece = heappop(self._queue)
            if self._alive[piece] and (first, length) == (self.first[piece], self.last[piece] - self.first[piece]):
                before, after = self._before[piece], self._after[piece]
                self._drop(piece)
                return first, self.last[piece], before, after
        return None

    def join(self, before: int, after: int) -> None:
        """Makes one piece of two neighbours."""
        self.last[before] = self.last[after]
        self._drop(after)
        self._enter(before)

    def _drop(self, piece: int) -> None:
        before, after = self._before[piece], self._after[piece]
        if before is not None:
            self._after[before] = after
        if after is not None:
            self._before[after] = before
        self._alive[piece] = False
        self._left -= 1


def find_jumps(t: np.ndarray, x: np.ndarray, speed_limit: float) -> np.ndarray:
    """(N, 6) bool: points to be replaced, by the bones and then, without those, by the speed.

    Args:
        t: (N,) strictly increasing, s.
        x: (N, 6, 3) m; NaN where missing.
        speed_limit: m/s, see `speed_jumps`.
    """
    jumps = bone_jumps(x)
    cleared = np.where(jumps[..., None], np.nan, x)
    for point in range(x.shape[1]):
        jumps[:, point] |= speed_jumps(t, cleared[:, point], speed_limit)
    return jumps


def describe_jumps(jumps: np.ndarray, frames: np.ndarray) -> str:
    """A sentence on what `find_jumps` found, (N, 6) bool, with the file's frame numbers (N,)."""
    rows = np.flatnonzero(jumps.any(axis=1))
    counts = ", ".join(f"{POINTS[point]} {count}" for point, count in enumerate(jumps.sum(axis=0)) if count)
    return f"jumps taken out between frames {frames[rows[0]]} and {frames[rows[-1]]} (frames: {counts})"
