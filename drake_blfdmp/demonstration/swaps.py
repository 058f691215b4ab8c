"""Markers that changed names: two points whose paths continue in each other from one sample to the next.

Optical systems lose two markers near each other and find them again the wrong way round; skeleton trackers confuse left
and right when a person turns. Nothing is missing then: the points are there under each other's names, and are
given back. What stays, a swap that also moved, is a jump.
"""

from itertools import accumulate, combinations
from typing import NamedTuple

import numpy as np

from drake_blfdmp.demonstration.bones import FOREARMS, UPPER_ARMS, link_lengths
from drake_blfdmp.skeleton import POINTS

_CROSSING = 0.5  # Of the straight way: what two exchanged points go at most across, from one to the other.
_CLEARLY_BETTER = 0.8  # Of the bones' misfit: names that fit so much better are taken for the right ones.
_MOST_REFERENCES = 6  # Different names that are tried for the bones' lengths, and for the first stretch.
_MOST_MISFIT = 0.3  # m; a jump says no more about names than that.


class Unswapped(NamedTuple):
    """Points under their own names.

    Attributes:
        x: (N, 6, 3) m.
        moved: (N, 6) bool, which points stood under another name.
    """

    x: np.ndarray
    moved: np.ndarray


def find_exchanges(t: np.ndarray, x: np.ndarray, speed_limit: float) -> list[tuple[int, int, int]]:
    """Samples from which on two points stand under each other's names, relative to where each was last seen.

    Args:
        t: (N,) strictly increasing, s.
        x: (N, 6, 3) m; NaN where missing.
        speed_limit: m/s: both points go faster under their names, and neither does across.

    Returns:
        (sample, point, point), in the order of the samples.
    """
    sample = np.where(np.isfinite(x).all(axis=-1), np.arange(len(x))[:, None], -1)
    last = np.maximum.accumulate(sample, axis=0)[:-1]  # -1: not seen yet.
    before = np.take_along_axis(x, last[..., None] % len(x), axis=0)
    reach = speed_limit * np.where(last >= 0, t[1:, None] - t[last], 0.0)
    straight = np.linalg.norm(x[1:] - before, axis=-1)
    fast = (straight > reach) & (last >= 0)
    found: list[tuple[int, int, int]] = []
    for a, b in combinations(range(len(POINTS)), 2):
        rows = np.flatnonzero(fast[:, a] & fast[:, b])
        a_to_b = np.linalg.norm(x[rows + 1, b] - before[rows, a], axis=-1)
        b_to_a = np.linalg.norm(x[rows + 1, a] - before[rows, b], axis=-1)
        allowed = np.minimum(reach[rows][:, [a, b]], _CROSSING * straight[rows][:, [a, b]]).min(axis=1)
        found += [(int(row) + 1, a, b) for row in rows[np.maximum(a_to_b, b_to_a) < allowed]]
    return sorted(found)


def swap_back(t: np.ndarray, x: np.ndarray, speed_limit: float) -> Unswapped:
    """Gives exchanged points their names back.

    Exchanges cut the recording into stretches, and lead from each one's names to the next one's. Where an exchange was
    not seen, because a gap or a jump hid it, they lead astray; so a stretch whose bones keep their lengths clearly
    better under the file's own names keeps these. Left and right arm exchanged as a whole leave the bones alone: then
    the names of most samples are right.

    Args:
        t: (N,) strictly increasing, s.
        x: (N, 6, 3) m; NaN where missing.
        speed_limit: m/s, see `find_exchanges`.
    """
    exchanges = find_exchanges(t, x, speed_limit)
    own = np.arange(len(POINTS))
    if not exchanges:
        return Unswapped(x, np.zeros(x.shape[:2], dtype=bool))
    swaps: dict[int, list[tuple[int, int]]] = {}
    for sample, a, b in exchanges:
        swaps.setdefault(sample, []).append((a, b))
    starts = [0, *swaps]
    stretches = [slice(start, stop) for start, stop in zip(starts, [*swaps, len(x)], strict=True)]

    counts = np.diff([*starts, len(x)])
    led = list(accumulate(swaps.values(), _exchanged, initial=own))
    medians = _bone_lengths(x, np.repeat(led, counts, axis=0))
    # Where each point stands at first: as the file says, or so that some later stretch is as the file says.
    openings = [np.argsort(column) for column in led[1 : 1 + _MOST_REFERENCES]]
    column = min(openings, key=lambda opening: _misfit(x[stretches[0]][:, opening], medians))
    column = column if _fits_better(x[stretches[0]], column, own, medians) else own
    columns = []
    for stretch in stretches:
        column = _exchanged(column, swaps.get(stretch.start, []))
        if _fits_better(x[stretch], own, column, medians):
            column = own
        columns.append(column)
    namings, which = np.unique(columns, axis=0, return_inverse=True)
    usual = namings[np.argmax(np.bincount(np.ravel(which), weights=counts))]
    naming = np.repeat(columns, counts, axis=0)
    named = np.take_along_axis(x, naming[..., None], axis=1)
    if not _fits_better(named, own, np.argsort(usual), medians):
        naming, named = naming[:, np.argsort(usual)], named[:, np.argsort(usual)]
    return Unswapped(named, naming != own)


def describe_swaps(moved: np.ndarray, frames: np.ndarray) -> str:
    """A sentence on what `swap_back` moved, (N, 6) bool, with the file's frame numbers (N,)."""
    rows = np.flatnonzero(moved.any(axis=1))
    names = ", ".join(POINTS[point] for point in np.flatnonzero(moved.any(axis=0)))
    return (
        f"swapped points: {names} stood under each other's names in {len(rows)} frames between frames "
        f"{frames[rows[0]]} and {frames[rows[-1]]}; swapped back"
    )


def _exchanged(column: np.ndarray, pairs: list[tuple[int, int]]) -> np.ndarray:
    """Where points stand once the columns of each pair are exchanged."""
    for a, b in pairs:
        column = np.where(column == a, b, np.where(column == b, a, column))
    return column


def _bone_lengths(x: np.ndarray, led: np.ndarray) -> np.ndarray:
    """(2,) upper arm and forearm, m, under the names that keep them most alike: the file's, or where exchanges led.

    Args:
        x: (N, 6, 3) m.
        led: (N, 6) the column of each point of the first sample; the names of any sample may be the right ones.
    """
    references, counts = np.unique(led, axis=0, return_counts=True)
    common = references[np.argsort(-counts)[:_MOST_REFERENCES]]
    namings = [np.broadcast_to(np.arange(len(POINTS)), led.shape), *(led[:, np.argsort(right)] for right in common)]
    best, least = np.full(2, np.nan), np.inf
    for naming in namings:
        named = np.take_along_axis(x, naming[..., None], axis=1)
        lengths = link_lengths(named)
        both = [lengths[:, pair][np.isfinite(lengths[:, pair])] for pair in (UPPER_ARMS, FOREARMS)]
        medians = np.array([np.median(one) if len(one) else np.nan for one in both])
        misfit = _misfit(named, medians)
        if misfit < _CLEARLY_BETTER * least:
            best, least = medians, misfit
    return best


def _fits_better(x: np.ndarray, one: np.ndarray, other: np.ndarray, medians: np.ndarray) -> bool:
    """Whether bones are clearly nearer to (2,) their lengths, m, with points from columns `one` than from `other`."""
    return _misfit(x[:, one], medians) < _CLEARLY_BETTER * _misfit(x[:, other], medians)


def _misfit(x: np.ndarray, medians: np.ndarray) -> float:
    """How far the bones of (N, 6, 3) are from (2,) their lengths on average, m; in shares, long ones look steady."""
    lengths = link_lengths(x)
    off = np.stack([lengths[:, pair] - median for pair, median in zip((UPPER_ARMS, FOREARMS), medians, strict=True)])
    off = np.minimum(np.abs(off[np.isfinite(off)]), _MOST_MISFIT)
    return float(off.mean()) if len(off) else 0.0
