"""The package's own CSV: `time_s,frame,ShoulderLeftX,...` in seconds and metres, a row a sample.

A missing point has empty cells. The numbers read back are those that were written.
"""

from pathlib import Path

import numpy as np

from drake_blfdmp.demonstration.demonstration import Recording
from drake_blfdmp.skeleton import POINTS, WRISTS

_SAMPLES_AT_ONCE = 4096


def joint_of(point: str) -> str:
    """A point of `skeleton.POINTS` in Kinect's spelling: "left_shoulder" is ShoulderLeft."""
    side, part = point.split("_")
    return part.title() + side.title()


def write_csv(path: Path, recording: Recording) -> None:
    """Writes a new file: positions, `ShoulderLeftConfidence` and so on where the sensor told any, and the hands'
    orientations as `WristLeftQw` to `WristRightQz` where there are any.

    Raises:
        OSError: the file exists or cannot be written.
    """
    joints = [joint_of(point) for point in POINTS]
    header = ["time_s", "frame", *(joint + axis for joint in joints for axis in "XYZ")]
    n = len(recording.t)
    tables = [recording.x.reshape(n, -1)]
    if recording.confidence is not None:
        header += [f"{joint}Confidence" for joint in joints]
        tables.append(recording.confidence)
    if recording.orientations is not None:
        header += [f"{joint_of(POINTS[wrist])}Q{axis}" for wrist in WRISTS for axis in "wxyz"]
        tables.append(recording.orientations.reshape(n, -1))
    with path.open("x", encoding="utf-8", newline="\n") as file:
        file.write(",".join(header) + "\n")
        for start in range(0, n, _SAMPLES_AT_ONCE):
            rows = slice(start, start + _SAMPLES_AT_ONCE)
            values = np.hstack([table[rows] for table in tables]).tolist()
            for t, frame, row in zip(recording.t[rows].tolist(), recording.frames[rows].tolist(), values, strict=True):
                # repr is the shortest text that reads back as the same number; NaN is the number unequal to itself.
                cells = [repr(value) if value == value else "" for value in row]
                file.write(f"{t!r},{frame},{','.join(cells)}\n")
