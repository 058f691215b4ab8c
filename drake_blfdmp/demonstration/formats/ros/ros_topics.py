"""The messages of a bag that may hold a person, kept by topic while the bag is read."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from drake_blfdmp.demonstration.formats.ros.zstd import ZSTD_MAGIC, decompress
from drake_blfdmp.errors import RecordingError

MARKER_ARRAY = "visualization_msgs/MarkerArray"
MARKER = "visualization_msgs/Marker"
TF = "tf2_msgs/TFMessage"
JOINT_STATE = "sensor_msgs/JointState"

_SAME = {"tf/tfMessage": TF}  # The same bytes under an older name.
_MAX_BYTES = 1 << 28  # About an hour of one Azure Kinect's markers.
_MAX_MESSAGES = 1 << 22
_MAX_MESSAGE = 1 << 24  # Bytes, out of its compression.


def printable(name: str) -> str:
    """A name from a file, fit for a message of one line."""
    return "".join(character for character in name[:200] if character.isprintable())


@dataclass
class Topic:
    """Messages of one type on one topic, in the order of the bag.

    Attributes:
        name: of the topic.
        type: "package/Type", without "/msg".
        cdr: whether the messages are ROS 2's CDR; else they are ROS 1's.
        definition: of the message, as the bag has it; empty where it has none.
        log_ns: when each message was recorded, ns.
        sequence: the numbers that the bag gives the messages, where it does.
        messages: their bytes.
    """

    name: str
    type: str
    cdr: bool
    definition: str = ""
    log_ns: list[int] = field(default_factory=list)
    sequence: list[int] = field(default_factory=list)
    messages: list[bytes] = field(default_factory=list)


@dataclass
class Bag:
    """What was found in a bag.

    Attributes:
        path: of the bag, for messages.
        topics: those that may hold a person.
        others: topic -> type of the rest, for messages.
        metadata: record -> its entries, where the bag has such.
    """

    path: Path
    topics: dict[tuple[str, str, bool], Topic] = field(default_factory=dict)
    others: dict[str, str] = field(default_factory=dict)
    metadata: dict[str, Mapping[str, str]] = field(default_factory=dict)
    _bytes: int = 0
    _messages: int = 0

    def topic(self, name: str, type_name: str, encoding: str, definition: str = "") -> Topic | None:
        """The topic to `add` messages to; None where it cannot hold a person. `encoding` is "cdr" or "ros1"."""
        name, plain = printable(name), printable(type_name).replace("/msg/", "/")
        plain = _SAME.get(plain, plain)
        if plain not in (MARKER_ARRAY, MARKER, TF, JOINT_STATE) or encoding not in ("cdr", "ros1"):
            self.others[name] = plain if encoding in ("cdr", "ros1") else f"{plain} in {printable(encoding)}"
            return None
        cdr = encoding == "cdr"
        return self.topics.setdefault((name, plain, cdr), Topic(name, plain, cdr, definition))

    def add(self, topic: Topic, log_ns: int, message: bytes, sequence: int = 0) -> None:
        """Keep a message; one that rosbag2 compressed is taken out of its compression.

        Raises:
            RecordingError: more than fits.
            ValueError: compressed and damaged.
        """
        if topic.cdr and message.startswith(ZSTD_MAGIC):
            message = decompress(message, _MAX_MESSAGE)
        self._bytes += len(message)
        self._messages += 1
        if self._bytes > _MAX_BYTES or self._messages > _MAX_MESSAGES:
            raise RecordingError(
                f"{self.path}: more than {_MAX_BYTES >> 20} MB or {_MAX_MESSAGES} messages of markers, transforms and "
                "joint states; cut the bag, or keep the person's topic alone"
            )
        topic.log_ns.append(log_ns)
        topic.sequence.append(sequence)
        topic.messages.append(message)


def times_of(stamp_ns: np.ndarray, log_ns: np.ndarray) -> tuple[np.ndarray, str]:
    """Times (N,) in s and a note: the headers' stamps, or else the times of recording where the stamps tell nothing.

    Args:
        stamp_ns: (N,) headers' stamps.
        log_ns: (N,) times of recording.
    """
    # A single zero is the first sample of a simulated run.
    unset = np.count_nonzero(stamp_ns == 0)
    if (len(stamp_ns) == 1 and not unset) or (len(stamp_ns) > 1 and np.ptp(stamp_ns) > 0 and unset <= 1):
        return stamp_ns / 1e9, "times are the messages' stamps"
    return log_ns / 1e9, "times are those of recording, since the messages' stamps tell none"
