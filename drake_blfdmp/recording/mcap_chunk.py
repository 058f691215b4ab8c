"""Chunks of an MCAP file, and the index at its end, as bytes. Without pydrake."""

import struct
import zlib
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
import zstandard
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import AttachmentIndex, ChunkIndex, McapRecord, MetadataIndex, Statistics, SummaryOffset

from drake_blfdmp.ros2 import mcap_records as mcap

_COMPRESSOR = zstandard.ZstdCompressor(  # Making one takes a third as long as compressing a chunk.
    # Samples repeat what is a few kilobytes behind: level 1's effort, with tables that stay in a processor's cache and
    # a window over the whole chunk, gives the default level's size in half its time.
    compression_params=zstandard.ZstdCompressionParameters.from_level(
        1, strategy=zstandard.STRATEGY_DFAST, window_log=20, hash_log=13, chain_log=13, min_match=5
    )
)


class Places(NamedTuple):
    """Where the N messages of a chunk stand: (N,) channels, log times (ns), offsets of the records in the chunk."""

    channel: np.ndarray
    time: np.ndarray
    offset: np.ndarray


def places_of(records: bytes) -> Places:
    """The messages in a chunk's content.

    Raises:
        ValueError, struct.error: it is damaged.
    """
    found = [
        (*struct.unpack_from("<HIQ", record.data or b"")[::2], record.start)
        for record in mcap.chunk_records(records)
        if record.opcode == mcap.MESSAGE
    ]
    return joined(
        [Places(*(np.array(column, dtype=np.uint64) for column in zip(*found, strict=True)))] if found else []
    )


def joined(some: Iterable[Places]) -> Places:
    """All of them in one."""
    some = list(some)
    if not some:
        return Places(*(np.empty(0, dtype=np.uint64) for _ in range(3)))
    return Places(*(np.concatenate([np.ravel(part) for part in column]) for column in zip(*some, strict=True)))


class ChunkEntry(NamedTuple):
    """A chunk's entry in the file's index, and how many messages of each channel it has."""

    index: ChunkIndex
    messages: dict[int, int]


Entry = ChunkEntry | AttachmentIndex | MetadataIndex
"""What the index at a file's end says of one part of it."""


def pack_chunk(records: bytes, places: Places, start: int) -> tuple[bytes, ChunkEntry]:
    """A chunk and its message indexes, to be written at byte `start` of their file, and its entry in the index."""
    first, last = _span(places)
    packed = _COMPRESSOR.compress(records)
    chunk = mcap.pack_record(
        mcap.CHUNK,
        struct.pack("<QQQI", first, last, len(records), zlib.crc32(records)),
        mcap.pack_string("zstd"),
        struct.pack("<Q", len(packed)),
        packed,
    )
    return index_chunk(chunk, "zstd", len(packed), len(records), places, start)


def index_chunk(
    chunk: bytes, compression: str, compressed: int, uncompressed: int, places: Places, start: int
) -> tuple[bytes, ChunkEntry]:
    """A whole chunk record with its message indexes, and its entry; the sizes are those of its content."""
    first, last = _span(places)
    parts, offsets, at = [chunk], {}, start + len(chunk)
    # By channel, then time, then place.
    order = np.lexsort((places.offset, places.time, places.channel))
    channels, begins = np.unique(places.channel[order], return_index=True)
    entries = np.column_stack([places.time, places.offset])[order].astype("<u8")
    for channel, part in zip(channels.tolist(), np.split(entries, begins[1:]), strict=True):
        record = mcap.pack_record(mcap.MESSAGE_INDEX, struct.pack("<HI", channel, part.nbytes), part.tobytes())
        offsets[int(channel)] = at
        parts.append(record)
        at += len(record)
    index = ChunkIndex(
        chunk_length=len(chunk),
        chunk_start_offset=start,
        compression=compression,
        compressed_size=compressed,
        message_end_time=last,
        message_index_length=at - start - len(chunk),
        message_index_offsets=offsets,
        message_start_time=first,
        uncompressed_size=uncompressed,
    )
    counts = np.diff([*begins, len(order)]).tolist()
    return b"".join(parts), ChunkEntry(index, dict(zip(map(int, channels), counts, strict=True)))


def _span(places: Places) -> tuple[int, int]:
    """First and last log time, ns; 0 without messages."""
    return (int(places.time.min()), int(places.time.max())) if len(places.time) else (0, 0)


def pack_end(
    schemas: Mapping[int, bytes],
    channels: Mapping[int, bytes],
    entries: Sequence[Entry],
    *,
    start: int,
    data_crc: int,
) -> bytes:
    """Everything behind a file's data: its checksum, the summary with the index, the footer.

    Args:
        schemas, channels: number -> the whole record.
        entries: of all that is in the file.
        start: size of the data, the byte where this is written.
        data_crc: checksum of the data.
    """
    chunks = [entry for entry in entries if isinstance(entry, ChunkEntry)]
    attachments = [entry for entry in entries if isinstance(entry, AttachmentIndex)]
    metadata = [entry for entry in entries if isinstance(entry, MetadataIndex)]
    messages = sum((Counter(chunk.messages) for chunk in chunks), Counter())
    filled = [chunk.index for chunk in chunks if chunk.messages]
    head = mcap.pack_record(mcap.DATA_END, struct.pack("<I", data_crc))
    start += len(head)
    statistics = Statistics(
        attachment_count=len(attachments),
        channel_count=len(channels),
        channel_message_counts=dict(sorted(messages.items())),
        chunk_count=len(chunks),
        message_count=messages.total(),
        message_end_time=max((chunk.message_end_time for chunk in filled), default=0),
        message_start_time=min((chunk.message_start_time for chunk in filled), default=0),
        metadata_count=len(metadata),
        schema_count=len(schemas),
    )
    groups = [
        (Opcode.SCHEMA, b"".join(schemas.values())),
        (Opcode.CHANNEL, b"".join(channels.values())),
        (Opcode.STATISTICS, _records([statistics])),
        (Opcode.CHUNK_INDEX, _records([chunk.index for chunk in chunks])),
        (Opcode.ATTACHMENT_INDEX, _records(attachments)),
        (Opcode.METADATA_INDEX, _records(metadata)),
    ]
    summary, offsets = b"", []
    for opcode, data in groups:
        if data:
            offsets.append(SummaryOffset(group_opcode=opcode, group_start=start + len(summary), group_length=len(data)))
        summary += data
    offset_start = start + len(summary)
    summary += _records(offsets)
    footer = struct.pack("<BQQQ", mcap.FOOTER, 20, start, offset_start)
    return head + summary + footer + struct.pack("<I", zlib.crc32(footer, zlib.crc32(summary))) + mcap.MAGIC


def _records(records: Iterable[McapRecord]) -> bytes:
    builder = RecordBuilder()
    for record in records:
        record.write(builder)
    return builder.end()
