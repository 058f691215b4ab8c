"""Palm poses, Jacobians and swivel angles of both arms, from Drake's kinematics."""

from typing import NamedTuple

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import JacobianWrtVariable

from drake_blfdmp.robot.plant import ARMS, JOINTS_PER_ARM, MakeKinematicPlant
from drake_blfdmp.robot.swivel import swivel_angle, swivel_jacobians


class ArmState(NamedTuple):
    """Kinematics of one arm at one configuration, in W.

    Attributes:
        rotation: (3, 3) R_WP of the palm.
        position: (3,) p_WP, m.
        jacobian: (6, 7) of the palm's twist, angular above translational.
        swivel: psi, rad.
        swivel_jacobian: (7,) J_psi.
    """

    rotation: np.ndarray
    position: np.ndarray
    jacobian: np.ndarray
    swivel: float
    swivel_jacobian: np.ndarray


class DualArmKinematics:
    """Kinematics of the two arms; holds a plant of its own and its context."""

    def __init__(self, plant: MultibodyPlant | None = None):
        """Use a finalized plant with both arms and nothing else that moves; one is made when none is given."""
        self._plant = plant or MakeKinematicPlant()
        self._context = self._plant.CreateDefaultContext()
        self._world = self._plant.world_frame()
        self._frames = []
        self._columns = []
        for arm in ARMS:
            instance = self._plant.GetModelInstanceByName(arm)
            names = ("palm", "shoulder", "elbow", "wrist")
            self._frames.append([self._plant.GetFrameByName(name, instance) for name in names])
            first = self._plant.GetJointByName("panda_joint1", instance).velocity_start()
            self._columns.append(slice(first, first + JOINTS_PER_ARM))

    def evaluate(self, q: np.ndarray) -> tuple[ArmState, ArmState]:
        """Both arms at q (14,)."""
        plant, context, world = self._plant, self._context, self._world
        plant.SetPositions(context, q)
        states = []
        for (palm, *points), columns in zip(self._frames, self._columns, strict=True):
            jacobian = plant.CalcJacobianSpatialVelocity(
                context, JacobianWrtVariable.kV, palm, np.zeros(3), world, world
            )[:, columns]
            X_WP = palm.CalcPoseInWorld(context)
            p_palm = X_WP.translation()
            shoulder, elbow, wrist = (frame.CalcPoseInWorld(context).translation() for frame in points)
            je, jw = swivel_jacobians(shoulder, elbow, wrist)
            # Joints 1-3 carry the elbow, joints 1-5 the wrist, as rigidly as they carry the palm.
            omega, v = jacobian[:3].T, jacobian[3:].T
            swivel_jacobian = np.zeros(JOINTS_PER_ARM)
            swivel_jacobian[:3] = v[:3] @ je + omega[:3] @ np.cross(elbow - p_palm, je)
            swivel_jacobian[:5] += v[:5] @ jw + omega[:5] @ np.cross(wrist - p_palm, jw)
            psi = float(swivel_angle(shoulder, elbow, wrist))
            states.append(ArmState(X_WP.rotation().matrix(), p_palm, jacobian, psi, swivel_jacobian))
        return states[0], states[1]
