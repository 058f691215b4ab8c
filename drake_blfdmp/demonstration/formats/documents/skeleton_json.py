"""JSON arrays of unnamed joints, frames x joints x (x, y, z), in a sensor's order, as in re-packs of NW-UCLA.

`{"file_name": ..., "skeletons": [frame][joint][x, y, z]}` or the array alone; 20 joints are a Kinect v1's, 25 a Kinect
v2's, 32 an Azure Kinect's, and their frames come 30 a second. An empty frame holds nobody; a fourth number is a
confidence; an array of one more dimension, [frame][body][joint], holds several people.

Source of the set: Wang, Nie, Xia, Wu, Zhu, "Cross-view action modeling, learning and recognition", CVPR 2014.
"""

import re
from pathlib import Path
from typing import Any

from drake_blfdmp.demonstration.formats.documents.json_frames import find_frames, stated_fields, stated_names
from drake_blfdmp.demonstration.formats.documents.json_points import is_missing, one_name_each, read_point
from drake_blfdmp.demonstration.formats.documents.json_text import load_json, looks_like_json
from drake_blfdmp.demonstration.formats.gathered_bodies import GatheredBodies
from drake_blfdmp.demonstration.formats.recording_format import Joints
from drake_blfdmp.demonstration.formats.sensor_joints import joints_by_number
from drake_blfdmp.demonstration.raw_recording import RawRecording
from drake_blfdmp.errors import RecordingError

CLOCK_HZ = 30.0
_ARRAYS = re.compile(rb"\[\s*(?:(?:\[\s*\]|null)\s*,\s*)*\[\s*(?:\[\s*)?\[\s*[-\dNn]")


class SkeletonJson:
    """Reader of arrays of unnamed joints; `joints` names a sensor's joints, or their numbers from 0."""

    name = "skeleton_json"

    def sniff(self, head: bytes) -> bool:
        """Whether JSON begins with arrays in arrays in an array, or calls an array `skeletons`."""
        return looks_like_json(head) and (
            _ARRAYS.search(head) is not None or re.search(rb'"skeletons"\s*:\s*\[\s*(?:\[|null|\])', head) is not None
        )

    def read(self, path: Path, joints: Joints | None) -> RawRecording:
        """Reads the file; frames are counted from 0.

        Raises:
            RecordingError: no JSON, no such array, frames of different numbers of joints, or what is no number.
        """
        frames, about = find_frames(path, load_json(path), lambda _: 0)
        count = _joint_count(path, frames)
        known = joints_by_number(range(count))
        names = stated_names(about, count) or [*(known.names.values() if known else map(str, range(count)))]
        wanted = [names.index(name) for name in one_name_each(path, names, joints)]
        gathered = GatheredBodies(str(path))
        empty = 0
        for index, frame in enumerate(frames):
            people = _people(frame)
            empty += not people
            for person, body in people:
                where = f"{path}: frame {index}" + (f", person {person}" if len(people) > 1 else "")
                x, confidence = _read_body(where, body, count, wanted)
                gathered.add(person, index, None, x, confidence)
        fields: dict[str, Any] = {"clock_hz": CLOCK_HZ, "up": known.up} if known else {}
        if known and known.sensor.startswith("Kinect"):
            fields["unit"] = "m"  # Azure Kinect and MediaPipe are written in either.
        order = f"{count} in the order of the {known.sensor}" if known else f"{count} of no known order, as set"
        return gathered.recording(
            has_clock=False, empty_frames=empty, notes=(f"joints: {order}",), **{**fields, **stated_fields(about)}
        )


def _joint_count(path: Path, frames: Any) -> int:
    """Joints of the first body."""
    for index, frame in enumerate(frames):
        if not is_missing(frame) and not isinstance(frame, list):
            raise RecordingError(f"{path}: frame {index} is no array of joints; export the recording again")
        for _, body in _people(frame):
            if isinstance(body, list):
                return len(body)
    raise RecordingError(f"{path}: no frame holds a person; record with somebody in view")


def _people(frame: Any) -> list[tuple[int, Any]]:
    """(number, array of joints) of the people in a frame: the frame itself, or each of its arrays of arrays."""
    if is_missing(frame):
        return []
    if isinstance(frame, list):
        first = next((body for body in frame if not is_missing(body)), [[]])
        if isinstance(first, list) and any(isinstance(joint, list) for joint in first):
            return [(number, body) for number, body in enumerate(frame) if not is_missing(body)]
    return [(0, frame)]


def _read_body(where: str, body: Any, count: int, wanted: list[int]) -> tuple[list, list[float]]:
    if not isinstance(body, list) or len(body) != count:
        held = f"holds {len(body)} joints, elsewhere {count}" if isinstance(body, list) else "is no array of joints"
        raise RecordingError(f"{where} {held}; repair or remove it")
    x: list = []
    confidence: list[float] = []
    for index in wanted:
        try:
            point, said = read_point(body[index])
        except ValueError as error:
            raise RecordingError(f"{where}: joint {index} {error}; repair or remove it") from None
        x.append(point)
        confidence.append(said)
    return x, confidence
