"""JSON of named key points, one object a frame, as pose estimators' scripts write it.

`[{"frame_id": 0, "keypoint_xyz": {"left_shoulder": [x, y, z], ...}}, ...]`, or the list under `frames`, or one object a
line, or one series a joint. The names' object may lie deeper (`bodies` with ids, `joints`, ...), the points may be
lists, objects with x, y, z and a confidence, objects with a `name` in a list, or null. A list of points without names
follows the document's own list of names, or the order of a tracker with so many joints.
"""

import re
from collections.abc import Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from drake_blfdmp.demonstration.formats.documents.json_frames import (
    find_frames,
    frame_numbers,
    frame_times,
    numbered,
    stated_fields,
    stated_names,
)
from drake_blfdmp.demonstration.formats.documents.json_points import is_missing, is_point, one_name_each, read_point
from drake_blfdmp.demonstration.formats.documents.json_text import load_json, looks_like_json
from drake_blfdmp.demonstration.formats.gathered_bodies import GatheredBodies
from drake_blfdmp.demonstration.formats.point_names import guess
from drake_blfdmp.demonstration.formats.recording_format import Joints
from drake_blfdmp.demonstration.formats.sensor_joints import joints_by_number
from drake_blfdmp.demonstration.formats.tables.table_names import plain as plain_name
from drake_blfdmp.demonstration.raw_recording import RawRecording
from drake_blfdmp.demonstration.upright import up_from_heads
from drake_blfdmp.errors import RecordingError
from drake_blfdmp.skeleton import SHOULDERS

_IDS = ("bodyid", "personid", "trackid", "trackingid", "subjectid", "skeletonid", "userid", "playerid", "id", "idx")
_NAMES = ("name", "joint", "jointname", "label", "jointtype", "keypoint", "landmark", "part", "type")
_PREFERRED = re.compile(r"3d|xyz|world")  # Beside pixels or normalised images, say.
_NO_POSITIONS = re.compile(r"2d$|xy$|uv$|pixel|orient|rot|quat|angle|veloc|accel|bbox")
_HEAD = re.compile(r"^(nose|head|headtop|face)$|^(left|right|l|r)?(eye|ear)(left|right|l|r)?$")
_SAMPLES = 200  # Frames that are looked at for the head.
_FARTHEST = 1e7  # In any unit; beyond it a number is no position.
_LEVELS = 5  # Objects around the names within a frame.
_LEAST_POINTS = 6  # Of objects whose names nobody knows, and of lists without names.


plain = lru_cache(maxsize=4096)(plain_name)  # The same few keys come in every frame.


class _Person(NamedTuple):
    id: object
    points: Mapping[str, Any] | Sequence[Any]


class KeypointJson:
    """Reader of frames of named key points; `joints` gives their names, "time" the entry that is the time."""

    name = "keypoint_json"

    def sniff(self, head: bytes) -> bool:
        """Whether the file is JSON: ask it after the readers of other JSON."""
        return looks_like_json(head)

    def read(self, path: Path, joints: Joints | None) -> RawRecording:
        """Reads the file; time and frame number where frames have them.

        Raises:
            RecordingError: no JSON, no frames, no points of such names, a frame without time although others have one,
                or what is no number.
        """
        known = frozenset(name for point, name in (joints or {}).items() if point != "time" and isinstance(name, str))
        frames, about = find_frames(path, load_json(path), lambda node: _series_length(node, known))
        people = [_people(frame, known) for frame in frames]
        names, notes, up = _names(path, people, about)
        chosen = one_name_each(path, names, joints)
        order = {name: index for index, name in enumerate(names)}
        wanted = [order[name] for name in chosen]
        t, time_unit = frame_times(path, frames, joints)
        numbers = frame_numbers(frames)
        gathered = GatheredBodies(str(path))
        for index, seen in enumerate(people):
            for person in seen:
                points = person.points
                values = (
                    [points.get(name) for name in chosen]
                    if isinstance(points, Mapping)
                    else [points[joint] if joint < len(points) else None for joint in wanted]
                )
                x, confidence = [], []
                for name, value in zip(chosen, values, strict=True):
                    try:
                        point, said = read_point(value)
                    except ValueError as error:
                        place = f"{path}: frame {index}: {name[:40]!r}"
                        raise RecordingError(f"{place} {error}; repair or remove it") from None
                    x.append(point)
                    confidence.append(said)
                gathered.add(person.id, int(numbers[index]), None if t is None else t[index], x, confidence)
        above = None if up is not None else _up(people, names, chosen)
        if above is not None:
            notes = (*notes, f"up: {above}, where the head is above the shoulders")
        fields = {"time_unit": time_unit, "up": up or above, **stated_fields(about)}
        return gathered.recording(
            has_clock=t is not None, empty_frames=sum(not seen for seen in people), notes=notes, **fields
        )


def _names(
    path: Path, people: Sequence[list[_Person]], about: Mapping[str, Any]
) -> tuple[list[str], tuple[str, ...], str | None]:
    """All names in the order of their first appearance; where they are not the points' own, a note and what is up."""
    held = [person.points for seen in people for person in seen]
    if not held:
        raise RecordingError(
            f"{path}: no frame holds points of three coordinates; give frames with named points such as left_wrist"
        )
    lists = [points for points in held if not isinstance(points, Mapping)]
    if not lists:
        points_only = (key for points in held for key, entry in points.items() if is_missing(entry) or is_point(entry))
        return list(dict.fromkeys(points_only)), (), None
    if len(lists) < len(held):
        raise RecordingError(f"{path}: some frames name their points, others do not; export the recording again")
    counts = {len(points) for points in lists}
    if len(counts) > 1:
        raise RecordingError(f"{path}: frames hold {min(counts)} to {max(counts)} points without names; name them")
    count = counts.pop()
    stated = stated_names(about, count)
    if stated is not None:
        return stated, ("joints: by the file's own list of names",), None
    known = joints_by_number(range(count))
    if known is None:
        return [*map(str, range(count))], (f"joints: {count} of no known order, as set",), None
    return [*known.names.values()], (f"joints: {count} in the order of the {known.sensor}",), known.up


def _up(people: Sequence[list[_Person]], names: Sequence[str], chosen: Sequence[str]) -> str | None:
    """The axis along which heads lie above shoulders, from some of the frames; None without names of a head."""
    heads = [name for name in names if _HEAD.search(plain(name))]
    held = [person.points for seen in people for person in seen if isinstance(person.points, Mapping)]
    samples = held[:: max(1, len(held) // _SAMPLES)]
    points = np.full((len(samples), len(heads) + 2, 3), np.nan)
    for k, sample in enumerate(samples):
        for j, name in enumerate([*heads, chosen[SHOULDERS[0]], chosen[SHOULDERS[1]]]):
            try:
                x = np.asarray(read_point(sample.get(name))[0], float)
            except ValueError:
                continue  # Said where it matters.
            points[k, j] = np.where((np.abs(x) < _FARTHEST).all() & x.any(), x, np.nan)
    return None if not heads or not samples else up_from_heads(_mean(points[:, :-2]), points[:, -2:].mean(axis=1))


def _mean(points: np.ndarray) -> np.ndarray:
    """(N, 3) the mean of those of (N, K, 3) that are seen."""
    seen = np.isfinite(points).all(axis=-1, keepdims=True)
    count = seen.sum(axis=1)
    return np.where(count > 0, np.where(seen, points, 0.0).sum(axis=1) / np.maximum(count, 1), np.nan)


def _people(node: Any, known: frozenset[str], depth: int = 0) -> list[_Person]:
    """The people in a frame, each with the object or list of its points."""
    if depth > _LEVELS or not node:
        return []
    if isinstance(node, dict):
        if _names_points(node, known):
            return [_Person(_id(node), node)]
        children = [(plain(key), key, entry) for key, entry in node.items() if isinstance(entry, list | dict) and entry]
        if len(children) > 1 and numbered(key for _, key, _ in children):
            return _with_ids([(key, _people(entry, known, depth + 1)) for _, key, entry in children])
        for key, _, entry in sorted(children, key=lambda child: _PREFERRED.search(child[0]) is None):
            found = [] if _NO_POSITIONS.search(key) else _people(entry, known, depth + 1)
            if found:
                own = _id(node)
                return [found[0]._replace(id=own)] if len(found) == 1 and own is not None else found
        return []
    if not isinstance(node, list):
        return []
    named = [_name(entry) for entry in node if isinstance(entry, dict)]
    if named and all(name is not None for name in named) and any(map(is_point, node)):
        return [_Person(None, dict(zip(named, (entry for entry in node if isinstance(entry, dict)), strict=True)))]
    if len(node) >= _LEAST_POINTS and any(map(is_point, node)):
        return [_Person(None, node)]
    return _with_ids([(index, _people(entry, known, depth + 1)) for index, entry in enumerate(node)])


def _with_ids(found: Sequence[tuple[object, list[_Person]]]) -> list[_Person]:
    """The people of several entries; those without an id get their entry's key."""
    return [person if person.id is not None else person._replace(id=key) for key, people in found for person in people]


def _names_points(node: Mapping[str, Any], known: frozenset[str]) -> bool:
    """Whether an object's keys name the joints of one person."""
    entries = [entry for key, entry in node.items() if _is_joint(key) or key in known]
    if entries:
        return any(map(is_point, entries)) or all(map(is_missing, entries))
    return sum(map(is_point, node.values())) >= _LEAST_POINTS


@lru_cache(maxsize=4096)
def _is_joint(key: str) -> bool:
    return bool(guess([key]))


def _id(node: Mapping[str, Any]) -> object:
    by_plain = {plain(key): entry for key, entry in node.items() if not isinstance(entry, dict)}
    for name in _IDS:
        value = by_plain.get(name)
        value = value[0] if isinstance(value, list) and value else value  # OpenPose's [-1].
        if isinstance(value, int | str):
            return value
    return None


def _name(entry: Mapping[str, Any]) -> str | None:
    by_plain = {plain(key): value for key, value in entry.items()}
    name = next((by_plain[key] for key in _NAMES if key in by_plain), None)
    return str(name) if isinstance(name, int | str) else None


def _series_length(node: Mapping[str, Any], known: frozenset[str]) -> int:
    """How many frames an object holds of which each joint is one series of points; 0 where it is no such object."""
    series = [entry for key, entry in node.items() if _is_joint(key) or key in known]
    lengths = {len(entry) for entry in series if isinstance(entry, list)}
    fits = len(lengths) == 1 and all(
        isinstance(entry, list) and all(is_point(p) or is_missing(p) for p in entry) for entry in series
    )
    return lengths.pop() if fits else 0
