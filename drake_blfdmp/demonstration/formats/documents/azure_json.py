"""JSON of Microsoft's offline processor for the Azure Kinect body tracker (k4abt).

`{"bone_list", "frames": [{"bodies": [{"body_id", "joint_positions": [[x, y, z] x 32], "joint_orientations"}],
"frame_id", "num_bodies", "timestamp_usec"}], "joint_names", "k4abt_sdk_version", "source_file"}`: millimetres in the
depth camera's frame (x right, y down, z forward). Later versions add `confidence_levels`, 0 none to 3 high.
"""

import re
from pathlib import Path
from typing import Any

import numpy as np

from drake_blfdmp.demonstration.formats.documents.json_frames import (
    find_frames,
    frame_numbers,
    frame_times,
    stated_names,
)
from drake_blfdmp.demonstration.formats.documents.json_points import one_name_each, read_point
from drake_blfdmp.demonstration.formats.documents.json_text import load_json, looks_like_json, number
from drake_blfdmp.demonstration.formats.gathered_bodies import GatheredBodies
from drake_blfdmp.demonstration.formats.recording_format import Joints
from drake_blfdmp.demonstration.formats.sensor_joints import AZURE_KINECT
from drake_blfdmp.demonstration.raw_recording import RawRecording
from drake_blfdmp.errors import RecordingError
from drake_blfdmp.skeleton import WRISTS

_BODIES = re.compile(rb'"bodies"\s*:')
_LEVELS = (0.0, 0.5, 1.0, 1.0)  # None, low, medium, high.
_OTHERS = re.compile(rb'"(?:joint_positions|timestamp_usec|num_bodies|bone_list|k4abt_sdk_version)"\s*:')


class AzureJson:
    """Reader of the offline processor's JSON; `joints` names the tracker's joints."""

    name = "azure_json"

    def sniff(self, head: bytes) -> bool:
        """Whether JSON holds `bodies` and another of the offline processor's keys."""
        return looks_like_json(head) and _BODIES.search(head) is not None and _OTHERS.search(head) is not None

    def read(self, path: Path, joints: Joints | None) -> RawRecording:
        """Reads the file; time from `timestamp_usec`, frame numbers from `frame_id`.

        Raises:
            RecordingError: no JSON, no frames, a frame without time or bodies, or a body without 32 joints.
        """
        frames, about = find_frames(path, load_json(path), lambda _: 0)
        names = stated_names(about, len(AZURE_KINECT)) or AZURE_KINECT
        wanted = [names.index(name) for name in one_name_each(path, names, joints)]
        t, time_unit = frame_times(path, frames, joints)
        numbers = frame_numbers(frames)
        gathered = GatheredBodies(str(path))
        empty = 0
        for index, frame in enumerate(frames):
            bodies = frame.get("bodies") if isinstance(frame, dict) else None
            if not isinstance(bodies, list):
                raise RecordingError(f"{path}: frame {index} has no list of bodies; remove it or export again")
            empty += not bodies
            for body in bodies:
                name = body.get("body_id", 0) if isinstance(body, dict) else 0
                x, confidence = _read_body(f"{path}: frame {index}, body {str(name)[:40]!r}", body, wanted)
                turns = [_read_turn(body, wanted[wrist]) for wrist in WRISTS]
                gathered.add(name, int(numbers[index]), None if t is None else t[index], x, confidence, turns)
        return gathered.recording(has_clock=t is not None, unit="mm", time_unit=time_unit, up="-y", empty_frames=empty)


def _read_turn(body: dict[str, Any], joint: int) -> list[float]:
    """A joint's orientation, w x y z; NaN where the file has none: points alone are enough."""
    turns = body.get("joint_orientations")
    turn = turns[joint] if isinstance(turns, list) and len(turns) == len(AZURE_KINECT) else None
    try:
        if isinstance(turn, list) and len(turn) == 4:
            return [number(value) for value in turn]
    except ValueError:
        pass
    return [np.nan] * 4


def _read_body(where: str, body: Any, wanted: list[int]) -> tuple[list, list[float] | None]:
    positions = body.get("joint_positions") if isinstance(body, dict) else None
    if not isinstance(positions, list) or len(positions) != len(AZURE_KINECT):
        raise RecordingError(f"{where} has no joint_positions of {len(AZURE_KINECT)} joints; remove it or export again")
    x: list = []
    for joint in wanted:
        try:
            x.append(read_point(positions[joint])[0])
        except ValueError as error:
            raise RecordingError(f"{where}: joint {joint} {error}; repair or remove it") from None
    levels = next((entry for key, entry in body.items() if "confidence" in key), None)
    if levels is None:
        return x, None
    try:
        return x, [_LEVELS[levels[joint]] for joint in wanted]
    except (TypeError, IndexError, KeyError):
        raise RecordingError(f"{where}: its confidence levels are not {len(AZURE_KINECT)} of 0 to 3; repair") from None
