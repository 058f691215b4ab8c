"""Records a simulated run in MCAP, for ROS 2 tools and without ROS."""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex
from pydrake.systems.framework import Context, DiagramBuilder, InputPort

from drake_blfdmp.recording.mcap_file import RecorderError
from drake_blfdmp.recording.plant_names import PlantNames, plant_names
from drake_blfdmp.recording.pose_rows import pose_rows
from drake_blfdmp.recording.sample_block import Make
from drake_blfdmp.recording.sampler import Sampler
from drake_blfdmp.recording.topic_recorder import TopicRecorder
from drake_blfdmp.recording.topics import PoseSource, RecordedTopic, check_unique
from drake_blfdmp.robot.body_poses import BodyPoses
from drake_blfdmp.ros2 import messages as ros2_messages

_OWN_TOPICS = {"robot_description", "joint_states", "tf", "tf_static"}


class McapRecorder(TopicRecorder):
    """Publishes joint states, poses, wrenches and named vectors to an MCAP file that ROS 2 tools open as it is.

    .. pydrake_system::

        name: McapRecorder
        input_ports:
        - <joint group>_state
        - <joint group>_effort (optional)
        - body_poses
        - <name given to AddVectorInput>
        - <name given to AddVectorInputs>
        - <name given to AddWrenchInput>
        - <name given to AddWrenchInputs>
        - <name given to AddMessageInput>
        - <name given to AddTemplateInput>
        - <name given to AddEventInput>

    A joint group's state port takes [q, v] (2n; rad, rad/s), its effort port n values (N m). `body_poses` takes
    MultibodyPlant's output port of that name and exists only when bodies are recorded. A recorder from AddToBuilder has
    `plant_state` and `plant_effort` in their place, the whole plant's, from which it places the bodies itself; with a
    joint of a kind that BodyPoses does not know, `body_poses` too.

    | topic | type | what |
    |---|---|---|
    | /robot_description | std_msgs/msg/String | the URDF, once, transient local |
    | /joint_states | sensor_msgs/msg/JointState | all joint groups |
    | /tf, /tf_static | tf2_msgs/msg/TFMessage | X_WB of each body; of what cannot move once, transient local |
    | /<name> of a wrench | geometry_msgs/msg/WrenchStamped | |
    | /<name> of a vector | sensor_msgs/msg/JointState | elements as `name`, values as `position` |
    | /<name> of a message | any of `ros2.messages.DEFINITIONS` | what its encoder makes of the port's value |
    | /events | rcl_interfaces/msg/Log | the event's name as `msg` |

    Every time is simulated time, as log time, as publish time and in the headers, so equal runs give equal files, byte
    for byte. What a killed process leaves is put together by `recover` (see McapFile).

    Vectors travel as JointState because it is the one standard message in which every value has a name: PlotJuggler
    shows `/margin/hands/position`, Rerun draws a curve called `hands`, Foxglove and Lichtblick plot
    `/margin.position[2]`. A Float64MultiArray has only indices, and one Float64 a topic costs a message an element.
    Viewers move the robot by ANY JointState whose names are its joints', so an element named as a joint is
    written as `<vector>.<element>`. The unit stands in the channel's metadata.

    A sample whose joint states are not finite is left out as a whole: viewers cannot place a robot at NaN.

    Once Close() has been called nothing more is recorded, and the simulation may go on. A recorder records one run: a
    sample earlier than the last one raises RecorderError.

    Warning:
        The file is complete only after ``Close()``, which leaving a ``with`` block calls, also through an exception.
    """

    def __init__(
        self,
        *,
        filename: str | Path,
        rate: float = 100.0,
        joints: Mapping[str, Sequence[str]] | None = None,
        bodies: Mapping[str, int] | None = None,
        static_bodies: Mapping[str, int] | None = None,
        static_frames: Mapping[str, RigidTransform] | None = None,
        robot_description: str = "",
        metadata: Mapping[str, object] | None = None,
        world_frame: str = "world",
        chunk_duration: float = 1.0,
    ):
        """Creates the file and declares the ports.

        Args:
            filename: the file to create; it must not exist.
            rate: samples per simulated second, Hz.
            joints: joint group -> names of its joints as in `robot_description`, in the order of the group's state.
            bodies: name of a link in `robot_description` -> its index in `body_poses`, for bodies that move.
            static_bodies: the same for bodies that do not.
            static_frames: name of a further frame F that does not move -> X_WF.
            robot_description: URDF of everything that is to be drawn; none when empty.
            metadata: what is to be known of the run (seed, versions, the scenario's hash, synthetic or real): the
                metadata record "run".
            world_frame: name of frame W.
            chunk_duration: simulated time in a chunk, s.

        Raises:
            RecorderError: the file exists or cannot be created, or a name or number is unusable.
        """
        joints, bodies = joints or {}, bodies or {}
        static_bodies, static_frames = static_bodies or {}, static_frames or {}
        for what, number in (("rate (Hz)", rate), ("chunk_duration (s)", chunk_duration)):
            if not (math.isfinite(number) and number > 0):
                raise RecorderError(f"recorder: {what} is {number}; give a positive number")
        joint_names = [name for group in joints.values() for name in group]
        check_unique("joint", joint_names)
        check_unique("body", [*bodies, *static_bodies, *static_frames])
        super().__init__(filename=filename, rate=rate, chunk_duration=chunk_duration, metadata=metadata)
        self._topics |= _OWN_TOPICS
        self._world_frame = world_frame
        self._static_bodies = {name: int(index) for name, index in static_bodies.items()}
        self._static_frames = dict(static_frames)
        self._joint_names = joint_names
        self._states: list[InputPort] = []
        self._efforts: list[InputPort] = []
        for group, names in joints.items():
            self._states.append(self.DeclareVectorInputPort(f"{group}_state", 2 * len(names)))
            self._efforts.append(self.DeclareVectorInputPort(f"{group}_effort", len(names)))
            self._optional.add(f"{group}_effort")
        self._description = robot_description
        if robot_description:
            self._description_channel = self._file.add_channel(
                "/robot_description", ros2_messages.STRING, transient_local=True
            )
        if static_bodies or static_frames:
            self._tf_static_channel = self._file.add_channel("/tf_static", ros2_messages.TF, transient_local=True)
        if joints:
            self._joint_states_channel = self._file.add_channel("/joint_states", ros2_messages.JOINT_STATE)
        if bodies or static_bodies:
            self._add_body_poses({name: int(index) for name, index in bodies.items()})

    @staticmethod
    def AddToBuilder(
        *,
        filename: str | Path,
        builder: DiagramBuilder,
        plant: MultibodyPlant,
        arms: Sequence[str],
        rate: float = 100.0,
        static_frames: Mapping[str, RigidTransform] | None = None,
        robot_description: str = "",
        metadata: Mapping[str, object] | None = None,
        chunk_duration: float = 1.0,
    ) -> "McapRecorder":
        """Adds a recorder of a finalized plant to the builder, connects it, and returns it.

        Its joints are those of the model instances `arms`; names are those of `plant_names`. Efforts are the plant's
        net actuation. For the other arguments see the constructor.

        Raises:
            RecorderError: as the constructor; or an arm is no model instance of the plant.
        """
        names = plant_names(plant, arms)
        check_unique("body", [*names.bodies, *names.static_bodies, *(static_frames or {})])
        context = plant.CreateDefaultContext()
        still = {
            name: plant.EvalBodyPoseInWorld(context, plant.get_body(BodyIndex(index)))
            for name, index in names.static_bodies.items()
        }
        recorder = McapRecorder(
            filename=filename,
            rate=rate,
            static_frames={**still, **(static_frames or {})},
            robot_description=robot_description,
            metadata=metadata,
            chunk_duration=chunk_duration,
        )
        recorder._add_plant(plant, names)
        builder.AddSystem(recorder)
        for name, port in (
            ("plant_state", plant.get_state_output_port()),
            ("plant_effort", plant.get_net_actuation_output_port()),
            ("body_poses", plant.get_body_poses_output_port()),
        ):
            if recorder.HasInputPort(name):
                builder.Connect(port, recorder.GetInputPort(name))
        return recorder

    def _add_plant(self, plant: MultibodyPlant, names: PlantNames) -> None:
        """Records a plant's joints and bodies by its whole state: reading one port costs as much as reading another."""
        self._joint_names = [name for group in names.joints.values() for name in group]
        state = self.DeclareVectorInputPort("plant_state", plant.num_multibody_states())
        if self._joint_names:
            parts = [(state, np.array([*names.positions, *names.velocities]))]
            # JointState wants an effort for every joint or for none.
            if len(names.efforts) == len(self._joint_names):
                effort = self.DeclareVectorInputPort("plant_effort", plant.num_actuated_dofs())
                parts.append((effort, np.array(names.efforts)))
            channel = self._file.add_channel("/joint_states", ros2_messages.JOINT_STATE)
            template = ros2_messages.joint_state_template(self._joint_names, effort=len(parts) > 1)
            self._recorded.append(RecordedTopic(channel, parts, template, finite=True))
        if not BodyPoses.known(plant):
            self._add_body_poses(names.bodies)
            return
        count = plant.num_positions()

        def maker(bodies: Sequence[int]) -> Make:
            poses = BodyPoses(plant, bodies)
            return lambda state: poses.evaluate(state[:, :count]).reshape(len(state), -1)

        self._poses = PoseSource(state, maker)
        self._add_bodies(names.bodies)

    def _add_body_poses(self, bodies: Mapping[str, int]) -> None:
        self._poses = PoseSource(self.DeclareAbstractInputPort("body_poses", AbstractValue.Make([RigidTransform()])))
        self._add_bodies(bodies)

    def _add_bodies(self, bodies: Mapping[str, int]) -> None:
        if bodies:
            channel = self._file.add_channel("/tf", ros2_messages.TF)
            template = ros2_messages.tf_template(self._world_frame, list(bodies))
            self._recorded.append(RecordedTopic(channel, [], template, make=_transforms, bodies=[*bodies.values()]))

    def _make_sampler(self, context: Context, t_ns: int) -> Sampler:
        """Writes what is written once, too."""
        if self._description:
            self._file.write(self._description_channel, t_ns, ros2_messages.string_message(self._description))
        still = self._still_frames(context)
        if still:
            template = ros2_messages.tf_template(self._world_frame, list(still))
            rows = pose_rows(np.array([pose.GetAsMatrix34() for pose in still.values()]))
            self._file.write(self._tf_static_channel, t_ns, template.encode(t_ns, rows))
        if self._states:
            halves = [(port, np.arange(port.size()).reshape(2, -1)) for port in self._states]
            parts = [(port, half[k]) for k in range(2) for port, half in halves]
            # JointState wants an effort for every joint or for none.
            effort = all(port.HasValue(context) for port in self._efforts)
            if effort:
                parts += [(port, np.arange(port.size())) for port in self._efforts]
            template = ros2_messages.joint_state_template(self._joint_names, effort=effort)
            self._recorded.insert(0, RecordedTopic(self._joint_states_channel, parts, template, finite=True))
        return super()._make_sampler(context, t_ns)

    def _still_frames(self, context: Context) -> dict[str, RigidTransform]:
        """Name -> X_WF of every frame that does not move."""
        frames: dict[str, RigidTransform] = {}
        if self._static_bodies and self._poses is not None:
            poses: Any = self._poses.port.Eval(context)
            frames = {name: poses[index] for name, index in self._static_bodies.items()}
        return frames | self._static_frames


def _transforms(poses: np.ndarray) -> np.ndarray:
    """Numbers of `/tf` (N, 7 B) of poses [R p] (N, 12 B)."""
    return pose_rows(poses.reshape(-1, 3, 4)).reshape(len(poses), -1)
