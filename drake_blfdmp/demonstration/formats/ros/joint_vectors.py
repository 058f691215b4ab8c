"""The six points as named numbers in sensor_msgs JointState, `left_shoulder_x` and so on: how runs are recorded."""

import re

import numpy as np

from drake_blfdmp.demonstration.formats.recording_format import Joints
from drake_blfdmp.demonstration.formats.ros.body_names import named_bodies
from drake_blfdmp.demonstration.formats.ros.ros_fields import alike, columns, reader_of, stamps
from drake_blfdmp.demonstration.formats.ros.ros_topics import Topic, printable, times_of
from drake_blfdmp.demonstration.raw_recording import Body, RawRecording
from drake_blfdmp.errors import RecordingError
from drake_blfdmp.skeleton import POINTS

_AXIS = re.compile(r"^(.+?)[\s_.:/]*([xyz])$", re.I)


def names_of(message: bytes, cdr: bool) -> list[str]:
    """The names in a JointState; none where it is no such message."""
    try:
        return _walk(reader_of(message, cdr), cdr)[0]
    except ValueError:
        return []


def has_points(names: list[str]) -> bool:
    """Whether the names are the coordinates of somebody's six points."""
    return bool(named_bodies(_stems(names)))


def read_joint_vectors(where: str, topic: Topic, joints: Joints | None) -> RawRecording:
    """The people on a topic; `joints` is not asked, since joints are named.

    Raises:
        RecordingError: a message that is none, or without the six points.
    """
    t_ns, log_ns = np.zeros(len(topic.messages), np.int64), np.array(topic.log_ns, float)
    x: dict[str, np.ndarray] = {}

    def walk(message: bytes):
        reader = reader_of(message, topic.cdr)
        return _walk(reader, topic.cdr), reader.structure

    try:
        for (names, stamp, at, count), numbers, raw in alike(topic.messages, walk):
            t_ns[numbers] = stamps(raw, stamp, topic.cdr)
            values = columns(raw, at, count, "<f8")
            stems = _stems(names)
            for rest, points in named_bodies(stems).items():
                body = x.setdefault(rest or "0", np.full((len(topic.messages), len(POINTS), 3), np.nan))
                for k, point in enumerate(POINTS):
                    at_axes = stems[points[point]]
                    if max(at_axes) < count:
                        body[numbers, k] = values[:, at_axes]
    except ValueError as error:
        raise RecordingError(f"{where}: {error}; record it again, or cut it before that") from None
    if not x:
        raise RecordingError(
            f"{where}: no values are named like the coordinates of both arms' joints; give another file"
        )
    t, note = times_of(t_ns, log_ns)
    frames = np.arange(len(t))
    return RawRecording(
        {name: Body(points, frames, t) for name, points in x.items()}, unit="m", time_unit="s", notes=(note,)
    )


def _stems(names: list[str]) -> dict[str, list[int]]:
    """Joint -> where its x, y and z stand."""
    found: dict[str, dict[str, int]] = {}
    for column, name in enumerate(names):
        match = _AXIS.match(name)
        if match:
            found.setdefault(match[1], {}).setdefault(match[2].lower(), column)
    return {stem: [axes[axis] for axis in "xyz"] for stem, axes in found.items() if len(axes) == 3}


def _walk(reader, cdr: bool) -> tuple[list[str], int, int, int]:
    """Names, and where the stamp and the positions stand, and how many."""
    if not cdr:
        reader.place(1, 4)  # seq
    stamp = reader.place(2, 4)
    reader.string()
    names = [printable(name) for name in reader.strings()]
    count = reader.uint32()
    at = reader.place(count, 8)
    for _ in range(2):  # velocity, effort
        reader.place(reader.uint32(), 8)
    return names, stamp, at, count
