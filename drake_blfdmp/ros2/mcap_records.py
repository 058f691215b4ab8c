"""MCAP's records as bytes, read from front to back without the index and in bounded memory (https://mcap.dev/spec).

The index stands at a file's end, which a killed writer never wrote; what stands before it is whole, record by record.
"""

import struct
import zlib
from collections.abc import Iterator
from typing import BinaryIO, NamedTuple

import lz4.frame
import zstandard

MAGIC = b"\x89MCAP0\r\n"
LARGEST = 50_000_000
"""Bytes of a record or of a chunk's content that are taken into memory; of attachments beyond it only the place is."""

HEADER, FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK, MESSAGE_INDEX = 1, 2, 3, 4, 5, 6, 7
ATTACHMENT, METADATA, DATA_END = 9, 12, 15

_HEAD = struct.Struct("<BQ")
_CHUNK = struct.Struct("<QQQII")
_MESSAGE = struct.Struct("<HIQQ")
_FOOTER = struct.Struct("<QQI")


class NotMcapError(ValueError):
    """Bytes that do not begin as MCAP does."""


class TooLargeError(ValueError):
    """A record that does not fit into `LARGEST`."""


class BrokenMcapError(ValueError):
    """Where a file stops being readable.

    Attributes:
        offset: byte up to which every record is whole.
        truncated: whether the file simply ends there, as a killed writer or a full disk leaves it.
    """

    def __init__(self, what: str, offset: int, *, truncated: bool = False):
        super().__init__(what)
        self.offset, self.truncated = offset, truncated


class Record(NamedTuple):
    """A record: its kind, where it begins in the file, and its content; None of an attachment beyond `LARGEST`."""

    opcode: int
    start: int
    length: int
    data: bytes | None


class Message(NamedTuple):
    """A message: times in ns."""

    channel: int
    sequence: int
    log_time: int
    publish_time: int
    data: bytes


def pack_record(opcode: int, *content: bytes) -> bytes:
    """A record from the parts of its content."""
    return _HEAD.pack(opcode, sum(map(len, content))) + b"".join(content)


def pack_message_head(channel: int, log_time: int, publish_time: int) -> bytes:
    """What stands before the data in a message's content; times in ns, no sequence number."""
    return _MESSAGE.pack(channel, 0, log_time, publish_time)


def pack_string(text: str) -> bytes:
    """Length, then UTF-8."""
    encoded = text.encode()
    return struct.pack("<I", len(encoded)) + encoded


def read_records(stream: BinaryIO, size: int) -> Iterator[Record]:
    """The records of a file of `size` bytes, chunks as they are; every checksum outside chunks is verified.

    Raises:
        NotMcapError, TooLargeError, BrokenMcapError.
    """
    magic = stream.read(len(MAGIC))
    if magic != MAGIC:
        if MAGIC.startswith(magic):
            raise BrokenMcapError("file ends within its first eight bytes", 0, truncated=True)
        raise NotMcapError("does not begin as MCAP")
    at, crc, summary_crc = len(MAGIC), zlib.crc32(MAGIC), 0
    in_summary = False
    while True:
        head = stream.read(_HEAD.size)
        opcode, length = _HEAD.unpack(head) if len(head) == _HEAD.size else (0, size)
        if at + _HEAD.size + length > size:
            raise _end_of_file(stream, size, at)
        data, crc_after = _content(stream, head, crc)
        if opcode == DATA_END:
            expected = int.from_bytes(data[:4] if data else b"", "little")
            if expected not in (0, crc):
                raise BrokenMcapError("the checksum of the data is wrong", at)
        elif opcode == FOOTER:
            if data is None or len(data) < _FOOTER.size:
                raise BrokenMcapError("the footer is too short", at)
            expected = _FOOTER.unpack_from(data)[2]
            if expected not in (0, zlib.crc32(head + data[:16], summary_crc)):
                raise BrokenMcapError("the checksum of the index is wrong", at)
        if in_summary and data is not None:
            summary_crc = zlib.crc32(head + data, summary_crc)
        crc = crc_after
        in_summary = in_summary or opcode == DATA_END
        yield Record(opcode, at, length, data)
        at += _HEAD.size + length
        if opcode == FOOTER:
            if stream.read(len(MAGIC)) != MAGIC:
                raise BrokenMcapError("the file's last bytes are missing", at, truncated=True)
            return


def _content(stream: BinaryIO, head: bytes, crc: int) -> tuple[bytes | None, int]:
    """A record's content, and the checksum of everything up to its end."""
    opcode, length = _HEAD.unpack(head)
    crc = zlib.crc32(head, crc)
    if length <= LARGEST:
        data = stream.read(length)
        return data, zlib.crc32(data, crc)
    if opcode != ATTACHMENT:
        raise TooLargeError(f"a record of {length / 1e6:.0f} MB")
    left = length
    while left and (piece := stream.read(min(left, 1 << 20))):
        left -= len(piece)
        crc = zlib.crc32(piece, crc)
    return None, crc


def _end_of_file(stream: BinaryIO, size: int, at: int) -> BrokenMcapError:
    """What it means that the record at `at` would reach beyond the file."""
    stream.seek(max(size - len(MAGIC), 0))
    if at > len(MAGIC) and stream.read() == MAGIC:  # It ends as it should: a length in it is wrong.
        return BrokenMcapError("a record's length is wrong", at)
    return BrokenMcapError("file ends within a record", at, truncated=True)


class Chunk(NamedTuple):
    """A chunk's content, decompressed and verified."""

    compression: str
    packed_size: int
    records: bytes


def open_chunk(data: bytes) -> Chunk:
    """Decompresses the content of a chunk record.

    Raises:
        TooLargeError: it would not fit.
        ValueError: it is damaged.
    """
    _, _, size, crc, name_length = _CHUNK.unpack_from(data)
    at = _CHUNK.size
    compression = data[at : at + name_length].decode()
    at += name_length
    packed_size = int.from_bytes(data[at : at + 8], "little")
    packed = memoryview(data)[at + 8 : at + 8 + packed_size]
    if len(packed) != packed_size:
        raise ValueError("a chunk's size is wrong")
    if size > LARGEST:
        raise TooLargeError(f"a chunk of {size / 1e6:.0f} MB")
    try:
        if compression == "zstd":
            # The frame's own word on its size would be believed, however large.
            if zstandard.frame_content_size(packed[:32].tobytes()) > size:
                raise ValueError("a chunk's size is wrong")
            records = zstandard.ZstdDecompressor().decompress(packed, max_output_size=size) if size else b""
        elif compression == "lz4":
            records = lz4.frame.LZ4FrameDecompressor().decompress(packed, max_length=size) if size else b""
        elif compression == "":
            records = packed.tobytes()
        else:
            raise ValueError(f"compression '{compression}' is not known")
    except (zstandard.ZstdError, RuntimeError, EOFError) as error:
        raise ValueError(f"a chunk cannot be decompressed ({error})") from None
    if len(records) != size or (crc and zlib.crc32(records) != crc):
        raise ValueError("a chunk's checksum is wrong")
    return Chunk(compression, packed_size, records)


def chunk_records(records: bytes) -> Iterator[Record]:
    """The records in a chunk's content; `start` is the place in it.

    Raises:
        ValueError: a record reaches beyond the chunk.
    """
    at = 0
    while at < len(records):
        if at + _HEAD.size > len(records):
            raise ValueError("a chunk ends within a record")
        opcode, length = _HEAD.unpack_from(records, at)
        end = at + _HEAD.size + length
        if end > len(records):
            raise ValueError("a chunk ends within a record")
        yield Record(opcode, at, length, records[at + _HEAD.size : end])
        at = end


def opened(record: Record) -> Iterator[Record]:
    """The records in a chunk, or else the record itself; raises as `open_chunk` and `chunk_records`."""
    if record.opcode == CHUNK:
        yield from chunk_records(open_chunk(record.data or b"").records)
    else:
        yield record


def unpack_message(data: bytes) -> Message:
    """The content of a message record.

    Raises:
        struct.error: it is too short.
    """
    return Message(*_MESSAGE.unpack_from(data), data[_MESSAGE.size :])
