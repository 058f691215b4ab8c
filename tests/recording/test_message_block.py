"""Records encoded many at once are those that each message's own template gives."""

import numpy as np

from drake_blfdmp.recording.message_block import MessageBlock
from drake_blfdmp.ros2 import mcap_records as mcap
from drake_blfdmp.ros2.cdr import CdrTemplate, CdrWriter


def template(doubles, singles, tail):
    """A stamp, a string that leaves what follows at an odd place, numbers, and bytes behind them."""
    writer = CdrWriter()
    writer.stamp()
    writer.string("abc")
    writer.float64s(doubles)
    writer.float32s(singles)
    for _ in range(tail):
        writer.uint8(7)
    return CdrTemplate(writer)


def test_every_number_of_every_message_at_every_instant():
    """Also where a message ends with a float32, or has none, or no numbers at all."""
    shapes = [(2, 3, 0), (3, 0, 1), (0, 1, 0), (0, 0, 2)]
    messages = [(number, template(*shape)) for number, shape in enumerate(shapes, start=1)]
    block = MessageBlock(messages)
    assert block.count == sum(doubles + singles for doubles, singles, _ in shapes)
    times = np.array([0, 1_250_000_000, 2 * 10**18 + 1])
    values = np.random.default_rng(1).normal(size=(3, block.count))
    for t_ns, numbers, records in zip(times.tolist(), values, block.encode(times, values), strict=True):
        expected, at, offsets = b"", 0, []
        for (channel, one), (doubles, singles, _) in zip(messages, shapes, strict=True):
            own = numbers[at : at + doubles + singles]
            at += len(own)
            offsets.append(len(expected))
            body = one.encode(t_ns, own[:doubles], own[doubles:])
            expected += mcap.pack_record(mcap.MESSAGE, mcap.pack_message_head(channel, t_ns, t_ns), body)
        assert records == expected
        assert block.offsets.tolist() == offsets
