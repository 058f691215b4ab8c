"""Kinematics of many postures at once: the arms' chains read from a plant, as products of arrays."""

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import MultibodyPlant

from drake_blfdmp.robot.plant import ARMS, JOINTS_PER_ARM
from drake_blfdmp.robot.swivel import swivel_angle, swivel_jacobians
from drake_blfdmp.vectors import cross, dot

ELBOW_CARRIED_BY, WRIST_CARRIED_BY = 3, 5
"""So many joints move the elbow, and the wrist."""


class ArmChains:
    """What `DualArmKinematics` says of one posture, for n postures of either arm, ten times as fast for n = 24.

    Each joint turns about the z axis of its frame M_k; at angle zero X_M(k-1)Mk is constant. Elbow, wrist and palm are
    fixed in M_3, M_5 and M_7.
    """

    def __init__(self, plant: MultibodyPlant):
        """Of a finalized plant with both arms, their bases welded to the world."""
        context = plant.CreateDefaultContext()
        plant.SetPositions(context, np.zeros(plant.num_positions()))
        self._turns, self._offsets = np.empty((2, JOINTS_PER_ARM, 3, 3)), np.empty((2, JOINTS_PER_ARM, 3))
        self._points = np.empty((3, 2, 3))  # The elbow in M_3, the wrist in M_5, the palm in M_7.
        self._palm, self._shoulders = np.empty((2, 3, 3)), np.empty((2, 3))
        for arm, name in enumerate(ARMS):
            instance = plant.GetModelInstanceByName(name)
            X_WM = [RigidTransform()]
            for k in range(JOINTS_PER_ARM):
                joint = plant.GetJointByName(f"panda_joint{k + 1}", instance)
                z = RotationMatrix.MakeFromOneVector(np.asarray(joint.revolute_axis()), 2)
                X_WM.append(joint.frame_on_child().CalcPoseInWorld(context) @ RigidTransform(z, np.zeros(3)))
                between = X_WM[-2].inverse() @ X_WM[-1]
                self._turns[arm, k] = between.rotation().matrix()
                self._offsets[arm, k] = between.translation()
            frames = {key: plant.GetFrameByName(key, instance) for key in ("shoulder", "elbow", "wrist", "palm")}
            poses = {key: frame.CalcPoseInWorld(context) for key, frame in frames.items()}
            carried = (ELBOW_CARRIED_BY, "elbow"), (WRIST_CARRIED_BY, "wrist"), (JOINTS_PER_ARM, "palm")
            for i, (k, key) in enumerate(carried):
                self._points[i, arm] = (X_WM[k].inverse() @ poses[key]).translation()
            self._palm[arm] = (X_WM[-1].inverse() @ poses["palm"]).rotation().matrix()
            self._shoulders[arm] = poses["shoulder"].translation()

    def evaluate(self, arm: np.ndarray, q: np.ndarray):
        """The fields of an `ArmState` with a leading axis: rotation, position, jacobian, swivel, swivel_jacobian.

        Args:
            arm: (n,) 0 for the left arm, 1 for the right one.
            q: (n, 7) its joints, rad.
        """
        n = len(q)
        rotation, origin = np.broadcast_to(np.eye(3), (n, 3, 3)), np.zeros((n, 3))
        axes, origins, points = np.empty((n, 7, 3)), np.empty((n, 7, 3)), []
        turns, offsets = self._turns[arm], self._offsets[arm]
        cosine, sine = np.cos(q)[:, :, None], np.sin(q)[:, :, None]
        for k in range(JOINTS_PER_ARM):
            origin = origin + (rotation @ offsets[:, k, :, None])[..., 0]
            still = rotation @ turns[:, k]
            rotation = np.empty_like(still)
            rotation[..., 0] = still[..., 0] * cosine[:, k] + still[..., 1] * sine[:, k]
            rotation[..., 1] = still[..., 1] * cosine[:, k] - still[..., 0] * sine[:, k]
            rotation[..., 2] = still[..., 2]
            axes[:, k], origins[:, k] = rotation[..., 2], origin
            if k + 1 in (ELBOW_CARRIED_BY, WRIST_CARRIED_BY, JOINTS_PER_ARM):
                points.append(origin + (rotation @ self._points[len(points)][arm][..., None])[..., 0])
        elbow, wrist, palm = points
        shoulder = self._shoulders[arm]
        jacobian = np.empty((n, 6, JOINTS_PER_ARM))
        jacobian[:, :3] = axes.swapaxes(1, 2)
        jacobian[:, 3:] = cross(axes, palm[:, None] - origins).swapaxes(1, 2)
        d_elbow, d_wrist = swivel_jacobians(shoulder, elbow, wrist)
        swivel_jacobian = np.zeros((n, JOINTS_PER_ARM))
        for k, point, slope in ((ELBOW_CARRIED_BY, elbow, d_elbow), (WRIST_CARRIED_BY, wrist, d_wrist)):
            swivel_jacobian[:, :k] += dot(cross(axes[:, :k], point[:, None] - origins[:, :k]), slope[:, None])
        return rotation @ self._palm[arm], palm, jacobian, swivel_angle(shoulder, elbow, wrist), swivel_jacobian
