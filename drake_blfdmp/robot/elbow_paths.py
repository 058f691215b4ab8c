"""Ways of both elbows that keep the arms off each other, where the person's own do not; of all of them the best.

A palm that faces a given way leaves an arm one freedom (`closed_form_ik`). On a grid of it every posture of a sample is
known, and so is which pairs of a left and a right one keep clear of each other. From the first sample to the last the
cheapest chain of pairs is found by dynamic programming: the joints move little, the elbows are near the person's.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from drake_blfdmp.robot.box import BoxParameters, TableParameters
from drake_blfdmp.robot.clearance import ClearanceChecker
from drake_blfdmp.robot.closed_form_ik import ClosedFormIk
from drake_blfdmp.robot.kinematics import DualArmKinematics
from drake_blfdmp.robot.plant import JOINTS_PER_ARM, JointLimits, MakeKinematicPlant
from drake_blfdmp.robot.rigid import rigid
from drake_blfdmp.robot.swivel import wrap
from drake_blfdmp.robot.tracking import bent_limits, rotation_matrix

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
        self._checker = ClearanceChecker(tables, box, max_distance=2.0 * clearance, among_arms=False)
        self._poses, self._clearance = poses, clearance

    def cleared(self, k: int, sample: _Sample) -> _Sample:
        """Sample k without the pairs of which one is too near."""
        X_WB = rigid(self._poses[k])
        counts = [len(postures) for postures in sample.postures]
        clear = [np.zeros(count, dtype=bool) for count in counts]
        for i in range(max(counts)):
            pair = [min(i, count - 1) for count in counts]
            distances = self._checker.link_clearances(_both(sample, *pair), X_WB)
            for arm in (0, 1):
                clear[arm][pair[arm]] = distances[arm] >= self._clearance
        return sample._replace(free=sample.free & clear[0][:, None] & clear[1])


class ElbowPaths:
    """Looks for both elbows' ways along paths of palm poses."""

    def __init__(
        self,
        kinematics: DualArmKinematics,
        limits: JointLimits,
        checker: ClearanceChecker,
        joint_margin: float,
        clearance: float,
    ):
        """Keep a margin from the joints' limits, rad, and a clearance of the arms among themselves, m."""
        self._ik = ClosedFormIk(MakeKinematicPlant())
        bent = bent_limits(limits, kinematics.straight_elbow)
        self._lower = bent.lower.reshape(2, JOINTS_PER_ARM) + joint_margin
        self._upper = bent.upper.reshape(2, JOINTS_PER_ARM) - joint_margin
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
        known: dict[int, _Sample] = {}
        # Where a way comes to an end its neighbours mostly do, too.
        for k in sorted(range(len(pose)), key=lambda k: abs(k - self._failed)):
            known[k] = self._sample(pose[k], swivel[k])
            if not known[k].free.any():
                self._failed = k
                return None
        samples = [known[k] for k in range(len(pose))]
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
                palms = pose[:, k, arm, 4:]
                normals = np.moveaxis(rotation_matrix(np.moveaxis(pose[:, k, arm, :4], -1, 0))[:, 2], 0, -1)
                there &= self._ik.may_reach(arm, palms, normals)
                left = np.flatnonzero(there)
                for rows in np.split(left, range(CHUNK, len(left), CHUNK)):
                    q = self._ik.postures(arm, palms[rows], normals[rows], self._angles)
                    there[rows] = self._inner(arm, q).any(axis=(1, 2))
        return there

    def _inner(self, arm: int, q: np.ndarray) -> np.ndarray:
        return np.all((q >= self._lower[arm]) & (q <= self._upper[arm]), axis=-1)

    def _sample(self, palms, swivel) -> _Sample:
        postures, places, costs = [], [], []
        for arm, palm in enumerate(palms):
            q = self._ik.postures(arm, palm[4:], rotation_matrix(palm[:4])[:, 2], self._angles)
            inner = self._inner(arm, q)
            q, place = q[inner], np.argwhere(inner)
            psi = self._kinematics.chains.evaluate(np.full(len(q), arm), q)[3]
            up = np.abs(wrap(np.pi - psi)) <= FARTHEST_SWING
            postures.append(q[up])
            places.append(place[up])
            costs.append(AS_THE_PERSON * wrap(psi[up] - swivel[arm]) ** 2)
        free = np.zeros([len(q) for q in postures], dtype=bool)
        if free.size:
            free = ~self._checker.overlapping(*postures, self._clearance)
        return _Sample(postures, places, costs, free)


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


def _steps(before: _Sample, now: _Sample, arm: int) -> np.ndarray:
    """The costs (n, m) of going from an arm's postures to those of the next sample: infinite for a jump."""
    moved = before.postures[arm][:, None] - now.postures[arm]
    (angle, branch), (next_angle, next_branch) = (sample.places[arm].T for sample in (before, now))
    turned = np.abs((angle[:, None] - next_angle + ANGLES // 2) % ANGLES - ANGLES // 2)
    near = (turned <= TURN) & (branch[:, None] == next_branch)
    return np.where(near, (moved**2).sum(axis=-1), np.inf)
