"""Ways of both elbows that keep the arms off each other, where the person's own do not; of all of them the best.

A palm that faces a given way leaves an arm one freedom (`closed_form_ik`). On a grid of it every posture of a sample is
known, and so is which pairs of a left and a right one keep clear of each other. From the first sample to the last the
cheapest chain of pairs is found by dynamic programming: the joints move little, the elbows are near the person's.
"""

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from drake_blfdmp.robot.box import BoxParameters, TableParameters
from drake_blfdmp.robot.clearance import ClearanceChecker
from drake_blfdmp.robot.closed_form_ik import ClosedFormIk
from drake_blfdmp.robot.kinematics import DualArmKinematics
from drake_blfdmp.robot.plant import JointLimits, MakeKinematicPlant
from drake_blfdmp.robot.rigid import rigid
from drake_blfdmp.robot.swivel import wrap
from drake_blfdmp.robot.tracking import rotation_matrix

ANGLES = 72
"""Of a wrist about the palm's normal that are looked at, all around."""

FARTHEST_SWING = np.deg2rad(115.0)
"""Of an elbow from straight up, rad: no arm on a pedestal holds it below (`Retarget.elbow_up`)."""

TURN = 3
"""So many of these angles a wrist may turn from a sample to the next, in its branch; else an arm would jump."""

AS_THE_PERSON = 0.02
"""Weight of an elbow's angle from the person's, against that of a joint's step."""

CHUNK = 256
"""So many palms are looked at at once."""


class _Sample(NamedTuple):
    """Postures (n, 7) and (m, 7) of both arms, their branches and angles (n, 2) and (m, 2), how far each is from the
    person's (n,) and (m,), and which pairs are free (n, m).
    """

    postures: list[np.ndarray]
    places: list[np.ndarray]
    costs: list[np.ndarray]
    free: np.ndarray


class Scene:
    """What stands around the arms along a path: tables, and a box that moves."""

    def __init__(self, tables: Sequence[TableParameters], box: BoxParameters, poses, clearance: float):
        """Keep a clearance, m, from the tables and from the box at poses (N, 7) X_WB, one a sample."""
        self._checker = ClearanceChecker(tables, box, max_distance=clearance + 0.02, among_arms=False)
        self._poses, self._clearance = poses, clearance

    def clear(self, k: int, left: np.ndarray, right: np.ndarray) -> np.ndarray:
        """Which pairs of n postures of the left arm and m of the right one are far enough from it at sample k.

        Args:
            left: (n, 7) rad, n > 0.
            right: (m, 7) rad, m > 0.

        Returns:
            (n, m) booleans.
        """
        X_WB = rigid(self._poses[k])
        clear = [np.zeros(len(postures), dtype=bool) for postures in (left, right)]
        for i in range(max(len(left), len(right))):
            pair = min(i, len(left) - 1), min(i, len(right) - 1)
            distances = self._checker.link_clearances(np.concatenate([left[pair[0]], right[pair[1]]]), X_WB)
            for arm in (0, 1):
                clear[arm][pair[arm]] = distances[arm] >= self._clearance
        return clear[0][:, None] & clear[1]

    def cleared(self, k: int, sample: _Sample) -> _Sample:
        """Sample k without the pairs of which one is too near."""
        return sample._replace(free=sample.free & self.clear(k, *sample.postures))


class ElbowPaths:
    """Looks for both elbows' ways along paths of palm poses."""

    def __init__(
        self,
        kinematics: DualArmKinematics,
        limits: JointLimits,
        checker: ClearanceChecker,
        clearance: float,
    ):
        """Stay within the joints' limits and keep a clearance of the arms among themselves, m."""
        self._ik = ClosedFormIk(MakeKinematicPlant(), limits)
        self._kinematics, self._checker, self._clearance = kinematics, checker, clearance
        self._angles = np.linspace(-np.pi, np.pi, ANGLES, endpoint=False)
        self._failed = 0

    def find(self, pose, swivel, scene: Callable[[], Scene] | None = None) -> np.ndarray | None:
        """The postures (N, 14), joint 7 at 0, rad, or None where there are none.

        Args:
            pose: (N, 2, 7) X_WP; the palms' rolls do not count.
            swivel: (N, 2) the person's swivel angles, rad.
            scene: makes what stands around, which the links keep clear of, too; asked where it matters.
        """
        samples = self._samples(np.asarray(pose), np.asarray(swivel))
        # An arm that does not get along alone need not be looked at beside the other.
        if not all(_passable(samples, arm) for arm in (0, 1)):
            return None
        # Where a way comes to an end its neighbours mostly do, too.
        for k in sorted(range(len(pose)), key=lambda k: abs(k - self._failed)):
            samples[k] = self._parted(samples[k])
            if not samples[k].free.any():
                self._failed = k
                return None
        chosen = _chain(samples)
        if scene is not None and len(chosen) == len(samples):
            around = scene()
            chosen = _chain([around.cleared(k, sample) for k, sample in enumerate(samples)])
        if len(chosen) < len(samples):
            return None
        return np.array([_both(sample, *pair) for sample, pair in zip(samples, chosen, strict=True)])

    def may_be(self, pose) -> np.ndarray:
        """Which of M paths (M, N, 2, 7) have postures for both arms at every sample: (M,)."""
        there, count = np.ones(len(pose), dtype=bool), pose.shape[1]
        # The ends first, then by halves: what lies between is mostly reached where its neighbours are.
        for k in sorted(range(count), key=lambda k: (0 < k < count - 1, -(k & -k))):
            for arm in (0, 1):
                palms, normals = pose[:, k, arm, 4:], _normals(pose[:, k, arm])
                there &= self._ik.may_reach(arm, palms, normals)
                left = np.flatnonzero(there)
                for rows in np.split(left, range(CHUNK, len(left), CHUNK)):
                    q = self._ik.postures(arm, palms[rows], normals[rows], self._angles)
                    there[rows] = self._ik.within_limits(arm, q).any(axis=(1, 2))
        return there

    def _samples(self, pose: np.ndarray, swivel: np.ndarray) -> list[_Sample]:
        """All postures at poses (N, 2, 7), and all pairs of them."""
        arms = [self._postures(arm, pose[:, arm], swivel[:, arm]) for arm in (0, 1)]
        return [
            _Sample(*map(list, zip(*both, strict=True)), np.ones([len(q) for q, *_ in both], dtype=bool))
            for both in zip(*arms, strict=True)
        ]

    def _postures(
        self, arm: int, pose: np.ndarray, swivel: np.ndarray
    ) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
        """An arm's at poses (N, 7): of each its postures, their places and costs, as in `_Sample`."""
        normals = _normals(pose)
        q = self._ik.postures(arm, pose[:, 4:], normals, self._angles)
        inner = np.argwhere(self._ik.within_limits(arm, q))
        q = q[tuple(inner.T)]
        psi = self._kinematics.chains.evaluate(np.full(len(q), arm), q)[3]
        up = np.abs(wrap(np.pi - psi)) <= FARTHEST_SWING
        inner, q, psi = inner[up], q[up], psi[up]
        costs = AS_THE_PERSON * wrap(psi - swivel[inner[:, 0]]) ** 2
        ends = np.searchsorted(inner[:, 0], np.arange(1, len(pose)))
        return list(zip(*(np.split(array, ends) for array in (q, inner[:, 1:], costs)), strict=True))

    def _parted(self, sample: _Sample) -> _Sample:
        """The sample without the pairs that are too near to each other, or an arm to itself."""
        if not sample.free.size:
            return sample
        return sample._replace(free=~self._checker.overlapping(*sample.postures, self._clearance))


def _normals(pose: np.ndarray) -> np.ndarray:
    """The palms' normals (N, 3) of X_WP (N, 7)."""
    return rotation_matrix(np.moveaxis(pose[:, :4], -1, 0))[:, 2].T


def _both(sample: _Sample, i: int, j: int) -> np.ndarray:
    return np.concatenate([sample.postures[0][i], sample.postures[1][j]])


def _chain(samples: Sequence[_Sample]) -> list[tuple[int, int]]:
    """The cheapest chain's indices of postures, sample by sample; as far as there is one."""
    total, before, back = np.empty((0, 0)), None, []
    for sample in samples:
        if before is None:
            reached = np.zeros(sample.free.shape)
        else:
            left, right = (_steps(before, sample, arm) for arm in (0, 1))
            if not min(left.shape[1], right.shape[1]):
                break
            ways = total[:, :, None] + right
            from_right = ways.argmin(axis=1)
            ways = left[:, :, None] + ways.min(axis=1)[:, None]
            from_left, reached = ways.argmin(axis=0), ways.min(axis=0)
        now = np.where(sample.free, reached + sample.costs[0][:, None] + sample.costs[1], np.inf)
        if not np.isfinite(now).any():
            break
        if before is not None:
            back.append((from_left, from_right))
        total, before = now, sample
    if before is None:
        return []
    i, j = (int(index) for index in np.unravel_index(total.argmin(), total.shape))
    chosen = [(i, j)]
    for from_left, from_right in reversed(back):
        i = int(from_left[i, j])
        j = int(from_right[i, j])
        chosen.append((i, j))
    return chosen[::-1]


def _passable(samples: Sequence[_Sample], arm: int) -> bool:
    """Whether an arm alone gets from the first sample to the last."""
    there = np.ones(len(samples[0].postures[arm]), dtype=bool)
    for before, now in pairwise(samples):
        there = np.isfinite(_steps(before, now, arm)[there]).any(axis=0)
    return bool(there.any())


def _steps(before: _Sample, now: _Sample, arm: int) -> np.ndarray:
    """The costs (n, m) of going from an arm's postures to those of the next sample: infinite for a jump."""
    moved = before.postures[arm][:, None] - now.postures[arm]
    (angle, branch), (next_angle, next_branch) = (sample.places[arm].T for sample in (before, now))
    turned = np.abs((angle[:, None] - next_angle + ANGLES // 2) % ANGLES - ANGLES // 2)
    # What differs by more than half a turn has a joint's limits on the way.
    near = (turned <= TURN) & (branch[:, None] == next_branch) & (np.abs(moved) < np.pi).all(axis=-1)
    return np.where(near, (moved**2).sum(axis=-1), np.inf)
