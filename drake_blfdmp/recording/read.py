"""Reads back what McapRecorder wrote, a damaged file up to the break."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from mcap.exceptions import InvalidMagic
from mcap.records import Attachment, Channel, Header, McapRecord, Message, Metadata, Schema
from mcap.stream_reader import StreamReader

from drake_blfdmp.recording.mcap_file import RecorderError
from drake_blfdmp.ros2.cdr import CdrReader
from drake_blfdmp.ros2.messages import JOINT_STATE, LOG, STRING, TF, WRENCH


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
class _Topic:
    channel: Channel
    type: str
    times: list[int] = field(default_factory=list)
    messages: list[bytes] = field(default_factory=list)


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
    topics: dict[int, _Topic] = {}
    metadata: dict[str, dict[str, str]] = {}
    attachments: dict[str, bytes] = {}
    damage = ""
    try:
        damage = _read_records(path, topics, metadata, attachments)
    except OSError as error:
        raise RecorderError(f"{path}: cannot be read ({error.strerror}); check the name") from None
    if damage and not recover:
        raise RecorderError(f"{path}: {damage}; read it with recover=True to get what stands before")

    series: dict[str, Series] = {}
    robot_description = ""
    events: list[tuple[str, float]] = []
    for topic in topics.values():
        name = topic.channel.topic
        if not topic.messages:
            continue
        try:
            if topic.type == STRING:
                robot_description = CdrReader(topic.messages[-1]).string()
            elif topic.type == LOG:
                events.extend(zip(map(_event, topic.messages), (t * 1e-9 for t in topic.times), strict=True))
            elif topic.type in _LAYOUTS:
                series[name] = _series(topic)
            else:
                raise ValueError(f"messages of type '{topic.type}'")
        except (ValueError, IndexError) as error:
            raise RecorderError(
                f"{path}: topic {name} was not written by McapRecorder ({error}); read it with mcap-ros2-support"
            ) from None
    return McapRun(series, robot_description, tuple(events), metadata, attachments, damage)


def _read_records(
    path: Path, topics: dict[int, _Topic], metadata: dict[str, dict[str, str]], attachments: dict[str, bytes]
) -> str:
    """Fills the dictionaries record by record; returns what stopped it, or an empty string at the file's end."""
    schemas: dict[int, Schema] = {}
    latest_ns = 0
    with path.open("rb") as stream:
        # A record cannot be longer than the file: without the limit a damaged length asks for any amount of memory.
        size = path.stat().st_size
        # `mcap.reader.make_reader` starts at the index at the file's end, which a killed writer leaves out.
        records = StreamReader(stream, validate_crcs=True, record_size_limit=size).records
        while True:
            try:
                record: McapRecord | None = next(records, None)
                if record is None:
                    return ""
                if isinstance(record, Schema):
                    schemas[record.id] = record
                elif isinstance(record, Channel):
                    topics.setdefault(record.id, _Topic(record, schemas[record.schema_id].name))
                elif isinstance(record, Message):
                    topic = topics[record.channel_id]
                    topic.times.append(record.log_time)
                    topic.messages.append(record.data)
                    latest_ns = max(latest_ns, record.log_time)
                elif isinstance(record, Metadata):
                    metadata[record.name] = record.metadata
                elif isinstance(record, Attachment):
                    attachments[record.name] = record.data
                elif isinstance(record, Header) and record.profile != "ros2":
                    raise RecorderError(f"{path}: profile '{record.profile}' instead of ros2; not a McapRecorder file")
            except (RecorderError, OSError):
                raise
            except InvalidMagic:
                if stream.tell() <= 8:
                    raise RecorderError(f"{path}: not an MCAP file; give a file that McapRecorder wrote") from None
                return f"damaged at its end, after t = {latest_ns * 1e-9:.6g} s"
            except Exception as error:  # Arbitrary bytes make the reader raise almost anything.
                reason = type(error).__name__
                return (
                    f"cut off or damaged near byte {stream.tell()} of {size}, "
                    f"after t = {latest_ns * 1e-9:.6g} s ({reason})"
                )


def _event(message: bytes) -> str:
    reader = CdrReader(message)
    reader.stamp()
    reader.uint8()
    reader.string()
    return reader.string()


_Layout = tuple[list[str], list[int], list[int]]  # Names; byte offsets of the float64; of the stamps.


def _joint_state_layout(message: bytes) -> _Layout:
    reader = CdrReader(message)
    stamp = reader.stamp()
    reader.string()
    names = reader.strings()
    return names, reader.float64_sequence() + reader.float64_sequence() + reader.float64_sequence(), [stamp]


def _tf_layout(message: bytes) -> _Layout:
    reader = CdrReader(message)
    names, float64s, stamps = [], [], []
    for _ in range(reader.uint32()):
        stamps.append(reader.stamp())
        reader.string()
        names.append(reader.string())
        float64s += reader.float64s(7)
    return names, float64s, stamps


def _wrench_layout(message: bytes) -> _Layout:
    reader = CdrReader(message)
    stamp = reader.stamp()
    reader.string()
    return ["force", "torque"], reader.float64s(6), [stamp]


_LAYOUTS: Mapping[str, Callable[[bytes], _Layout]] = {
    JOINT_STATE: _joint_state_layout,
    TF: _tf_layout,
    WRENCH: _wrench_layout,
}


def _series(topic: _Topic) -> Series:
    """Decodes all messages at once: they differ in stamps and float64 only, which is checked."""
    names, float64s, stamps = _LAYOUTS[topic.type](topic.messages[0])
    length = len(topic.messages[0])
    if any(len(message) != length for message in topic.messages):
        raise ValueError("messages of different length")
    raw = np.frombuffer(b"".join(topic.messages), dtype=np.uint8).reshape(-1, length)
    constant = np.ones(length, dtype=bool)
    columns = np.add.outer(np.array(float64s, dtype=int), np.arange(8))
    constant[columns] = False
    constant[np.add.outer(np.array(stamps, dtype=int), np.arange(8))] = False
    if np.any(raw[:, constant] != raw[0, constant]):
        raise ValueError("names that change from message to message")
    values = np.ascontiguousarray(raw[:, columns.ravel()]).view("<f8").astype(float)
    n = len(values)
    unit = topic.channel.metadata.get("unit", "")
    if topic.type == TF:
        values = values.reshape(n, len(names), 7)
    elif topic.type == WRENCH:
        values = values.reshape(n, 2, 3)
    elif not unit:
        fields = values.reshape(n, -1, len(names))
        values = np.full((n, len(names), 3), np.nan)
        values[:, :, : fields.shape[1]] = fields.transpose(0, 2, 1)
    return Series(np.array(topic.times) * 1e-9, tuple(names), values, unit)
