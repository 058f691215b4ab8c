"""Messages that are written together again and again and differ in times and numbers alone."""

from collections.abc import Sequence

import numpy as np

from drake_blfdmp.ros2 import mcap_records as mcap
from drake_blfdmp.ros2.cdr import CdrTemplate

_SECOND = 1_000_000_000


class MessageBlock:
    """MCAP's records of several messages, of many instants at once, filled in by a few assignments.

    Encoding message by message costs several microseconds each; a sample of a run has more than a dozen.

    Attributes:
        channels: (K,) of the messages.
        offsets: (K,) where their records begin.
        count: M, how many numbers all messages have together; a message's float64 stand before its float32.
    """

    def __init__(self, messages: Sequence[tuple[int, CdrTemplate | None]]):
        """Of (channel, template): what is sent on it; without a template only to say where one message stands."""
        parts, offsets, times, at = [], [], [], 0
        # Places in the bytes, and of numbers their columns among the values given to `encode`.
        stamps, doubles, singles = ([np.empty(0, dtype=int)] for _ in range(3))
        double_columns, single_columns = ([np.empty(0, dtype=int)] for _ in range(2))
        self.count = 0
        for channel, template in messages:
            blank = b"" if template is None else template.blank
            record = mcap.pack_record(mcap.MESSAGE, mcap.pack_message_head(channel, 0, 0), blank)
            body = at + len(record) - len(blank)
            offsets.append(at)
            times += [body - 16, body - 8]  # Log time, publish time.
            if template is not None:
                stamps.append(body + template.stamp_offsets)
                doubles.append(body + template.float64_offsets)
                singles.append(body + template.float32_offsets)
                middle = self.count + template.float64_count
                double_columns.append(np.arange(self.count, middle))
                self.count = middle + template.float32_count
                single_columns.append(np.arange(middle, self.count))
            parts.append(record)
            at += len(record)
        self.channels = np.array([channel for channel, _ in messages], dtype=np.uint64)
        self.offsets = np.array(offsets, dtype=np.uint64)
        self._blank = np.frombuffer(b"".join(parts), dtype=np.uint8)
        self._times = np.array(times, dtype=int)
        self._stamps = np.concatenate(stamps)
        self._doubles, self._double_columns = np.concatenate(doubles), np.concatenate(double_columns)
        self._singles, self._single_columns = np.concatenate(singles), np.concatenate(single_columns)

    def encode(self, times_ns: np.ndarray, values: np.ndarray) -> list[bytes]:
        """The records of each of N instants.

        Args:
            times_ns: (N,) of the messages and of every stamp in them, ns.
            values: (N, M) numbers, in the messages' order.
        """
        n, size = len(times_ns), len(self._blank)
        if not size:
            return [b""] * n
        records = np.tile(self._blank, (n, 1))
        # Views of a number from each byte on: they stand at any place.
        float64s, uint64s, float32s = (
            np.ndarray((n, size - bytes_ + 1), dtype=f"<{kind}{bytes_}", buffer=records, strides=(size, 1))
            for kind, bytes_ in (("f", 8), ("u", 8), ("f", 4))
        )
        times = np.asarray(times_ns, dtype=np.uint64)[:, None]
        seconds, rest = np.divmod(times, np.uint64(_SECOND))
        uint64s[:, self._times] = times
        uint64s[:, self._stamps] = seconds | rest << np.uint64(32)  # `pack_stamp`
        if len(self._singles):
            float32s[:, self._singles] = values[:, self._single_columns]
            values = values[:, self._double_columns]
        float64s[:, self._doubles] = values
        whole = records.tobytes()
        return [whole[at : at + size] for at in range(0, n * size, size)]
