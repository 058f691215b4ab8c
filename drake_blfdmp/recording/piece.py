"""Pieces of a chunk in progress: records that are written together, and where the messages in them are."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from drake_blfdmp.recording.mcap_chunk import Places
from drake_blfdmp.recording.message_block import MessageBlock


class Piece(NamedTuple):
    """Records that come one after the other in a file.

    Attributes:
        records: the bytes.
        t_ns: simulated time of the messages, ns.
        block: where in the bytes the messages are; None where there are none.
    """

    records: bytes
    t_ns: int
    block: MessageBlock | None


def places_of_pieces(pieces: Sequence[Piece]) -> Iterator[Places]:
    """Where the messages of a chunk's pieces are, block by block: a chunk has many pieces of few kinds."""
    kinds: dict[MessageBlock, list[tuple[int, int]]] = {}
    at = 0
    for records, t_ns, block in pieces:
        if block is not None:
            kinds.setdefault(block, []).append((at, t_ns))
        at += len(records)
    for block, some in kinds.items():
        begins, times = np.array(some, dtype=np.uint64).T[:, :, None]
        shape = (len(some), len(block.channels))
        yield Places(np.broadcast_to(block.channels, shape), np.broadcast_to(times, shape), begins + block.offsets)
