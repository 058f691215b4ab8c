"""Rows of numbers without a header: the joints of a depth sensor in its own order, as in UTKinect-Action3D.

A row begins with a frame number, a time, both, either with a person's number, or nothing; then come the sensor's
joints, each x, y, z (3 numbers), with its tracking state or confidence (4), or with its orientation as a quaternion
between (7, 8). How many numbers a row has tells all this. Source of the plainest kind: Xia, Chen, Aggarwal, "View
invariant human action recognition using histograms of 3D joints", CVPRW 2012; frames without a person are left out
there, and some numbers occur twice.
"""

from collections import Counter
from collections.abc import Collection, Iterable, Sequence
from itertools import islice
from pathlib import Path
from typing import NamedTuple

import numpy as np

from drake_blfdmp.demonstration.formats.confidence import confidence_of_numbers
from drake_blfdmp.demonstration.formats.point_names import resolve
from drake_blfdmp.demonstration.formats.recording_format import Joints
from drake_blfdmp.demonstration.formats.sensor_joints import AZURE_KINECT, KINECT_V1, KINECT_V2
from drake_blfdmp.demonstration.formats.tables.dialect import COMMENTS, Dialect, find_dialect
from drake_blfdmp.demonstration.formats.tables.table_rows import leading_columns, split_people
from drake_blfdmp.demonstration.formats.tables.tables import read_columns
from drake_blfdmp.demonstration.formats.text import head_lines, is_digits, is_number, numbered_lines
from drake_blfdmp.demonstration.raw_recording import RawRecording
from drake_blfdmp.errors import RecordingError
from drake_blfdmp.skeleton import POINTS

_LEADING = (0, 1, 2)  # Frame number, time, person: not all three.
_CELLS = (3, 4, 7, 8)
_SAMPLE_ROWS = 20


class Layout(NamedTuple):
    """How rows are written: cells before the joints, cells a joint, separators."""

    leading: int
    cells: int
    dialect: Dialect


class JointRows:
    """Reader of one sensor's rows; `joints` may name any of the sensor's joints.

    Args:
        name: of the format.
        order: the sensor's joints.
        up: the axis that points up in its frame.
        unit: of its lengths, where all tools write the same.
        clock_hz: its frame rate, where it has only one.
    """

    def __init__(
        self, name: str, order: Sequence[str], up: str, unit: str | None = None, clock_hz: float | None = None
    ):
        self.name = name
        self._order = tuple(order)
        self._up = up
        self._unit = unit
        self._clock_hz = clock_hz
        self._layouts = {first + cells * len(order): (first, cells) for first in _LEADING for cells in _CELLS}

    def sniff(self, head: bytes) -> bool:
        """Whether most of the first lines are rows of so many numbers (a damaged row must not hide the format)."""
        return self._layout(head_lines(head)) is not None

    def read(self, path: Path, joints: Joints | None) -> RawRecording:
        """Reads the file.

        Raises:
            RecordingError: a row with another number of columns, a cell that is no number, or an unknown joint.
        """
        layout = self._layout(line for _, line in numbered_lines(path))
        if layout is None:
            number, line = next(numbered_lines(path), (1, ""))
            raise RecordingError(
                f"{path}: line {number} has {len(find_dialect(line).row(line))} columns, expected {len(self._order)} "
                "joints of 3, 4, 7 or 8 numbers, after frame number or time or neither; give another format"
            )
        first, cells, dialect = layout
        order = self._sorted_joints(path, joints)
        columns = [first + cells * joint + axis for joint in order[: len(POINTS)] for axis in range(3)]
        states = [first + cells * joint + cells - 1 for joint in order] if cells in (4, 8) else []
        leading = list(range(first))
        table = read_columns(
            path,
            dialect,
            first + cells * len(self._order),
            [*leading, *columns, *states],
            leading,
            skip_empty=first > 0,
        )
        x = np.stack([table.numbers[column] for column in columns], axis=-1).reshape(-1, len(POINTS), 3)
        said = np.stack([table.numbers[column] for column in states], axis=-1) if states else np.empty((len(x), 0))
        confidence, note = confidence_of_numbers(said, x)
        t, frames, person = leading_columns(table, leading)
        bodies, empty = split_people(person, x, t, frames, confidence)
        return RawRecording(
            bodies,
            unit=self._unit,
            clock_hz=self._clock_hz,
            up=self._up,
            empty_frames=empty,
            notes=(note,) if note else (),
        )

    def _layout(self, lines: Iterable[str]) -> Layout | None:
        """That of most of the first rows."""
        seen: Counter[Layout] = Counter()
        rows = (line for line in lines if not line.startswith(COMMENTS))
        for line in islice(rows, _SAMPLE_ROWS):
            dialect = find_dialect(line, *self._layouts)
            width = width_of_numbers(line, dialect, self._layouts)
            if width:
                seen[Layout(*self._layouts[width], dialect)] += 1
        return max(seen, key=lambda layout: seen[layout]) if seen else None

    def _sorted_joints(self, path: Path, joints: Joints | None) -> list[int]:
        """Numbers of the sensor's joints, those of the points first."""
        chosen = resolve(str(path), self._order, joints)
        numbers: list[int] = []
        for point in POINTS:
            name = chosen[point]
            if not isinstance(name, str):
                raise RecordingError(f"{path}: columns have no names in this format; give {point} one joint name")
            numbers.append(self._order.index(name))
        return numbers + [joint for joint in range(len(self._order)) if joint not in numbers]


def width_of_numbers(line: str, dialect: Dialect, widths: Collection[int]) -> int:
    """The number of cells of a row that holds one of `widths` numbers and nothing else; 0 for any other line."""
    cells = dialect.row(line)
    rows = len(cells) in widths and all(map(is_number, cells)) and any(map(is_digits, cells))
    return len(cells) if rows else 0


KINECT_V1_ROWS = JointRows("kinect_v1_rows", KINECT_V1, up="y", unit="m", clock_hz=30.0)
KINECT_V2_ROWS = JointRows("kinect_v2_rows", KINECT_V2, up="y", unit="m", clock_hz=30.0)
AZURE_KINECT_ROWS = JointRows("azure_kinect_rows", AZURE_KINECT, up="-y")
