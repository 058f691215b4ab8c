"""Whether two arms get along a way in one go: postures for every sample, free of overlap, each near the one before.

At a sample a palm that faces a given way leaves an arm one freedom, the swivel of its elbow, beside a finite number of
branches; the roll of the palm is joint 7's alone and moves no body. So an arm's postures are found on a grid of swivel
angles, from many starts, and pairs of them are joined from sample to sample. What is asked for is less than a plan
needs: elbows are where they like, they may jump by `MOVE` between samples, bodies may touch, no margin from limits.
"""

from collections.abc import Sequence

import numpy as np
from pydrake.math import RotationMatrix

from drake_blfdmp.robot.clearance import ClearanceChecker
from drake_blfdmp.robot.kinematics import DualArmKinematics
from drake_blfdmp.robot.plant import ARMS, HOME, JOINTS_PER_ARM, MakeKinematicPlant, ReadJointLimits
from drake_blfdmp.robot.posture import newton_postures

SWIVELS = 24
"""Angles of an elbow that are looked at, all around."""

STARTS = 8
"""Postures that Newton's method starts from at each of them, beside those found for the sample before."""

ITERATIONS = 30
"""Of Newton's method from each."""

ALIKE = 0.05
"""Postures that differ by less, rad, are taken for one."""

FEW = 40
"""Pairs of postures a sample that an easy way is got along with."""

BEFORE, AFTER = 4, 3
"""Samples around the one at which another way was at an end, that a way is looked at first."""

MOVE = 0.8
"""A joint that moves by more from a sample to the next, rad, jumps."""

Sample = tuple[np.ndarray, np.ndarray, float]
"""The middle between the palms (3,), m in W, the direction (3,) from left to right, and the palms' distance, m."""


class JoinedPostures:
    """Looks for two arms' postures along a way."""

    def __init__(self, seed: int = 0):
        """Starts are drawn from a seed."""
        plant = MakeKinematicPlant()
        self._kinematics = DualArmKinematics(plant)
        limits = ReadJointLimits(plant, [plant.GetModelInstanceByName(arm) for arm in ARMS])
        self._lower, self._upper = (array.reshape(2, JOINTS_PER_ARM) for array in (limits.lower, limits.upper))
        self._checker = ClearanceChecker(max_distance=0.02)
        rng = np.random.default_rng(seed)
        starts = rng.uniform(self._lower[:, None], self._upper[:, None], (2, STARTS, JOINTS_PER_ARM))
        starts[:, 0], starts[..., JOINTS_PER_ARM - 1] = HOME, 0.0
        self._starts = starts
        self._failed = 0

    def get_along(self, middles: np.ndarray, yaw: np.ndarray, apart: np.ndarray) -> bool:
        """Whether the arms get to the end of a way; args as of `reached`.

        Looks first where the way before was at an end: on its neighbour it mostly is, too.
        """
        near = slice(max(self._failed - BEFORE, 0), self._failed + AFTER)
        window = _way(middles, yaw, apart)[near]
        if self._failed and window and self._reached(window, capsules=True)[0] < len(window):
            return False
        got = self.reached(middles, yaw, apart)
        if got < len(middles):
            self._failed = got
        return got == len(middles)

    def reached(self, middles: np.ndarray, yaw: np.ndarray, apart: np.ndarray) -> int:
        """How many samples the arms get along a way at most; all K only where they get to its end.

        Args:
            middles: (K, 3) between the palms, m in W.
            yaw: (K,) of the line between the palms, left to right, rad.
            apart: (K,) the palms' distance, m.
        """
        way = _way(middles, yaw, apart)
        # Capsules overlap or do not in all pairs at once, so they are asked first.
        got, _ = self._reached(way, capsules=True)
        if got < len(way):
            return got
        # Where it is easy a few pairs do; only where there were more is what fails so looked at in full.
        got, all_pairs = self._reached(way, most=FEW)
        return got if all_pairs or got == len(way) else self._reached(way)[0]

    def _reached(self, way: Sequence[Sample], *, capsules: bool = False, most: int | None = None) -> tuple[int, bool]:
        """How many samples the arms get along.

        Args:
            way: its samples.
            capsules: only capsules count.
            most: so many pairs of postures a sample at most; None: all.

        Returns:
            The number, and whether no pair was left out.
        """
        all_pairs = True
        before, there = [np.empty((0, JOINTS_PER_ARM))] * 2, np.empty((0, 0), dtype=bool)
        for k, sample in enumerate(way):
            now = self._both(sample, before)
            if k == 0:
                possible = np.ones([len(postures) for postures in now], dtype=bool)
            else:
                left, right = (_near(*two) for two in zip(before, now, strict=True))
                possible = (left.T.astype(int) @ there.astype(int) @ right.astype(int)) > 0
            there = possible & ~self._checker.overlapping(*now) if possible.any() else possible
            if not capsules:
                there = self._free(now, there, most)
            if not there.any():
                return k, all_pairs
            all_pairs = all_pairs and (most is None or there.sum() < most)
            before = now
        return len(way), all_pairs

    def _both(self, sample: Sample, before: Sequence[np.ndarray]) -> list[np.ndarray]:
        """Both arms' `_postures` at a sample."""
        middle, normal, apart = sample
        return [
            self._postures(arm, middle + sign * 0.5 * apart * normal, -sign * normal, before[arm])
            for arm, sign in enumerate((-1.0, 1.0))
        ]

    def _postures(self, arm: int, palm: np.ndarray, normal: np.ndarray, before: np.ndarray) -> np.ndarray:
        """An arm's postures (n, 7) at a palm's position and normal, joint 7 at 0."""
        if np.linalg.norm(palm - self._kinematics.shoulders[arm]) > self._kinematics.arm_length[arm]:
            return np.empty((0, JOINTS_PER_ARM))
        starts = np.concatenate([before, self._starts[arm]])
        swivels = np.repeat(np.linspace(-np.pi, np.pi, SWIVELS, endpoint=False), len(starts))
        guesses, count = np.tile(starts, (SWIVELS, 1)), len(swivels)
        quaternion = RotationMatrix.MakeFromOneVector(normal, 2).ToQuaternion().wxyz()
        pose = np.tile(np.concatenate([quaternion, palm]), (count, 1))
        q, solved = newton_postures(self._kinematics, np.full(count, arm), guesses, pose, swivels, ITERATIONS)
        lower, upper = self._lower[arm], self._upper[arm]
        q = lower + (q[solved] - lower) % (2.0 * np.pi)
        q = q[((q >= lower) & (q <= upper)).all(axis=1)]
        return q[np.unique(np.round(q / ALIKE), axis=0, return_index=True)[1]]

    def _free(self, postures: Sequence[np.ndarray], possible: np.ndarray, most: int | None) -> np.ndarray:
        """Those of the possible pairs in which nothing overlaps; the first so many in a random order."""
        free, pairs = np.zeros_like(possible), np.argwhere(possible)
        for left, right in pairs if most is None else np.random.default_rng(0).permutation(pairs):
            q = np.concatenate([postures[0][left], postures[1][right]])
            free[left, right] = self._checker.min_clearance(q)[0] >= 0.0
            if most is not None and free.sum() >= most:
                break
        return free


def _way(middles: np.ndarray, yaw: np.ndarray, apart: np.ndarray) -> list[Sample]:
    """The samples of a way, as of `JoinedPostures.reached`."""
    normals = np.stack([np.cos(yaw), np.sin(yaw), np.zeros(len(yaw))], axis=-1)
    return list(zip(middles, normals, apart, strict=True))


def _near(before: np.ndarray, now: np.ndarray) -> np.ndarray:
    """Which of n postures lie near which of m: (n, m)."""
    return np.abs(before[:, None] - now).max(axis=-1, initial=0.0) <= MOVE
