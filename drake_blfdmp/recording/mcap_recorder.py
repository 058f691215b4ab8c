"""Records a simulated run in MCAP, for ROS 2 tools and without ROS."""

import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import Context, DiagramBuilder, InputPort, LeafSystem

from drake_blfdmp.recording.mcap_file import McapFile, RecorderError
from drake_blfdmp.recording.plant_names import plant_names
from drake_blfdmp.recording.pose_rows import PoseRows
from drake_blfdmp.recording.sampler import Encode, RecordedBodies, RecordedJoints, RecordedPort, Sampler
from drake_blfdmp.ros2 import messages as ros2_messages

_NAME = re.compile(r"[A-Za-z]\w*(/[A-Za-z]\w*)*", re.ASCII)
_OWN_TOPICS = ("robot_description", "joint_states", "tf", "tf_static", "events")
_FORCE_FIRST = np.array([3, 4, 5, 0, 1, 2])


def _check_unique(what: str, names: Sequence[str]) -> None:
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice or "" in names:
        raise RecorderError(f"recorder: {what} name '{twice[0] if twice else ''}' is empty or given twice; rename it")


class McapRecorder(LeafSystem):
    """Publishes joint states, poses, wrenches and named vectors to an MCAP file that ROS 2 tools open as it is.

    .. pydrake_system::

        name: McapRecorder
        input_ports:
        - <joint group>_state
        - <joint group>_effort (optional)
        - body_poses
        - <name given to AddVectorInput>
        - <name given to AddWrenchInput>
        - <name given to AddMessageInput>

    A joint group's state port takes [q, v] (2n; rad, rad/s), its effort port n values (N m). `body_poses` takes
    MultibodyPlant's output port of that name and exists only when bodies are recorded.

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
        LeafSystem.__init__(self)
        joints, bodies = joints or {}, bodies or {}
        static_bodies, static_frames = static_bodies or {}, static_frames or {}
        for what, number in (("rate (Hz)", rate), ("chunk_duration (s)", chunk_duration)):
            if not (math.isfinite(number) and number > 0):
                raise RecorderError(f"recorder: {what} is {number}; give a positive number")
        self._joint_names = [name for group in joints.values() for name in group]
        _check_unique("joint", self._joint_names)
        _check_unique("body", [*bodies, *static_bodies, *static_frames])
        self._topics: set[str] = set(_OWN_TOPICS)
        self._world_frame = world_frame
        self._robot_description = robot_description
        self._bodies = {name: int(index) for name, index in bodies.items()}
        self._static_bodies = {name: int(index) for name, index in static_bodies.items()}
        self._static_frames = dict(static_frames)

        self._state_inputs: dict[str, InputPort] = {}
        self._effort_inputs: dict[str, InputPort] = {}
        for group, names in joints.items():
            self._state_inputs[group] = self.DeclareVectorInputPort(f"{group}_state", 2 * len(names))
            self._effort_inputs[group] = self.DeclareVectorInputPort(f"{group}_effort", len(names))
        self._body_poses_input: InputPort | None = None
        if bodies or static_bodies:
            self._body_poses_input = self.DeclareAbstractInputPort("body_poses", AbstractValue.Make([RigidTransform()]))
        self._inputs: list[RecordedPort] = []
        self._sampler: Sampler | None = None
        self._last_ns: int | None = None
        self.DeclarePeriodicPublishEvent(1.0 / rate, 0.0, self._publish)

        self._file = McapFile(filename, chunk_duration=chunk_duration)
        self._file.add_metadata("run", metadata or {})
        if robot_description:
            self._description_channel = self._file.add_channel(
                "/robot_description", ros2_messages.STRING, transient_local=True
            )
        if static_bodies or static_frames:
            self._tf_static_channel = self._file.add_channel("/tf_static", ros2_messages.TF, transient_local=True)
        if joints:
            self._joint_states_channel = self._file.add_channel("/joint_states", ros2_messages.JOINT_STATE)
        if bodies:
            self._tf_channel = self._file.add_channel("/tf", ros2_messages.TF)
        self._events_channel = self._file.add_channel("/events", ros2_messages.LOG)

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

        The joint groups are the model instances `arms`; names are those of `plant_names`. Efforts are the plant's net
        actuation. For the other arguments see the constructor.

        Raises:
            RecorderError: as the constructor; or an arm is no model instance of the plant.
        """
        names = plant_names(plant, arms)
        recorder = McapRecorder(
            filename=filename,
            rate=rate,
            joints=names.joints,
            bodies=names.bodies,
            static_bodies=names.static_bodies,
            static_frames=static_frames,
            robot_description=robot_description,
            metadata=metadata,
            chunk_duration=chunk_duration,
        )
        builder.AddSystem(recorder)
        for arm in arms:
            instance = plant.GetModelInstanceByName(arm)
            builder.Connect(plant.get_state_output_port(instance), recorder.GetInputPort(f"{arm}_state"))
            if plant.num_actuated_dofs(instance) == len(names.joints[arm]):
                builder.Connect(plant.get_net_actuation_output_port(instance), recorder.GetInputPort(f"{arm}_effort"))
        if names.bodies or names.static_bodies:
            builder.Connect(plant.get_body_poses_output_port(), recorder.GetInputPort("body_poses"))
        return recorder

    @property
    def path(self) -> Path:
        """The file."""
        return self._file.path

    def AddVectorInput(
        self,
        name: str,
        size: int,
        elements: Sequence[str],
        unit: str,
        *,
        single_precision: bool = False,
        every: int = 1,
    ) -> InputPort:
        """Declares an input port called `name` and records it on the topic `/<name>`; returns the port.

        Call it before the diagram is built.

        Args:
            name: letters, digits, `_`, and `/` between parts.
            size: the port's size.
            elements: (size,) names of the elements.
            unit: of all elements, for example "m"; "1" for pure numbers.
            single_precision: round to the seven digits of a float32, which halves what the numbers take in the file.
            every: record each so many samples only.

        Raises:
            RecorderError: the name is taken or unusable, `elements` does not fit `size`, or there is no unit.
        """
        if len(elements) != size:
            raise RecorderError(f"recorder: vector '{name}' has size {size} but {len(elements)} names; name each")
        if not unit:
            raise RecorderError(f"recorder: vector '{name}' has no unit; give one, '1' for pure numbers")
        _check_unique(f"vector '{name}': element", list(elements))
        written = [f"{name}.{element}" if element in self._joint_names else element for element in elements]
        template = ros2_messages.joint_state_template(written, velocity=False, effort=False)
        port, channel = self._declare(name, size, ros2_messages.JOINT_STATE, {"unit": unit}, every)
        self._inputs.append(RecordedPort(channel, port, template, every, np.arange(size), single_precision))
        return port

    def AddWrenchInput(self, name: str, frame: str, *, single_precision: bool = False, every: int = 1) -> InputPort:
        """Declares an input port (6) called `name` and records it on the topic `/<name>`; returns the port.

        Call it before the diagram is built.

        Args:
            name, single_precision, every: as in AddVectorInput.
            frame: name of the frame in which the wrench is expressed, and at whose origin its force is applied.

        The port takes Drake's order, SpatialForce.get_coeffs(): torque (3, N m), then force (3, N).

        Raises:
            RecorderError: the name is taken or unusable.
        """
        port, channel = self._declare(name, 6, ros2_messages.WRENCH, {"unit": "N, N m"}, every)
        template = ros2_messages.wrench_template(frame)
        self._inputs.append(RecordedPort(channel, port, template, every, _FORCE_FIRST, single_precision))
        return port

    def AddMessageInput(
        self,
        name: str,
        size: int,
        message_type: str,
        encode: Encode,
        *,
        metadata: Mapping[str, str] | None = None,
        every: int = 1,
    ) -> InputPort:
        """Declares an input port called `name`, of whose value `encode` makes the messages on the topic `/<name>`.

        Call it before the diagram is built.

        Args:
            name, size, every: as in AddVectorInput.
            message_type: one of `ros2.messages.DEFINITIONS`.
            encode: the CDR message of a time (ns) and the port's value (size,).
            metadata: of the channel.

        Raises:
            RecorderError: the name is taken or unusable, or `every` is not 1 or more.
        """
        port, channel = self._declare(name, size, message_type, metadata or {}, every)
        self._inputs.append(RecordedPort(channel, port, encode, every, np.arange(size)))
        return port

    def Event(self, name: str, t: float) -> None:
        """Records that `name` (grasp, lift, release and so on) happened at simulated time `t` (s).

        Raises:
            RecorderError: `t` is negative or no number.
        """
        if not (math.isfinite(t) and t >= 0):
            raise RecorderError(f"recorder: event '{name}' at t = {t} s; give a time from 0 on")
        if not self._file.closed:
            t_ns = round(t * 1e9)
            self._file.write(self._events_channel, t_ns, ros2_messages.log_message(t_ns, "drake_blfdmp", name))

    def AddAttachment(self, name: str, data: bytes | str, media_type: str = "text/plain") -> None:
        """Stores a whole file (scenario, skill, summary) in the recording.

        Raises:
            RecorderError: the recorder is closed.
        """
        if self._file.closed:
            raise RecorderError(f"{self._file.path}: attachment '{name}' comes after Close(); add it before")
        self._file.add_attachment(name, data.encode() if isinstance(data, str) else data, media_type)

    def Close(self) -> None:
        """Completes the file; a second call does nothing.

        Raises:
            RecorderError: the rest cannot be written.
        """
        self._file.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.Close()

    def _take_topic(self, name: str) -> None:
        if not _NAME.fullmatch(name):
            raise RecorderError(f"recorder: '{name}' is no topic name; use letters, digits, '_', and '/' between parts")
        if name in self._topics or self.HasInputPort(name):
            raise RecorderError(f"recorder: '{name}' is taken; choose another name")
        if self._file.closed or self._last_ns is not None:
            raise RecorderError(f"recorder: '{name}' comes after the first sample; add it before the diagram is built")
        self._topics.add(name)

    def _declare(
        self, name: str, size: int, message_type: str, metadata: Mapping[str, str], every: int
    ) -> tuple[InputPort, int]:
        """The port and the channel of a topic of its own."""
        if every < 1:
            raise RecorderError(f"recorder: '{name}' is to be recorded every {every} samples; give 1 or more")
        self._take_topic(name)
        return self.DeclareVectorInputPort(name, size), self._file.add_channel(f"/{name}", message_type, metadata)

    def _start(self, context: Context, t_ns: int) -> Sampler:
        """Checks the connections, writes what is written once, and fixes what a sample is."""
        required = [*self._state_inputs.values(), *(one.port for one in self._inputs)]
        if self._body_poses_input is not None:
            required.append(self._body_poses_input)
        for port in required:
            if not port.HasValue(context):
                raise RecorderError(f"recorder: input port '{port.get_name()}' is not connected; connect it")
        if self._robot_description:
            self._file.write(self._description_channel, t_ns, ros2_messages.string_message(self._robot_description))
        still = self._still_frames(context)
        if still:
            template = ros2_messages.tf_template(self._world_frame, list(still))
            rows = PoseRows(len(still)).fill([pose.GetAsMatrix34() for pose in still.values()])
            self._file.write(self._tf_static_channel, t_ns, template.encode(t_ns, rows))
        joints = bodies = None
        if self._state_inputs:
            states, efforts = list(self._state_inputs.values()), list(self._effort_inputs.values())
            joints = RecordedJoints(self._joint_states_channel, self._joint_names, states, efforts)
        if self._bodies and self._body_poses_input is not None:
            bodies = RecordedBodies(self._tf_channel, self._body_poses_input, self._world_frame, self._bodies)
        return Sampler(context, joints, bodies, self._inputs)

    def _still_frames(self, context: Context) -> dict[str, RigidTransform]:
        """Name -> X_WF of every frame that does not move."""
        frames: dict[str, RigidTransform] = {}
        if self._static_bodies and self._body_poses_input is not None:
            poses: Any = self._body_poses_input.Eval(context)
            frames = {name: poses[index] for name, index in self._static_bodies.items()}
        return frames | self._static_frames

    def _publish(self, context: Context) -> None:
        """Writes one sample of everything."""
        file = self._file
        if file.closed:
            return
        t_ns = round(context.get_time() * 1e9)
        if self._last_ns is not None and t_ns < self._last_ns:
            raise RecorderError(
                f"{file.path}: time went back from {self._last_ns * 1e-9:.6g} s to {t_ns * 1e-9:.6g} s; "
                "use a new recorder, and a new file, for each run"
            )
        self._last_ns = t_ns
        if self._sampler is None:
            self._sampler = self._start(context, t_ns)
        self._sampler.write(context, t_ns, file)
