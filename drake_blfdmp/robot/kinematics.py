"""Palm poses, Jacobians and swivel angles of both arms, from Drake's kinematics."""

from typing import NamedTuple

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import JacobianWrtVariable

from drake_blfdmp.robot.arm_chains import ArmChains
from drake_blfdmp.robot.plant import ARMS, JOINTS_PER_ARM, MakeKinematicPlant
from drake_blfdmp.robot.swivel import swivel_angle, swivel_jacobians
from drake_blfdmp.vectors import cross

_ORIGIN = np.zeros(3)


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
    """Kinematics of the two arms; holds a plant of its own and its context.

    Attributes:
        shoulders: (2, 3) where each arm's first two axes meet, m in W.
        straight_elbow: (2,) the angles of joint 4, rad, at which each arm is straight; bent are smaller ones.
        arm_length: (2,) no palm gets farther from its shoulder, m.
        chains: the same kinematics for many postures at once.
    """

    def __init__(self, plant: MultibodyPlant | None = None):
        """Use a finalized plant with both arms and nothing else that moves; one is made when none is given."""
        self._plant = plant or MakeKinematicPlant()
        self._context = self._plant.CreateDefaultContext()
        self._world = self._plant.world_frame()
        self._frames = []
        shoulders = []  # The first two axes meet there whatever the joints' angles.
        self._columns = []
        for arm in ARMS:
            instance = self._plant.GetModelInstanceByName(arm)
            names = ("palm", "elbow", "wrist")
            self._frames.append([self._plant.GetFrameByName(name, instance) for name in names])
            shoulder = self._plant.GetFrameByName("shoulder", instance)
            shoulders.append(shoulder.CalcPoseInWorld(self._context).translation())
            first = self._plant.GetJointByName("panda_joint1", instance).velocity_start()
            self._columns.append(slice(first, first + JOINTS_PER_ARM))
        self.shoulders = np.array(shoulders)
        self.straight_elbow = self._straight_elbow()
        self.arm_length = self._arm_length()
        self.chains = ArmChains(self._plant)

    def _straight_elbow(self) -> np.ndarray:
        """The angles (2,) of joint 4, rad, at which shoulder, elbow and wrist lie on one line."""
        self._plant.SetPositions(self._context, np.zeros(2 * JOINTS_PER_ARM))
        angles = np.empty(2)
        for arm, (_, *frames) in enumerate(self._frames):
            elbow, wrist = (frame.CalcPoseInWorld(self._context).translation() for frame in frames)
            upper, fore = elbow - self.shoulders[arm], wrist - elbow
            # At 0 the links are parallel and the elbow, whose axis lies beside them, is past straight.
            angles[arm] = -np.arctan2(np.linalg.norm(cross(upper, fore)), upper @ fore)
        return angles

    def _arm_length(self) -> np.ndarray:
        """From the shoulder to the wrist of a straight arm, and from there to the palm, which turns about the wrist."""
        q = np.zeros((2, JOINTS_PER_ARM))
        q[:, 3] = self.straight_elbow
        self._plant.SetPositions(self._context, q.ravel())
        lengths = np.empty(2)
        for arm, frames in enumerate(self._frames):
            palm, _, wrist = (frame.CalcPoseInWorld(self._context).translation() for frame in frames)
            lengths[arm] = np.linalg.norm(wrist - self.shoulders[arm]) + np.linalg.norm(palm - wrist)
        return lengths

    def evaluate(self, q: np.ndarray) -> tuple[ArmState, ArmState]:
        """Both arms at q (14,)."""
        plant, context, world = self._plant, self._context, self._world
        plant.SetPositions(context, q)
        poses, jacobians, points = [], [], np.empty((3, 2, 3))
        for arm, ((palm, *frames), columns) in enumerate(zip(self._frames, self._columns, strict=True)):
            jacobian = plant.CalcJacobianSpatialVelocity(context, JacobianWrtVariable.kV, palm, _ORIGIN, world, world)
            jacobians.append(jacobian[:, columns])
            poses.append(palm.CalcPoseInWorld(context))
            points[0, arm] = self.shoulders[arm]
            for i, frame in enumerate(frames, start=1):
                points[i, arm] = frame.CalcPoseInWorld(context).translation()
        d_elbow, d_wrist = swivel_jacobians(*points)
        palms = np.array([pose.translation() for pose in poses])
        moment_elbow, moment_wrist = cross(points[1] - palms, d_elbow), cross(points[2] - palms, d_wrist)
        psi = swivel_angle(*points)
        states = []
        for arm, (pose, jacobian) in enumerate(zip(poses, jacobians, strict=True)):
            # Joints 1-3 carry the elbow, joints 1-5 the wrist, as rigidly as they carry the palm.
            omega, v = jacobian[:3].T, jacobian[3:].T
            swivel_jacobian = np.zeros(JOINTS_PER_ARM)
            swivel_jacobian[:3] = v[:3] @ d_elbow[arm] + omega[:3] @ moment_elbow[arm]
            swivel_jacobian[:5] += v[:5] @ d_wrist[arm] + omega[:5] @ moment_wrist[arm]
            states.append(ArmState(pose.rotation().matrix(), palms[arm], jacobian, float(psi[arm]), swivel_jacobian))
        return states[0], states[1]
