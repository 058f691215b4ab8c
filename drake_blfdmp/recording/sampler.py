"""What is written of every sample of a run: the layout of all its messages, and the ports their numbers come from.

A sample is read at once and encoded later, together with others: in between the simulation has used up what a
processor keeps at hand, and Python's way through a dozen messages takes several times as long then.
"""

import math
import time
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from pydrake.math import RigidTransform
from pydrake.systems.framework import Context

from drake_blfdmp.recording.mcap_file import McapFile
from drake_blfdmp.recording.pose_rows import pose_rows
from drake_blfdmp.recording.sample_block import ROWS, SampleBlock
from drake_blfdmp.recording.topics import EncodedTopic, RecordedBodies, RecordedTopic
from drake_blfdmp.ros2 import messages as ros2_messages

LONGEST_S, SLOWEST_S = 0.4, 0.1
"""For how long a sample is held at most, s of wall time, and samples farther apart than this are not held at all."""


class _Held(NamedTuple):
    """A sample that is read and not yet written: time, number, bodies' poses, values of what is encoded one by one."""

    t_ns: int
    number: int
    poses: Sequence[RigidTransform]
    values: Sequence[np.ndarray]


class Sampler:
    """Reads samples of ports, holds them for a moment, and writes them to a file."""

    def __init__(
        self,
        topics: Sequence[RecordedTopic],
        bodies: RecordedBodies | None = None,
        encoded: Sequence[EncodedTopic] = (),
    ):
        """Fixes which messages a sample has, and where in them each port's numbers go."""
        # Of how many samples one is recorded -> its messages.
        self._blocks = {1: SampleBlock()}
        self._encoded = list(encoded)
        self._bodies = bodies
        finite = [np.empty(0, dtype=int)]
        for one in topics:
            block = self._blocks.setdefault(one.every, SampleBlock())
            places = np.concatenate([block.take(port)[order] for port, order in one.parts])
            if one.finite:
                finite.append(places)
            if one.make is not None:
                places = block.made(places, one.template.float64_count, one.make)
            block.add(one.channel, one.template, places, single_precision=one.single_precision)
        self._pose_places = self._lay_out_bodies(bodies)
        for block in self._blocks.values():
            block.finish()
        self._finite = np.concatenate(finite)
        self._moving = [] if bodies is None else list(bodies.indices.values())
        self._samples = 0
        self._held: list[_Held] = []
        self._since = self._last = -math.inf

    def _lay_out_bodies(self, bodies: RecordedBodies | None) -> np.ndarray:
        """Where the poses stand, one after the other."""
        block = self._blocks[1]
        places = block.room(7 * (0 if bodies is None else len(bodies.indices)))
        if bodies is not None:
            block.add(bodies.channel, ros2_messages.tf_template(bodies.frame, list(bodies.indices)), places)
        return places

    def sample(self, context: Context, t_ns: int, file: McapFile) -> None:
        """Reads one sample of everything, or nothing where a joint's state is not finite; writes what was held long."""
        number = self._samples
        states = self._blocks[1].sample(number % ROWS, context)[self._finite]
        # A sum, because it is several times faster than looking at each.
        if not math.isfinite(states.sum()) and not np.isfinite(states).all():
            return
        poses: Any = None if self._bodies is None else self._bodies.port.Eval(context)
        for every, block in self._blocks.items():
            if every > 1 and number % every == 0:
                block.sample(number // every % ROWS, context)
        values = [np.array(one.port.Eval(context)) for one in self._encoded if number % one.every == 0]
        # An interruption before leaves the sample out, one after leaves it in.
        self._held.append(_Held(t_ns, number, poses, values))
        self._samples = number + 1
        now = time.monotonic()
        if len(self._held) == 1:
            self._since = now
        slow, self._last = now - self._last > SLOWEST_S, now
        if slow or now - self._since > LONGEST_S or len(self._held) == ROWS:
            self.flush(file)

    def flush(self, file: McapFile) -> None:
        """Writes what is held; the file's bytes do not depend on when."""
        if not self._held:
            return
        records = {every: self._encode(every) for every in self._blocks}
        while self._held:
            one = self._held.pop(0)
            for every, block in self._blocks.items():
                if one.number % every == 0:
                    file.write_records(block.messages, one.t_ns, records[every][one.number])
            due = (topic for topic in self._encoded if one.number % topic.every == 0)
            for topic, value in zip(due, one.values, strict=True):
                message = topic.encode(one.t_ns, value)
                if message is not None:
                    file.write(topic.channel, one.t_ns, message)

    def _encode(self, every: int) -> dict[int, bytes]:
        """The records of a block for each held sample that has them, by its number."""
        due = [one for one in self._held if one.number % every == 0]
        places, rows = None, None
        if every == 1 and self._moving:
            matrices = [one.poses[index].GetAsMatrix34() for one in due for index in self._moving]
            places, rows = self._pose_places, pose_rows(np.array(matrices)).reshape(len(due), -1)
        at, times = [one.number // every % ROWS for one in due], [one.t_ns for one in due]
        records = self._blocks[every].encode(at, times, places, rows)
        return {one.number: record for one, record in zip(due, records, strict=True)}
