"""MCAP files (https://mcap.dev/spec) with ROS 2 or ROS 1 messages, read from front to back without their index.

Among them are this package's own: its recordings (`/skeleton`, see `mcap_writer`) and its runs (`/points`).
"""

import shlex
import struct
from io import BytesIO
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
    from mcap.data_stream import ReadDataStream
    from mcap.exceptions import McapError
    from mcap.records import Channel, Metadata, Schema

    from drake_blfdmp.ros2 import mcap_records as mcap

    schemas: dict[int, Schema] = {}
    channels: dict[int, Topic | None] = {}
    latest_ns = 0
    size = path.stat().st_size

    def add(record: mcap.Record) -> None:
        nonlocal latest_ns
        data = record.data or b""
        if record.opcode == mcap.MESSAGE:
            message = mcap.unpack_message(data)
            topic = channels[message.channel]
            if topic is not None:
                bag.add(topic, message.log_time, message.data, message.sequence)
            latest_ns = max(latest_ns, message.log_time)
        elif record.opcode == mcap.SCHEMA:
            schema = Schema.read(ReadDataStream(BytesIO(data)))
            schemas[schema.id] = schema
        elif record.opcode == mcap.CHANNEL:
            channel = Channel.read(ReadDataStream(BytesIO(data)))
            if channel.id not in channels:
                schema = schemas.get(channel.schema_id)
                channels[channel.id] = bag.topic(
                    channel.topic,
                    schema.name if schema is not None else "no type",
                    channel.message_encoding,
                    schema.data.decode(errors="replace") if schema is not None else "",
                )
        elif record.opcode == mcap.METADATA:
            metadata = Metadata.read(ReadDataStream(BytesIO(data)))
            bag.metadata[metadata.name] = metadata.metadata

    at = 0
    try:
        with path.open("rb") as stream:
            for outer in mcap.read_records(stream, size):
                at = outer.start
                for record in mcap.opened(outer):
                    add(record)
    except (RecordingError, OSError):
        raise
    except mcap.TooLargeError as error:
        raise RecordingError(f"{named}: {error}, more than is read at once; write smaller chunks") from None
    except (ValueError, LookupError, struct.error, McapError) as error:
        truncated = isinstance(error, mcap.BrokenMcapError) and error.truncated
        if isinstance(error, mcap.BrokenMcapError):
            at = error.offset
        raise RecordingError(
            f"{named}: {'truncated' if truncated else 'damaged'} at byte {at} of {size}, whole up to "
            f"t = {latest_ns * 1e-9:.6g} s; run python run.py recover {shlex.quote(str(path))}"
        ) from None
