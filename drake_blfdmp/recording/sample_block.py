"""All numbers of the samples that are held, what is made of them, and the messages that they stand in."""

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


class _Cadence:
    """What is recorded of one of so many samples."""

    def __init__(self, every: int):
        self.every = every
        self.ports: dict[int, tuple[InputPort, np.ndarray]] = {}
        self.parts: list[tuple[InputPort, slice]] = []
        self.made: list[tuple[np.ndarray, Make, np.ndarray]] = []
        self.messages: list[tuple[int, CdrTemplate]] = []
        self.block = MessageBlock([])
        self.order = self.rounded = np.empty(0, dtype=int)

    def add(self, channel: int, template: CdrTemplate, places: np.ndarray, *, single_precision: bool) -> None:
        if single_precision:
            self.rounded = np.append(self.rounded, len(self.order) + np.arange(len(places)))
        self.order = np.append(self.order, places)
        self.messages.append((channel, template))

    def finish(self) -> None:
        self.parts = [(port, slice(places[0], places[0] + len(places))) for port, places in self.ports.values()]
        self.block = MessageBlock(self.messages)

    def sample(self, values: np.ndarray, context: Context) -> None:
        for port, part in self.parts:
            value: Any = port.Eval(context)
            values[part] = value

    def encode(self, times_ns: np.ndarray, values: np.ndarray) -> list[bytes]:
        """The records of samples; writes what is made into their values."""
        for given, make, room in self.made:
            values[:, room] = make(values[:, given])
        numbers = values[:, self.order]
        numbers[:, self.rounded] = numbers[:, self.rounded].astype(np.float32)
        return self.block.encode(times_ns, numbers)


class SampleBlock:
    """Gathers the values of ports, sample by sample, and encodes many samples at once. ::

        places = block.take(port, every)             # for every port
        places = block.made(places, 3, make, every)  # for what is made of others
        block.add(channel, template, places, every)  # for every message
        block.finish()
        block.sample(number, context)                # for every sample
        block.sample_slow(number, context)
        values, pieces = block.encode(numbers, times)  # of several

    Of samples 0, 1, 2 and so on those are recorded whose number is a multiple of `every`.
    """

    def __init__(self):
        self._count = 0
        self._always = _Cadence(1)
        self._cadences = {1: self._always}  # This one first: what the others are made of.
        self._values = np.empty((ROWS, 0))

    def take(self, port: InputPort, every: int = 1) -> np.ndarray:
        """The places among the values that the port's numbers get; a port that is there already is evaluated once."""
        index, cadence = int(port.get_index()), self._cadence(every)
        for one in (self._always, cadence):
            if index in one.ports:
                return one.ports[index][1]
        places = self.room(port.size())
        cadence.ports[index] = port, places
        return places

    def room(self, count: int) -> np.ndarray:
        """Places of numbers that come from no port, but from what is given to `encode`."""
        self._count += count
        return np.arange(self._count - count, self._count)

    def made(self, places: np.ndarray, count: int, make: Make, every: int = 1) -> np.ndarray:
        """The places of `count` numbers that are made of those at `places` when samples are encoded."""
        room = self.room(count)
        self._cadence(every).made.append((places, make, room))
        return room

    def add(
        self,
        channel: int,
        template: CdrTemplate,
        places: np.ndarray,
        every: int = 1,
        *,
        single_precision: bool = False,
    ) -> None:
        """A message whose numbers are the values at `places`, rounded if so asked."""
        self._cadence(every).add(channel, template, places, single_precision=single_precision)

    def finish(self) -> None:
        """Lays everything out."""
        self._values = np.zeros((ROWS, self._count))
        for cadence in self._cadences.values():
            cadence.finish()

    def sample(self, number: int, context: Context) -> np.ndarray:
        """Evaluates the ports of which every sample is recorded, and holds their values among all (M,)."""
        values = self._values[number % ROWS]
        self._always.sample(values, context)
        return values

    def sample_slow(self, number: int, context: Context) -> None:
        """The other ports that are due."""
        for every, cadence in self._cadences.items():
            if every > 1 and number % every == 0:
                cadence.sample(self._values[number % ROWS], context)

    def encode(
        self, numbers: Sequence[int], times_ns: Sequence[int], places: np.ndarray | None = None, given: Any = None
    ) -> tuple[np.ndarray, list[list[tuple[MessageBlock, bytes]]]]:
        """The values of N samples that are held (N, M), and of each its records, block by block.

        Args:
            numbers: (N,) of the samples.
            times_ns: (N,) simulated times, ns.
            places, given: (P,) from `room`, and (N, P) what stands there.
        """
        values, times = self._values[[number % ROWS for number in numbers]], np.array(times_ns)
        if places is not None:
            values[:, places] = given
        pieces: list[list[tuple[MessageBlock, bytes]]] = [[] for _ in numbers]
        for every, cadence in self._cadences.items():
            due = [k for k, number in enumerate(numbers) if number % every == 0]
            if not due:
                continue
            records = cadence.encode(times[due], values if every == 1 else values[due])
            if cadence.messages:
                for k, record in zip(due, records, strict=True):
                    pieces[k].append((cadence.block, record))
        return values, pieces

    def _cadence(self, every: int) -> _Cadence:
        return self._cadences.setdefault(every, _Cadence(every))
