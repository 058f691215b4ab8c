"""Whether two arms get along a way in one go: postures for every sample, free of overlap, joined to those before.

At a sample a palm that faces a given way leaves an arm one freedom, the wrist's angle about the palm's normal, beside
eight branches; the roll of the palm is joint 7's alone and moves no body. So an arm's postures are those on a grid of
such angles, in closed form. Pairs of both arms' postures are joined from sample to sample and, as the palms may wait
for the elbows, within a sample. What is asked for is less than a plan needs: elbows are where they like, take their
time and may turn as they like.
"""

from collections.abc import Callable, Iterable, Sequence
from functools import cache, partial

import numpy as np

from drake_blfdmp.robot.clearance import ClearanceChecker
from drake_blfdmp.robot.closed_form_ik import ClosedFormIk
from drake_blfdmp.robot.plant import JointLimits, MakeKinematicPlant

ANGLES = 72
"""Of a wrist about the palm's normal that are looked at, all around."""

ALIKE = 0.3
"""Postures in which no joint differs by more, rad, are joined whatever their branches: these meet where an arm is
singular.
"""

Postures = tuple[np.ndarray, np.ndarray]
"""An arm's postures (n, 7), joint 7 at 0, rad, and their angles and branches (n, 2)."""

Pairs = tuple[list[Postures], np.ndarray]
"""Both arms' postures at a sample, and which pairs of them are free of overlap (n, m)."""

Clear = Callable[[int, np.ndarray, np.ndarray], np.ndarray]
"""Of a sample, n postures of the left arm and m of the right one, the pairs (n, m) that keep clear (`Scene.clear`)."""

_ALONE = np.ones((1, 1), dtype=np.float32)
"""How an arm that is not there gets along."""


class JoinedPostures:
    """Looks for two arms' postures along a way."""

    def __init__(self, limits: JointLimits | None = None, clearance: float = 0.0):
        """Of joints within limits, or their own where None, and of arms that keep a clearance of each other, m."""
        self._ik = ClosedFormIk(MakeKinematicPlant(), limits)
        self._angles = np.linspace(-np.pi, np.pi, ANGLES, endpoint=False)
        self._checker, self._clearance = ClearanceChecker(max_distance=0.02), clearance
        self._failed = 0

    def get_along(self, middles: np.ndarray, yaw: np.ndarray, apart: np.ndarray, clear: Clear | None = None) -> bool:
        """Whether the arms get to the end of a way; args as of `reached`."""
        return self.reached(middles, yaw, apart, clear) == len(middles)

    def reached(self, middles: np.ndarray, yaw: np.ndarray, apart: np.ndarray, clear: Clear | None = None) -> int:
        """How many samples the arms get along a way; all K only where they get to its end.

        A sample without any pair of postures counts as the first that is not got to, whatever lies before it.

        Args:
            middles: (K, 3) between the palms, m in W.
            yaw: (K,) of the line between the palms, left to right, rad.
            apart: (K,) the palms' distance, m.
            clear: tells of sample k's postures which keep clear of what stands around.
        """
        way, last = self._both(middles, yaw, apart), len(middles) - 1
        # An arm that does not get along alone need not be looked at beside the other, nor postures that lead nowhere.
        alone, arms = zip(*(_on_the_way(list(samples)) for samples in zip(*way, strict=True)), strict=True)
        if min(alone) < len(way):
            return min(alone)
        way = [list(sample) for sample in zip(*arms, strict=True)]
        pairs = cache(partial(self._free, way))
        # Where a way comes to an end its neighbours mostly do, too.
        for k in (min(self._failed, last), last):
            if not pairs(k)[1].any():
                return k
        got = _joined_up(map(pairs, range(len(way))))
        if got < len(way):
            self._failed = got
            return got
        if clear is None:
            return got
        if not self._kept(clear, last, pairs(last))[1].any():
            return last
        return _joined_up(self._kept(clear, k, pairs(k)) for k in range(len(way)))

    def _free(self, way: list[list[Postures]], k: int) -> Pairs:
        """Sample k's pairs, and which of them keep the clearance."""
        return way[k], ~self._checker.overlapping(*(q for q, _ in way[k]), self._clearance)

    @staticmethod
    def _kept(clear: Clear, k: int, pairs: Pairs) -> Pairs:
        """Sample k's without those that are not clear."""
        now, free = pairs
        some = [np.flatnonzero(free.any(axis=1 - arm)) for arm in (0, 1)]
        if min(map(len, some)):
            kept = free.copy()
            kept[np.ix_(*some)] &= clear(k, *(q[rows] for (q, _), rows in zip(now, some, strict=True)))
            free = kept
        return now, free

    def _both(self, middles: np.ndarray, yaw: np.ndarray, apart: np.ndarray) -> list[list[Postures]]:
        """Both arms' `_postures` at the samples of a way, as of `reached`."""
        normals = np.stack([np.cos(yaw), np.sin(yaw), np.zeros(len(yaw))], axis=-1)
        aside = 0.5 * np.asarray(apart)[:, None] * normals
        arms = [self._postures(arm, middles + sign * aside, -sign * normals) for arm, sign in enumerate((-1.0, 1.0))]
        return [list(sample) for sample in zip(*arms, strict=True)]

    def _postures(self, arm: int, palms: np.ndarray, normals: np.ndarray) -> list[Postures]:
        """An arm's at each of K palms (K, 3), m in W, that face the ways (K, 3)."""
        found = self._ik.postures(arm, palms, normals, self._angles)
        inner = self._ik.within_limits(arm, found)
        return [(q[within], np.argwhere(within)) for q, within in zip(found, inner, strict=True)]


def _on_the_way(samples: list[Postures]) -> tuple[int, list[Postures]]:
    """How many samples an arm alone gets to from the first; and of each the postures that lie on a way to the last."""
    forth = _passed(samples)
    got = next((k for k, reached in enumerate(forth) if not reached.any()), len(samples))
    if got < len(samples):
        return got, samples
    both = [one & other for one, other in zip(forth, reversed(_passed(samples[::-1])), strict=True)]
    return got, [(q[kept], places[kept]) for (q, places), kept in zip(samples, both, strict=True)]


def _passed(samples: Sequence[Postures]) -> list[np.ndarray]:
    """Which postures of each sample an arm alone gets to from the first one's."""
    passed, before, there = [], samples[0], np.ones(len(samples[0][0]), dtype=bool)
    for now in samples:
        there = (there.astype(np.float32) @ _joined(before, now)) > 0
        there = _grown(there[:, None], np.ones((len(there), 1), dtype=bool), _joined(now, now), _ALONE)[:, 0]
        passed.append(there)
        before = now
    return passed


def _joined_up(samples: Iterable[Pairs]) -> int:
    """How many samples are got to from the first, from pair to pair of those that are free."""
    before, there, k = [], np.empty((0, 0), dtype=bool), -1
    for k, (now, free) in enumerate(samples):
        if k:
            left, right = (_joined(*two) for two in zip(before, now, strict=True))
            there = (left.T @ there.astype(np.float32) @ right > 0) & free
        else:
            there = free
        there = _grown(there, free, *(_joined(one, one) for one in now))
        if not there.any():
            return k
        before = now
    return k + 1


def _joined(one: Postures, other: Postures) -> np.ndarray:
    """Which of n postures an arm gets to from which of m without passing others: (n, m), 0 or 1."""
    (q, places), (other_q, other_places) = one, other
    turned = np.abs(places[:, None, 0] - other_places[:, 0])
    beside = np.minimum(turned, ANGLES - turned) <= 1
    same = places[:, None, 1] == other_places[:, 1]
    moved = np.abs(q[:, None] - other_q).max(axis=-1, initial=0.0)
    # What differs by more than half a turn has a joint's limits on the way.
    return ((beside & same & (moved < np.pi)) | (moved <= ALIKE)).astype(np.float32)


def _grown(there: np.ndarray, free: np.ndarray, left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """The pairs (n, m) that are got to from some by turning elbows, of those that are free."""
    while there.any():
        more = (left @ there.astype(np.float32) @ right > 0) & free
        if np.array_equal(more, there):
            break
        there = more
    return there
