"""Distances of the nearest pairs of links and how joint velocities change them, to keep the moving arms apart."""

import numpy as np
from pydrake.geometry import FrameId, GeometryId
from pydrake.multibody.tree import JacobianWrtVariable

from drake_blfdmp.robot.braking import braking_speed
from drake_blfdmp.robot.clearance import ClearanceChecker
from drake_blfdmp.robot.plant import JOINTS_PER_ARM

INFLUENCE = 0.1
"""Pairs farther than this beyond the clearance, m, are not looked at."""

MOST_PAIRS = 8
"""Of the pairs only the nearest count: their Jacobians are what costs time."""

REFRESH = 0.01
"""How far a joint may move, rad, until distances are looked up anew and not carried on by their gradients."""

CARRIED = 6e-4
"""By how much, m, the clearance is widened to pay for that: how far it errs (measured in the tests)."""

NEAR_SIZE = 2 * JOINTS_PER_ARM + MOST_PAIRS * (1 + 2 * JOINTS_PER_ARM)
"""Numbers in a record of `PairClearance.near`."""

RECEDE = 0.1
"""Largest speed with which a pair that is too near is moved apart, m/s."""


class PairClearance(ClearanceChecker):
    """Velocity dampers between what must not touch, among both arms and their pedestals (`ClearanceChecker`).

    A pair at distance d may come nearer at V(d - clearance) (`braking`), which near the clearance is
    gain * (d - clearance), Faverjon and Tournassoud's velocity damper; a pair that is too near has to part.
    """

    def __init__(self, clearance: float):
        """Builds the scene.

        Args:
            clearance: least distance to be kept, m.

        Raises:
            TaskError: `clearance` is not such that the pairs can be looked at.
        """
        super().__init__(max_distance=clearance + INFLUENCE)
        self._clearance = clearance + CARRIED
        self._columns = []
        for arm in self._arms:
            first = self.plant.GetJointByName("panda_joint1", arm).velocity_start()
            self._columns.extend(range(first, first + JOINTS_PER_ARM))

    def pairs(self, q) -> tuple[np.ndarray, np.ndarray]:
        """Distances (m,), m, of near pairs, the nearest first, and their gradients (m, 14), m/rad, at q (14,), rad."""
        for arm, q_arm in zip(self._arms, (q[:JOINTS_PER_ARM], q[JOINTS_PER_ARM:]), strict=True):
            self.plant.SetPositions(self._plant_context, arm, q_arm)
        query = self._query_port.Eval(self._scene_context)
        inspector = query.inspector()
        found = query.ComputeSignedDistancePairwiseClosestPoints(self._max_distance)
        found = sorted(found, key=lambda pair: pair.distance)[:MOST_PAIRS]
        rows = np.zeros((len(found), len(self._columns)))
        for row, pair in zip(rows, found, strict=True):
            for id, point, sign in ((pair.id_A, pair.p_ACa, 1.0), (pair.id_B, pair.p_BCb, -1.0)):
                row += sign * (pair.nhat_BA_W @ self._point_jacobian(inspector, id, point))
        return np.array([pair.distance for pair in found]), rows

    def near(self, q, known=None) -> np.ndarray:
        """A record (NEAR_SIZE,) of the near pairs at q (14,), rad, or near it: that posture, their distances and rows.

        Args:
            known: an earlier record, which is handed back where no joint has moved by more than REFRESH since.
        """
        if known is not None and np.all(np.abs(q - known[: len(self._columns)]) <= REFRESH):
            return known
        distances, rows = self.pairs(q)
        record = np.zeros(NEAR_SIZE)
        record[: len(q)], record[len(q) : len(q) + MOST_PAIRS] = q, np.inf
        record[len(q) : len(q) + len(distances)] = distances
        record[len(q) + MOST_PAIRS :][: rows.size] = rows.ravel()
        return record

    def carried_on(self, record, q) -> tuple[np.ndarray, np.ndarray]:
        """What `pairs` returns, at q (14,), from a record of `near`: distances go on by their gradients."""
        n = len(self._columns)
        distances = record[n : n + MOST_PAIRS]
        count = int(np.isfinite(distances).sum())
        rows = record[n + MOST_PAIRS :].reshape(MOST_PAIRS, n)[:count]
        return distances[:count] + rows @ (q - record[:n]), rows

    def _point_jacobian(self, inspector, id: GeometryId, point) -> np.ndarray:
        frame_id: FrameId = inspector.GetFrameId(id)
        frame, world = self.plant.GetBodyFromFrameId(frame_id).body_frame(), self.plant.world_frame()
        at = inspector.GetPoseInFrame(id) @ point
        jacobian = self.plant.CalcJacobianTranslationalVelocity(
            self._plant_context, JacobianWrtVariable.kV, frame, at, world, world
        )
        return jacobian[:, self._columns]

    def least_rates(self, distances, rows, gain: float, acceleration, time_step: float) -> np.ndarray:
        """The least rates of change (m,), m/s, of distances (m,) with gradients `rows` (m, 14).

        Args:
            distances: m.
            rows: m/rad.
            gain: 1/s.
            acceleration: (14,) with which the joints can brake, rad/s^2.
            time_step: s.
        """
        room = distances - self._clearance
        braking = np.abs(rows) @ np.minimum(acceleration, 1e6)
        return np.where(room >= 0.0, -braking_speed(room, gain, braking, time_step), np.minimum(-gain * room, RECEDE))
