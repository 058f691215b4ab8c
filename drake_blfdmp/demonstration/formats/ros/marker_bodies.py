"""Which markers are whose joints: told by texts or namespaces, or by numbers in the order of a sensor's joints."""

from collections.abc import Callable, Iterable, Mapping
from typing import NamedTuple

import numpy as np

from drake_blfdmp.demonstration.formats.point_names import guess, resolve
from drake_blfdmp.demonstration.formats.recording_format import Joints
from drake_blfdmp.demonstration.formats.ros.body_names import named_bodies, named_point
from drake_blfdmp.demonstration.formats.ros.marker_tracks import TEXT, MarkerKey, Track
from drake_blfdmp.demonstration.formats.sensor_joints import AZURE_KINECT, KINECT_V1, KINECT_V2, MEDIAPIPE_POSE
from drake_blfdmp.errors import RecordingError
from drake_blfdmp.skeleton import POINTS

_SENSORS = {
    "Azure Kinect": AZURE_KINECT,
    "Kinect v2": KINECT_V2,
    "Kinect v1": KINECT_V1,
    "MediaPipe": MEDIAPIPE_POSE,
}
_STRIDE = 100  # Marker id = body * stride + joint; some publishers take the number of joints instead.

Tracks = Mapping[MarkerKey, Track]
Markers = dict[str, dict[str, list[MarkerKey]]]
"""Body -> point -> the markers that are this point, one after another."""


class Sorted(NamedTuple):
    """Whose joints the markers are, which sensor numbers them so (empty where names told), and how that was found."""

    bodies: Markers
    sensor: str
    note: str


def sort_markers(where: str, tracks: Tracks, joints: Joints | None) -> Sorted:
    """Sort a topic's markers by person and point.

    Args:
        where: file and topic, for messages.
        tracks: all markers of the topic.
        joints: the user's names of the points: texts, namespaces, a sensor's joints, or marker numbers.

    Raises:
        RecordingError: no six markers are one person's arms, or `joints` names what there is not.
    """
    shapes = {key: track for key, track in tracks.items() if key.type != TEXT and key.point < 0}
    texts = {key: track for key, track in tracks.items() if key.type == TEXT}
    lists = {key: track for key, track in tracks.items() if key.point >= 0}
    wanted = {point: name for point, name in (joints or {}).items() if point != "time"}
    for point, name in wanted.items():
        if not isinstance(name, str):
            raise RecordingError(f"{where}: a marker has one name for its three axes; give {point} one name")
    for what, some, label in (
        ("texts", shapes, lambda key: key.text),
        ("namespaces", shapes, lambda key: key.ns),
        ("texts", texts, lambda key: key.text),
    ):
        bodies = _by_label(where, {key: track for key, track in some.items() if label(key)}, label, wanted)
        if bodies:
            return Sorted(bodies, "", f"joints: named by the markers' {what}")
    for some, stride, what in (
        (lists, None, "order in the markers' points"),
        (shapes, _STRIDE, f"marker id (person * {_STRIDE} + joint)"),
        (shapes, 0, "marker id (person * number of joints + joint)"),
    ):
        found = _by_sensor(where, some, stride, wanted)
        if found is not None:
            return Sorted(*found, f"joints: {len(_SENSORS[found[1]])} of {found[1]} by {what}")
    bodies = _by_label(where, shapes, lambda key: str(key.id % _STRIDE), wanted)
    if bodies and wanted:
        return Sorted(bodies, "", "joints: by marker number, as set")
    names = sorted({key.text or key.ns or str(key.id) for key in (shapes or tracks)})
    resolve(where, names, joints)  # Raises what is missing.
    raise RecordingError(
        f"{where}: no six markers of one person belong together; give joints the markers' texts, namespaces or numbers"
    )


def _by_label(where: str, tracks: Tracks, label: Callable[[MarkerKey], str], wanted: Mapping) -> Markers:
    """The bodies whose six markers bear names; none where they do not."""
    by_name: dict[str, list[MarkerKey]] = {}
    for key in tracks:
        by_name.setdefault(label(key), []).append(key)
    if wanted:
        named = {name.lower() for name in by_name}
        if not all(isinstance(name, str) and name.lower() in named for name in wanted.values()):
            return {}
        if len(wanted) < len(POINTS) and not {*guess(by_name), *wanted} >= set(POINTS):
            return {}
        chosen = {"": {point: str(name) for point, name in resolve(where, list(by_name), wanted).items()}}
    else:
        chosen = named_bodies(by_name)
    bodies: Markers = {}
    for rest, points in chosen.items():
        bodies.update(_persons(rest, {point: by_name[name] for point, name in points.items()}, tracks))
    return bodies


def _persons(rest: str, points: dict[str, list[MarkerKey]], tracks: Tracks) -> Markers:
    """Several persons whose joints have the same names: told apart by the marker id, or else by order."""
    shared = set.intersection(*({key.id for key in keys} for keys in points.values()))
    alone = not shared and all(_never_together(tracks[key] for key in keys) for keys in points.values())
    by_person: Markers = {}
    for point, keys in points.items():
        rank = {number: k for k, number in enumerate(sorted({key.id for key in keys}))}
        for key in keys:
            # An id that all joints share is the person's; else ids count the markers, person after person, or
            # message after message, where no message has two of a name.
            person = key.id if shared else 0 if alone else rank[key.id]
            several = len(shared) > 1 if shared else len(rank) > 1 and not alone
            words = [rest, str(person) if several else "", _again(key)]
            by_person.setdefault(_joined(words), {}).setdefault(point, []).append(key)
    return _whole(by_person)


def _never_together(tracks: Iterable[Track]) -> bool:
    messages = np.concatenate([track.message for track in tracks])
    return len(np.unique(messages)) == len(messages)


def _by_sensor(where: str, tracks: Tracks, stride: int | None, wanted: Mapping) -> tuple[Markers, str] | None:
    """The bodies whose joints are numbered as a sensor does, and which; of all namespaces together, or else of each.

    Args:
        where: file and topic, for messages.
        tracks: the markers.
        stride: the marker's id is body * stride + joint; 0 takes the sensor's number of joints, None the order in a
            list of points, whose id is the body's.
        wanted: the user's joints.
    """
    by_space: dict[str, list[MarkerKey]] = {}
    for key in tracks:
        by_space.setdefault(key.ns, []).append(key)
    for spaces in ([list(tracks)], list(by_space.values()) if len(by_space) > 1 else []):
        bodies: Markers = {}
        sensor = ""
        for keys in spaces:
            found = _numbered(keys, stride)
            if found is None:
                continue
            sensor, numbers = found
            chosen = resolve(where, _SENSORS[sensor], wanted)
            point_of = {_SENSORS[sensor].index(str(name)): point for point, name in chosen.items()}
            for key, (body, joint) in zip(keys, numbers, strict=True):
                if joint in point_of:
                    name = _joined([key.ns if len(by_space) > 1 else "", str(body), _again(key)])
                    bodies.setdefault(name, {}).setdefault(point_of[joint], []).append(key)
        if _whole(bodies):
            return _whole(bodies), sensor
    return None


def _numbered(keys: list[MarkerKey], stride: int | None) -> tuple[str, list[tuple[int, int]]] | None:
    """The sensor, and (body, joint) of each marker.

    Every joint must occur somewhere in the file, and no other number: fewer would be another sensor's, or a guess.
    """
    for sensor, names in _SENSORS.items():
        count = len(names)
        if stride is None:
            numbers = [(key.id, key.point) for key in keys]
        else:
            numbers = [divmod(key.id, stride or count) for key in keys]
        if {joint for _, joint in numbers} != set(range(count)):
            continue
        # Numbers in a row fit several counts: only the right one makes whole bodies.
        if stride != 0 or len(set(numbers)) == count * len({body for body, _ in numbers}):
            return sensor, numbers
    return None


def _again(key: MarkerKey) -> str:
    return f"({key.again + 1})" if key.again else ""


def _joined(words: Iterable[str]) -> str:
    return " ".join(word for word in words if word) or "0"


def _whole(bodies: Markers) -> Markers:
    return {name: points for name, points in bodies.items() if len(points) == len(POINTS)}


def label_of(key: MarkerKey) -> str:
    """What names a marker, for notes."""
    return next((text for text in (key.text, key.ns) if named_point(text)), "")
