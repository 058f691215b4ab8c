"""A topic's messages, one after the other, brought to the frame times of a playback: nothing else of them is kept."""

from dataclasses import dataclass, field

import numpy as np

from drake_blfdmp.errors import BlfDmpError
from drake_blfdmp.ros2.messages import TF
from drake_blfdmp.viewing.playback.layouts import Layout, layout_of
from drake_blfdmp.viewing.playback.poses import between

LONGEST_GAP_NS = 1_000_000_000
"""Between two samples farther apart the earlier one is held: nothing was published because nothing moved."""

LATE_NS = 50_000_000
"""Messages that come later than this behind a newer one mean that time went back; others are left out."""

_MOST_LAYOUTS = 256
_NEVER = np.iinfo(np.int64).max


@dataclass
class _Stream:
    """Messages of one layout: the last one seen, and the values at the frame times passed so far."""

    layout: Layout
    values: np.ndarray
    gap: np.ndarray
    next: int = 0
    last: bytes | None = None
    last_ns: int = 0


@dataclass
class TopicSampler:
    """Samples one topic.

    Attributes:
        where: file and topic, for messages.
        type: JointState, TFMessage or WrenchStamped.
        times_ns: (F,) increasing frame times on the file's clock.
        late: messages left out because a newer one had come before.
    """

    where: str
    type: str
    times_ns: np.ndarray
    late: int = 0
    _latest_ns: int | None = None
    _streams: dict[int, list[_Stream]] = field(default_factory=dict)

    def add(self, t_ns: int, message: bytes) -> None:
        """Takes the next message.

        Raises:
            BlfDmpError: it cannot be decoded, or time goes back.
        """
        if self._latest_ns is not None and t_ns < self._latest_ns:
            if self._latest_ns - t_ns > LATE_NS:
                raise BlfDmpError(
                    f"{self.where}: time goes back from {self._latest_ns * 1e-9:.3f} s to {t_ns * 1e-9:.3f} s; "
                    "two recordings in one file are played only after they are split"
                )
            self.late += 1
            return
        self._latest_ns = t_ns
        stream = self._stream(message)
        if stream.next >= len(self.times_ns):
            return
        if t_ns >= self.times_ns[stream.next]:
            self._fill(stream, t_ns, message)
        stream.last, stream.last_ns = message, t_ns

    def finish(self) -> dict[tuple[str, ...], np.ndarray]:
        """Values (F, width) of each name; the last sample is held to the end, the first from the beginning.

        A row that is not finite counts as not sampled; names without any finite sample are left out.
        """
        best: dict[tuple[str, ...], tuple[np.ndarray, np.ndarray]] = {}
        for stream in (stream for streams in self._streams.values() for stream in streams):
            if stream.last is None:
                continue
            if stream.next < len(self.times_ns):
                stream.values[stream.next :] = stream.layout.values(stream.last)
                stream.gap[stream.next :] = self.times_ns[stream.next :] - stream.last_ns + LONGEST_GAP_NS
            for row, name in enumerate(stream.layout.names):
                values = stream.values[:, row]
                gap = np.where(np.isfinite(values).all(axis=-1), stream.gap, _NEVER)
                if name in best:
                    # The same name in messages of several layouts: at each time those whose samples are closest.
                    other, other_gap = best[name]
                    nearer = gap < other_gap
                    values, gap = np.where(nearer[:, None], values, other), np.minimum(gap, other_gap)
                best[name] = values, gap
        held = {name: _held(values, gap) for name, (values, gap) in best.items()}
        return {name: values for name, values in held.items() if values is not None}

    def _stream(self, message: bytes) -> _Stream:
        alike = self._streams.setdefault(len(message), [])
        raw = np.frombuffer(message, dtype=np.uint8)
        for stream in alike:
            if stream.layout.fits(raw):
                return stream
        try:
            layout = layout_of(self.type, message)
        except (ValueError, IndexError) as error:
            raise BlfDmpError(
                f"{self.where}: a message is no {self.type} ({error}); playback reads little-endian CDR"
            ) from None
        if sum(map(len, self._streams.values())) >= _MOST_LAYOUTS:
            raise BlfDmpError(f"{self.where}: its messages have more than {_MOST_LAYOUTS} different sets of names")
        shape = (len(self.times_ns), len(layout.names), layout.width)
        stream = _Stream(layout, np.full(shape, np.nan), np.full(len(self.times_ns), _NEVER))
        alike.append(stream)
        return stream

    def _fill(self, stream: _Stream, t_ns: int, message: bytes) -> None:
        """Values at the frame times up to `t_ns`, the time of `message`."""
        start, end = stream.next, int(np.searchsorted(self.times_ns, t_ns, side="right"))
        after, times = stream.layout.values(message), self.times_ns[start:end]
        stream.next = end
        if stream.last is None:
            stream.values[start:end], stream.gap[start:end] = after, t_ns - times + LONGEST_GAP_NS
            return
        before, gap = stream.layout.values(stream.last), t_ns - stream.last_ns
        share = (times - stream.last_ns) / gap if gap else np.ones(len(times))
        if gap > LONGEST_GAP_NS:
            share = np.floor(share)
        stream.gap[start:end] = gap
        # What is not finite at one end is so in between, but not at the other end itself.
        if self.type == TF:
            values = between(before, after, share)
        else:
            part = share[:, None, None]
            with np.errstate(invalid="ignore"):
                values = (1.0 - part) * before + part * after
        values[share == 0.0], values[share == 1.0] = before, after
        stream.values[start:end] = values


def _held(values: np.ndarray, gap: np.ndarray) -> np.ndarray | None:
    """Values (F, width) with those never sampled taken from before, at the beginning from after; None without any."""
    known = gap < _NEVER
    if not known.any():
        return None
    at = np.where(known, np.arange(len(known)), -1)
    at = np.maximum.accumulate(at)
    return values[np.where(at < 0, int(np.argmax(known)), at)]
