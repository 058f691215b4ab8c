"""MCAP files of another writer, and what reading them takes."""

import numpy as np
from mcap.writer import CompressionType, Writer

from drake_blfdmp.ros2.messages import DEFINITIONS, JOINT_STATE, joint_state_template

# MB at most so far. What a process is started from counts in ru_maxrss as well, so that is no measure of it.
PEAK = "peak = int(open('/proc/self/status').read().split('VmHWM:')[1].split()[0]) // 1024"


def write_foreign(path, messages, *, profile="ros2", compression=CompressionType.LZ4, use_chunking=True):
    """A file of another writer: messages are (time in ns, bytes) on /joint_states."""
    writer = Writer(str(path), compression=compression, use_chunking=use_chunking, chunk_size=2000)
    writer.start(profile=profile, library="another")
    schema = writer.register_schema(JOINT_STATE, "ros2msg", DEFINITIONS[JOINT_STATE].encode())
    channel = writer.register_channel("/joint_states", "cdr", schema)
    for t, data in messages:
        writer.add_message(channel, log_time=t, data=data, publish_time=t)
    writer.finish()


def joints(t, names=("a", "b"), **fields):
    template = joint_state_template(names, **fields)
    return template.encode(t, t + np.arange(template.float64_count, dtype=float))
