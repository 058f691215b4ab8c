import json

import numpy as np
import pytest
from file_samples import in_order, listed, write_keypoint_json
from json_documents import HOLES, T, X, check_error, frames, said, written

from drake_blfdmp.demonstration.formats import read_recording
from drake_blfdmp.demonstration.formats.sensor_joints import MEDIAPIPE_POSE
from drake_blfdmp.skeleton import POINTS


def test_keypoints(tmp_path):
    recording = read_recording(write_keypoint_json(tmp_path / "a", T, HOLES, indent=2))
    assert (recording.format, recording.up, recording.confidence) == ("keypoint_json", None, None)
    np.testing.assert_allclose(recording.x, HOLES, atol=1e-9)
    np.testing.assert_allclose(recording.t, T, atol=1e-8)
    assert "unit: mm, for upper arms measure 290" in said(recording)
    assert "clock: ms, as the file or its format says" in said(recording)


def wide(point):
    return dict(zip("xyz", point, strict=True))


LAYOUTS = {
    "directly": lambda f: f,
    "under another key": lambda f: [{"frame": i, "joints3d": points, "joints2d": {}} for i, points in enumerate(f)],
    "beside pixels": lambda f: [{"keypoints": {k: [4, 5, 0.9] for k in p}, "keypoints_3d": p} for p in f],
    "objects": lambda f: {"frames": [{k: wide(v) for k, v in points.items()} for points in f]},
    "capitals": lambda f: [
        {"Joints": {k: {"Position": dict(zip("XYZ", v, strict=True))} for k, v in p.items()}} for p in f
    ],
    "named list": lambda f: [{"landmarks": [{"name": k, **wide(v)} for k, v in points.items()]} for points in f],
    "series": lambda f: {"keypoints": {name: [points[name] for points in f] for name in POINTS}},
    "numbered frames": lambda f: {f"frame_{i}": points for i, points in enumerate(f)},
    "one object a line": lambda f: "\n".join(json.dumps({"keypoints": points}) for points in f),
    "in recording": lambda f: {"recording": {"info": {"camera": "a"}, "samples": f}},
    "other joints": lambda f: [{"nose": [1, 2, 3], **points, "left_hip": None} for points in f],
}


@pytest.mark.parametrize("layout", LAYOUTS)
def test_keypoint_layouts(tmp_path, layout):
    recording = read_recording(written(tmp_path / "a", LAYOUTS[layout](frames())))
    assert recording.format == "keypoint_json"
    np.testing.assert_allclose(recording.x, X, atol=1e-8)
    np.testing.assert_allclose(recording.t, np.arange(len(T)) / 30.0)


def test_a_joint_may_be_left_out_and_frames_may_be_empty(tmp_path):
    document = frames()
    del document[3]["left_wrist"]
    document[6] = {"left_wrist": None, "right_wrist": {}}
    document[10], document[11] = None, {}
    recording = read_recording(written(tmp_path / "a", document))
    np.testing.assert_array_equal(recording.frames, np.setdiff1d(np.arange(len(T)), [10, 11]))
    assert np.isnan(recording.x[3, 2]).all()
    assert np.isnan(recording.x[6]).all()
    assert "2 frames hold no person" in said(recording)


def test_landmarks_without_names(tmp_path):
    joints = in_order(X, MEDIAPIPE_POSE)
    document = [{"world_landmarks": [{**wide(p), "visibility": 0.5} for p in points]} for points in listed(joints)]
    recording = read_recording(written(tmp_path / "a", document))
    np.testing.assert_allclose(recording.x, X, atol=1e-8)
    np.testing.assert_array_equal(recording.confidence, 0.5)
    assert recording.up == "-y"
    assert "33 in the order of the MediaPipe" in said(recording)
    cut = [{"world_landmarks": entry["world_landmarks"][: -1 - i % 2]} for i, entry in enumerate(document)]
    check_error("31 to 32 points without names", written(tmp_path / "b", cut))
    lists = {"joint_names": list(MEDIAPIPE_POSE), "frames": [{"pose": points} for points in listed(joints)]}
    np.testing.assert_allclose(read_recording(written(tmp_path / "c", lists)).x, X, atol=1e-8)


def test_people_by_id(tmp_path):
    document = [
        {"t": float(t), "bodies": [{"id": 7, "joints": frames(X[:1])[0]}, {"id": "me", "joints": points}][(i < 5) :]}
        for i, (t, points) in enumerate(zip(T, frames(), strict=True))
    ]
    recording = read_recording(written(tmp_path / "a", document))
    np.testing.assert_allclose(recording.x, X, atol=1e-8)
    assert "person: me of 2" in said(recording)
    other = read_recording(tmp_path / "a", body="7")
    np.testing.assert_allclose(other.t, T[5:])
    np.testing.assert_array_equal(other.frames, np.arange(5, len(T)))


@pytest.mark.parametrize(
    ("said_of_wrist", "said_of_others", "expected"),
    [
        ({"confidence": 0.25}, {"confidence": 1.0}, 0.25),
        ({"TrackingState": 1}, {"TrackingState": 2}, 0.5),
        ({"TrackingState": "Inferred"}, {"TrackingState": "Tracked"}, 0.5),
        ({"visibility": 0.0}, {"visibility": 0.75}, 0.0),
    ],
)
def test_confidence(tmp_path, said_of_wrist, said_of_others, expected):
    document = [
        {k: {**wide(v), **(said_of_wrist if k == "left_wrist" else said_of_others)} for k, v in points.items()}
        for points in frames()
    ]
    recording = read_recording(written(tmp_path / "a", document))
    np.testing.assert_array_equal(recording.confidence[:, 2], expected)
    assert (recording.confidence[:, [0, 1, 3, 4, 5]] > expected).all()
    np.testing.assert_allclose(recording.x, X, atol=1e-8)


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("timestamp", lambda t: float(t)),
        ("timestamp_usec", lambda t: round(t * 1e6)),
        ("timeMs", lambda t: f"{t * 1e3:.6f}"),
        ("time", lambda t: f"2024-02-29T23:59:{t + 10:.6f}Z"),
        (
            "header",
            lambda t: {"stamp": {"sec": 1_700_000_000 + int(t), "nanosec": round(t % 1 * 1e9)}, "frame_id": "a"},
        ),
    ],
)
def test_times(tmp_path, key, value):
    document = [{key: value(float(t)), "pose": points} for t, points in zip(T, frames(), strict=True)]
    recording = read_recording(written(tmp_path / "a", document))
    np.testing.assert_allclose(recording.t - recording.t[0], T, atol=2e-6)
    assert "assumed" not in said(recording)


def test_time_by_name_and_rate_and_units_of_the_document(tmp_path):
    document = [{"when": float(t), "pose": points} for t, points in zip(T, frames(), strict=True)]
    np.testing.assert_allclose(read_recording(written(tmp_path / "a", document), joints={"time": "when"}).t, T)
    check_error("no column 'then' for time", tmp_path / "a", joints={"time": "then"})
    recording = read_recording(
        written(tmp_path / "b", {"fps": 60.0, "units": "mm", "up": "Z", "frames": frames(X * 1e3)})
    )
    np.testing.assert_allclose(recording.t, np.arange(len(T)) / 60.0)
    assert recording.up == "z"
    assert "mm, the file or its format says" in said(recording)


def test_text_as_tools_write_it(tmp_path):
    text = json.dumps(frames(HOLES)).replace("null", "nan")
    path = tmp_path / "a"
    path.write_bytes(b"\xef\xbb\xbf\r\n" + text.replace("}, ", "},\r\n\r\n").encode())
    np.testing.assert_allclose(read_recording(path).x, HOLES, atol=1e-8)
