"""What is written at every sample of a run: the layout of all its messages, and the ports their numbers come from."""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from pydrake.systems.framework import Context, InputPort

from drake_blfdmp.recording.mcap_file import McapFile
from drake_blfdmp.recording.pose_rows import PoseRows
from drake_blfdmp.recording.sample_block import SampleBlock
from drake_blfdmp.ros2 import messages as ros2_messages
from drake_blfdmp.ros2.cdr import CdrTemplate

Encode = Callable[[int, np.ndarray], bytes]
"""The message of a port's value at a time in ns."""


class RecordedPort(NamedTuple):
    """A port that is recorded on a topic of its own.

    Attributes:
        channel, port: where to and where from.
        content: template of its messages, or what makes them.
        every: of how many samples one is recorded.
        order: (n,) place in the port's value of each number in a template.
        single_precision: whether these numbers are rounded.
    """

    channel: int
    port: InputPort
    content: CdrTemplate | Encode
    every: int
    order: np.ndarray
    single_precision: bool = False


class RecordedJoints(NamedTuple):
    """What goes into `/joint_states`.

    Attributes:
        channel: where to.
        names: of all joints, group by group.
        states, efforts: a port a group: [q, v]; torques, which are recorded when every group has them.
    """

    channel: int
    names: Sequence[str]
    states: Sequence[InputPort]
    efforts: Sequence[InputPort]


class RecordedBodies(NamedTuple):
    """What goes into `/tf`.

    Attributes:
        channel, port: where to and where from.
        frame: that the poses are in.
        indices: name of a body -> its index in the port's value.
    """

    channel: int
    port: InputPort
    frame: str
    indices: Mapping[str, int]


class Sampler:
    """Writes samples of ports to a file."""

    def __init__(
        self,
        context: Context,
        joints: RecordedJoints | None,
        bodies: RecordedBodies | None,
        ports: Sequence[RecordedPort],
    ):
        """Fixes which messages a sample has, and where in them each port's numbers go.

        Args:
            context: in which what is connected has a value.
        """
        block = SampleBlock()
        # Of how many samples one is recorded -> its messages; those that are encoded one by one.
        self._blocks = {1: block}
        self._apart = [one for one in ports if not isinstance(one.content, CdrTemplate)]
        self._bodies = bodies
        self._samples = 0
        state_count = self._lay_out_joints(context, joints)
        for one in ports:
            if isinstance(one.content, CdrTemplate):
                its = self._blocks.setdefault(one.every, SampleBlock())
                places = its.take(one.port)[one.order]
                its.add(one.channel, one.content, places, single_precision=one.single_precision)
        indices = {} if bodies is None else bodies.indices
        self._pose_rows = PoseRows(len(indices))
        places = block.room(7 * len(indices))
        if bodies is not None:
            block.add(bodies.channel, ros2_messages.tf_template(bodies.frame, list(indices)), places)
        for its in self._blocks.values():
            its.finish()
        self._states = block.values[:state_count]
        self._poses = block.values[len(block.values) - len(places) :].reshape(-1, 7)

    def _lay_out_joints(self, context: Context, joints: RecordedJoints | None) -> int:
        """How many numbers the states have; they stand first."""
        if joints is None:
            return 0
        block = self._blocks[1]
        states = [block.take(port).reshape(2, -1) for port in joints.states]
        fields = [state[0] for state in states] + [state[1] for state in states]
        # JointState wants an effort for every joint or for none.
        effort = all(port.HasValue(context) for port in joints.efforts)
        if effort:
            fields += [block.take(port) for port in joints.efforts]
        template = ros2_messages.joint_state_template(joints.names, effort=effort)
        block.add(joints.channel, template, np.concatenate(fields))
        return sum(state.size for state in states)

    def write(self, context: Context, t_ns: int, file: McapFile) -> None:
        """Writes one sample of everything, or nothing where a joint's state is not finite."""
        self._blocks[1].fill(context)
        # A sum, because it is several times faster than looking at each.
        if not math.isfinite(self._states.sum()) and not np.isfinite(self._states).all():
            return
        if self._bodies is not None:
            poses: Any = self._bodies.port.Eval(context)
            moving = self._bodies.indices.values()
            self._poses[:] = self._pose_rows.fill([poses[index].GetAsMatrix34() for index in moving])
        for every, block in self._blocks.items():
            if self._samples % every == 0:
                if every > 1:
                    block.fill(context)
                file.write_block(block.messages, t_ns, block.values)
        for one in self._apart:
            if self._samples % one.every == 0:
                value: Any = one.port.Eval(context)
                file.write(one.channel, t_ns, one.content(t_ns, value))  # type: ignore[operator]
        self._samples += 1
