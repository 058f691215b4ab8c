"""What is written of every sample of a run: the layout of all its messages, and the ports their numbers come from.

A sample is read at once and encoded later, together with others: in between the simulation has used up what a
processor keeps at hand, and Python's way through a dozen messages takes several times as long then.
"""

import math
import time
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from pydrake.math import RigidTransform
from pydrake.systems.framework import Context

from drake_blfdmp.recording.mcap_file import McapFile, RecorderError
from drake_blfdmp.recording.piece import Piece
from drake_blfdmp.recording.sample_block import ROWS, SampleBlock
from drake_blfdmp.recording.topics import POSE_SIZE, EncodedTopic, PoseSource, RecordedTopic

LONGEST_S, SLOWEST_S = 0.4, 0.1
"""For how long a sample is held at most, s of wall time, and samples farther apart than this are not held at all."""


class _Held(NamedTuple):
    """A sample that is read and not yet written: its time, its number, and bodies' poses where a port gives them."""

    t_ns: int
    number: int
    poses: Sequence[RigidTransform]


class Sampler:
    """Reads samples of ports, holds them for a moment, and writes them to a file."""

    def __init__(
        self,
        topics: Sequence[RecordedTopic],
        encoded: Sequence[EncodedTopic] = (),
        poses: PoseSource | None = None,
    ):
        """Fixes which messages a sample has, and where in them each port's numbers go.

        Raises:
            RecorderError: a topic wants bodies' poses, and there is nothing that tells them.
        """
        self._block = SampleBlock()
        self._poses_port = None if poses is None or poses.make is not None else poses.port
        self._bodies = sorted({body for one in topics for body in one.bodies})
        pose_places = self._lay_out_poses(poses)
        finite = [np.empty(0, dtype=int)]
        for one in topics:
            parts = [self._block.take(port, one.every)[order] for port, order in one.parts]
            places = np.concatenate([*parts, *(pose_places[body] for body in one.bodies)])
            if one.finite:
                finite.append(places)
            if one.make is not None:
                count = one.template.float64_count + one.template.float32_count
                places = self._block.made(places, count, one.make, one.every)
            self._block.add(one.channel, one.template, places, one.every, single_precision=one.single_precision)
        self._encoded = [(one, self._block.take(one.port, one.every)) for one in encoded]
        self._block.finish()
        self._finite = np.concatenate(finite)
        self._samples = 0
        self._held: list[_Held] = []
        self._since = self._last = -math.inf

    def _lay_out_poses(self, poses: PoseSource | None) -> dict[int, np.ndarray]:
        """Body -> where its pose stands."""
        self._pose_places, count = np.empty(0, dtype=int), POSE_SIZE * len(self._bodies)
        if not self._bodies:
            return {}
        if poses is None:
            raise RecorderError("recorder: poses of bodies are wanted, which only a recorder of a plant knows")
        if poses.make is None:
            self._pose_places = places = self._block.room(count)
        else:
            places = self._block.made(self._block.take(poses.port), count, poses.make(self._bodies))
        return dict(zip(self._bodies, places.reshape(-1, POSE_SIZE), strict=True))

    def sample(self, context: Context, t_ns: int, file: McapFile) -> None:
        """Reads one sample of everything, or nothing where a joint's state is not finite; writes what was held long."""
        number = self._samples
        states = self._block.sample(number, context)[self._finite]
        # Their squares' sum, because it is several times faster than looking at each.
        if not math.isfinite(states.dot(states)) and not np.isfinite(states).all():
            return
        poses: Any = () if self._poses_port is None else self._poses_port.Eval(context)
        self._block.sample_slow(number, context)
        # An interruption before leaves the sample out, one after leaves it in.
        self._held.append(_Held(t_ns, number, poses))
        self._samples = number + 1
        now = time.monotonic()
        if len(self._held) == 1:
            self._since = now
        slow, self._last = now - self._last > SLOWEST_S, now
        if slow or now - self._since > LONGEST_S or len(self._held) == ROWS:
            self.flush(file)

    def flush(self, file: McapFile) -> None:
        """Writes what is held; the file's bytes do not depend on when."""
        if self._held:
            file.write_pieces(self._pieces(file))

    def _pieces(self, file: McapFile) -> Iterator[Piece]:
        """What is to be written; a sample is no longer held once its pieces are taken."""
        held, given = self._held, None
        if self._poses_port is not None and self._bodies:
            matrices = [one.poses[body].GetAsMatrix34() for one in held for body in self._bodies]
            given = np.reshape(matrices, (len(held), -1))
        numbers, times = [one.number for one in held], [one.t_ns for one in held]
        values, pieces = self._block.encode(numbers, times, self._pose_places, given)
        for row, blocks in zip(values, pieces, strict=True):
            one = held.pop(0)
            for block, records in blocks:
                yield Piece(records, one.t_ns, block)
            for topic, places in self._encoded:
                message = topic.encode(one.t_ns, row[places]) if one.number % topic.every == 0 else None
                if message is not None:
                    yield file.piece(topic.channel, one.t_ns, message)
