"""What of a MultibodyPlant is recorded, and under which names."""

from collections.abc import Sequence
from dataclasses import dataclass, field

from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex

from drake_blfdmp.recording.mcap_file import RecorderError


@dataclass(frozen=True)
class PlantNames:
    """Names on the topics, and where their values stand in the plant's output ports.

    Attributes:
        joints: model instance -> its joints' names, in the order of its state.
        bodies: name -> index in `body_poses`, of bodies that can move.
        static_bodies: name -> index in `body_poses`, of bodies welded to the world.
        positions, velocities: where the joints, group by group, stand in the plant's whole state [q, v].
        efforts: where they stand in its whole net actuation; as many as there are joints that an actuator drives.
    """

    joints: dict[str, list[str]] = field(default_factory=dict)
    bodies: dict[str, int] = field(default_factory=dict)
    static_bodies: dict[str, int] = field(default_factory=dict)
    positions: list[int] = field(default_factory=list)
    velocities: list[int] = field(default_factory=list)
    efforts: list[int] = field(default_factory=list)


def plant_names(plant: MultibodyPlant, arms: Sequence[str]) -> PlantNames:
    """Names everything in a finalized plant but the world.

    Joints and bodies of `arms` (model instances whose joints have one degree of freedom) are called `<arm>_<name>`; so
    are other bodies whose name occurs twice, after their model instance; the rest keep their own names.

    Raises:
        RecorderError: an arm is no model instance of the plant, or has a joint of several degrees of freedom.
    """
    names = PlantNames()
    actuators = [plant.get_joint_actuator(index) for index in plant.GetJointActuatorIndices()]
    inputs = {int(actuator.joint().index()): int(actuator.input_start()) for actuator in actuators}
    for arm in arms:
        if not plant.HasModelInstanceNamed(arm):
            raise RecorderError(f"recorder: the plant has no model instance '{arm}'; name the plant's arms")
        indices = plant.GetJointIndices(plant.GetModelInstanceByName(arm))
        joints = [joint for joint in map(plant.get_joint, indices) if joint.num_velocities() > 0]
        for joint in joints:
            if joint.num_velocities() != 1:
                raise RecorderError(
                    f"recorder: joint '{joint.name()}' of '{arm}' has {joint.num_velocities()} degrees of freedom; "
                    "leave this model out of the arms, its bodies are recorded anyway"
                )
        joints.sort(key=lambda joint: joint.velocity_start())
        names.joints[arm] = [f"{arm}_{joint.name()}" for joint in joints]
        names.positions.extend(joint.position_start() for joint in joints)
        names.velocities.extend(plant.num_positions() + joint.velocity_start() for joint in joints)
        names.efforts.extend(inputs[int(joint.index())] for joint in joints if int(joint.index()) in inputs)

    anchored = {int(body.index()) for body in plant.GetBodiesWeldedTo(plant.world_body())}
    for index in range(1, plant.num_bodies()):  # 0 is the world.
        body = plant.get_body(BodyIndex(index))
        model = plant.GetModelInstanceName(body.model_instance())
        name = body.name()
        if model in arms or plant.NumBodiesWithName(name) > 1:
            name = f"{model}_{name}"
        (names.static_bodies if index in anchored else names.bodies)[name] = index
    return names
