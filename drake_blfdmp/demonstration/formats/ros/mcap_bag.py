"""MCAP files (https://mcap.dev/spec) with ROS 2 or ROS 1 messages, read from front to back without their index.

Among them are this package's own: its recordings (`/skeleton`, see `mcap_writer`) and its runs (`/points`).
"""

from pathlib import Path

from drake_blfdmp.demonstration.formats.recording_format import Joints
from drake_blfdmp.demonstration.formats.ros.ros_bag import read_bag
from drake_blfdmp.demonstration.formats.ros.ros_topics import Bag, Topic
from drake_blfdmp.demonstration.raw_recording import RawRecording
from drake_blfdmp.errors import RecordingError

MAGIC = b"\x89MCAP0\r\n"


class McapBag:
    """Reader of MCAP files; `joints` names markers' texts, namespaces, joints or numbers, or frames."""

    name = "mcap"

    def sniff(self, head: bytes) -> bool:
        """Whether the file begins as MCAP."""
        return head.startswith(MAGIC)

    def read(self, path: Path, joints: Joints | None) -> RawRecording:
        """Reads the file; times are the messages' stamps.

        Raises:
            RecordingError: a damaged file, or nobody in it.
        """
        bag = Bag(path)
        add_mcap(bag, path, path)
        return read_bag(bag, joints)


def add_mcap(bag: Bag, path: Path, named: Path) -> None:
    """Adds the messages of an MCAP file; every checksum is verified.

    Args:
        bag: what to add to.
        path: the file.
        named: what it is called in messages.

    Raises:
        RecordingError: a damaged file, or more messages than fit.
    """
    from mcap.records import Channel, McapRecord, Message, Metadata, Schema
    from mcap.stream_reader import StreamReader

    schemas: dict[int, Schema] = {}
    channels: dict[int, Topic | None] = {}
    with path.open("rb") as stream:
        # A record cannot be longer than the file: without the limit a damaged length asks for any amount of memory.
        records = StreamReader(stream, validate_crcs=True, record_size_limit=path.stat().st_size).records
        while True:
            try:
                record: McapRecord | None = next(records, None)
                if record is None:
                    return
                if isinstance(record, Message):
                    topic = channels[record.channel_id]
                    if topic is not None:
                        bag.add(topic, record.log_time, record.data, record.sequence)
                elif isinstance(record, Schema):
                    schemas[record.id] = record
                elif isinstance(record, Channel) and record.id not in channels:
                    schema = schemas.get(record.schema_id)
                    channels[record.id] = bag.topic(
                        record.topic,
                        schema.name if schema is not None else "no type",
                        record.message_encoding,
                        schema.data.decode(errors="replace") if schema is not None else "",
                    )
                elif isinstance(record, Metadata):
                    bag.metadata[record.name] = record.metadata
            except RecordingError:
                raise
            except Exception as error:  # Arbitrary bytes make the reader raise almost anything.
                raise RecordingError(
                    f"{named}: cut off or damaged before byte {stream.tell()} ({type(error).__name__}); "
                    "repair it with mcap recover"
                ) from None
