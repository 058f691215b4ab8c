"""Reads back what McapRecorder wrote, a damaged file up to the break."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from drake_blfdmp.recording.mcap_file import RecorderError
from drake_blfdmp.recording.samples import LAYOUTS, constant_bytes, shaped, text_of
from drake_blfdmp.recording.stream import McapStream, Topic
from drake_blfdmp.ros2.messages import LOG, MARKERS, STRING


@dataclass(frozen=True)
class Series:
    """One topic's N samples.

    Attributes:
        t: (N,) simulated time, s.
        names: joints, bodies or elements; force and torque for a wrench.
        values: by type of topic: joint states (N, names, 3) position, velocity, effort, NaN where not recorded;
            transforms (N, names, 7) x y z (m) qx qy qz qw; wrenches (N, 2, 3) force (N), torque (N m); vectors
            (N, names).
        unit: of a vector or wrench; empty otherwise.
    """

    t: np.ndarray
    names: tuple[str, ...]
    values: np.ndarray
    unit: str = ""


@dataclass(frozen=True)
class McapRun:
    """What a file holds.

    Attributes:
        series: topic -> its samples.
        robot_description: the URDF, or empty.
        events: (name, simulated time in s), in the order of the file.
        metadata: record -> its entries.
        attachments: name -> bytes.
        damage: empty, or what is wrong with the file and from when on nothing could be read.
    """

    series: dict[str, Series] = field(default_factory=dict)
    robot_description: str = ""
    events: tuple[tuple[str, float], ...] = ()
    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    attachments: dict[str, bytes] = field(default_factory=dict)
    damage: str = ""


@dataclass
class _Messages:
    topic: Topic
    times: list[int] = field(default_factory=list)
    data: list[bytes] = field(default_factory=list)


def read_mcap(filename: str | Path, *, recover: bool = False) -> McapRun:
    """Reads a recording of a run; every checksum is verified.

    Args:
        filename: a file that McapRecorder wrote. Other tools' messages are for `mcap-ros2-support` or `rosbags`.
        recover: return what stands before the damage of a damaged file (`McapRun.damage` says what it is).

    Raises:
        RecorderError: there is no such file, it is no MCAP file, a topic's messages are not McapRecorder's, or the
            file is damaged and `recover` is False.
    """
    path = Path(filename)
    stream = McapStream(path, recover=recover, empty=True)
    topics: dict[str, _Messages] = {}
    for topic, message in stream.messages():
        messages = topics.setdefault(topic.name, _Messages(topic))
        messages.times.append(message.log_time)
        messages.data.append(message.data)
    if stream.profile != "ros2" and not stream.damage:
        raise RecorderError(f"{path}: profile '{stream.profile}' instead of ros2; not a McapRecorder file")
    series: dict[str, Series] = {}
    robot_description = ""
    events: list[tuple[str, float]] = []
    for name, messages in topics.items():
        kind = messages.topic.type
        try:
            if kind == STRING:
                robot_description = text_of(kind, messages.data[-1])
            elif kind == LOG:
                texts = (text_of(kind, data) for data in messages.data)
                events.extend(zip(texts, (t * 1e-9 for t in messages.times), strict=True))
            elif kind in LAYOUTS:
                series[name] = _series(messages)
            elif kind != MARKERS:  # They draw what other topics have as numbers.
                raise ValueError(f"messages of type '{kind}'")
        except (ValueError, IndexError) as error:
            raise RecorderError(
                f"{path}: topic {name} was not written by McapRecorder ({error}); read it with mcap-ros2-support"
            ) from None
    return McapRun(series, robot_description, tuple(events), stream.metadata, stream.attachments, stream.damage)


def _series(messages: _Messages) -> Series:
    """Decodes all messages at once: they differ in stamps and float64 only, which is checked."""
    kind, unit = messages.topic.type, messages.topic.metadata.get("unit", "")
    layout = LAYOUTS[kind](messages.data[0])
    length = len(messages.data[0])
    if any(len(message) != length for message in messages.data):
        raise ValueError("messages of different length")
    raw = np.frombuffer(b"".join(messages.data), dtype=np.uint8).reshape(-1, length)
    constant, columns = constant_bytes(layout, length)
    if np.any(raw[:, constant] != raw[0, constant]):
        raise ValueError("names that change from message to message")
    numbers = np.ascontiguousarray(raw[:, columns]).view("<f8").astype(float)
    return Series(np.array(messages.times) * 1e-9, layout.names, shaped(kind, layout, numbers, unit), unit)
