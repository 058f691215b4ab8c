"""Whether two arms get along a way in one go: postures for every sample, free of overlap, joined to those before.

At a sample a palm that faces a given way leaves an arm one freedom, the wrist's angle about the palm's normal, beside
eight branches; the roll of the palm is joint 7's alone and moves no body. So an arm's postures are those on a grid of
such angles, in closed form. Pairs of both arms' postures are joined from sample to sample and, as the palms may wait
for the elbows, within a sample. What is asked for is less than a plan needs: elbows are where they like and take their
time, bodies may touch, no margin from limits.
"""

from collections.abc import Sequence

import numpy as np

from drake_blfdmp.robot.box import TableParameters
from drake_blfdmp.robot.clearance import ClearanceChecker
from drake_blfdmp.robot.closed_form_ik import ClosedFormIk
from drake_blfdmp.robot.plant import MakeKinematicPlant

ANGLES = 72
"""Of a wrist about the palm's normal that are looked at, all around."""

ALIKE = 0.3
"""Postures in which no joint differs by more, rad, are joined whatever their branches: these meet where an arm is
singular.
"""

Sample = tuple[np.ndarray, np.ndarray, float]
"""The middle between the palms (3,), m in W, the direction (3,) from left to right, and the palms' distance, m."""

Postures = tuple[np.ndarray, np.ndarray]
"""An arm's postures (n, 7), joint 7 at 0, rad, and their angles and branches (n, 2)."""

Pairs = tuple[list[Postures], np.ndarray]
"""Both arms' postures at a sample, and which pairs of them are free of overlap (n, m)."""


class JoinedPostures:
    """Looks for two arms' postures along a way."""

    def __init__(self):
        """Of the two arms as they stand."""
        self._ik = ClosedFormIk(MakeKinematicPlant())
        self._angles = np.linspace(-np.pi, np.pi, ANGLES, endpoint=False)
        self._checker = ClearanceChecker(max_distance=0.02)
        self._failed = 0

    def get_along(
        self, middles: np.ndarray, yaw: np.ndarray, apart: np.ndarray, tables: Sequence[TableParameters] = ()
    ) -> bool:
        """Whether the arms get to the end of a way; args as of `reached`."""
        return self.reached(middles, yaw, apart, tables) == len(middles)

    def reached(
        self, middles: np.ndarray, yaw: np.ndarray, apart: np.ndarray, tables: Sequence[TableParameters] = ()
    ) -> int:
        """How many samples the arms get along a way; all K only where they get to its end.

        A sample without any posture counts as the first that is not got to, whatever lies before it.

        Args:
            middles: (K, 3) between the palms, m in W.
            yaw: (K,) of the line between the palms, left to right, rad.
            apart: (K,) the palms' distance, m.
            tables: that the links do not get into.
        """
        way, known = _way(middles, yaw, apart), {}
        # Where a way comes to an end its neighbours mostly do, too.
        for k in sorted(range(len(way)), key=lambda k: abs(k - self._failed)):
            known[k] = self._free(way[k])
            if not known[k][1].any():
                self._failed = k
                return k
        in_order = [known[k] for k in range(len(way))]
        got = _joined_up(in_order)
        if got < len(way):
            return got
        around = ClearanceChecker(tables, max_distance=0.02, among_arms=False)
        return _joined_up([(now, free & _clear(around, *(q for q, _ in now))) for now, free in in_order])

    def _free(self, sample: Sample) -> Pairs:
        now = self._both(sample)
        postures = [q for q, _ in now]
        free = np.zeros([len(q) for q in postures], dtype=bool)
        return now, ~self._checker.overlapping(*postures) if free.size else free

    def _both(self, sample: Sample) -> list[Postures]:
        """Both arms' `_postures` at a sample."""
        middle, normal, apart = sample
        return [
            self._postures(arm, middle + sign * 0.5 * apart * normal, -sign * normal)
            for arm, sign in enumerate((-1.0, 1.0))
        ]

    def _postures(self, arm: int, palm: np.ndarray, normal: np.ndarray) -> Postures:
        q = self._ik.postures(arm, palm, normal, self._angles)
        within = self._ik.within_limits(arm, q)
        return q[within], np.argwhere(within)


def _way(middles: np.ndarray, yaw: np.ndarray, apart: np.ndarray) -> list[Sample]:
    """The samples of a way, as of `JoinedPostures.reached`."""
    normals = np.stack([np.cos(yaw), np.sin(yaw), np.zeros(len(yaw))], axis=-1)
    return list(zip(middles, normals, apart, strict=True))


def _joined_up(samples: Sequence[Pairs]) -> int:
    """How many samples are got to from the first, from pair to pair of those that are free."""
    before, there = [], np.empty((0, 0), dtype=bool)
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
    return len(samples)


def _joined(one: Postures, other: Postures) -> np.ndarray:
    """Which of n postures an arm gets to from which of m without passing others: (n, m), 0 or 1."""
    (q, places), (other_q, other_places) = one, other
    turned = np.abs(places[:, None, 0] - other_places[:, 0])
    beside = np.minimum(turned, ANGLES - turned) <= 1
    same = places[:, None, 1] == other_places[:, 1]
    alike = np.abs(q[:, None] - other_q).max(axis=-1, initial=0.0) <= ALIKE
    return ((beside & same) | alike).astype(np.float32)


def _grown(there: np.ndarray, free: np.ndarray, left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """The pairs (n, m) that are got to from some by turning elbows, of those that are free."""
    while there.any():
        more = (left @ there.astype(np.float32) @ right > 0) & free
        if np.array_equal(more, there):
            break
        there = more
    return there


def _clear(around: ClearanceChecker, left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Which pairs of n and m postures overlap nothing that stands around: (n, m)."""
    clear = np.zeros((2, max(len(left), len(right))), dtype=bool)
    for i in range(clear.shape[1]):
        both = np.concatenate([left[min(i, len(left) - 1)], right[min(i, len(right) - 1)]])
        clear[:, i] = around.link_clearances(both) >= 0.0
    return clear[0, : len(left), None] & clear[1, : len(right)]
