"""One message of a recording as names and numbers. Without pydrake."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from drake_blfdmp.ros2.cdr import CdrReader
from drake_blfdmp.ros2.messages import JOINT_STATE, LOG, STRING, TF, WRENCH


@dataclass(frozen=True)
class Sample:
    """One message.

    Attributes:
        topic: its name, `/` included.
        type: of the message, for example sensor_msgs/msg/JointState.
        t: log time, s.
        names: joints, elements, child frames; force and torque of a wrench.
        values: joint states (names, 3) position, velocity, effort, NaN where not recorded; vectors (names,); transforms
            (names, 7) x y z (m) qx qy qz qw; wrenches (2, 3) force (N), torque (N m); empty of every other type.
        frames: parent frame of each transform; frame of a wrench.
        text: of a String or a Log.
        unit: of a vector or wrench; empty otherwise.
        data: the message's bytes, for types that are not decoded here.
    """

    topic: str
    type: str
    t: float
    names: tuple[str, ...]
    values: np.ndarray
    frames: tuple[str, ...]
    text: str
    unit: str
    data: bytes = field(repr=False)


class Layout(NamedTuple):
    """Where the numbers of a message stand.

    Attributes:
        names, frames: as in `Sample`.
        float64s: byte offset of each number.
        stamps: byte offset of each time stamp (8 bytes).
        present: of a joint state, whether positions, velocities and efforts are there.
    """

    names: tuple[str, ...]
    frames: tuple[str, ...]
    float64s: list[int]
    stamps: list[int]
    present: tuple[bool, ...] = ()


def _joint_state(message: bytes) -> Layout:
    reader = CdrReader(message)
    stamp = reader.stamp()
    reader.string()
    names = tuple(reader.strings())
    fields = [reader.float64_sequence() for _ in range(3)]
    for what, columns in zip(("positions", "velocities", "efforts"), fields, strict=True):
        if len(columns) not in (0, len(names)):
            raise ValueError(f"{len(columns)} {what} of {len(names)} joints")
    return Layout(names, (), [at for columns in fields for at in columns], [stamp], tuple(map(bool, fields)))


def _transforms(message: bytes) -> Layout:
    reader = CdrReader(message)
    names, parents, float64s, stamps = [], [], [], []
    for _ in range(reader.uint32()):
        stamps.append(reader.stamp())
        parents.append(reader.string())
        names.append(reader.string())
        float64s += reader.float64s(7)
    return Layout(tuple(names), tuple(parents), float64s, stamps)


def _wrench(message: bytes) -> Layout:
    reader = CdrReader(message)
    stamp = reader.stamp()
    frame = reader.string()
    return Layout(("force", "torque"), (frame,), reader.float64s(6), [stamp])


LAYOUTS: Mapping[str, Callable[[bytes], Layout]] = {JOINT_STATE: _joint_state, TF: _transforms, WRENCH: _wrench}


def shaped(type_name: str, layout: Layout, numbers: np.ndarray, unit: str) -> np.ndarray:
    """(N, ...) values as in `Sample` of N messages' numbers (N, M), in the messages' order."""
    n, names = len(numbers), len(layout.names)
    if type_name == TF:
        return numbers.reshape(n, names, 7)
    if type_name == WRENCH:
        return numbers.reshape(n, 2, 3)
    if unit:
        return numbers
    values = np.full((n, names, 3), np.nan)
    values[:, :, np.flatnonzero(layout.present)] = numbers.reshape(n, -1, names).transpose(0, 2, 1)
    return values


def text_of(type_name: str, message: bytes) -> str:
    """The text of a String or a Log; empty of every other type.

    Raises:
        ValueError: it is no such message.
    """
    reader = CdrReader(message)
    if type_name == LOG:
        reader.stamp()
        reader.uint8()
        reader.string()
    return reader.string() if type_name in (STRING, LOG) else ""


class Decoder:
    """Decodes one topic's messages; a layout is worked out anew only when something but the numbers changes."""

    def __init__(self, topic: str, type_name: str, unit: str):
        """Of a topic, its type, and the unit in its metadata."""
        self._topic, self._type, self._unit = topic, type_name, unit
        self._layout: Layout | None = None
        self._constant = np.zeros(0, dtype=bool)
        self._pattern = np.zeros(0, dtype=np.uint8)
        self._columns = np.zeros(0, dtype=int)

    def decode(self, t: float, message: bytes) -> Sample:
        """The sample of a message at log time `t` (s).

        Raises:
            ValueError: the bytes are not of the topic's type.
        """
        if self._type not in LAYOUTS:
            text = text_of(self._type, message) if self._type in (STRING, LOG) else ""
            return Sample(self._topic, self._type, t, (), np.empty(0), (), text, self._unit, message)
        raw = np.frombuffer(message, dtype=np.uint8)
        layout = self._layout
        if layout is None or len(raw) != len(self._constant) or (raw[self._constant] != self._pattern).any():
            layout = self._learn(message)
        numbers = raw[self._columns].view("<f8")
        values = shaped(self._type, layout, numbers[None], self._unit)[0]
        return Sample(self._topic, self._type, t, layout.names, values, layout.frames, "", self._unit, message)

    def _learn(self, message: bytes) -> Layout:
        layout = LAYOUTS[self._type](message)
        if self._unit and layout.present and layout.present != (True, False, False):
            self._unit = ""  # Joint states whose writer names a unit.
        self._layout = layout
        self._constant, self._columns = constant_bytes(layout, len(message))
        self._pattern = np.frombuffer(message, dtype=np.uint8)[self._constant]
        return layout


def constant_bytes(layout: Layout, length: int) -> tuple[np.ndarray, np.ndarray]:
    """Which (length,) bytes stay from message to message of one layout, and where (8 M,) those of the numbers are."""
    columns = np.add.outer(np.array(layout.float64s, dtype=int), np.arange(8)).ravel()
    constant = np.ones(length, dtype=bool)
    constant[columns] = False
    constant[np.add.outer(np.array(layout.stamps, dtype=int), np.arange(8)).ravel()] = False
    return constant, columns
