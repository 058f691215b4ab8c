"""Samples at which the sensor, not the person, jumped: markers swapped, joints behind the box, a second skeleton."""

import numpy as np
from scipy.ndimage import median_filter

from drake_blfdmp.demonstration.bones import BONES, length_jumps, link_lengths, robust_sigma
from drake_blfdmp.skeleton import LINKS

_SHORTEST_STAY_S = 0.5  # A point that stays this long where it jumped to is taken to be there.


def bone_jumps(x: np.ndarray) -> np.ndarray:
    """Points that make a bone impossibly long or short.

    A wrong elbow breaks both bones of its arm, a wrong shoulder or wrist only one.

    Args:
        x: (N, 6, 3) m; NaN where missing.

    Returns:
        (N, 6) bool.
    """
    broken = np.zeros((len(x), len(LINKS)), dtype=bool)
    broken[:, BONES] = length_jumps(link_lengths(x)[:, BONES])
    upper_left, lower_left, _, lower_right, upper_right = broken.T
    arms = [
        (upper & ~lower, upper & lower, lower & ~upper)
        for upper, lower in ((upper_left, lower_left), (upper_right, lower_right))
    ]
    return np.stack([*arms[0], *arms[1]], axis=-1)


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
    # Inclusive [first, last] of each piece; samples between pieces are those already taken out.
    pieces = [[int(i), int(j) - 1] for i, j in zip([0, *cuts], [*cuts, len(t)], strict=True)]
    # Of pieces of one length the one farthest from its surroundings goes first.
    deviation = np.linalg.norm(p - median_filter(p, size=(11, 1), mode="nearest"), axis=1)

    def rank(piece: list[int]) -> tuple[int, float]:
        return piece[1] - piece[0], -deviation[piece[0]]

    while len(pieces) > 1:
        short = [piece for piece in pieces if t[piece[1]] - t[piece[0]] < _SHORTEST_STAY_S]
        if not short:
            break
        removed = min(short, key=rank)
        index = pieces.index(removed)
        pieces.pop(index)
        jumps[valid[removed[0] : removed[1] + 1]] = True
        if 0 < index < len(pieces):
            before, after = pieces[index - 1], pieces[index]
            distance = float(np.linalg.norm(p[after[0]] - p[before[1]]))
            if distance <= limit * (t[after[0]] - t[before[1]]):
                pieces[index - 1 : index + 1] = [[before[0], after[1]]]
    # A joined piece spans samples taken out before, which stay out.
    return jumps


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
