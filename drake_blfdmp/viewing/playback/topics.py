"""Which topics of a file playback reads, when they move, and the frame times that follow from it."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from mcap.records import Channel

from drake_blfdmp.errors import BlfDmpError
from drake_blfdmp.ros2.messages import JOINT_STATE, LOG, STRING, TF, WRENCH
from drake_blfdmp.viewing.playback.chunks import Contents

MOST_FRAMES = 1000
FRAMES_HZ = 30.0
_KNOWN = {
    "robot_description": STRING,
    "joint_states": JOINT_STATE,
    "tf": TF,
    "tf_static": TF,
    "events": LOG,
    "points": JOINT_STATE,
    "margin": JOINT_STATE,
    "link_lengths": JOINT_STATE,
    "bands": JOINT_STATE,
}
"""Last part of a topic's name -> the type it has; any topic of type WrenchStamped is a force."""


def last_part(channel: Channel) -> str:
    """The topic's name without its namespace."""
    return channel.topic.rpartition("/")[2]


def wanted_topics(contents: Contents) -> dict[int, Channel]:
    """The channels that playback reads, of those with messages.

    Raises:
        BlfDmpError: the profile is another one; a topic that playback knows has another type; none is there.
    """
    path = contents.path
    if contents.profile not in ("ros2", ""):
        raise BlfDmpError(
            f"{path}: profile '{contents.profile}' in place of 'ros2'; convert it to ROS 2 messages first"
        )
    topics: dict[int, Channel] = {}
    strange: list[str] = []
    for number in contents.times:
        channel = contents.channels.get(number)
        if channel is None:
            continue
        kind, expected = contents.type_of(channel), _KNOWN.get(last_part(channel))
        if kind in (WRENCH, expected):
            if channel.message_encoding == "cdr":
                topics[number] = channel
            else:
                strange.append(f"{channel.topic} is encoded as '{channel.message_encoding}' in place of 'cdr'")
        elif last_part(channel) in ("robot_description", "joint_states", "tf", "tf_static"):
            strange.append(f"{channel.topic} has the schema '{kind or 'none'}' in place of {expected}")
    found = {last_part(channel) for channel in topics.values()}
    described, points = "robot_description" in found, "points" in found
    if not described and not points:
        there = strange or [f"its topics: {', '.join(sorted(c.topic for c in contents.channels.values())) or 'none'}"]
        raise BlfDmpError(
            f"{path}: nothing to draw, neither /robot_description ({STRING}) nor /points ({JOINT_STATE}); {there[0]}"
        )
    if not points and not found & {"tf", "joint_states"}:
        there = strange or ["record one of them"]
        raise BlfDmpError(f"{path}: no transforms: neither /tf ({TF}) nor /joint_states ({JOINT_STATE}); {there[0]}")
    return topics


def moving_span(contents: Contents, topics: Mapping[int, Channel]) -> tuple[int, int]:
    """First and last time (ns) of what moves.

    Raises:
        BlfDmpError: all of it is at one time.
    """
    moving = [contents.times[n] for n, c in topics.items() if contents.type_of(c) not in (STRING, LOG)]
    moving = [
        contents.times[n]
        for n, c in topics.items()
        if contents.type_of(c) in (JOINT_STATE, TF) and last_part(c) != "tf_static"
    ] or moving
    first, last = min(times.first for times in moving), max(times.last for times in moving)
    if last <= first:
        raise BlfDmpError(
            f"{contents.path}: zero duration, all that moves is at t = {first * 1e-9:.3f} s; there is nothing to play"
        )
    return first, last


def frame_times(path: Path, duration: float, start: float | None, end: float | None) -> np.ndarray:
    """Frame times (F,), s since the first message, at most MOST_FRAMES.

    Raises:
        BlfDmpError: the part asked for is empty, or beyond the file's end.
    """
    begin, stop = 0.0 if start is None else start, duration if end is None else min(end, duration)
    if not (np.isfinite(begin) and begin >= 0.0) or (end is not None and not np.isfinite(end)):
        raise BlfDmpError(f"{path}: --from {start} --to {end}: give seconds from 0 to {duration:.2f}")
    if begin >= duration:
        raise BlfDmpError(f"{path}: --from {begin:g} is not before the file's end at {duration:.2f} s")
    if begin >= stop:
        raise BlfDmpError(f"{path}: --from {begin:g} is not before --to {stop:g}; the part to play is empty")
    count = int(np.clip(round((stop - begin) * FRAMES_HZ) + 1, 2, MOST_FRAMES))
    return np.linspace(begin, stop, count)
