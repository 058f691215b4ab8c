"""Two Pandas with palms: added to a plant, held by joint PD, and their limits."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import JointActuator, ModelInstanceIndex, PdControllerGains

from drake_blfdmp.errors import TaskError
from drake_blfdmp.robot.models import PACKAGE_NAME, MakeParser

ARMS = ("left_arm", "right_arm")
JOINTS_PER_ARM = 7

# N m/rad and N m s/rad, joints 1-7. See `SetJointPd` for how they were chosen.
DEFAULT_STIFFNESS = (3000.0, 3000.0, 3000.0, 3000.0, 800.0, 800.0, 400.0)
DEFAULT_DAMPING = (130.0, 170.0, 140.0, 120.0, 28.0, 28.0, 18.0)

# rad, one arm: the palms in front of the chest, forearms level, clear of everything.
HOME = (0.0, -0.5, 0.0, -2.2, 0.0, 1.7, 0.785)


@dataclass(frozen=True)
class JointLimits:
    """Limits of both arms' joints; each (14,), joints 1-7 of the left arm, then of the right.

    Attributes:
        lower, upper: position, rad.
        velocity: rad/s.
        acceleration: rad/s^2.
        effort: N m.
    """

    lower: np.ndarray
    upper: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    effort: np.ndarray


def AddDualPanda(plant: MultibodyPlant) -> tuple[ModelInstanceIndex, ModelInstanceIndex]:
    """Adds both arms on their pedestals (`models/dual_panda.dmd.yaml`) to a plant that is not finalized.

    Gravity is off for the arms: it stands for the gravity compensation a Panda always runs.

    Returns:
        The model instances `left_arm` and `right_arm`, bases at (-0.2, 0, 0.4) and (0.2, 0, 0.4) m in W, facing +y.
    """
    MakeParser(plant).AddModelsFromUrl(f"package://{PACKAGE_NAME}/dual_panda.dmd.yaml")
    left, right = (plant.GetModelInstanceByName(arm) for arm in ARMS)
    for arm in (left, right):
        plant.set_gravity_enabled(arm, False)
    return left, right


def MakeKinematicPlant() -> MultibodyPlant:
    """Both arms and nothing else that moves, finalized, without a scene graph: 14 positions, for inverse kinematics."""
    plant = MultibodyPlant(time_step=0.0)
    AddDualPanda(plant)
    plant.Finalize()
    return plant


def ArmActuators(plant: MultibodyPlant, arm: ModelInstanceIndex) -> list[JointActuator]:
    """The seven actuators of one arm, joint 1 first.

    Raises:
        TaskError: the plant is not finalized.
    """
    if not plant.is_finalized():
        raise TaskError(f"the plant of {plant.GetModelInstanceName(arm)} is not finalized: call Finalize() first")
    return [plant.get_joint_actuator(index) for index in plant.GetJointActuatorIndices(arm)]


def SetJointPd(
    plant: MultibodyPlant,
    instances: Sequence[ModelInstanceIndex],
    stiffness: Sequence[float] | np.ndarray = DEFAULT_STIFFNESS,
    damping: Sequence[float] | np.ndarray = DEFAULT_DAMPING,
) -> None:
    """Gives each arm Drake's built-in joint PD, implicit in the contact solver and held to the effort limits.

    The desired state comes in at `plant.get_desired_state_input_port(instance)`, (14,): seven positions, rad, then
    seven velocities, rad/s.

    The default stiffness of the arm is that of Franka's own joint impedance (libfranka's examples set 3000-2500
    N m/rad); the wrist, whose effort limit is 12 N m, is softer. A palm whose desired position lies 10 mm inside a
    box then presses with about 70 N (`contact.palm_stiffness` says more exactly). The damping is critical for the
    diagonal of the mass matrix with the palms in front of the chest.

    Args:
        plant: finalized.
        instances: the arms.
        stiffness: (7,) N m/rad, > 0.
        damping: (7,) N m s/rad, >= 0.

    Raises:
        TaskError: the plant is not finalized, or a gain has the wrong shape or sign.
    """
    gains = {}
    for name, values in (("stiffness", stiffness), ("damping", damping)):
        array = np.asarray(values, dtype=float)
        if array.shape != (JOINTS_PER_ARM,) or not np.all(np.isfinite(array)) or np.any(array < 0):
            raise TaskError(f"joint PD {name}: {values} must be {JOINTS_PER_ARM} finite numbers >= 0")
        gains[name] = array
    if np.any(gains["stiffness"] == 0):
        raise TaskError(f"joint PD stiffness: {stiffness} must be > 0 for every joint")
    for instance in instances:
        for actuator, p, d in zip(ArmActuators(plant, instance), gains["stiffness"], gains["damping"], strict=True):
            actuator.set_controller_gains(PdControllerGains(p=p, d=d))


def ReadJointLimits(plant: MultibodyPlant, instances: Sequence[ModelInstanceIndex]) -> JointLimits:
    """Reads the limits of the given arms, in their order, from a finalized plant that may hold other models too.

    Raises:
        TaskError: the plant is not finalized.
    """
    actuators = [actuator for instance in instances for actuator in ArmActuators(plant, instance)]
    joints = [actuator.joint() for actuator in actuators]
    return JointLimits(
        lower=np.concatenate([joint.position_lower_limits() for joint in joints]),
        upper=np.concatenate([joint.position_upper_limits() for joint in joints]),
        velocity=np.concatenate([joint.velocity_upper_limits() for joint in joints]),
        acceleration=np.concatenate([joint.acceleration_upper_limits() for joint in joints]),
        effort=np.array([actuator.effort_limit() for actuator in actuators]),
    )
