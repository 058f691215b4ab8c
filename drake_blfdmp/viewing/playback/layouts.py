"""Where the numbers of a ROS 2 message stand, found once for all messages of the same shape.

Messages on one topic may differ from each other: names in another order, joints or frames spread over several messages.
Each distinct set of names, in its order, is a layout; the numbers of a message of known layout are read at once.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from drake_blfdmp.ros2.cdr import CdrReader
from drake_blfdmp.ros2.messages import JOINT_STATE, TF, WRENCH

_LARGEST = 1e8  # m, rad or N; the browser draws with single precision.


@dataclass(frozen=True)
class Layout:
    """What messages of one shape share.

    Attributes:
        names: what each row of numbers belongs to: (parent, child) of a transform, (frame,) of a wrench, (joint or
            element,) of a joint state.
        width: numbers in a row: 7, 6 and 1.
    """

    names: tuple[tuple[str, ...], ...]
    width: int
    _columns: np.ndarray
    _fixed: np.ndarray
    _content: np.ndarray

    def fits(self, raw: np.ndarray) -> bool:
        """Whether a message (bytes, as long as the first) has this layout."""
        return bool(np.array_equal(raw[self._fixed], self._content))

    def values(self, message: bytes) -> np.ndarray:
        """The numbers (rows, width) of a message that fits, in its order; NaN where one is beyond any use."""
        raw = np.frombuffer(message, dtype=np.uint8)
        values = raw[self._columns].view("<f8").reshape(len(self.names), self.width).astype(float)
        return np.where(np.abs(values) < _LARGEST, values, np.nan)


def layout_of(message_type: str, message: bytes) -> Layout:
    """The layout of a JointState, TFMessage or WrenchStamped.

    Raises:
        ValueError: the message is not of this type, or no plain CDR.
    """
    reader = CdrReader(message)
    names, offsets, width = _READ[message_type](reader)
    if reader.left > 3 + 8:  # Padding at the end; more means another type.
        raise ValueError(f"{reader.left} bytes are left behind its last field")
    columns = np.add.outer(np.array(offsets, dtype=int), np.arange(8)).ravel()
    fixed = np.concatenate([np.arange(0), *(np.arange(at, at + size) for at, size in reader.structure)]).astype(int)
    content = np.frombuffer(message, dtype=np.uint8)[fixed]
    return Layout(tuple(names), width, columns, fixed, content)


_Read = tuple[list[tuple[str, ...]], list[int], int]


def _frame(name: str) -> str:
    """A frame's name; tf of ROS 1 began them with a slash."""
    return name.lstrip("/")


def _joint_state(reader: CdrReader) -> _Read:
    reader.stamp()
    reader.string()
    names = reader.strings()
    positions = reader.float64_sequence()
    reader.float64_sequence()
    reader.float64_sequence()
    if not positions:  # A message of velocities or efforts alone.
        return [], [], 1
    if len(positions) != len(names):
        raise ValueError(f"{len(names)} names but {len(positions)} positions")
    return [(name,) for name in names], positions, 1


def _transforms(reader: CdrReader) -> _Read:
    names, offsets = [], []
    for _ in range(reader.uint32()):
        reader.stamp()
        parent = reader.string()
        names.append((_frame(parent), _frame(reader.string())))
        offsets += reader.float64s(7)
    return names, offsets, 7


def _wrench(reader: CdrReader) -> _Read:
    reader.stamp()
    frame = reader.string()
    return [(_frame(frame),)], reader.float64s(6), 6


_READ: dict[str, Callable[[CdrReader], _Read]] = {JOINT_STATE: _joint_state, TF: _transforms, WRENCH: _wrench}
