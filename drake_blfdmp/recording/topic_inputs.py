"""The ports that a recorder may be given, and what is recorded of each; the base of `TopicRecorder`."""

import re
from collections.abc import Mapping, Sequence

import numpy as np
from pydrake.systems.framework import InputPort, LeafSystem

from drake_blfdmp.recording.mcap_file import McapFile, RecorderError
from drake_blfdmp.recording.sample_block import Make
from drake_blfdmp.recording.topics import Encode, EncodedTopic, PoseSource, RecordedTopic, VectorTopic, check_unique
from drake_blfdmp.robot.contact_wrenches import wrench_in_body
from drake_blfdmp.ros2 import messages as ros2_messages
from drake_blfdmp.ros2.cdr import CdrTemplate

LOGGER = "drake_blfdmp"
"""Name of the logger whose messages the events are."""

_NAME = re.compile(r"[A-Za-z]\w*(/[A-Za-z]\w*)*", re.ASCII)
_FORCE_FIRST = np.array([3, 4, 5, 0, 1, 2])


class TopicInputs(LeafSystem):
    """Declares input ports and says what is recorded of them, until the first sample.

    A subclass has the file `_file`, and in it the channel of the events, `_events_channel`.
    """

    _file: McapFile
    _events_channel: int

    def __init__(self):
        """Without any port."""
        LeafSystem.__init__(self)
        self._topics = {"events"}
        self._joint_names: list[str] = []  # That no element of a vector may have.
        self._recorded: list[RecordedTopic] = []
        self._encoded: list[EncodedTopic] = []
        self._poses: PoseSource | None = None
        self._sampled = False  # Once a sample was taken nothing more is declared.

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
            name, elements, unit, single_precision: as in VectorTopic.
            size: the port's size, and that of `elements`.
            every: record each so many samples only.

        Raises:
            RecorderError: the name is taken or unusable, `elements` does not fit `size`, or there is no unit.
        """
        if len(elements) != size:
            raise RecorderError(f"recorder: vector '{name}' has size {size} but {len(elements)} names; name each")
        return self.AddVectorInputs(name, [VectorTopic(name, elements, unit, single_precision)], every=every)

    def AddVectorInputs(self, name: str, topics: Sequence[VectorTopic], *, every: int = 1) -> InputPort:
        """Declares one input port called `name` for several topics; returns the port.

        Its value is theirs, one after the other, as from a Multiplexer. Reading a port costs microseconds whatever its
        size, so this is cheaper than a port a topic. Call it before the diagram is built.

        Args:
            name: of the port.
            topics: a topic or more.
            every: record each so many samples only.

        Raises:
            RecorderError: a name is taken or unusable, or a topic has no unit.
        """
        self._check_port(name, every)
        for topic in topics:
            if not topic.unit:
                raise RecorderError(f"recorder: vector '{topic.name}' has no unit; give one, '1' for pure numbers")
            check_unique(f"vector '{topic.name}': element", list(topic.elements))
        channels = [self._add_topic(topic.name, ros2_messages.JOINT_STATE, {"unit": topic.unit}) for topic in topics]
        sizes = [len(topic.elements) if topic.size is None else topic.size for topic in topics]
        port, at = self.DeclareVectorInputPort(name, sum(sizes)), 0
        for topic, channel, size in zip(topics, channels, sizes, strict=True):
            names = [f"{topic.name}.{one}" if one in self._joint_names else one for one in topic.elements]
            template = ros2_messages.joint_state_template(names, velocity=False, effort=False)
            places, at = np.arange(at, at + size), at + size
            one = RecordedTopic(
                channel, [(port, places)], template, every, topic.single_precision, topic.make, topic.bodies
            )
            self._recorded.append(one)
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
        return self.AddWrenchInputs(name, {name: frame}, single_precision=single_precision, every=every)

    def AddWrenchInputs(
        self,
        name: str,
        frames: Mapping[str, str],
        *,
        bodies: Sequence[int] | None = None,
        single_precision: bool = False,
        every: int = 1,
    ) -> InputPort:
        """Declares one input port (6 K) called `name` for K wrenches; returns the port. Otherwise as AddWrenchInput.

        Args:
            name: of the port.
            frames: topic, without its first `/` -> frame, in the order of the port's value.
            bodies: indices of the bodies that the frames are, when the port has the wrenches expressed in W, applied
                at W's origin: they are recorded in the bodies' frames then. Only a recorder that records bodies can.
            single_precision, every: as in AddVectorInput.

        Raises:
            RecorderError: a name is taken or unusable.
        """
        self._check_port(name, every)
        channels = [self._add_topic(topic, ros2_messages.WRENCH, {"unit": "N, N m"}) for topic in frames]
        port = self.DeclareVectorInputPort(name, 6 * len(frames))
        turned = [()] * len(frames) if bodies is None else [(int(body),) for body in bodies]
        for k, (channel, frame, body) in enumerate(zip(channels, frames.values(), turned, strict=True)):
            template, make = ros2_messages.wrench_template(frame), _in_body if body else None
            part = port, 6 * k + (np.arange(6) if body else _FORCE_FIRST)
            self._recorded.append(RecordedTopic(channel, [part], template, every, single_precision, make, body))
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
        self._check_port(name, every)
        channel = self._add_topic(name, message_type, metadata or {})
        port = self.DeclareVectorInputPort(name, size)
        self._encoded.append(EncodedTopic(channel, port, encode, every))
        return port

    def AddTemplateInput(
        self,
        name: str,
        size: int,
        message_type: str,
        template: CdrTemplate,
        make: Make | None = None,
        *,
        metadata: Mapping[str, str] | None = None,
        every: int = 1,
    ) -> InputPort:
        """As AddMessageInput, of messages that differ in times and numbers alone: many are encoded at once.

        Args:
            name, size, message_type, metadata, every: as in AddMessageInput.
            template: of the messages.
            make: makes N messages' numbers, the template's float64 and then its float32, of the port's values
                (N, size); None takes these as they are.

        Raises:
            RecorderError: the name is taken or unusable, or `every` is not 1 or more.
        """
        self._check_port(name, every)
        channel = self._add_topic(name, message_type, metadata or {})
        port = self.DeclareVectorInputPort(name, size)
        self._recorded.append(RecordedTopic(channel, [(port, np.arange(size))], template, every, make=make))
        return port

    def AddEventInput(self, name: str, names: Sequence[str]) -> InputPort:
        """Declares an input port (1) called `name` whose value is an index of `names`; returns the port.

        Whenever it changes, its name is written as an event, as `Event` does; so is the first. A number whose name is
        empty is no event. Call it before the diagram is built.

        Raises:
            RecorderError: the name is taken.
        """
        self._check_port(name, 1)
        self._check_early(name)
        port, last = self.DeclareVectorInputPort(name, 1), [-1]

        def encode(t_ns: int, value: np.ndarray) -> bytes | None:
            number = int(value[0])
            changed, last[0] = number != last[0], number
            return ros2_messages.log_message(t_ns, LOGGER, names[number]) if changed and names[number] else None

        self._encoded.append(EncodedTopic(self._events_channel, port, encode, 1))
        return port

    def _add_topic(self, name: str, message_type: str, metadata: Mapping[str, str]) -> int:
        """The channel of a topic of its own."""
        if not _NAME.fullmatch(name):
            raise RecorderError(f"recorder: '{name}' is no topic name; use letters, digits, '_', and '/' between parts")
        if name in self._topics:
            raise RecorderError(f"recorder: '{name}' is taken; choose another name")
        self._check_early(name)
        self._topics.add(name)
        return self._file.add_channel(f"/{name}", message_type, metadata)

    def _check_port(self, name: str, every: int) -> None:
        if every < 1:
            raise RecorderError(f"recorder: '{name}' is to be recorded every {every} samples; give 1 or more")
        if self.HasInputPort(name):
            raise RecorderError(f"recorder: '{name}' is taken; choose another name")

    def _check_early(self, name: str) -> None:
        if self._file.closed or self._sampled:
            raise RecorderError(f"recorder: '{name}' comes after the first sample; add it before the diagram is built")


def _in_body(rows: np.ndarray) -> np.ndarray:
    """Force, torque (N, 6) in a body's frame, of a wrench in W and the body's pose [R p] (N, 6 + 12)."""
    wrenches, poses = np.split(rows, [6], axis=1)
    return wrench_in_body(wrenches, poses.reshape(-1, 3, 4))[:, _FORCE_FIRST]
