"""People in visualization_msgs MarkerArray (or Marker) messages: one marker a joint, as body trackers publish for RViz.

The Azure Kinect ROS driver's `body_tracking_data` is the best known: 32 spheres a person, in the depth camera's frame.
Colours tell confidence in some: green tracked, blue guessed, red not seen.
"""

import numpy as np

from drake_blfdmp.demonstration.formats.gathered_bodies import MAX_BODIES
from drake_blfdmp.demonstration.formats.recording_format import Joints
from drake_blfdmp.demonstration.formats.ros.body_names import hand_note
from drake_blfdmp.demonstration.formats.ros.marker_bodies import label_of, sort_markers
from drake_blfdmp.demonstration.formats.ros.marker_tracks import MarkerKey, Track, read_tracks
from drake_blfdmp.demonstration.formats.ros.ros_frames import up_of
from drake_blfdmp.demonstration.formats.ros.ros_topics import MARKER, Topic, times_of
from drake_blfdmp.demonstration.raw_recording import Body, RawRecording
from drake_blfdmp.errors import RecordingError
from drake_blfdmp.skeleton import POINTS, WRISTS

_CONFIDENCE = {(0, 1, 0): 1.0, (0, 0, 1): 0.5, (1, 0, 0): 0.0}  # By red, green, blue.


def read_markers(where: str, topic: Topic, joints: Joints | None, *, alpha_is_confidence: bool = False) -> RawRecording:
    """The people on a topic.

    Args:
        where: file and topic, for messages.
        topic: of MarkerArray or Marker messages.
        joints: see `read_recording`.
        alpha_is_confidence: what `mcap_writer` says of its own files.

    Raises:
        RecordingError: a message that is none, or nobody's arms.
    """
    try:
        tracks = read_tracks(topic)
    except ValueError as error:
        raise RecordingError(f"{where}: {error}; record it again, or cut it before that") from None
    if not tracks:
        raise RecordingError(
            f"{where}: {len(topic.messages)} messages without any marker; record with somebody in view"
        )
    log_ns, number = np.array(topic.log_ns, float), np.arange(len(topic.messages))
    if topic.type == MARKER:
        tracks, log_ns, number = _as_arrays(tracks, log_ns)
    found = sort_markers(where, tracks, joints)
    if len(found.bodies) > MAX_BODIES:
        raise RecordingError(f"{where}: more than {MAX_BODIES} different people; repair their ids or cut the file")
    used = {key for points in found.bodies.values() for keys in points.values() for key in keys}
    told = alpha_is_confidence or _colours_tell_confidence(tracks)
    bodies, clocks = {}, set()
    for name, points in found.bodies.items():
        bodies[name], clock = _body(
            [[tracks[key] for key in points[point]] for point in POINTS], log_ns, told, alpha_is_confidence
        )
        clocks.add(clock)
    seen = set().union(*(body.frames.tolist() for body in bodies.values()))
    frames = {key.frame for key in used}
    return RawRecording(
        bodies,
        unit="m",  # REP 103: lengths in ROS are in metres.
        time_unit="s",
        up=up_of(frames, azure_kinect=found.sensor == "Azure Kinect"),
        empty_frames=int(np.unique(number).size) - len(seen),
        notes=(found.note, *hand_note(sorted({label_of(key) for key in used})), *sorted(clocks)),
    )


def _as_arrays(
    tracks: dict[MarkerKey, Track], log_ns: np.ndarray
) -> tuple[dict[MarkerKey, Track], np.ndarray, np.ndarray]:
    """Single markers as if those of one stamp had come in one message."""
    stamp_ns = np.full(len(log_ns), -1)
    for track in tracks.values():
        stamp_ns[track.message] = track.stamp_ns
    told = np.ptp(stamp_ns[stamp_ns >= 0]) > 0 if np.any(stamp_ns >= 0) else False
    clock = stamp_ns if told else log_ns
    _, first, number = np.unique(clock, return_index=True, return_inverse=True)
    moved = {key: track._replace(message=number[track.message]) for key, track in tracks.items()}
    return moved, log_ns[first], number


def _body(points: list[list[Track]], log_ns: np.ndarray, told: bool, alpha: bool) -> tuple[Body, str]:
    """One person from the tracks of its six points, and how its times were found."""
    frames = np.unique(np.concatenate([track.message for tracks in points for track in tracks]))
    x = np.full((len(frames), len(POINTS), 3), np.nan)
    confidence = np.zeros((len(frames), len(POINTS)))
    turns = np.full((len(frames), len(POINTS), 4), np.nan)
    stamp_ns = np.zeros(len(frames), np.int64)
    for point, tracks in enumerate(points):
        for track in tracks:
            row = np.searchsorted(frames, track.message)
            # (0, 0, 0) stands for a joint not seen: no joint lies in a sensor.
            x[row, point] = np.where(np.all(track.x == 0.0, axis=1, keepdims=True), np.nan, track.x)
            confidence[row, point] = track.rgba[:, 3] if alpha else _confidence(track.rgba)
            turns[row, point] = track.turn
            stamp_ns[row] = track.stamp_ns
    turns[~np.isfinite(x).all(axis=-1)] = np.nan
    confidence[~np.isfinite(x).all(axis=-1)] = 0.0
    t, note = times_of(stamp_ns, log_ns[frames])
    confidence = np.clip(np.nan_to_num(confidence), 0.0, 1.0) if told else None
    return Body(x, frames, t, confidence, turns[:, WRISTS]), note


def _confidence(rgba: np.ndarray) -> np.ndarray:
    """(n,) by colour; 1 for every other colour."""
    confidence = np.ones(len(rgba))
    for colour, value in _CONFIDENCE.items():
        confidence[(rgba[:, :3] == colour).all(axis=1)] = value
    return confidence


def _colours_tell_confidence(tracks: dict[MarkerKey, Track]) -> bool:
    """Whether colours are of those three alone, and change on single markers: a person's own colour does not."""
    rgb = np.concatenate([track.rgba[:, :3] for track in tracks.values()])
    known = np.zeros(len(rgb), bool)
    for colour in _CONFIDENCE:
        known |= (rgb == colour).all(axis=1)
    return bool(known.all()) and any(np.any(track.rgba[1:, :3] != track.rgba[:-1, :3]) for track in tracks.values())
