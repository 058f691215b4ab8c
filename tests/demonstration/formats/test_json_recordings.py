import json

import numpy as np
import pytest
from file_samples import SENSOR_NAMES, in_order, write_azure_json, write_skeleton_json
from json_documents import HOLES, T, X, check_error, frames, said, written
from synthetic_carry import SHARED

from drake_blfdmp.demonstration.bones import link_lengths
from drake_blfdmp.demonstration.formats import read_recording
from drake_blfdmp.demonstration.formats.documents import json_text
from drake_blfdmp.demonstration.formats.documents.json_text import load_json, looks_like_json
from drake_blfdmp.demonstration.formats.sensor_joints import AZURE_KINECT, KINECT_V2
from drake_blfdmp.errors import RecordingError
from drake_blfdmp.skeleton import POINTS

# Arrays of unnamed joints.


def test_skeletons_in_kinect_order(tmp_path):
    recording = read_recording(write_skeleton_json(tmp_path / "a12_s01", T, HOLES))
    assert (recording.format, recording.up) == ("skeleton_json", "y")
    np.testing.assert_allclose(recording.x, HOLES, atol=1e-8)
    np.testing.assert_allclose(recording.t, np.arange(len(T)) / 30.0)
    assert "unit: m" in said(recording)
    assert "frame numbers at 30 a second, by its format" in said(recording)
    assert "20 in the order of the Kinect v1" in said(recording)


@pytest.mark.parametrize(("order", "up"), [(KINECT_V2, "y"), (AZURE_KINECT, "-y")])
def test_skeletons_of_other_sensors(tmp_path, order, up):
    recording = read_recording(write_skeleton_json(tmp_path / "a", T, X * 1000.0, order))
    assert recording.up == up
    np.testing.assert_allclose(recording.x, X, atol=1e-8)
    assert "unit: mm" in said(recording)


def test_skeleton_frames_without_anybody(tmp_path):
    recording = read_recording(write_skeleton_json(tmp_path / "a", T, X, empty=(0, 7)))
    np.testing.assert_array_equal(recording.frames, np.setdiff1d(np.arange(len(T)), [0, 7]))
    np.testing.assert_allclose(recording.x, X[recording.frames], atol=1e-8)
    assert "2 frames hold no person" in said(recording)


def test_skeleton_arrays_alone_of_several_people_and_with_states(tmp_path):
    order = in_order(X, KINECT_V2)
    states = np.where(np.arange(25) == KINECT_V2.index("WristLeft"), 1.0, 2.0)
    with_states = np.concatenate([order, np.broadcast_to(states[:, None], (*order.shape[:2], 1))], axis=-1)
    still = np.broadcast_to(with_states[:1], with_states.shape)
    path = written(tmp_path / "a", np.stack([still, with_states], axis=1).tolist())
    recording = read_recording(path)
    np.testing.assert_allclose(recording.x, X, atol=1e-8)
    np.testing.assert_array_equal(recording.confidence, np.tile([1, 1, 0.5, 1, 1, 1], (len(T), 1)))
    assert "person: 1 of 2" in said(recording)
    np.testing.assert_allclose(read_recording(path, body="0").x, X[:1].repeat(len(T), axis=0), atol=1e-8)


def test_skeletons_of_no_known_sensor_take_numbers_or_the_files_names(tmp_path):
    order = ("Head", *SENSOR_NAMES)
    path = write_skeleton_json(tmp_path / "a", T, X, order)
    check_error("nothing is named like left_shoulder", path)
    numbers = {point: str(order.index(name)) for point, name in zip(POINTS, SENSOR_NAMES, strict=True)}
    np.testing.assert_allclose(read_recording(path, joints=numbers).x, X, atol=1e-8)
    named = write_skeleton_json(tmp_path / "b", T, X, order, joint_names=list(order), fps=50, unit="metres")
    recording = read_recording(named)
    np.testing.assert_allclose(recording.x, X, atol=1e-8)
    np.testing.assert_allclose(recording.t, np.arange(len(T)) / 50.0)


def test_origin_is_a_joint_not_seen(tmp_path):
    zeros = X.copy()
    zeros[4, 1] = 0.0
    recording = read_recording(write_skeleton_json(tmp_path / "a", T, zeros))
    assert np.isnan(recording.x[4, 1]).all()
    assert np.isfinite(np.delete(recording.x, 4, axis=0)).all()


# The offline processor of the Azure Kinect.


def test_azure(tmp_path):
    confidence = np.full((len(T), 6), 2)
    confidence[4], confidence[5, 0], confidence[6, 1] = 1, 0, 3
    recording = read_recording(write_azure_json(tmp_path / "a", T, X, confidence))
    assert (recording.format, recording.up) == ("azure_json", "-y")
    np.testing.assert_allclose(recording.x, X, atol=1e-9)
    np.testing.assert_allclose(recording.t, T, atol=1e-6)
    np.testing.assert_array_equal(recording.confidence, np.array([0.0, 0.5, 1.0, 1.0])[confidence])
    assert "unit: mm, the file or its format says" in said(recording)
    assert "clock: us" in said(recording)


def test_azure_of_low_confidence_alone(tmp_path):
    recording = read_recording(write_azure_json(tmp_path / "a", T, X, np.ones((len(T), 6), int)))
    np.testing.assert_array_equal(recording.confidence, 0.5)
    assert read_recording(write_azure_json(tmp_path / "b", T, X)).confidence is None


def test_azure_people_come_and_go(tmp_path):
    def bodies(i):
        return [] if i in (0, 3) else [(2, 0.0), (5, 0.5)] if i < 50 else [(2, 0.0)]

    path = write_azure_json(tmp_path / "a", T, X, bodies=bodies, indent=None)
    recording = read_recording(path)
    np.testing.assert_array_equal(recording.frames, np.setdiff1d(np.arange(len(T)), [0, 3]))
    np.testing.assert_allclose(recording.x, X[recording.frames], atol=1e-9)
    assert "2 frames hold no person" in said(recording)
    assert "person: 2 of 2" in said(recording)
    np.testing.assert_allclose(read_recording(path, body="5").x, X[recording.frames[:48]] + 0.5, atol=1e-9)


# What is refused.


def test_no_recordings(tmp_path):
    for name, text, message in (
        ("cut", json.dumps(frames())[:-40], "no JSON ("),
        ("cut", json.dumps(frames(), indent=1)[:900], "line "),
        ("settings", '{"a": 1, "b": {"c": "d"}}', "without a list of frames"),
        ("words", '["a", "b"]', "holds points of three coordinates"),
        ("pixels", [{"keypoints": {point: [3, 4] for point in POINTS}}], "points of three coordinates"),
        ("nobody", '{"skeletons": [[], null, []]}', "no frame holds a person"),
        ("deep", "[" * 100_000, "too deeply"),
        ("deep", '{"frames":' * 50_000, "too deeply"),
        ("digits", "[[[" + "9" * 9000 + ",1,2]]]", "thousands of digits"),
    ):
        check_error(message, written(tmp_path / name, text))
    (tmp_path / "latin").write_bytes(b'[{"a": "caf\xe9"}]')
    check_error("line 1 is not UTF-8", tmp_path / "latin")


def test_many_small_parts_are_refused_before_they_fill_the_memory(tmp_path):
    path = written(tmp_path / "a", "[" + "{}," * 5_000_000 + "{}]")
    check_error("MB of memory; cut the recording", path)


def test_other_letters_take_more_memory(tmp_path, monkeypatch):
    monkeypatch.setattr(json_text, "_MAX_PARSED_BYTES", 1000)
    assert load_json(written(tmp_path / "a", '["' + "a" * 300 + '"]')) == ["a" * 300]
    with pytest.raises(RecordingError, match="of memory"):
        load_json(written(tmp_path / "b", '["' + "a" * 300 + '\u00e9"]', encoding="utf-8"))


@pytest.mark.parametrize(
    ("value", "message"),
    [
        ([1.0, 2.0], "frame 4: 'left_wrist' holds 2 numbers"),
        (["a", 2.0, 3.0], "frame 4: 'left_wrist' holds what is no number"),
        ("near", "frame 4: 'left_wrist' is no x, y, z"),
        ({"x": 1.0}, "frame 4: 'left_wrist' has no x, y and z"),
        ([10**400, 0, 1], "frame 4: 'left_wrist' holds what is no number"),
    ],
)
def test_bad_points(tmp_path, value, message):
    document = frames()
    document[4]["left_wrist"] = value
    check_error(message, written(tmp_path / "a", document))


def test_bad_frames(tmp_path):
    timed = [{"timestamp": float(t), "joints": points} for t, points in zip(T, frames(), strict=True)]
    for value in (None, "soon", float("nan"), 10**400, [1]):
        timed[6]["timestamp"] = value
        check_error("frame 6: 'timestamp' is no time", written(tmp_path / "a", timed))
    check_error(
        "nothing is named like left_wrist", written(tmp_path / "b", frames(names=(*POINTS[:2], "Paw", *POINTS[3:])))
    )
    skeletons = json.loads(write_skeleton_json(tmp_path / "c", T, X).read_text())
    skeletons["skeletons"][8].pop()
    check_error("frame 8 holds 19 joints, elsewhere 20", written(tmp_path / "c", skeletons))
    skeletons["skeletons"][8] = [[1, 2]] * 20
    check_error("frame 8: joint 4 holds 2 numbers", written(tmp_path / "c", skeletons))
    azure = json.loads(write_azure_json(tmp_path / "d", T, X).read_text())
    azure["frames"][2]["bodies"][0]["joint_positions"].pop()
    check_error("frame 2, body '1' has no joint_positions of 32 joints", written(tmp_path / "d", azure))
    azure["frames"][2]["bodies"] = None
    check_error("frame 2 has no list of bodies", written(tmp_path / "d", azure))


def test_only_json_looks_like_json():
    assert all(map(looks_like_json, (b"[[[1", b' {"a', b"[-1", b"\xef\xbb\xbf[\n{", b"[null", b"[NaN"[:1] + b"n")))
    assert not any(map(looks_like_json, (b"", b"(1", b"[Header]\n", b"{x", b'{"a\0', b"1,2", b"[section]")))


def test_equal_keys_and_special_numbers(tmp_path):
    assert load_json(written(tmp_path / "a", '{"a": 1, "a": 2}')) == {"a": 2}
    assert np.isnan(load_json(written(tmp_path / "b", "[NaN, -nan(ind), nan]"))).all()


# Real files.


def shared(pattern):
    paths = sorted(SHARED.glob(pattern)) if SHARED.is_dir() else []
    if not paths:
        pytest.skip(f"{SHARED / pattern} is not here")
    return paths


def test_real_kinect_carries():
    for path in shared("kinect_v1_nw_ucla/*.json"):
        recording = read_recording(path)
        assert (recording.format, recording.up) == ("skeleton_json", "y")
        assert len(recording.t) == len(json.loads(path.read_text())["skeletons"])
        lengths = np.median(link_lengths(recording.x), axis=0)
        assert ((lengths[[0, 4]] > 0.239 - 0.117) & (lengths[[0, 4]] < 0.239 + 0.117)).all()  # 3 sigma of the set.
        assert ((lengths[[1, 3]] > 0.244 - 0.132) & (lengths[[1, 3]] < 0.244 + 0.132)).all()


def test_real_keypoints_and_their_cleaned_version():
    lost, longest = 0, 0.0
    for path in shared("rgbd_arm_keypoints/*_Original.json"):
        original = read_recording(path)
        cleaned = read_recording(path.with_name(path.name.replace("Original", "DepthProjection")))
        assert "unit: mm" in said(original)
        np.testing.assert_array_equal(original.frames, cleaned.frames)
        held = [frame["keypoint_xyz"] for frame in json.loads(path.read_text())]
        raw = np.array([[frame[point] for point in POINTS] for frame in held]) / 1000.0
        missing = (raw == 0.0).all(axis=-1)
        np.testing.assert_allclose(original.x, np.where(missing[..., None], np.nan, raw))
        lost += missing.sum()
        longest = max(longest, *(np.linalg.norm(raw[:, i] - raw[:, i + 1], axis=-1).max() for i in (1, 4)))
        assert np.nanmax(link_lengths(cleaned.x)[:, [1, 3]]) < np.nanmax(link_lengths(original.x)[:, [1, 3]])
    assert lost > 0
    assert longest > 1.2  # To the origin, where the depth camera saw nothing.


def test_origin_is_told(tmp_path):
    zeros = X.copy()
    zeros[4, 1] = zeros[8] = 0.0
    assert "7 points at exactly (0, 0, 0) count as missing" in said(
        read_recording(write_skeleton_json(tmp_path / "a", T, zeros))
    )
