"""Headerless Kinect v1 rows, as in UTKinect-Action3D: a frame number, then 20 joints x, y, z in metres, y up.

Source: Xia, Chen, Aggarwal, "View invariant human action recognition using histograms of 3D joints", CVPRW 2012. The
frame number counts a 30 Hz clock; frames without a tracked person are left out and some numbers occur twice.
"""

from pathlib import Path

import numpy as np

from drake_blfdmp.demonstration.demonstration import Recording
from drake_blfdmp.demonstration.formats.point_names import resolve
from drake_blfdmp.demonstration.formats.recording_format import ReadOptions, assemble
from drake_blfdmp.demonstration.formats.text import head_lines, is_number, number_or_nan, numbered_lines
from drake_blfdmp.errors import RecordingError
from drake_blfdmp.skeleton import POINTS

CLOCK_HZ = 30.0
JOINTS = (
    "HipCenter", "Spine", "ShoulderCenter", "Head",
    "ShoulderLeft", "ElbowLeft", "WristLeft", "HandLeft",
    "ShoulderRight", "ElbowRight", "WristRight", "HandRight",
    "HipLeft", "KneeLeft", "AnkleLeft", "FootLeft",
    "HipRight", "KneeRight", "AnkleRight", "FootRight",
)  # fmt: skip
COLUMNS = 1 + 3 * len(JOINTS)


class KinectV1Rows:
    """Reader of Kinect v1 rows; `joints` may name any of `JOINTS`."""

    name = "kinect_v1_rows"
    up = "y"

    def sniff(self, head: bytes) -> bool:
        """Whether one of the first lines is a row of 61 numbers (a damaged row must not hide the format)."""
        rows = [_cells(line) for line in head_lines(head)[:5]]
        return any(len(row) == COLUMNS and all(map(is_number, row)) for row in rows)

    def read(self, path: Path, options: ReadOptions) -> Recording:
        """Reads the file; time is frame number / 30 Hz.

        Raises:
            RecordingError: a row with another number of columns, a cell that is no number, or an unknown joint.
        """
        chosen = resolve(str(path), JOINTS, options.joints)
        first_columns = []
        for point in POINTS:
            name = chosen[point]
            if not isinstance(name, str):
                raise RecordingError(f"{path}: columns have no names in this format; give {point} one joint name")
            first_columns.append(1 + 3 * JOINTS.index(name))
        wanted = [column + axis for column in first_columns for axis in range(3)]
        frames: list[int] = []
        rows: list[list[float]] = []
        for number, line in numbered_lines(path):
            cells = _cells(line)
            if len(cells) != COLUMNS:
                raise RecordingError(
                    f"{path}: line {number} has {len(cells)} columns, expected {COLUMNS} "
                    "(frame number and 20 joints x, y, z); repair or remove the line"
                )
            try:
                frames.append(int(float(cells[0])))
                rows.append([number_or_nan(cells[column]) for column in wanted])
            except (ValueError, OverflowError):
                raise RecordingError(
                    f"{path}: line {number} holds a cell that is no number; repair or remove it"
                ) from None
        frame_numbers = np.array(frames, dtype=int)
        x = np.array(rows, dtype=float).reshape(-1, len(POINTS), 3)
        return assemble(path, self.name, options, frame_numbers / CLOCK_HZ, x, frame_numbers)


def _cells(line: str) -> list[str]:
    return line.replace(",", " ").split()
