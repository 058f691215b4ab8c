"""BVH, the motion files of animation: a skeleton of joints and its angles, frame by frame.

Positions follow by forward kinematics: a joint's frame is its parent's, moved by its offset and turned by its rotation
channels in the file's order, R = R_first R_second R_third, degrees. The format states no unit and no axis: the arms
tell the one, the line from the root to the shoulders the other.

Format: Meredith, Maddock, "Motion capture file formats explained", University of Sheffield 2001.
"""

import re
from collections.abc import Sequence, Set
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from drake_blfdmp.demonstration.bones import FOREARMS, PLAUSIBLE_BONE, UPPER_ARMS, link_lengths
from drake_blfdmp.demonstration.formats.bone_names import guess_bones
from drake_blfdmp.demonstration.formats.mocap.bvh_hierarchy import Joint, ancestors, channel_names, parse_hierarchy
from drake_blfdmp.demonstration.formats.point_names import resolve
from drake_blfdmp.demonstration.formats.recording_format import Joints
from drake_blfdmp.demonstration.formats.tables.dialect import find_dialect
from drake_blfdmp.demonstration.formats.tables.tables import read_columns
from drake_blfdmp.demonstration.formats.text import head_lines, numbered_lines
from drake_blfdmp.demonstration.length_unit import METRES
from drake_blfdmp.demonstration.raw_recording import Body, RawRecording
from drake_blfdmp.errors import RecordingError
from drake_blfdmp.skeleton import POINTS, SHOULDERS, WRISTS

_HEADER_LINES = 50_000
_CMU = 0.0254 / 0.45  # m, the unit of the CMU set, whose bones no metric unit fits.
_FRAME_TIMES = (1e-5, 10.0)  # s; others are no frame time.
_UPRIGHT = 0.8  # Cosine between an axis and the trunk above which it is up.
_LARGEST = 1e9  # Of any channel; beyond it an angle is no angle.
_BLOCK = 20_000  # Frames at once, which bounds the memory.


class _Header(NamedTuple):
    joints: list[Joint]
    promised: int | None
    rate_hz: float | None
    first_line: int
    first_row: str


class Bvh:
    """Reader of BVH files; `joints` names joints."""

    name = "bvh"

    def sniff(self, head: bytes) -> bool:
        """Whether the first word is HIERARCHY."""
        lines = head_lines(head)
        return bool(lines) and lines[0].split()[0].upper() == "HIERARCHY"

    def read(self, path: Path, joints: Joints | None) -> RawRecording:
        """Reads the file; frames are counted from 0 at its frame time.

        Raises:
            RecordingError: a damaged hierarchy, a joint that is not there, a row of another number of columns, a cell
                that is no number, or no frames.
        """
        header = _read_header(path)
        chosen = _people(path, header.joints, joints)
        chains = {index: ancestors(header.joints, index) for person in chosen.values() for index in person}
        moving = sorted({index for chain in chains.values() for index in chain})
        wanted = [
            column
            for index in moving
            for column in range(
                header.joints[index].column, header.joints[index].column + len(header.joints[index].channels)
            )
        ]
        names = channel_names(header.joints)
        table = read_columns(
            path,
            find_dialect(header.first_row, len(names)),
            len(names),
            wanted,
            first_line=header.first_line,
            names=names,
        )
        frames = np.arange(len(table.lines))
        wrists = {person[k] for person in chosen.values() for k in WRISTS}
        positions, turns = _forward_kinematics(header.joints, moving, table.numbers, len(frames), wrists)
        notes = []
        if header.promised is not None and header.promised != len(frames):
            notes.append(f"the header promises {header.promised} frames, the file holds {len(frames)}")
        bodies, ups = {}, []
        for person, indices in chosen.items():
            x = np.stack([positions[index] for index in indices], axis=1)
            ups.append(_up(x, positions[chains[indices[0]][0]]))
            if _is_cmu(x):
                x = x * _CMU
                notes.append("unit: lengths in 1/0.45 inch, as in the CMU set; they are given in m here")
            bodies[person] = Body(x, frames, orientations=np.stack([turns[indices[k]] for k in WRISTS], axis=1))
        return RawRecording(bodies, clock_hz=header.rate_hz, up=ups[0], notes=tuple(dict.fromkeys(notes)))


def _read_header(path: Path) -> _Header:
    """Everything above the first row of numbers."""
    joints: list[Joint] = []
    hierarchy: list[tuple[int, str]] = []
    promised = rate_hz = None
    first_line = 0
    for number, line in numbered_lines(path):
        words = line.split()
        if not joints:
            if words[0].upper() == "MOTION":
                joints = parse_hierarchy(str(path), hierarchy)
                if not joints:
                    raise RecordingError(f"{path}: a BVH hierarchy without joints; export it again")
            hierarchy.append((number, line if hierarchy else re.sub(r"^\s*HIERARCHY", "", line, flags=re.I)))
            if number > _HEADER_LINES:
                break
            continue
        frames = re.match(r"\s*Frames\s*:?\s*(\d{1,15})\s*$", line, re.I)
        time = re.match(r"\s*Frame\s*Time\s*:?\s*(\S+)\s*$", line, re.I)
        if frames:
            promised = int(frames[1])
        elif time:
            rate_hz = _rate(time[1])
        else:
            return _Header(joints, promised, rate_hz, number, line)
        first_line = number + 1
    if not joints:
        raise RecordingError(f"{path}: a BVH without MOTION section; the file is cut off, export it again")
    return _Header(joints, promised, rate_hz, first_line, "")


def _rate(frame_time: str) -> float | None:
    try:
        seconds = float(frame_time.replace(",", "."))
    except ValueError:
        return None
    return 1.0 / seconds if _FRAME_TIMES[0] < seconds < _FRAME_TIMES[1] else None


def _people(path: Path, skeleton: Sequence[Joint], joints: Joints | None) -> dict[str, list[int]]:
    """Person -> the indices of the joints at the six points; one person a root."""
    root_of: list[int] = []
    roots: dict[int, list[int]] = {}
    for index, joint in enumerate(skeleton):
        root_of.append(index if joint.parent < 0 else root_of[joint.parent])
        roots.setdefault(root_of[index], []).append(index)
    whole = {
        skeleton[root].name if len({skeleton[r].name for r in roots}) == len(roots) else str(root): members
        for root, members in roots.items()
        if len(guess_bones(skeleton[index].name for index in members)) == len(POINTS)
    }
    if joints or not whole:
        whole = {"0": list(range(len(skeleton)))}
    chosen: dict[str, list[int]] = {}
    for person, members in whole.items():
        names = [skeleton[index].name for index in members]
        resolved = resolve(str(path), names, {**guess_bones(names), **(joints or {})})
        if not all(isinstance(name, str) for name in resolved.values()):
            raise RecordingError(f"{path}: a BVH joint has one name; give each point one name")
        chosen[person] = [members[names.index(str(resolved[point]))] for point in POINTS]
    return chosen


def _forward_kinematics(
    skeleton: Sequence[Joint],
    moving: Sequence[int],
    channels: dict[int, np.ndarray],
    count: int,
    wanted: Set[int],
) -> tuple[dict[int, np.ndarray], dict[int, np.ndarray]]:
    """Joint -> (N, 3) its origin in the world, in the file's unit, for `moving` joints (parents before children).

    And joint -> (N, 4) its orientation there, w x y z, NaN where missing, for the `wanted` ones among them.
    """
    turns = {index: np.empty((count, 4)) for index in wanted}
    positions = {index: np.empty((count, 3)) for index in moving}
    replaces = {index: _replaces_offset(skeleton[index], channels) for index in moving}
    with np.errstate(all="ignore"):  # Absurd numbers become infinite, and are missing then.
        for first in range(0, count, _BLOCK):
            block = slice(first, min(first + _BLOCK, count))
            turned: dict[int, tuple[Rotation, np.ndarray]] = {}
            for index in moving:
                joint = skeleton[index]
                length = block.stop - block.start
                local = np.broadcast_to(joint.offset, (length, 3)).copy()
                lost = np.zeros(length, dtype=bool)
                axes, angles = "", []
                for column, (axis, is_rotation) in enumerate(joint.channels, joint.column):
                    values = channels[column][block]
                    missing = ~(np.abs(values) < _LARGEST)
                    if is_rotation:
                        axes += "XYZ"[axis]
                        angles.append(np.where(missing, 0.0, values))  # Rotation takes no NaN.
                        lost |= missing
                    else:
                        values = np.where(missing, np.nan, values)
                        local[:, axis] = values if replaces[index] else local[:, axis] + values
                turn = _turn(axes, angles, length)
                if joint.parent >= 0:
                    before, lost_before = turned[joint.parent]
                    local = positions[joint.parent][block] + before.apply(local)
                    local[lost_before] = np.nan
                    turn = before * turn
                    lost |= lost_before
                positions[index][block] = local
                turned[index] = turn, lost
                if index in turns:
                    q = np.roll(turn.as_quat(), 1, axis=-1)
                    q[lost] = np.nan
                    turns[index][block] = q
    return positions, turns


def _turn(axes: str, angles: Sequence[np.ndarray], count: int) -> Rotation:
    """(N) R = R_first R_second ... about the axes in turn, from (N,) angles, degrees."""
    if 1 <= len(axes) <= 3 and all(a != b for a, b in pairwise(axes)):
        return Rotation.from_euler(axes, np.stack(angles, axis=-1), degrees=True)  # Capitals: each about the new axes.
    turn = Rotation.identity(count)
    for axis, angle in zip(axes, angles, strict=True):
        turn = turn * Rotation.from_euler(axis, angle[:, None], degrees=True)
    return turn


def _replaces_offset(joint: Joint, channels: dict[int, np.ndarray]) -> bool:
    """Whether position channels stand in the offset's place, as most exporters mean it, or are added to it.

    Of a root it does not matter. Of others, values in the offset's place are about as long as the offset.
    """
    columns = [(column, axis) for column, (axis, turns) in enumerate(joint.channels, joint.column) if not turns]
    if joint.parent < 0 or not columns:
        return True
    with np.errstate(all="ignore"):
        moved = np.linalg.norm(np.stack([channels[column] for column, _ in columns], axis=-1), axis=-1)
    longer = moved[np.isfinite(moved)] >= np.linalg.norm(joint.offset[[axis for _, axis in columns]]) / 2.0
    return bool(longer.sum() >= len(longer) / 2.0)


def _up(x: np.ndarray, root: np.ndarray) -> str:
    """The axis along which the shoulders stand above the root; y, BVH's usual one, where none is clear."""
    with np.errstate(all="ignore"):
        trunk = x[:, SHOULDERS].mean(axis=1) - root
        trunk = trunk / np.linalg.norm(trunk, axis=-1, keepdims=True)
    trunk = trunk[np.isfinite(trunk).all(axis=-1)]
    mean = trunk.mean(axis=0) if len(trunk) else np.zeros(3)
    axis = int(np.argmax(np.abs(mean)))
    return ("-" if mean[axis] < 0.0 else "") + "xyz"[axis] if abs(mean[axis]) > _UPRIGHT else "y"


def _is_cmu(x: np.ndarray) -> bool:
    """Whether the arms are plausible in the CMU set's unit, and in no metric one."""
    with np.errstate(all="ignore"):
        lengths = link_lengths(x)
    lengths = lengths[np.isfinite(lengths).all(axis=-1)]
    if len(lengths) == 0:
        return False
    arms = np.median(lengths, axis=0)[[*UPPER_ARMS, *FOREARMS]]
    fits = [bool(np.all((arms * u >= PLAUSIBLE_BONE[0]) & (arms * u <= PLAUSIBLE_BONE[1]))) for u in METRES.values()]
    return not any(fits) and bool(np.all((arms * _CMU >= PLAUSIBLE_BONE[0]) & (arms * _CMU <= PLAUSIBLE_BONE[1])))
