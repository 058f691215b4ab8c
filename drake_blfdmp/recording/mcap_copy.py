"""What is whole of an MCAP file, copied into a complete one record by record. Without pydrake."""

import struct
import zlib
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import BinaryIO

import numpy as np
from mcap.data_stream import ReadDataStream, RecordBuilder
from mcap.exceptions import McapError
from mcap.records import AttachmentIndex, Header, McapRecord, Metadata, MetadataIndex

from drake_blfdmp.recording.journal import read_journal
from drake_blfdmp.recording.mcap_chunk import ChunkEntry, Entry, index_chunk, pack_chunk, pack_end, places_of
from drake_blfdmp.recording.mcap_file import CHUNK_BYTES, RecorderError
from drake_blfdmp.ros2 import mcap_records as mcap

Progress = Callable[[str, float], None]
_PRIVATE = 0x80  # From here on records mean what their writer says.
DAMAGE = (ValueError, IndexError, struct.error, McapError)


@dataclass(frozen=True)
class Recovery:
    """What came of it.

    Attributes:
        path: the new file; None where the old one is intact.
        messages, topics: how many the new file has.
        from_journal: how many of the messages.
        until_s: its latest log time, s.
        left_out: chunks, attachments and metadata that are damaged.
        damage: what was wrong.
    """

    path: Path | None
    messages: int = 0
    topics: int = 0
    from_journal: int = 0
    until_s: float = 0.0
    left_out: int = 0
    damage: str = ""


class McapCopy:
    """What is whole of one file on its way into another."""

    def __init__(self, path: Path, stream: BinaryIO, size: int, target: Path, output: BinaryIO, progress: Progress):
        self._path, self._stream, self._size, self._target, self._output = path, stream, size, target, output
        self._progress = progress
        self._at, self._crc = 0, 0
        self._schemas: dict[int, bytes] = {}
        self._channels: dict[int, bytes] = {}
        self._entries: list[Entry] = []
        self._loose: list[bytes] = []  # Records that stood in no chunk; they get one.
        self._loose_bytes = 0
        self._chunks = self._left_out = 0
        self._header = False

    def run(self) -> Recovery:
        """Copy, and say what came of it."""
        self._write(mcap.MAGIC)
        damage, told = [], 0
        try:
            for record in mcap.read_records(self._stream, self._size):
                if record.opcode == mcap.DATA_END:
                    break
                try:
                    self._take(record)
                except mcap.TooLargeError:
                    raise
                except DAMAGE as error:
                    raise mcap.BrokenMcapError(str(error), record.start) from None
                if record.start > told:
                    told = record.start + self._size // 100
                    self._progress("recovering", record.start / self._size)
        except mcap.BrokenMcapError as error:
            if error.truncated or not self._left_out:  # Else it is the data's checksum, which says the same again.
                damage.append(f"{'truncated' if error.truncated else 'damaged'} at byte {error.offset} of {self._size}")
        if self._left_out:
            damage.append(f"{self._left_out} damaged record{'s' if self._left_out > 1 else ''} left out")
        self._finish_loose()
        from_journal = self._add_journal()
        chunks = [entry for entry in self._entries if isinstance(entry, ChunkEntry)]
        messages = sum(sum(chunk.messages.values()) for chunk in chunks)
        if not self._header or not self._entries:
            raise RecorderError(f"{self._path}: nothing in it is whole, and there is no journal; record again")
        self._write(pack_end(self._schemas, self._channels, self._entries, start=self._at, data_crc=self._crc))
        self._output.flush()
        self._progress("recovering", 1.0)
        return Recovery(
            path=self._target,
            messages=messages,
            topics=len({channel for chunk in chunks for channel in chunk.messages}),
            from_journal=from_journal,
            until_s=max((chunk.index.message_end_time for chunk in chunks), default=0) * 1e-9,
            left_out=self._left_out,
            damage=", ".join(damage) or "no index at its end",
        )

    def _write(self, data: bytes) -> None:
        self._output.write(data)
        self._at += len(data)
        self._crc = zlib.crc32(data, self._crc)

    def _take(self, record: mcap.Record) -> None:
        """Copies a record of the data section."""
        if record.data is None:
            self._copy_attachment(record)
        elif record.opcode == mcap.CHUNK:
            self._finish_loose()
            self._chunks += 1
            self._copy_chunk(record.data)
        elif record.opcode in (mcap.SCHEMA, mcap.CHANNEL, mcap.MESSAGE):
            if self._note(record.opcode, record.data):
                self._loose.append(mcap.pack_record(record.opcode, record.data))
                self._loose_bytes += len(self._loose[-1])
            if self._loose_bytes >= CHUNK_BYTES:
                self._finish_loose()
        elif record.opcode in (mcap.ATTACHMENT, mcap.METADATA):
            try:
                entry = _entry(record.opcode, record.data, self._at)
            except DAMAGE:
                self._left_out += 1
                return
            self._entries.append(entry)
            self._write(mcap.pack_record(record.opcode, record.data))
        elif record.opcode == mcap.HEADER and not self._header:
            _same(Header.read(ReadDataStream(BytesIO(record.data))), record.data)
            self._header = True
            self._write(mcap.pack_record(mcap.HEADER, record.data))
        elif record.opcode >= _PRIVATE:
            self._write(mcap.pack_record(record.opcode, record.data))

    def _copy_chunk(self, data: bytes) -> None:
        try:
            chunk = mcap.open_chunk(data)
            places = places_of(chunk.records)
            for record in mcap.chunk_records(chunk.records):
                if record.opcode != mcap.MESSAGE:
                    self._note(record.opcode, record.data or b"")
            if not set(np.unique(places.channel).tolist()) <= set(self._channels):
                raise ValueError("a channel that is not described")
        except mcap.TooLargeError:
            raise
        except DAMAGE:
            self._left_out += 1
            self._describe_channels()
            return
        whole = mcap.pack_record(mcap.CHUNK, data)
        sizes = chunk.packed_size, len(chunk.records)
        written, entry = index_chunk(whole, chunk.compression, *sizes, places, self._at)
        self._entries.append(entry)
        self._write(written)

    def _note(self, opcode: int, data: bytes) -> bool:
        """Takes note of a schema or channel; whether what a message needs is known."""
        number = int.from_bytes(data[:2], "little")
        if opcode == mcap.SCHEMA:
            self._schemas[number] = mcap.pack_record(opcode, data)
        elif opcode == mcap.CHANNEL:
            self._channels[number] = mcap.pack_record(opcode, data)
        return opcode != mcap.MESSAGE or number in self._channels

    def _describe_channels(self) -> None:
        """Schemas and channels that a lost chunk described, from the index at the file's end."""
        with suppress(OSError, *DAMAGE), self._path.open("rb") as stream:
            stream.seek(self._size - 28)  # Footer and magic are 37 bytes, the first nine of them the record's head.
            start = int.from_bytes(stream.read(8), "little")
            stream.seek(start)
            content = stream.read(self._size - 37 - start)
            for record in mcap.chunk_records(content):
                known = self._schemas if record.opcode == mcap.SCHEMA else self._channels
                number = int.from_bytes((record.data or b"")[:2], "little")
                if record.opcode in (mcap.SCHEMA, mcap.CHANNEL) and number not in known:
                    self._note(record.opcode, record.data or b"")
                    self._write(mcap.pack_record(record.opcode, record.data or b""))

    def _copy_attachment(self, record: mcap.Record) -> None:
        """Copies one that is too large for the memory, piece by piece."""
        with self._path.open("rb") as stream:
            stream.seek(record.start)
            head = stream.read(1 << 16)[9:]
            self._entries.append(_attachment_entry(head, record.length, self._at))
            stream.seek(record.start)
            left = 9 + record.length
            while left and (piece := stream.read(min(left, 1 << 20))):
                self._write(piece)
                left -= len(piece)

    def _finish_loose(self) -> None:
        """Puts records that stood in no chunk into one."""
        records = b"".join(self._loose)
        self._loose, self._loose_bytes = [], 0
        if records:
            written, entry = pack_chunk(records, places_of(records), self._at)
            self._entries.append(entry)
            self._write(written)

    def _add_journal(self) -> int:
        """Adds what the journal has of the chunk in progress; how many messages."""
        count = 0
        content = read_journal(self._path, self._chunks)
        for record in mcap.chunk_records(content):
            if self._note(record.opcode, record.data or b""):
                self._loose.append(mcap.pack_record(record.opcode, record.data or b""))
                count += record.opcode == mcap.MESSAGE
        self._finish_loose()
        return count


def _entry(opcode: int, data: bytes, start: int) -> Entry:
    """The index's entry of an attachment or metadata at `start`; raises one of DAMAGE where it makes no sense."""
    if opcode == mcap.ATTACHMENT:
        if int.from_bytes(data[-4:], "little") not in (0, zlib.crc32(data[:-4])):
            raise ValueError("an attachment's checksum is wrong")
        return _attachment_entry(data, len(data), start)
    metadata = Metadata.read(ReadDataStream(BytesIO(data)))
    _same(metadata, data)
    return MetadataIndex(offset=start, length=9 + len(data), name=metadata.name)


def _same(record: McapRecord, data: bytes) -> None:
    """Raises ValueError where a record read from a content would not be written as that again."""
    builder = RecordBuilder()
    record.write(builder)
    if builder.end()[9:] != data:
        raise ValueError("a record is damaged")


def _attachment_entry(content: bytes, length: int, start: int) -> AttachmentIndex:
    """The index's entry of an attachment record of `length` bytes at `start`, from the beginning of its content."""
    stream = ReadDataStream(BytesIO(content))
    log_time, create_time = stream.read8(), stream.read8()
    name, media_type = stream.read_prefixed_string(), stream.read_prefixed_string()
    return AttachmentIndex(
        offset=start,
        length=9 + length,
        log_time=log_time,
        create_time=create_time,
        data_size=stream.read8(),
        name=name,
        media_type=media_type,
    )
