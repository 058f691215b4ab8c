"""All messages of a sample as one block, and the ports that its numbers come from."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from pydrake.systems.framework import Context, InputPort

from drake_blfdmp.recording.message_block import MessageBlock
from drake_blfdmp.ros2.cdr import CdrTemplate

Make = Callable[[np.ndarray], np.ndarray]
"""Numbers (N, m) of N samples, made of others (N, n) of theirs."""

ROWS = 64
"""How many samples can be held before they are encoded together."""


class SampleBlock:
    """Gathers the values of ports, sample by sample, and encodes many samples at once. ::

        places = block.take(port)              # for every port
        block.add(channel, template, places)   # for every message
        block.finish()
        values = block.sample(row, context)    # for every sample
        records = block.encode(rows, times)    # of several

    Attributes, once it is finished:
        messages: the block.
    """

    def __init__(self):
        self.messages = MessageBlock([])
        self._count = 0
        self._ports: dict[int, tuple[InputPort, np.ndarray]] = {}
        self._messages: list[tuple[int, CdrTemplate]] = []
        self._order: list[np.ndarray] = [np.empty(0, dtype=int)]
        self._rounded = np.empty(0, dtype=int)
        self._parts: list[tuple[InputPort, slice]] = []
        self._made: list[tuple[np.ndarray, Make, np.ndarray]] = []
        self._values = np.empty((ROWS, 0))

    def take(self, port: InputPort) -> np.ndarray:
        """The places among the values that the port's numbers get; a port taken twice is evaluated once."""
        index = int(port.get_index())
        if index not in self._ports:
            self._ports[index] = port, self.room(port.size())
        return self._ports[index][1]

    def room(self, count: int) -> np.ndarray:
        """Places of numbers that come from no port, but from what is given to `encode`."""
        self._count += count
        return np.arange(self._count - count, self._count)

    def made(self, places: np.ndarray, count: int, make: Make) -> np.ndarray:
        """The places of `count` numbers that are made of those at `places` when samples are encoded."""
        room = self.room(count)
        self._made.append((places, make, room))
        return room

    def add(self, channel: int, template: CdrTemplate, places: np.ndarray, *, single_precision: bool = False) -> None:
        """A message whose numbers are the values at `places`, rounded if so asked."""
        self._messages.append((channel, template))
        self._order.append(places)
        if single_precision:
            self._rounded = np.concatenate([self._rounded, places])

    def finish(self) -> None:
        """Lays everything out."""
        self._values = np.zeros((ROWS, self._count))
        self._parts = [(port, slice(places[0], places[0] + len(places))) for port, places in self._ports.values()]
        self.messages = MessageBlock(self._messages, np.concatenate(self._order))

    def sample(self, row: int, context: Context) -> np.ndarray:
        """Evaluates all ports, and holds their values (M,) in a row."""
        values = self._values[row]
        for port, part in self._parts:
            value: Any = port.Eval(context)
            values[part] = value
        return values

    def encode(
        self, rows: Sequence[int], times_ns: Sequence[int], places: np.ndarray | None = None, numbers: Any = None
    ) -> list[bytes]:
        """The records of each of some rows.

        Args:
            rows: (N,) in which they are held.
            times_ns: (N,) simulated times, ns.
            places, numbers: (P,) from `room`, and (N, P) what stands there.
        """
        values = self._values[rows]
        if places is not None:
            values[:, places] = numbers
        for given, make, room in self._made:
            values[:, room] = make(values[:, given])
        values[:, self._rounded] = values[:, self._rounded].astype(np.float32)
        return self.messages.encode(np.array(times_ns), values)
