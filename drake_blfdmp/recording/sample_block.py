"""All messages of a sample as one block, and the ports that its numbers come from."""

from typing import Any

import numpy as np
from pydrake.systems.framework import Context, InputPort

from drake_blfdmp.recording.message_block import MessageBlock
from drake_blfdmp.ros2.cdr import CdrTemplate


class SampleBlock:
    """Gathers the values of ports, and says where in a MessageBlock each goes. ::

        places = block.take(port)              # for every port
        block.add(channel, template, places)   # for every message
        block.finish()
        block.fill(context)                    # for every sample

    Attributes, once it is finished:
        messages: the block.
        values: (M,) the numbers of a sample, in the order in which they were taken.
    """

    def __init__(self):
        self.messages = MessageBlock([])
        self.values = np.empty(0)
        self._count = 0
        self._ports: list[tuple[InputPort, np.ndarray]] = []
        self._messages: list[tuple[int, CdrTemplate]] = []
        self._order: list[np.ndarray] = [np.empty(0, dtype=int)]
        self._rounded = np.empty(0, dtype=int)
        self._parts: list[tuple[InputPort, np.ndarray]] = []
        self._round: list[np.ndarray] = []

    def take(self, port: InputPort) -> np.ndarray:
        """The places among the values that the port's numbers get."""
        places = self.room(port.size())
        self._ports.append((port, places))
        return places

    def room(self, count: int) -> np.ndarray:
        """Places of numbers that come from no port, but are written to `values` by hand."""
        self._count += count
        return np.arange(self._count - count, self._count)

    def add(self, channel: int, template: CdrTemplate, places: np.ndarray, *, single_precision: bool = False) -> None:
        """A message whose numbers are the values at `places`, rounded if so asked."""
        self._messages.append((channel, template))
        self._order.append(places)
        if single_precision:
            self._rounded = np.concatenate([self._rounded, places])

    def finish(self) -> None:
        """Lays everything out."""
        self.values = np.empty(self._count)
        self._parts = [(port, self.values[places[0] : places[0] + len(places)]) for port, places in self._ports]
        # Whole stretches, because a list of places takes several times as long.
        places = np.unique(self._rounded)
        gaps = np.flatnonzero(np.diff(places) > 1) + 1
        self._round = [self.values[part[0] : part[-1] + 1] for part in np.split(places, gaps) if len(part)]
        self.messages = MessageBlock(self._messages, np.concatenate(self._order))

    def fill(self, context: Context) -> None:
        """Evaluates all ports."""
        for port, part in self._parts:
            value: Any = port.Eval(context)
            part[:] = value
        for part in self._round:
            part[:] = part.astype(np.float32)
