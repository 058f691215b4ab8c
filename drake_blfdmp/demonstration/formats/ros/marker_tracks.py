"""visualization_msgs Marker and MarkerArray as tracks: one marker's positions over the messages in which it stands.

Layouts: ROS 1 (a sequence number in each header), ROS 2 to Galactic, ROS 2 from Humble on (textures and mesh files).
Where the bag brings no definition, the layout is the one that a message fits to its last byte.
"""

from collections import Counter
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from drake_blfdmp.demonstration.formats.ros.ros_fields import alike, columns, reader_of, stamps
from drake_blfdmp.demonstration.formats.ros.ros_topics import MARKER_ARRAY, Topic, printable
from drake_blfdmp.ros2.cdr import CdrReader

ARROW, CUBE, SPHERE, CYLINDER, CUBE_LIST, SPHERE_LIST, POINT_LIST, TEXT, MESH = 0, 1, 2, 3, 6, 7, 8, 9, 10
_ONE_POSE = (ARROW, CUBE, SPHERE, CYLINDER, TEXT, MESH)
_LISTS = (CUBE_LIST, SPHERE_LIST, POINT_LIST)
_ADD = 0
_MOST_POINTS = 256  # In a list of points that may be joints.


class MarkerKey(NamedTuple):
    """What tells a marker from the others of a topic.

    `again` counts markers of the same name in one message, `point` the points of a list (-1: the marker's own pose).
    """

    frame: str
    ns: str
    id: int
    type: int
    text: str
    again: int
    point: int


class Track(NamedTuple):
    """One marker: numbers of its messages (n,), stamps (n,) ns, positions (n, 3) m, colours (n, 4) from 0 to 1.

    And its orientations (n, 4), w x y z, of any length.
    """

    message: np.ndarray
    stamp_ns: np.ndarray
    x: np.ndarray
    rgba: np.ndarray
    turn: np.ndarray


class _Marker(NamedTuple):
    """One marker in one message: what it is, and the bytes where its numbers stand."""

    key: MarkerKey
    stamp: int
    pose: int
    rgba: int
    points: int
    count: int


def read_tracks(topic: Topic) -> dict[MarkerKey, Track]:
    """All markers that are shown somewhere; those that are deleted are left out.

    Raises:
        ValueError: a message that is no such message, with its number.
    """
    textured = _is_textured(topic) if topic.cdr else False
    parts: dict[MarkerKey, list[Track]] = {}

    def walk(message: bytes) -> tuple[list[_Marker], list[tuple[int, int]]]:
        reader = reader_of(message, topic.cdr)
        return _walk(reader, topic, textured), reader.structure

    for markers, numbers, raw in alike(topic.messages, walk):
        for marker in markers:
            stamp_ns, rgba = stamps(raw, marker.stamp, topic.cdr), columns(raw, marker.rgba, 4, "<f4")
            pose = columns(raw, marker.pose, 7, "<f8")
            turn = pose[:, [6, 3, 4, 5]]
            if marker.key.type in _ONE_POSE:
                parts.setdefault(marker.key, []).append(Track(numbers, stamp_ns, pose[:, :3], rgba, turn))
                continue
            points = columns(raw, marker.points, 3 * marker.count, "<f8").reshape(len(raw), marker.count, 3)
            for k, x in enumerate(_in_frame(pose, points).transpose(1, 0, 2)):
                parts.setdefault(marker.key._replace(point=k), []).append(Track(numbers, stamp_ns, x, rgba, turn))
    return {key: _joined(tracks) for key, tracks in parts.items()}


def _joined(parts: Sequence[Track]) -> Track:
    if len(parts) == 1:
        return parts[0]
    track = Track(*(np.concatenate(fields) for fields in zip(*parts, strict=True)))
    order = np.argsort(track.message, kind="stable")
    return Track(*(field[order] for field in track))


def _in_frame(pose: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Points (n, k, 3) of markers' own frames in the frame of their header."""
    q = pose[:, 3:].copy()
    with np.errstate(over="ignore", invalid="ignore"):
        norm = np.linalg.norm(q, axis=1)
    q[~((norm > 1e-9) & (norm < 1e9))] = (0.0, 0.0, 0.0, 1.0)  # Left unset by many publishers.
    return np.einsum("nij,nkj->nki", Rotation.from_quat(q).as_matrix(), points) + pose[:, None, :3]


def _is_textured(topic: Topic) -> bool:
    """Whether the messages have the fields that came with Humble."""
    if "mesh_use_embedded_materials" in topic.definition:
        return "texture_resource" in topic.definition
    fullest = max(topic.messages, key=len, default=b"")
    for textured in (True, False):
        try:
            _walk(CdrReader(fullest), topic, textured)
        except ValueError:
            continue
        return textured
    return True


def _walk(reader: CdrReader, topic: Topic, textured: bool) -> list[_Marker]:
    seen: Counter[MarkerKey] = Counter()
    markers: list[_Marker] = []
    for _ in range(reader.uint32() if topic.type == MARKER_ARRAY else 1):
        marker = _walk_marker(reader, topic.cdr, textured, seen)
        if marker is not None:
            markers.append(marker)
    if reader.left > (7 if topic.cdr else 0):  # Some middleware pads a message's end.
        raise ValueError(f"{reader.left} bytes more than a {topic.type}")
    return markers


def _walk_marker(reader: CdrReader, cdr: bool, textured: bool, seen: Counter[MarkerKey]) -> _Marker | None:
    stamp, frame = _walk_header(reader, cdr)
    ns = reader.string()
    number, kind, action = reader.int32(), reader.int32(), reader.int32()
    pose = reader.place(7, 8)
    reader.place(3, 8)  # scale
    rgba = reader.place(4, 4)
    reader.place(2, 4)  # lifetime
    reader.place(1, 1)  # frame_locked
    count = reader.uint32()
    points = reader.place(3 * count, 8)
    reader.place(4 * reader.uint32(), 4)  # colors
    if textured:
        reader.string()
        _walk_header(reader, cdr)
        reader.string()
        reader.place(reader.uint32(), 1)
        reader.place(2 * reader.uint32(), 4)  # uv_coordinates
    text = reader.string()
    reader.string()  # mesh_resource
    if textured:
        reader.string()
        reader.place(reader.uint32(), 1)
    reader.place(1, 1)  # mesh_use_embedded_materials
    if action != _ADD or not (kind in _ONE_POSE or (kind in _LISTS and count <= _MOST_POINTS)):
        return None
    key = MarkerKey(printable(frame), printable(ns), number, kind, printable(text), 0, -1)
    seen[key] += 1
    return _Marker(key._replace(again=seen[key] - 1), stamp, pose, rgba, points, count)


def _walk_header(reader: CdrReader, cdr: bool) -> tuple[int, str]:
    """Where the stamp stands, and the frame."""
    if not cdr:
        reader.place(1, 4)  # seq
    return reader.place(2, 4), reader.string().removeprefix("/")
