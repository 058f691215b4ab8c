"""Messages that are written together again and again and differ in times and numbers alone."""

from collections.abc import Sequence

import numpy as np

from drake_blfdmp.ros2 import mcap_records as mcap
from drake_blfdmp.ros2.cdr import CdrTemplate

_SECOND = 1_000_000_000


class MessageBlock:
    """MCAP's records of several messages, of many instants at once, filled in by three assignments.

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
        self._blank = np.frombuffer(b"".join(parts), dtype=np.uint8)
        self._times = np.array(times, dtype=int)
        self._stamps = np.concatenate(stamps) if stamps else np.empty(0, dtype=int)
        self._numbers = np.concatenate(numbers) if numbers else np.empty(0, dtype=int)
        self.count = len(self._numbers)
        self._order = slice(None) if order is None else order

    def encode(self, times_ns: np.ndarray, values: np.ndarray) -> list[bytes]:
        """The records of each of N instants.

        Args:
            times_ns: (N,) of the messages and of every stamp in them, ns.
            values: (N, ...) numbers; M of them where no order was given.
        """
        n, size = len(times_ns), len(self._blank)
        if not size:
            return [b""] * n
        records = np.tile(self._blank, (n, 1))
        # A view of eight bytes from each byte on: numbers stand at any place.
        float64s, uint64s = (
            np.ndarray((n, size - 7), dtype=kind, buffer=records, strides=(size, 1)) for kind in ("<f8", "<u8")
        )
        times = np.asarray(times_ns, dtype=np.uint64)[:, None]
        seconds, rest = np.divmod(times, np.uint64(_SECOND))
        uint64s[:, self._times] = times
        uint64s[:, self._stamps] = seconds | rest << np.uint64(32)  # `pack_stamp`
        float64s[:, self._numbers] = values[:, self._order]
        whole = records.tobytes()
        return [whole[at : at + size] for at in range(0, n * size, size)]
