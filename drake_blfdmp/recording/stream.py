"""Reads recordings of any length from front to back, sample by sample, in bounded memory. Without pydrake."""

import struct
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path

from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.records import Attachment, Channel, Header, Metadata, Schema

from drake_blfdmp.recording.mcap_file import RecorderError, recover_hint
from drake_blfdmp.recording.samples import Decoder, Sample
from drake_blfdmp.ros2 import mcap_records as mcap
from drake_blfdmp.ros2.messages import LOG


def damage_text(error: mcap.BrokenMcapError, size: int, latest_ns: int) -> str:
    """What is wrong with a file of `size` bytes whose latest whole message is at `latest_ns`."""
    reason = "truncated" if error.truncated else "damaged"
    why = "" if error.truncated else f" ({error})"
    return f"{reason} at byte {error.offset} of {size}{why}, whole up to t = {latest_ns * 1e-9:.6g} s"


@dataclass
class Topic:
    """A topic of a file.

    Attributes:
        name, type: as in `Sample`.
        metadata: of its channel.
        messages: how many were read so far.
        latest_ns: log time of the latest.
    """

    name: str
    type: str
    metadata: dict[str, str] = field(default_factory=dict)
    messages: int = 0
    latest_ns: int = 0


class McapStream:
    """Iterates over the samples of an MCAP file with ROS 2 messages, whoever wrote it, in the order of the file.

    Memory stays below 300 MB, however long the file is. Every checksum is verified. ::

        stream = McapStream("run.mcap", topics={"/joint_states"})
        for sample in stream:
            print(sample.t, sample.names, sample.values)

    Attributes, all as far as the file has been read:
        path: the file.
        profile: as the file's header has it.
        topics: name -> Topic, also of topics that are left out.
        metadata: record -> its entries.
        attachments: name -> bytes, up to 50 MB in all.
        latest_ns: latest log time of all messages, ns.
        damage: empty, or what is wrong with the file and from when on nothing could be read.
    """

    def __init__(
        self,
        filename: str | Path,
        *,
        topics: set[str] | None = None,
        recover: bool = False,
        empty: bool = False,
        progress: Callable[[float], None] = lambda share: None,
    ):
        """Nothing is read yet.

        Args:
            filename: the file.
            topics: only these; all when None.
            recover: stop at a damage, which is in `damage` then, in place of raising.
            empty: whether a file without a message will do.
            progress: called with the share that has been read, 0 to 1, now and then.
        """
        self.path = Path(filename)
        self._only, self._recover, self._empty, self._progress = topics, recover, empty, progress
        self._begin()

    def _begin(self) -> None:
        """Forgets what was read."""
        self.topics: dict[str, Topic] = {}
        self.metadata: dict[str, dict[str, str]] = {}
        self.attachments: dict[str, bytes] = {}
        self.profile = ""
        self.latest_ns = 0
        self.damage = ""

    def __iter__(self) -> Iterator[Sample]:
        """The samples.

        Raises:
            RecorderError: as `messages`; or a message is not of its topic's type.
        """
        decoders: dict[str, Decoder] = {}
        for topic, message in self.messages():
            decoder = decoders.get(topic.name)
            if decoder is None:
                decoder = decoders[topic.name] = Decoder(topic.name, topic.type, topic.metadata.get("unit", ""))
            try:
                sample = decoder.decode(message.log_time * 1e-9, message.data)
            except (ValueError, IndexError, struct.error) as error:
                raise RecorderError(
                    f"{self.path}: {topic.name}: message {topic.messages} at t = {message.log_time * 1e-9:.6g} s is no "
                    f"{topic.type} ({error}); leave this topic out"
                ) from None
            yield sample

    def messages(self) -> Iterator[tuple[Topic, mcap.Message]]:
        """The messages as bytes.

        Raises:
            RecorderError: there is no such file; it is no MCAP file, or of another profile than ROS 2, or has no
                message; a topic's time goes backwards; or the file is truncated or damaged and is not to be recovered.
        """
        self._begin()
        try:
            size = self.path.stat().st_size
            with self.path.open("rb") as stream:
                yield from self._messages(mcap.read_records(stream, size), size)
        except OSError as error:
            raise RecorderError(f"{self.path}: cannot be read ({error.strerror}); check the name") from None
        except mcap.NotMcapError:
            raise RecorderError(f"{self.path}: not an MCAP file; give a file that ends in .mcap") from None
        except mcap.TooLargeError as error:
            raise RecorderError(
                f"{self.path}: {error}, more than the {mcap.LARGEST / 1e6:.0f} MB that are read at once; write it anew "
                "with smaller chunks"
            ) from None
        except mcap.BrokenMcapError as error:
            self.damage = damage_text(error, size, self.latest_ns)
            if not self._recover:
                raise RecorderError(f"{self.path}: {self.damage}; {recover_hint(self.path)}") from None
        if not self._empty and not self.damage and not any(topic.messages for topic in self.topics.values()):
            raise RecorderError(f"{self.path}: holds no message; nothing was recorded")

    def _messages(self, records: Iterator[mcap.Record], size: int) -> Iterator[tuple[Topic, mcap.Message]]:
        schemas: dict[int, str] = {}
        channels: dict[int, Topic] = {}
        told = 0.0
        for outer in records:
            try:
                for record in mcap.opened(outer):
                    if record.opcode == mcap.MESSAGE:
                        message = mcap.unpack_message(record.data or b"")
                        topic = channels[message.channel]
                        if self._count(topic, message.log_time):
                            yield topic, message
                    elif record.data is not None:
                        self._keep(record.opcode, record.data, schemas, channels)
            except mcap.TooLargeError:
                raise
            except KeyError as error:
                raise mcap.BrokenMcapError(f"there is no channel or schema {error}", outer.start) from None
            except (ValueError, IndexError, struct.error, McapError) as error:
                raise mcap.BrokenMcapError(str(error) or type(error).__name__, outer.start) from None
            if outer.start > told * size + size / 100:
                told = outer.start / size
                self._progress(told)
        self._progress(1.0)

    def _count(self, topic: Topic, t_ns: int) -> bool:
        """Counts a message; whether it is wanted."""
        # Events may be written once all is over.
        if t_ns < topic.latest_ns and topic.type != LOG:
            raise RecorderError(
                f"{self.path}: {topic.name}: time goes back from {topic.latest_ns * 1e-9:.6g} s to "
                f"{t_ns * 1e-9:.6g} s at message {topic.messages + 1}; give a file with one run, in the order of time"
            )
        topic.messages += 1
        topic.latest_ns = max(topic.latest_ns, t_ns)
        self.latest_ns = max(self.latest_ns, t_ns)
        return self._only is None or topic.name in self._only

    def _keep(self, opcode: int, data: bytes, schemas: dict[int, str], channels: dict[int, Topic]) -> None:
        """Takes note of everything that is no message."""
        stream = ReadDataStream(BytesIO(data))
        if opcode == mcap.SCHEMA:
            schema = Schema.read(stream)
            schemas[schema.id] = schema.name
        elif opcode == mcap.CHANNEL:
            channel = Channel.read(stream)
            if channel.id not in channels:
                type_name = schemas[channel.schema_id] if channel.schema_id else ""
                topic = Topic(channel.topic, type_name, channel.metadata)
                channels[channel.id] = self.topics.setdefault(channel.topic, topic)
        elif opcode == mcap.METADATA:
            metadata = Metadata.read(stream)
            self.metadata[metadata.name] = metadata.metadata
        elif opcode == mcap.ATTACHMENT:
            if int.from_bytes(data[-4:], "little") not in (0, zlib.crc32(data[:-4])):
                raise ValueError("an attachment's checksum is wrong")
            attachment = Attachment.read(stream)
            if sum(map(len, self.attachments.values())) + len(attachment.data) <= mcap.LARGEST:
                self.attachments[attachment.name] = attachment.data
        elif opcode == mcap.HEADER:
            self.profile = Header.read(stream).profile
            if self.profile not in ("ros2", ""):
                raise RecorderError(f"{self.path}: profile '{self.profile}' instead of ros2; convert it to ROS 2 first")
