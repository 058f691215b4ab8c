"""Messages that are written together again and again and differ in times and numbers alone."""

from collections.abc import Sequence

import numpy as np

from drake_blfdmp.ros2 import mcap_records as mcap
from drake_blfdmp.ros2.cdr import CdrTemplate, pack_stamp


class MessageBlock:
    """MCAP's records of several messages, filled in by three assignments.

    Encoding message by message costs several microseconds each; a sample of a run has more than a dozen.

    Attributes:
        channels: (K,) of the messages.
        offsets: (K,) where their records begin.
        count: M, how many numbers all messages have together.
    """

    def __init__(self, messages: Sequence[tuple[int, CdrTemplate | None]], order: np.ndarray | None = None):
        """Of channels and what is sent on them; without a template only to say where one message stands.

        Args:
            messages: (channel, template).
            order: (M,) of each number in the messages, its place among the values given to `encode`; as they come when
                None.
        """
        parts, offsets, times, stamps, numbers, at = [], [], [], [], [], 0
        for channel, template in messages:
            blank = b"" if template is None else template.blank
            record = mcap.pack_record(mcap.MESSAGE, mcap.pack_message_head(channel, 0, 0), blank)
            body = at + len(record) - len(blank)
            offsets.append(at)
            times += [body - 16, body - 8]  # Log time, publish time.
            if template is not None:
                stamps.append(body + template.stamp_offsets)
                numbers.append(body + template.float64_offsets)
            parts.append(record)
            at += len(record)
        self.channels = np.array([channel for channel, _ in messages], dtype=np.uint64)
        self.offsets = np.array(offsets, dtype=np.uint64)
        self._bytes = bytearray(b"".join(parts))
        self._times = np.array(times, dtype=int)
        self._stamps = np.concatenate(stamps) if stamps else np.empty(0, dtype=int)
        self._numbers = np.concatenate(numbers) if numbers else np.empty(0, dtype=int)
        self.count = len(self._numbers)
        if order is not None:
            self._numbers = self._numbers[np.argsort(order)]
        # A view of eight bytes from each byte on: numbers stand at any place.
        shape = (max(len(self._bytes) - 7, 0),)
        self._float64s = np.ndarray(shape, dtype="<f8", buffer=self._bytes, strides=(1,))
        self._uint64s = np.ndarray(shape, dtype="<u8", buffer=self._bytes, strides=(1,))

    def encode(self, t_ns: int, values: np.ndarray) -> bytes:
        """The records at one instant.

        Args:
            t_ns: time of the messages and of every stamp in them, ns.
            values: (M,) numbers.
        """
        self._uint64s[self._times] = t_ns
        self._uint64s[self._stamps] = int.from_bytes(pack_stamp(t_ns), "little")
        self._float64s[self._numbers] = values
        return bytes(self._bytes)
