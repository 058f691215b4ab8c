"""An MCAP file under construction: ROS 2 profile, simulated time only, nothing lost that was handed over."""

import atexit
import os
import shlex
import zlib
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from mcap.data_stream import RecordBuilder
from mcap.records import Attachment, AttachmentIndex, Channel, Header, McapRecord, Metadata, MetadataIndex, Schema

import drake_blfdmp
from drake_blfdmp.errors import BlfDmpError
from drake_blfdmp.recording.journal import Journal, journal_of
from drake_blfdmp.recording.mcap_chunk import ChunkEntry, Entry, joined, pack_chunk, pack_end
from drake_blfdmp.recording.message_block import MessageBlock
from drake_blfdmp.recording.piece import Piece, places_of_pieces
from drake_blfdmp.ros2 import mcap_records as mcap
from drake_blfdmp.ros2.messages import DEFINITIONS

CHUNK_BYTES = 1024 * 1024


class RecorderError(BlfDmpError):
    """A recording of a run cannot be written or read."""


def recover_hint(path: Path) -> str:
    """What to do about a file that is not complete."""
    return f"run python run.py recover {shlex.quote(str(path))}"


def _qos(*, transient_local: bool) -> str:
    """Quality of service as rosbag2 stores it: a latched topic is sent again to whoever subscribes late."""
    # The numbers are rmw's: history keep_last, reliability reliable, durability transient_local or volatile; "infinite"
    # is the largest duration. Numbers, not names, because every rosbag2 reads those.
    infinite = "{sec: 9223372036, nsec: 854775807}"
    return (
        f"- {{history: 1, depth: {1 if transient_local else 10}, reliability: 1, "
        f"durability: {1 if transient_local else 2}, deadline: {infinite}, lifespan: {infinite}, liveliness: 1, "
        f"liveliness_lease_duration: {infinite}, avoid_ros_namespace_conventions: false}}\n"
    )


class _Written(NamedTuple):
    """What is in the file and what is still to come, replaced as a whole: an interruption finds one state or the next.

    Attributes:
        size, crc: of the file as far as it counts; what stands behind was interrupted and is written over.
        entries: how many of the noted ones count.
        chunks: how many there are.
        pending: the chunk in progress.
    """

    size: int
    crc: int
    entries: int
    chunks: int
    pending: list[Piece]


class McapFile:
    """Writes messages to a new MCAP file.

    The bytes depend on what is written and on nothing else (no wall clock, no process or machine name), so equal runs
    give equal files. A chunk is closed, compressed and written after `chunk_duration` of SIMULATED time, or at 1 MiB:
    cutting by the wall clock would lose the equality. What is in no chunk yet is in the journal `<file>.journal`
    beside it (see `journal`), so that a process killed outright loses the message in hand and no more; `recover` puts
    both together. Everything else is in the file as soon as its method returns.

    An interruption at any place (Ctrl-C, a signal's exception) leaves a file that `close` completes, and a file that is
    forgotten is completed at the interpreter's exit.

    Attributes:
        path: of the file.
        closed: whether it is complete, or given up.
        before_close: called by `close` first: whoever holds messages back writes them there.

    Args:
        filename: the file to create.
        chunk_duration: s of simulated time.

    Raises:
        RecorderError: the file exists, or cannot be created.
    """

    def __init__(self, filename: str | Path, *, chunk_duration: float = 1.0):
        self.path = Path(filename)
        try:
            if self.path.exists():
                raise FileExistsError
            self._journal = Journal(self.path)
        except FileExistsError:
            there = self.path if self.path.exists() else journal_of(self.path)
            raise RecorderError(f"{there}: already exists and is not overwritten; choose another name") from None
        except OSError as error:
            raise self._cannot_create(error) from None
        self._chunk_ns = round(chunk_duration * 1e9)
        self._chunk_end: int | None = None
        self._numbers: dict[str, int] = {}
        self._schemas: dict[int, bytes] = {}
        self._channels: dict[int, bytes] = {}
        self._entries: list[Entry] = []
        self._single: dict[int, MessageBlock] = {}
        self._latest_ns = 0
        self._pending_bytes = 0
        self._written = _Written(0, 0, 0, 0, [])
        self._kept = 0, 0  # Of the chunk after so many, so many pieces are in the journal.
        self._pid = os.getpid()
        self.closed = False
        self.before_close: Callable[[], None] = lambda: None
        try:
            self._descriptor = os.open(self.path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666)
            try:
                self._append(mcap.MAGIC + _record(Header("ros2", f"drake_blfdmp {drake_blfdmp.__version__}")))
            except OSError:
                os.close(self._descriptor)
                self.path.unlink()
                raise
        except OSError as error:
            self._journal.close(remove=True)
            raise self._cannot_create(error) from None
        atexit.register(self._close_at_exit)

    def add_metadata(self, name: str, data: Mapping[str, object]) -> None:
        """Adds a metadata record; values are written as `str(value)`."""
        record = _record(Metadata(name=name, metadata={str(key): str(value) for key, value in data.items()}))
        self._try_append(record, MetadataIndex(offset=self._written.size, length=len(record), name=name))

    def add_attachment(self, name: str, data: bytes, media_type: str) -> None:
        """Adds an attachment, logged at the latest message's simulated time; its creation time is 0, "not known"."""
        attachment = Attachment(create_time=0, log_time=self._latest_ns, name=name, media_type=media_type, data=data)
        record = _record(attachment)
        index = AttachmentIndex(
            offset=self._written.size,
            length=len(record),
            create_time=0,
            log_time=self._latest_ns,
            data_size=len(data),
            name=name,
            media_type=media_type,
        )
        self._try_append(record, index)

    def add_channel(
        self, topic: str, message_type: str, metadata: Mapping[str, str] | None = None, *, transient_local: bool = False
    ) -> int:
        """Adds a topic of one of the types in `ros2.messages.DEFINITIONS`; returns its number for `write`."""
        if message_type not in self._numbers:
            number = len(self._numbers) + 1
            definition = DEFINITIONS[message_type].encode()
            schema = _record(Schema(id=number, data=definition, encoding="ros2msg", name=message_type))
            self._schemas[number] = schema
            self._numbers[message_type] = number
            self._pend(Piece(schema, 0, None))
        number = len(self._channels) + 1
        channel = _record(
            Channel(
                id=number,
                topic=topic,
                message_encoding="cdr",
                schema_id=self._numbers[message_type],
                metadata={"offered_qos_profiles": _qos(transient_local=transient_local), **(metadata or {})},
            )
        )
        self._channels[number] = channel
        self._pend(Piece(channel, 0, None))
        self._keep()
        return number

    def write(self, channel: int, t_ns: int, data: bytes) -> None:
        """Adds a message at simulated time `t_ns` (ns)."""
        self.write_pieces([self.piece(channel, t_ns, data)])

    def piece(self, channel: int, t_ns: int, data: bytes) -> Piece:
        """A message for `write_pieces`."""
        block = self._single.get(channel)
        if block is None:
            block = self._single[channel] = MessageBlock([(channel, None)])
        return Piece(mcap.pack_record(mcap.MESSAGE, mcap.pack_message_head(channel, t_ns, t_ns), data), t_ns, block)

    def write_pieces(self, pieces: Iterable[Piece]) -> None:
        """Adds messages, in the order of time; those taken from an iterator that fails are written all the same."""
        try:
            for piece in pieces:
                t_ns, end = piece.t_ns, self._chunk_end
                if end is not None and (t_ns >= end or self._pending_bytes >= CHUNK_BYTES):
                    self._try_finish_chunk()
                if self._chunk_end is None:
                    self._chunk_end = t_ns + self._chunk_ns
                self._latest_ns = max(self._latest_ns, t_ns)
                self._pend(piece)
        finally:
            self._keep()

    def _pend(self, piece: Piece) -> None:
        """Adds records to the chunk in progress."""
        self._written.pending.append(piece)
        self._pending_bytes += len(piece.records)

    def _keep(self) -> None:
        """Writes to the journal what is pending and not there yet, all at once: each time costs microseconds."""
        chunks, pending = self._written.chunks, self._written.pending
        first = self._kept[1] if self._kept[0] == chunks else 0
        self._kept = chunks, len(pending)
        if first < len(pending):
            try:
                self._journal.add(chunks, b"".join(piece.records for piece in pending[first:]))
            except OSError as error:
                raise self._cannot_write(error) from None

    def _try_finish_chunk(self) -> None:
        try:
            self._finish_chunk()
        except OSError as error:
            raise self._cannot_write(error) from None

    def _finish_chunk(self) -> None:
        """Writes the chunk in progress, if it has any message."""
        pending = self._written.pending
        places = joined(places_of_pieces(pending))
        if len(places.time):
            self._append(*pack_chunk(b"".join(piece.records for piece in pending), places, self._written.size))
        self._pending_bytes, self._chunk_end = 0, None

    def _try_append(self, data: bytes, entry: Entry) -> None:
        try:
            self._append(data, entry)
        except OSError as error:
            raise self._cannot_write(error) from None

    def _append(self, data: bytes, entry: Entry | None = None) -> None:
        """Writes to the file itself; with a chunk's entry the chunk in progress is in it then."""
        size, crc, entries, chunks, pending = self._written
        self._put(data, size)
        if entry is not None:
            self._entries[entries:] = [entry]
            entries += 1
        if isinstance(entry, ChunkEntry):
            chunks, pending = chunks + 1, []
        self._written = _Written(size + len(data), zlib.crc32(data, crc), entries, chunks, pending)

    def _put(self, data: bytes, start: int) -> None:
        """Writes at a place of the file, all or nothing."""
        left, at = memoryview(data), start
        try:
            while left:
                done = os.pwrite(self._descriptor, left, at)
                left, at = left[done:], at + done
        except OSError:
            os.ftruncate(self._descriptor, start)
            raise

    def close(self) -> None:
        """Writes the last chunk, the indexes and the summary, and closes the file; a second call does nothing.

        Where that cannot be written the journal stays, and nothing is lost that it holds.
        """
        if self.closed:
            return
        try:
            self.before_close()
        except Exception:  # An interruption leaves it open: what is held then comes with the next call.
            self._complete()
            raise
        self._complete()

    def _complete(self) -> None:
        try:
            self._finish_chunk()
            size, crc, count, _, _ = self._written
            end = pack_end(self._schemas, self._channels, self._entries[:count], start=size, data_crc=crc)
            self._put(end, size)
            os.ftruncate(self._descriptor, size + len(end))  # Behind it an interruption may have left something.
        except OSError as error:
            self._release(complete=False)
            raise self._cannot_write(error) from None
        self._release(complete=True)

    def _release(self, *, complete: bool) -> None:
        self.closed = True
        os.close(self._descriptor)
        self._journal.close(remove=complete)
        atexit.unregister(self._close_at_exit)

    def _close_at_exit(self) -> None:
        if os.getpid() == self._pid:  # A fork has the file as well.
            with suppress(RecorderError):
                self.close()

    def _cannot_create(self, error: OSError) -> RecorderError:
        return RecorderError(
            f"{self.path}: cannot be created ({error.strerror}); give a name in a writable folder with free space"
        )

    def _cannot_write(self, error: OSError) -> RecorderError:
        return RecorderError(
            f"{self.path}: writing failed ({error.strerror}); free space there or record elsewhere; "
            f"what was written is kept, {recover_hint(self.path)}"
        )


def _record(record: McapRecord) -> bytes:
    builder = RecordBuilder()
    record.write(builder)
    return builder.end()
