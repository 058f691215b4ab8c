"""The HIERARCHY of a BVH file: joints, their parents, offsets, and the channels that move them."""

import re
from bisect import bisect_right
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from drake_blfdmp.errors import RecordingError

_ITEM = re.compile(
    r"""(?:
    (?:ROOT|JOINT)[ \t]+(?P<name>[^\n{}]{1,300}?)\s*\{
    |(?P<end>End[ \t]*Site)[^\n{}]{0,300}\s*\{
    |OFFSET\s+(?P<offset>\S+\s+\S+\s+\S+)
    |CHANNELS\s+(?P<count>\d{1,3})(?P<channels>(?:\s+[XYZ](?:position|rotation))*)
    |(?P<close>\})
    )""",
    re.I | re.X,
)
_NOT_BLANK = re.compile(r"\S")
_MAX_JOINTS, _MAX_DEPTH = 5000, 100


class Joint(NamedTuple):
    """One joint.

    Attributes:
        name: may hold blanks.
        parent: index of its parent, always smaller than its own; -1 for a root.
        offset: (3,) from the parent, in the parent's frame.
        channels: axis 0 to 2, and whether it is a rotation, in the file's order.
        column: of its first channel.
    """

    name: str
    parent: int
    offset: np.ndarray
    channels: tuple[tuple[int, bool], ...]
    column: int


def parse_hierarchy(where: str, lines: Sequence[tuple[int, str]]) -> list[Joint]:
    """The joints in the file's order.

    Args:
        where: the file, for messages.
        lines: (number, text) of the lines between HIERARCHY and MOTION.

    Raises:
        RecordingError: what is no part of a hierarchy, braces that do not match, or joints without offset.
    """
    text = "\n".join(line for _, line in lines).rstrip()
    starts = np.cumsum([0, *(len(line) + 1 for _, line in lines)])
    names: list[str] = []
    parents: list[int] = []
    offsets: list[np.ndarray | None] = []
    channels: list[tuple[tuple[int, bool], ...]] = []
    open_joints: list[int] = []  # -1 for an end site.
    position = 0
    while (following := _NOT_BLANK.search(text, position)) is not None:
        position = following.start()
        line = lines[bisect_right(starts, position) - 1][0]
        item = _ITEM.match(text, position)
        if item is None:
            raise RecordingError(f"{where}: line {line} is no part of a BVH hierarchy; export it again")
        position = item.end()
        inside = open_joints[-1] if open_joints else None
        if item["name"] is not None:
            if inside == -1 or len(names) == _MAX_JOINTS or len(open_joints) == _MAX_DEPTH:
                raise RecordingError(
                    f"{where}: line {line}: a joint in an end site, or more than {_MAX_JOINTS} joints or "
                    f"{_MAX_DEPTH} in a row; export one person's skeleton"
                )
            open_joints.append(len(names))
            parents.append(-1 if inside is None else inside)
            names.append("".join(filter(str.isprintable, item["name"])))
            offsets.append(None)
            channels.append(())
        elif item["end"]:
            open_joints.append(-1)
        elif inside is None:
            raise RecordingError(f"{where}: line {line} belongs to no joint; export it again")
        elif item["close"]:
            open_joints.pop()
        elif inside >= 0 and item["offset"]:
            offsets[inside] = _offset(where, line, item["offset"])
        elif inside >= 0 and item["count"]:
            words = item["channels"].lower().split()
            if len(words) != int(item["count"]) or channels[inside]:
                raise RecordingError(
                    f"{where}: line {line}: {item['count']} channels, but {len(words)} names; repair it"
                )
            channels[inside] = tuple(("xyz".index(word[0]), word.endswith("rotation")) for word in words)
    if open_joints:
        raise RecordingError(
            f"{where}: the BVH hierarchy is cut off or lacks {len(open_joints)} braces; export it again"
        )
    columns = np.cumsum([0, *map(len, channels)])
    joints = []
    for index, offset in enumerate(offsets):
        if offset is None:
            raise RecordingError(f"{where}: joint {names[index]:.60} has no OFFSET; export it again")
        joints.append(Joint(names[index], parents[index], offset, channels[index], int(columns[index])))
    return joints


def channel_names(joints: Sequence[Joint]) -> list[str]:
    """One name a column, such as `Hips Zrotation`, for messages."""
    return [
        f"{joint.name} {'XYZ'[axis]}{'rotation' if turns else 'position'}"
        for joint in joints
        for axis, turns in joint.channels
    ]


def ancestors(joints: Sequence[Joint], index: int) -> list[int]:
    """The joint's indices from its root down to itself."""
    chain = [index]
    while joints[chain[-1]].parent >= 0:
        chain.append(joints[chain[-1]].parent)
    return chain[::-1]


def _offset(where: str, line: int, text: str) -> np.ndarray:
    try:
        offset = np.array([float(word.replace(",", ".")) for word in text.split()])
    except ValueError:
        offset = np.full(3, np.nan)
    if not np.isfinite(offset).all():
        raise RecordingError(f"{where}: line {line}: an OFFSET that is no three numbers; repair it")
    return offset
