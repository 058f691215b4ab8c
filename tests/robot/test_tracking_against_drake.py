"""The same palm motion by Drake's `DifferentialInverseKinematicsSystem`: a second opinion on the whole loop."""

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.common.value import AbstractValue
from pydrake.math import RigidTransform
from pydrake.multibody.inverse_kinematics import DifferentialInverseKinematicsSystem
from pydrake.multibody.math import SpatialVelocity
from pydrake.planning import (
    CollisionCheckerParams,
    DofMask,
    JointLimits,
    RobotDiagramBuilder,
    SceneGraphCollisionChecker,
)
from pydrake.systems.framework import BusValue
from scipy.spatial.transform import Rotation

from drake_blfdmp.robot.kinematics import DualArmKinematics
from drake_blfdmp.robot.plant import ARMS, AddDualPanda, MakeKinematicPlant, ReadJointLimits
from drake_blfdmp.robot.tracking import DualArmTracker, rotation_matrix

PLANT = MakeKinematicPlant()
LIMITS = ReadJointLimits(PLANT, [PLANT.GetModelInstanceByName(arm) for arm in ARMS])
KINEMATICS = DualArmKinematics(PLANT)
START = np.array([0.5, 0.8, -0.5, -1.9, -1.0, 1.75, 0.0, -0.5, 0.8, 0.5, -1.9, 1.0, 1.75, 0.0])
"""Elbows bent, joint 2 well away from 0, where joints 1 and 3 share an axis."""
DT = 0.01


class DrakesArms:
    """Both palms as goal frames of one of Drake's systems; velocities limited, nothing else."""

    def __init__(self):
        robot = RobotDiagramBuilder(time_step=0.0)
        arms = AddDualPanda(robot.plant())
        robot.plant().Finalize()
        instances = list(arms)
        checker = SceneGraphCollisionChecker(
            CollisionCheckerParams(model=robot.Build(), robot_model_instances=instances, edge_step_size=0.1)
        )
        ik = DifferentialInverseKinematicsSystem
        cost = ik.LeastSquaresCost.Config()
        cost.cartesian_qp_weight = 1000.0
        cost.cartesian_axis_masks = {f"{arm}::palm": np.ones(6) for arm in ARMS}
        centring = ik.JointCenteringCost.Config()
        centring.posture_gain = 0.0
        centring.cartesian_axis_masks = cost.cartesian_axis_masks
        recipe = ik.Recipe()
        recipe.AddIngredient(ik.LeastSquaresCost(cost))
        recipe.AddIngredient(ik.JointCenteringCost(centring))
        fast = np.full(6, 10.0)
        self.system = ik(
            recipe=recipe,
            task_frame="world",
            collision_checker=checker,
            active_dof=DofMask(14, True),
            time_step=DT,
            K_VX=1.0,
            Vd_TG_limit=SpatialVelocity(fast[:3], fast[3:]),
        )
        self.context = self.system.CreateDefaultContext()
        assert JointLimits(checker.plant()).num_positions() == 14

    def velocity(self, q, pose):
        """Joint velocities (14,) that take both palms to their poses (2, 7) within one step."""
        bus = BusValue()
        for arm, X in zip(ARMS, pose, strict=True):
            bus.Set(f"{arm}::palm", AbstractValue.Make(RigidTransform(Quaternion(X[:4]), X[4:])))
        self.system.GetInputPort("position").FixValue(self.context, q)
        self.system.GetInputPort("nominal_posture").FixValue(self.context, START)
        self.system.GetInputPort("desired_cartesian_poses").FixValue(self.context, AbstractValue.Make(bus))
        return self.system.GetOutputPort("commanded_velocity").Eval(self.context)


def palms(q):
    states = KINEMATICS.evaluate(q)
    return np.array([[*np.roll(Rotation.from_matrix(s.rotation).as_quat(), 1), *s.position] for s in states])


def test_the_same_motion_by_drakes_system_takes_the_same_palm_paths():
    """A bow to the side and up with a turn, 1.5 s there and back; the elbows are free to differ, and do."""
    drake, tracker = DrakesArms(), DualArmTracker(KINEMATICS, LIMITS)
    home = palms(START)
    swivel = np.array([s.swivel for s in KINEMATICS.evaluate(START)])

    def goal(t):
        u, pose = 0.5 * (1.0 - np.cos(2.0 * np.pi * t / 1.5)), home.copy()
        for arm in range(2):
            turn = Rotation.from_rotvec([0.0, 0.15 * u, 0.2 * u]).as_matrix() @ rotation_matrix(home[arm, :4])
            pose[arm, :4] = np.roll(Rotation.from_matrix(turn).as_quat(), 1)
        pose[:, 4:] += u * np.array([0.06, 0.08, 0.1]) + 0.5 * u * (1.0 - u) * np.array([0.0, 0.0, 0.2])
        return pose

    ours, drakes, v = START, START, np.zeros(14)
    apart, farthest, elbows = 0.0, 0.0, 0.0
    for k in range(150):
        now, after = goal(k * DT), goal((k + 1) * DT)
        twist = np.zeros((2, 6))
        for arm in range(2):
            turn = Rotation.from_matrix(rotation_matrix(after[arm, :4]) @ rotation_matrix(now[arm, :4]).T)
            twist[arm] = np.concatenate([turn.as_rotvec(), after[arm, 4:] - now[arm, 4:]]) / DT
        tracked = tracker.velocity(ours, now, twist, swivel + 0.2 * np.sin(k * DT), np.full(2, 0.2), v, DT)
        np.testing.assert_array_equal(tracked.scale, 1.0)
        v = tracked.velocity
        ours, drakes = ours + DT * v, drakes + DT * np.asarray(drake.velocity(drakes, after))
        a, b = palms(ours), palms(drakes)
        apart = max(apart, np.abs(a[:, 4:] - b[:, 4:]).max())
        farthest = max(farthest, np.linalg.norm(a[:, 4:] - home[:, 4:], axis=-1).max())
        elbows = max(elbows, np.abs(ours - drakes).max())
    assert farthest > 0.1
    assert elbows > 0.05
    assert apart < 1e-3
