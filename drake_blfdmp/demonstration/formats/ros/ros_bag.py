"""From the messages of a bag to the people in it, whatever the bag's container."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from drake_blfdmp.demonstration.formats.point_names import listed
from drake_blfdmp.demonstration.formats.recording_format import Joints
from drake_blfdmp.demonstration.formats.ros.joint_vectors import has_points, names_of, read_joint_vectors
from drake_blfdmp.demonstration.formats.ros.marker_arrays import read_markers
from drake_blfdmp.demonstration.formats.ros.ros_topics import JOINT_STATE, MARKER, MARKER_ARRAY, TF, Bag, Topic
from drake_blfdmp.demonstration.formats.ros.transforms import read_transforms
from drake_blfdmp.demonstration.raw_recording import RawRecording
from drake_blfdmp.errors import RecordingError

OWN_METADATA = "recording"  # The metadata record of files that `mcap_writer` made.
SKELETON_TOPIC = "/skeleton"

_AXES = tuple(sign + axis for sign in ("", "-") for axis in "xyz")


def read_bag(bag: Bag, joints: Joints | None) -> RawRecording:
    """The people on the topics of the first kind that holds any: marker arrays, markers, transforms, named numbers.

    Raises:
        RecordingError: no topic may hold a person, or none does; then what stands against the first.
    """
    with_messages = [topic for topic in bag.topics.values() if topic.messages]
    if "run" in bag.metadata:  # Its markers show /points again, and fewer of them.
        with_messages = [topic for topic in with_messages if topic.name != SKELETON_TOPIC]
    refusal: RecordingError | None = None
    for kind in (MARKER_ARRAY, MARKER, TF, JOINT_STATE):
        topics = [topic for topic in with_messages if topic.type == kind]
        if kind == JOINT_STATE:
            topics = [topic for topic in topics if has_points(names_of(topic.messages[0], topic.cdr))]
        found: dict[str, RawRecording] = {}
        for group in [topics] if kind == TF and topics else [[topic] for topic in topics]:
            try:
                found[group[0].name] = _read(bag, group, joints)
            except RecordingError as error:
                refusal = refusal or error
        if found:
            return _together(found)
    if refusal is not None:
        raise refusal
    rest = {**bag.others, **{topic.name: topic.type for topic in bag.topics.values()}}
    raise RecordingError(
        f"{bag.path}: holds no {MARKER_ARRAY}, {MARKER} or {TF} messages of a person; "
        f"it has {listed([f'{name} ({kind})' for name, kind in rest.items()]) if rest else 'no topics'}"
    )


def _read(bag: Bag, group: list[Topic], joints: Joints | None) -> RawRecording:
    topic = group[0]
    where = f"{bag.path}: {topic.name}"
    if topic.type == TF:
        return read_transforms(str(bag.path), group, joints)
    if topic.type == JOINT_STATE:
        raw = read_joint_vectors(where, topic, joints)
        run = bag.metadata.get("run")
        # Runs of this package: in the person's torso frame.
        return raw if run is None else replace(raw, up="z", synthetic=_synthetic(run))
    own = bag.metadata.get(OWN_METADATA, {}) if topic.name == SKELETON_TOPIC else {}
    raw = read_markers(where, topic, joints, alpha_is_confidence=own.get("confidence") == "alpha")
    if not own:
        return raw
    numbers = np.array(topic.sequence)
    bodies = {name: replace(body, frames=numbers[body.frames]) for name, body in raw.bodies.items()}
    up = own.get("up") if own.get("up") in _AXES else raw.up
    return replace(raw, bodies=bodies, up=up, synthetic=_synthetic(own))


def _synthetic(metadata: Mapping[str, str]) -> bool:
    return metadata.get("synthetic") == "True"


def _together(found: dict[str, RawRecording]) -> RawRecording:
    """One recording of the people on several topics, each named after its topic."""
    if len(found) == 1:
        return next(iter(found.values()))
    ups = {raw.up for raw in found.values()}
    notes = dict.fromkeys(note for raw in found.values() for note in raw.notes)
    return RawRecording(
        {f"{topic} {name}": body for topic, raw in found.items() for name, body in raw.bodies.items()},
        unit="m",
        time_unit="s",
        up=ups.pop() if len(ups) == 1 else None,
        notes=tuple(notes),
    )
