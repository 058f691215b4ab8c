"""The journal beside a file under construction: what of the chunk in progress is not in the file yet. Without pydrake.

It is a row of pieces of the chunk's content, MCAP records as they will stand in it. Before each stand its length, a
checksum, and how many chunks the file had when this one began. The next chunk's pieces are written over the last one's,
which that number tells apart. Once the file is complete the journal is gone.

It is written through memory that the operating system shares with the file, which survives the process and costs no
call into the system: a sample is written a hundred times a second, between others' work.
"""

import mmap
import os
import struct
import zlib
from pathlib import Path

SUFFIX = ".journal"
_HEAD = struct.Struct("<IIQ")
_FIRST_SIZE = 1 << 18


def journal_of(path: Path) -> Path:
    """The journal's name beside a file's."""
    return path.with_name(path.name + SUFFIX)


class Journal:
    """The journal of a new file."""

    def __init__(self, path: Path):
        """Create it for the file `path`.

        Raises:
            OSError: it exists, or cannot be created or written.
        """
        self.path = journal_of(path)
        self._descriptor = os.open(self.path, os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o666)
        self._size = self._at = 0
        self._chunks = 0
        try:
            self._grow(_FIRST_SIZE)
        except OSError:
            self.close(remove=True)
            raise

    def _grow(self, size: int) -> None:
        # Zeros are written, not left out: memory of a hole would fail on a full disk without a word.
        zeros = memoryview(bytes(size - self._size))
        while zeros:
            zeros = zeros[os.pwrite(self._descriptor, zeros, size - len(zeros)) :]
        self._memory = mmap.mmap(self._descriptor, size)
        self._size = size

    def add(self, chunks: int, piece: bytes) -> None:
        """Add a piece of the chunk that follows the file's first `chunks`.

        Raises:
            OSError: there is no space for it.
        """
        if chunks != self._chunks:
            self._chunks, self._at = chunks, 0
        at, begin = self._at, self._at + _HEAD.size
        end = begin + len(piece)
        if end > self._size:
            self._grow(2 * end)
        self._memory[begin:end] = piece
        _HEAD.pack_into(self._memory, at, len(piece), zlib.crc32(piece, chunks & 0xFFFFFFFF), chunks)
        self._at = end

    def close(self, *, remove: bool) -> None:
        """Close it; keep it where it is still needed."""
        if self._descriptor >= 0:
            os.close(self._descriptor)  # The memory goes with the object.
            self._descriptor = -1
        if remove:
            self.path.unlink(missing_ok=True)


def read_journal(path: Path, chunks: int) -> bytes:
    """What the journal of the file `path` holds, as far as whole, of the chunk after its first `chunks`."""
    try:
        data = journal_of(path).read_bytes()
    except OSError:
        return b""
    at, pieces = 0, []
    while at + _HEAD.size <= len(data):
        length, crc, before = _HEAD.unpack_from(data, at)
        at += _HEAD.size
        piece = data[at : at + length]
        if before != chunks or not 0 < length == len(piece) or zlib.crc32(piece, before & 0xFFFFFFFF) != crc:
            break
        pieces.append(piece)
        at += length
    return b"".join(pieces)
