"""ROS 1 bags (format 2.0, https://wiki.ros.org/Bags/Format/2.0), read from front to back without their index.

So a bag that was never closed (`.bag.active`) can be read as far as its chunks are whole, and an index that lies does
no harm. A record is a header of `name=value` fields and data; messages and connections stand in chunks.
"""

import bz2
import struct
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from typing import BinaryIO

from drake_blfdmp.demonstration.formats.recording_format import Joints
from drake_blfdmp.demonstration.formats.ros.ros_bag import read_bag
from drake_blfdmp.demonstration.formats.ros.ros_topics import Bag, Topic, printable
from drake_blfdmp.demonstration.raw_recording import RawRecording
from drake_blfdmp.errors import RecordingError

_MAGIC = b"#ROSBAG V2.0\n"
_MESSAGE, _BAG, _CHUNK, _CONNECTION = 2, 3, 5, 7
_MAX_CHUNK = 1 << 28
_MAX_HEADER = 1 << 20


class RosBag1:
    """Reader of ROS 1 bags; `joints` names markers' texts, namespaces, joints or numbers, or frames."""

    name = "rosbag1"

    def sniff(self, head: bytes) -> bool:
        """Whether the file begins as a bag of any version."""
        return head.startswith(b"#ROSBAG V")

    def read(self, path: Path, joints: Joints | None) -> RawRecording:
        """Reads the bag; times are the messages' stamps.

        Raises:
            RecordingError: another version, an encrypted or damaged bag, or nobody in it.
        """
        bag = Bag(path)
        connections: dict[int, Topic | None] = {}
        with path.open("rb") as file:
            if file.read(len(_MAGIC)) != _MAGIC:
                raise RecordingError(f"{path}: is no ROS bag of version 2.0; convert it with rosbag fix")
            try:
                for op, fields, data in _records(file, path.stat().st_size):
                    if op == _BAG and fields.get("encryptor"):
                        raise RecordingError(f"{path}: is encrypted; decrypt it with rosbag decrypt")
                    if op == _CHUNK:
                        content = _decompressed(fields, data)
                        for inner in _records(BytesIO(content), len(content)):
                            _take(bag, connections, *inner)
                    else:
                        _take(bag, connections, op, fields, data)
            # Arbitrary bytes make the decompressors raise almost anything.
            except (ValueError, KeyError, struct.error, OSError, EOFError, RuntimeError) as error:
                raise RecordingError(
                    f"{path}: cut off or damaged before byte {file.tell()} ({printable(str(error))}); "
                    "repair it with rosbag reindex"
                ) from None
        return read_bag(bag, joints)


def _records(file: BinaryIO, size: int) -> Iterator[tuple[int, dict[str, bytes], bytes]]:
    """Yields (op, header fields, data) of each record up to byte `size`."""
    while file.tell() < size:
        fields = _fields(_sized(file, size, _MAX_HEADER))
        yield int.from_bytes(fields["op"], "little"), fields, _sized(file, size, size)


def _fields(header: bytes) -> dict[str, bytes]:
    """Name -> value of a header."""
    fields: dict[str, bytes] = {}
    at = 0
    while at < len(header):
        (length,) = struct.unpack_from("<I", header, at)
        name, equals, value = header[at + 4 : at + 4 + length].partition(b"=")
        if not equals or at + 4 + length > len(header):
            raise ValueError("a header without fields")
        fields[name.decode()] = value
        at += 4 + length
    return fields


def _sized(file: BinaryIO, size: int, most: int) -> bytes:
    """Bytes behind their number; never more than the file has left."""
    (length,) = struct.unpack("<I", file.read(4))
    if length > min(most, size - file.tell()):
        raise ValueError(f"a record of {length} bytes ends behind the file")
    return file.read(length)


def _decompressed(fields: dict[str, bytes], data: bytes) -> bytes:
    (size,) = struct.unpack("<I", fields["size"])
    kind = fields["compression"].decode()
    if size > _MAX_CHUNK:
        raise ValueError(f"a chunk of {size} bytes")
    if kind == "none":
        content = data
    elif kind == "bz2":
        content = bz2.BZ2Decompressor().decompress(data, size)
    elif kind == "lz4":
        from lz4.frame import LZ4FrameDecompressor

        content = LZ4FrameDecompressor().decompress(data, size)
    else:
        raise ValueError(f"compression '{kind[:20]}'")
    if len(content) != size:
        raise ValueError(f"a chunk of {len(content)} bytes instead of {size}")
    return content


def _take(bag: Bag, connections: dict[int, Topic | None], op: int, fields: dict[str, bytes], data: bytes) -> None:
    """Keeps what a record says of topics and messages; the others are the index's."""
    if op not in (_CONNECTION, _MESSAGE):
        return
    (number,) = struct.unpack("<I", fields["conn"])
    if op == _MESSAGE:
        seconds, nanoseconds = struct.unpack("<II", fields["time"])
        topic = connections[number]
        if topic is not None:
            bag.add(topic, seconds * 1_000_000_000 + nanoseconds, data)
    elif number not in connections:
        described = _fields(data)
        connections[number] = bag.topic(
            fields["topic"].decode(),
            described["type"].decode(),
            "ros1",
            described.get("message_definition", b"").decode(errors="replace"),
        )
