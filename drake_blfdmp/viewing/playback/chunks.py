"""An MCAP file record by record, without holding more than one chunk of it.

`mcap.reader` keeps the index of the whole file in memory, half a gigabyte for one of 10 GB, and needs that index; here
the records are walked over by their lengths, so a file without index, or with its end missing, is read the same way.
"""

import struct
from array import array
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from io import BufferedReader, BytesIO
from pathlib import Path

import numpy as np
from mcap.data_stream import ReadDataStream
from mcap.exceptions import EndOfFile
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, Header, Metadata, Schema
from mcap.stream_reader import get_chunk_data_stream

from drake_blfdmp.errors import BlfDmpError

MAGIC = b"\x89MCAP0\r\n"
_RECORD = struct.Struct("<BQ")
_MESSAGE = struct.Struct("<HIQQ")
_CHUNK_TIMES = struct.Struct("<QQ")
_LARGEST_CHUNK = 1 << 30
_LAST_NS = 1 << 62  # In the year 2116.

Progress = Callable[[str, float], None]


class DamageError(BlfDmpError):
    """The file ends, or stops to make sense, at a byte that the message names."""


@dataclass
class Times:
    """First and last log time of a channel's messages, ns, and their number."""

    first: int
    last: int
    count: int


@dataclass
class Contents:
    """What a first walk over a file finds; no message is looked into.

    Attributes:
        profile: of the header.
        channels, schemas: by their numbers.
        times: channel -> when it has messages; only of channels that have some.
        metadata: record -> its entries.
        damage: empty, or where the file is cut off or damaged.
    """

    path: Path
    profile: str = ""
    channels: dict[int, Channel] = field(default_factory=dict)
    schemas: dict[int, Schema] = field(default_factory=dict)
    times: dict[int, Times] = field(default_factory=dict)
    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    damage: str = ""
    # Which channels each chunk holds, as an index into a list of the distinct sets: chunks are many, sets are few.
    _sets: list[frozenset[int]] = field(default_factory=list)
    _set_of_chunk: array = field(default_factory=lambda: array("L"))

    def type_of(self, channel: Channel) -> str:
        """The name of the channel's schema; empty without one."""
        schema = self.schemas.get(channel.schema_id)
        return schema.name if schema is not None else ""


def look_through(path: Path, progress: Progress) -> Contents:
    """Walks over a file once: topics, times, metadata.

    Raises:
        BlfDmpError: there is no such file, or it is no MCAP file.
    """
    contents = Contents(path)
    known: dict[frozenset[int], int] = {}
    for opcode, body, stream in _opened(path, contents, "looking through", progress):
        if opcode == Opcode.CHUNK:
            chunk_at = stream.tell()
            contents._set_of_chunk.append(0)
            found = _indexes_behind(stream, chunk_at + body)
            missing = found is None or not set(found) <= set(contents.channels)
            if missing:
                stream.seek(chunk_at)
                try:
                    found = _open_chunk(contents, _chunk(stream, body))
                except DamageError as error:
                    contents.damage = str(error)
                    break
            for channel, seen in (found or {}).items():
                _seen(contents.times, channel, seen.first, seen.last, seen.count)
            key = frozenset(found or ())
            if key not in known:
                known[key] = len(contents._sets)
                contents._sets.append(key)
            contents._set_of_chunk[-1] = known[key]
        elif opcode == Opcode.MESSAGE:
            try:
                channel, t = _head(stream.read(min(body, _MESSAGE.size)), 0, body)
            except DamageError as error:
                contents.damage = str(error)
                break
            _seen(contents.times, channel, t, t, 1)
        elif opcode in (Opcode.HEADER, Opcode.SCHEMA, Opcode.CHANNEL, Opcode.METADATA):
            _register(contents, opcode, stream.read(body))
    return contents


def messages(
    contents: Contents,
    channels: Iterable[int],
    until_ns: int,
    near: np.ndarray,
    sparse: Iterable[int],
    progress: Progress,
) -> Iterator[tuple[int, int, bytes]]:
    """Channel, log time (ns) and bytes of the messages of some channels, in the order of the file.

    Args:
        contents: of the file.
        channels: their numbers.
        until_ns: chunks that begin later are passed over.
        near: (K, 2) increasing intervals of time, ns; chunks that touch none are passed over, unless they hold messages
            of `sparse`.
        sparse: channels with so few messages that each counts.
        progress: called now and then.

    Raises:
        DamageError: a chunk is damaged.
    """
    wanted, sparse = frozenset(channels), frozenset(sparse)
    holds = [bool(wanted & held) for held in contents._sets]
    counts = [bool(sparse & held) for held in contents._sets]
    chunk = -1
    for opcode, body, stream in _opened(contents.path, Contents(contents.path), "reading", progress):
        if opcode == Opcode.CHUNK:
            chunk += 1
            which = contents._set_of_chunk[chunk] if chunk < len(contents._set_of_chunk) else None
            if which is None or not holds[which]:
                continue
            at = stream.tell()
            first, last = _CHUNK_TIMES.unpack(stream.read(_CHUNK_TIMES.size))
            stream.seek(at)
            if not counts[which]:
                after = int(np.searchsorted(near[:, 1], first))
                if first > until_ns or after >= len(near) or near[after, 0] > last:
                    continue
            data = _chunk(stream, body)
            for code, start, end in _inside(data):
                if code == Opcode.MESSAGE:
                    channel, t = _head(data, start, end)
                    if channel in wanted:
                        yield channel, t, data[start + _MESSAGE.size : end]
        elif opcode == Opcode.MESSAGE:
            data = stream.read(body)
            channel, t = _head(data, 0, len(data))
            if channel in wanted:
                yield channel, t, data[_MESSAGE.size :]


def _opened(path: Path, contents: Contents, what: str, progress: Progress) -> Iterator[tuple[int, int, BufferedReader]]:
    """Opcode and length of every record of the data section, with the stream where its content begins.

    What stops it before the data's end goes to `contents.damage`.
    """
    try:
        with path.open("rb") as stream:
            size = path.stat().st_size
            start = stream.read(len(MAGIC))
            if start != MAGIC:
                kind = "is empty" if not start else "is no MCAP file"
                raise BlfDmpError(f"{path}: {kind}; name a recording that ends in .mcap")
            at = stream.tell()
            try:
                while True:
                    stream.seek(at)
                    head = stream.read(_RECORD.size)
                    if len(head) < _RECORD.size:
                        raise DamageError(f"cut off at byte {size}")
                    opcode, length = _RECORD.unpack(head)
                    begin, at = at, at + _RECORD.size + length
                    if opcode == Opcode.DATA_END:
                        break
                    if opcode == 0 or opcode == Opcode.FOOTER:
                        raise DamageError(f"damaged at byte {begin}")
                    if at > size:
                        raise DamageError(f"cut off at byte {size}, within a record that begins at byte {begin}")
                    progress(what, begin / size)
                    yield opcode, length, stream
                stream.seek(max(size - len(MAGIC), 0))
                if stream.read() != MAGIC:
                    raise DamageError(f"cut off at byte {size}, within its index")
                progress(what, 1.0)
            except DamageError as error:
                contents.damage = str(error)
    except OSError as error:
        raise BlfDmpError(f"{path}: cannot be read ({error.strerror}); check the name") from None


def _chunk(stream: BufferedReader, length: int) -> bytes:
    """A chunk's records, decompressed and checked."""
    at = stream.tell()
    if length > _LARGEST_CHUNK:
        raise DamageError(f"damaged at byte {at}: a chunk of {length} bytes")
    try:
        chunk = Chunk.read(ReadDataStream(BytesIO(stream.read(length))))
        data, count = get_chunk_data_stream(chunk, validate_crc=True)
        return data.read(count)
    except Exception as error:  # Arbitrary bytes make decompressors raise almost anything.
        raise DamageError(f"damaged near byte {at} ({type(error).__name__})") from None


def _inside(data: bytes) -> Iterator[tuple[int, int, int]]:
    """Opcode, start and end of the content of each record in a chunk."""
    at = 0
    while at + _RECORD.size <= len(data):
        opcode, length = _RECORD.unpack_from(data, at)
        at += _RECORD.size
        yield opcode, at, at + length
        at += length


def _open_chunk(contents: Contents, data: bytes) -> dict[int, Times]:
    """Takes the schemas and channels in a chunk, and returns the times of its messages."""
    times: dict[int, Times] = {}
    for code, start, end in _inside(data):
        if code == Opcode.MESSAGE:
            channel, t = _head(data, start, end)
            _seen(times, channel, t, t, 1)
        else:
            _register(contents, code, data[start:end])
    return times


def _head(data: bytes, start: int, end: int) -> tuple[int, int]:
    """Channel and log time of a message whose record is data[start:end]."""
    if end - start < _MESSAGE.size:
        raise DamageError(f"damaged: a message of {end - start} bytes")
    channel, _, t, _ = _MESSAGE.unpack_from(data, start)
    if t > _LAST_NS:
        raise DamageError(f"damaged: a message at t = {t * 1e-9:g} s")
    return channel, t


def _indexes_behind(stream: BufferedReader, at: int) -> dict[int, Times] | None:
    """What the message indexes behind a chunk that ends at byte `at` say; None where there are none."""
    times: dict[int, Times] = {}
    stream.seek(at)
    while True:
        head = stream.read(_RECORD.size)
        if len(head) < _RECORD.size:
            break
        opcode, length = _RECORD.unpack(head)
        if opcode != Opcode.MESSAGE_INDEX or length > _LARGEST_CHUNK:
            break
        body = stream.read(length)
        if len(body) < length or length % 16 != 6:
            break
        channel, _ = struct.unpack_from("<HI", body)
        stamps = np.frombuffer(body, dtype="<u8", offset=6)[::2]
        if len(stamps) and int(stamps.max()) <= _LAST_NS:
            _seen(times, channel, int(stamps.min()), int(stamps.max()), len(stamps))
    return times or None


def _seen(times: dict[int, Times], channel: int, first: int, last: int, count: int) -> None:
    old = times.get(channel)
    if old is None:
        times[channel] = Times(first, last, count)
    else:
        old.first, old.last, old.count = min(old.first, first), max(old.last, last), old.count + count


def _register(contents: Contents, opcode: int, body: bytes) -> None:
    """Takes a header, schema, channel or metadata record."""
    stream = ReadDataStream(BytesIO(body))
    try:
        if opcode == Opcode.HEADER:
            contents.profile = Header.read(stream).profile
        elif opcode == Opcode.SCHEMA:
            schema = Schema.read(stream)
            contents.schemas[schema.id] = schema
        elif opcode == Opcode.CHANNEL:
            channel = Channel.read(stream)
            contents.channels[channel.id] = channel
        elif opcode == Opcode.METADATA:
            record = Metadata.read(stream)
            contents.metadata[record.name] = dict(record.metadata)
    except (EndOfFile, UnicodeDecodeError, struct.error):
        contents.damage = f"damaged: a record of kind {opcode} cannot be read"
