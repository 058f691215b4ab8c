"""CDR, the bytes of a ROS 2 message: a writer and a reader of single fields, and templates of fixed-size messages.

Only what this package's messages need: little-endian plain CDR (the encapsulation header `00 01 00 00`), in which every
field is aligned to its own size, counted from the end of that header (OMG DDSI-RTPS 2.5 section 10.2, OMG CORBA 3.4
part 2 section 9.3).
"""

import struct

import numpy as np

ENCAPSULATION = b"\x00\x01\x00\x00"
_HEADER = len(ENCAPSULATION)


def pack_stamp(t_ns: int) -> bytes:
    """A builtin_interfaces/Time (8 bytes): int32 seconds, uint32 nanoseconds."""
    return struct.pack("<iI", *divmod(t_ns, 1_000_000_000))


class CdrWriter:
    """Appends fields to a message; `float64s`, `float32s` and `stamp` leave zeros behind and remember where they stand.

    Attributes:
        float64_offsets: byte offset of every float64 left open, counted from the end of the encapsulation header.
        float32_offsets: the same for every float32.
        stamp_offsets: the same for every time stamp (8 bytes each).
    """

    def __init__(self):
        self._body = bytearray()
        self.float64_offsets: list[int] = []
        self.float32_offsets: list[int] = []
        self.stamp_offsets: list[int] = []

    def _align(self, size: int) -> None:
        self._body.extend(bytes(-len(self._body) % size))

    def uint8(self, value: int) -> None:
        self._body.append(value)

    def uint32(self, value: int) -> None:
        self._align(4)
        self._body.extend(struct.pack("<I", value))

    def int32(self, value: int) -> None:
        self._align(4)
        self._body.extend(struct.pack("<i", value))

    def float32(self, value: float) -> None:
        self._align(4)
        self._body.extend(struct.pack("<f", value))

    def float64(self, value: float) -> None:
        """A float64 that stays as it is in a template."""
        self._align(8)
        self._body.extend(struct.pack("<d", value))

    def string(self, text: str) -> None:
        """Length with the closing NUL, the UTF-8 bytes, the NUL."""
        encoded = text.encode() + b"\0"
        self.uint32(len(encoded))
        self._body.extend(encoded)

    def strings(self, texts) -> None:
        """A sequence of strings."""
        self.uint32(len(texts))
        for text in texts:
            self.string(text)

    def float64s(self, count: int) -> None:
        """`count` float64 in a row, without a length before them."""
        # No elements, no alignment: an empty sequence is its length alone.
        for _ in range(count):
            self._align(8)
            self.float64_offsets.append(len(self._body))
            self._body.extend(bytes(8))

    def float32s(self, count: int) -> None:
        """`count` float32 in a row, without a length before them."""
        for _ in range(count):
            self._align(4)
            self.float32_offsets.append(len(self._body))
            self._body.extend(bytes(4))

    def float64_sequence(self, count: int) -> None:
        """A sequence of `count` float64."""
        self.uint32(count)
        self.float64s(count)

    def stamp(self) -> None:
        """A builtin_interfaces/Time."""
        self._align(4)
        self.stamp_offsets.append(len(self._body))
        self._body.extend(bytes(8))

    def message(self, t_ns: int = 0) -> bytes:
        """The message so far, with its encapsulation header and every stamp set to `t_ns`."""
        body = bytearray(self._body)
        for offset in self.stamp_offsets:
            body[offset : offset + 8] = pack_stamp(t_ns)
        return ENCAPSULATION + bytes(body)


class CdrTemplate:
    """A message of fixed size, of which only the stamps and the open numbers change from one sample to the next.

    Encoding field by field in Python costs about a microsecond a field; here all float64 go in by one assignment.
    """

    def __init__(self, writer: CdrWriter):
        message = writer.message()
        # Four bytes before the encapsulation header put the body, hence every float64 in it, on a multiple of eight.
        padded = bytearray(4 + len(message) + -(4 + len(message)) % 8)
        padded[4 : 4 + len(message)] = message
        self._message = memoryview(padded)[4 : 4 + len(message)]
        body = 4 + _HEADER
        self._padded = padded
        self._float64s = np.frombuffer(padded, dtype="<f8")
        at = (np.array(writer.float64_offsets, dtype=int) + body) // 8
        contiguous = len(at) > 0 and at[-1] - at[0] == len(at) - 1
        self._at = slice(at[0], at[-1] + 1) if contiguous else at
        self._stamps = [offset + body for offset in writer.stamp_offsets]
        self.float64_count = len(at)
        self._float32s = np.frombuffer(padded, dtype="<f4")
        self._at_32 = (np.array(writer.float32_offsets, dtype=int) + body) // 4
        self.float32_count = len(self._at_32)

    def encode(self, t_ns: int, values: np.ndarray, singles: np.ndarray | None = None) -> bytes:
        """The message at one instant.

        Args:
            t_ns: time for every stamp, ns.
            values: `float64_count` numbers, of any shape, in the order of the message.
            singles: the same for the float32; those of the message before stay when None.
        """
        stamp = pack_stamp(t_ns)
        for offset in self._stamps:
            self._padded[offset : offset + 8] = stamp
        self._float64s[self._at] = values.ravel()
        if singles is not None:
            self._float32s[self._at_32] = singles.ravel()
        return self._message.tobytes()

    @property
    def blank(self) -> bytes:
        """The message as it is now."""
        return self._message.tobytes()

    @property
    def float64_offsets(self) -> np.ndarray:
        """(float64_count,) where in the message they stand, in bytes."""
        return 8 * np.arange(len(self._float64s))[self._at] - 4  # The padding before it.

    @property
    def float32_offsets(self) -> np.ndarray:
        """(float32_count,) the same for the float32."""
        return 4 * self._at_32 - 4

    @property
    def stamp_offsets(self) -> np.ndarray:
        """Where the stamps stand."""
        return np.array(self._stamps, dtype=int) - 4


class CdrReader:
    """Walks over the fields of one message, in the order in which a `CdrWriter` wrote them.

    Attributes:
        structure: (start, size) of the bytes read by value so far, not only by place: what messages of one kind share.

    Raises:
        ValueError: the bytes are no little-endian CDR, or end within a field.
    """

    def __init__(self, data: bytes):
        # The last two bytes are options, in which some middleware counts the padding at the message's end.
        if len(data) < _HEADER or data[:2] != ENCAPSULATION[:2]:
            raise ValueError(f"encapsulation header {data[:_HEADER].hex()} instead of {ENCAPSULATION.hex()}")
        self._data = data
        self._at = _HEADER
        self.structure: list[tuple[int, int]] = []

    def _take(self, size: int, align: int) -> int:
        start = self._at + -(self._at - _HEADER) % align
        if start + size > len(self._data):
            raise ValueError(f"message of {len(self._data)} bytes ends within a field")
        self._at = start + size
        return start

    def _read(self, size: int, align: int) -> int:
        start = self._take(size, align)
        self.structure.append((start, size))
        return start

    @property
    def left(self) -> int:
        """Bytes behind the last field read."""
        return len(self._data) - self._at

    def uint8(self) -> int:
        return self._data[self._read(1, 1)]

    def int32(self) -> int:
        return struct.unpack_from("<i", self._data, self._read(4, 4))[0]

    def uint32(self) -> int:
        return struct.unpack_from("<I", self._data, self._read(4, 4))[0]

    def string(self) -> str:
        length = self.uint32()
        start = self._read(length, 1)
        return self._data[start : start + length - 1].decode()

    def place(self, count: int, size: int, align: int | None = None) -> int:
        """Where (byte offset in the message) the next `count` fields of `size` bytes stand; passes over them."""
        return self._take(count * size, size if align is None else align) if count else self._at

    def strings(self) -> list[str]:
        return [self.string() for _ in range(self.uint32())]

    def float64s(self, count: int) -> list[int]:
        """Where (byte offsets in the message, the encapsulation header included) the next `count` float64 stand."""
        if count == 0:
            return []
        start = self._take(8 * count, 8)
        return list(range(start, start + 8 * count, 8))

    def float64_sequence(self) -> list[int]:
        return self.float64s(self.uint32())

    def stamp(self) -> int:
        """Where a time stamp stands (byte offset in the message)."""
        return self._take(8, 4)
