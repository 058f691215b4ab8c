from itertools import permutations

import numpy as np
import pytest
from synthetic_carry import carry
from text_samples import KINECT, SHORT, save, write_long_csv

from drake_blfdmp.demonstration.formats import read_recording
from drake_blfdmp.demonstration.formats.sensor_joints import AZURE_KINECT, KINECT_V2, MEDIAPIPE_POSE
from drake_blfdmp.errors import RecordingError

T, X = carry(duration=1.0)


def check_error(said, path, **options):
    with pytest.raises(RecordingError) as caught:
        read_recording(path, **options)
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "header", [",".join(order) for order in list(permutations(["time_s", "joint", "x", "y", "z"]))[::7]]
)
@pytest.mark.parametrize("separator", [",", ";", "\t", " "])
def test_any_order_and_separator(tmp_path, header, separator):
    recording = read_recording(write_long_csv(tmp_path / "a.csv", T, X, header=header, separator=separator))
    assert recording.format == "long_csv"
    np.testing.assert_allclose(recording.x, X, atol=1e-8)
    np.testing.assert_allclose(recording.t, T)
    np.testing.assert_array_equal(recording.frames, np.arange(len(T)))


@pytest.mark.parametrize(
    "names",
    [
        "Frame,Joint_Name,X,Y,Z",
        "frame_id,marker,pos_x,pos_y,pos_z",
        "FrameNumber,JointType,PositionX,PositionY,PositionZ",
        "#frame,landmark,x (m),y (m),z (m)",
        "frame,bodypart,x_position,y_position,z_position",
    ],
)
def test_usual_names_of_columns(tmp_path, names):
    path = write_long_csv(tmp_path / "a.csv", T, X, header="frame,joint,x,y,z")
    path.write_text(names + path.read_text()[len("frame,joint,x,y,z") :])
    recording = read_recording(path)
    assert recording.format == "long_csv"
    np.testing.assert_allclose(recording.x, X, atol=1e-8)


@pytest.mark.parametrize(
    ("order", "first", "up", "sensor"),
    [
        (KINECT_V2, 0, "y", "Kinect v2"),
        (KINECT_V2, 1, "y", "Kinect v2"),
        (AZURE_KINECT, 0, "-y", "Azure Kinect"),
        (MEDIAPIPE_POSE, 0, "-y", "MediaPipe"),
        (KINECT, None, "y", "Kinect v1"),
    ],
)
def test_joints_by_number(tmp_path, order, first, up, sensor):
    if first is None:
        names, many = (4, 5, 6, 8, 9, 10), X  # The arms alone.
    else:
        names, many = range(first, first + len(order)), np.full((len(T), len(order), 3), 0.5)
        many[:, [order.index(name) for name in KINECT]] = X
    recording = read_recording(write_long_csv(tmp_path / "a.csv", T, many, names))
    np.testing.assert_allclose(recording.x, X, atol=1e-8)
    assert recording.up == up
    assert f"joints: numbered as by {sensor}" in recording.evidence


def test_numbers_of_no_sensor_have_to_be_named(tmp_path):
    path = write_long_csv(tmp_path / "a.csv", T, X, names=range(50, 56))
    check_error("nothing is named like left_shoulder", path)
    lines = write_long_csv(tmp_path / "b.csv", T, X, names=(4, 5, 6, 8, 9, 10)).read_text().splitlines()
    check_error("nothing is named like", save(tmp_path / "b.csv", [*lines, lines[-1].replace(",10,", ",12345,")]))
    points = ("left_shoulder", "left_elbow", "left_wrist", "right_shoulder", "right_elbow", "right_wrist")
    joints = {point: str(50 + index) for index, point in enumerate(points)}
    np.testing.assert_allclose(read_recording(path, joints=joints).x, X, atol=1e-8)


def test_missing_rows_and_cells_are_missing_points(tmp_path):
    lines = write_long_csv(tmp_path / "a.csv", T, X, header="frame,joint,x,y,z,confidence").read_text().splitlines()
    lines[9] = "1,LWrist,,NaN,,None"  # Line 10: frame 1, left wrist.
    del lines[5]  # Frame 0, right elbow.
    expected = X.copy()
    expected[1, 2] = np.nan
    expected[0, 4] = np.nan
    recording = read_recording(save(tmp_path / "b.csv", lines))
    np.testing.assert_allclose(recording.x, expected, atol=1e-8)
    seen = np.ones((len(T), 6))
    seen[1, 2] = seen[0, 4] = 0.0
    np.testing.assert_array_equal(recording.confidence, seen)


def test_repeated_rows_and_frames_out_of_order(tmp_path):
    lines = write_long_csv(tmp_path / "a.csv", T, X, header="frame,joint,x,y,z").read_text().splitlines()
    twice = "3,LWrist,9,9,9"
    late = [lines[0], *lines[13:19], *lines[1:13], *lines[19:], twice]
    recording = read_recording(save(tmp_path / "b.csv", late))
    np.testing.assert_array_equal(recording.frames, [2, 0, 1, *range(3, len(T))])
    np.testing.assert_allclose(recording.x, X[recording.frames], atol=1e-8)
    assert "1 rows give a joint of a frame once more and are left out" in recording.evidence


def test_several_people(tmp_path):
    one = write_long_csv(tmp_path / "a.csv", T, X, header="time_s,body,joint,x,y,z").read_text().splitlines()
    other = write_long_csv(tmp_path / "b.csv", T[5:], 0.9 * X[5:], header="time_s,body,joint,x,y,z").read_text()
    rows = [line.replace(",7,", ",8,", 1) for line in other.splitlines()[1:]]
    path = save(tmp_path / "c.csv", [*one, *rows])
    np.testing.assert_allclose(read_recording(path).x, X, atol=1e-8)
    second = read_recording(path, body="8")
    np.testing.assert_allclose(second.x, 0.9 * X[5:], atol=1e-8)
    np.testing.assert_array_equal(second.frames, np.arange(5, len(T)))


def test_neither_frame_nor_time(tmp_path):
    path = write_long_csv(tmp_path / "a.csv", T, X, header="joint,x,y,z")
    np.testing.assert_allclose(read_recording(path).x, X, atol=1e-8)
    lines = path.read_text().splitlines()
    check_error("names neither frame nor time", save(tmp_path / "b.csv", lines[:-1]))


def test_content_refused(tmp_path):
    lines = write_long_csv(tmp_path / "a.csv", T, X).read_text().splitlines()
    check_error("holds a header but no samples", save(tmp_path / "b.csv", lines[:1]))
    check_error("line 4 has 5 columns", save(tmp_path / "b.csv", [*lines[:3], lines[3].rsplit(",", 1)[0], *lines[4:]]))
    bad = [*lines[:3], lines[3].replace("0.", "O.", 1), *lines[4:]]
    check_error("line 4, column", save(tmp_path / "b.csv", bad))
    check_error("nothing is named like right_wrist", save(tmp_path / "b.csv", [x for x in lines if SHORT[5] not in x]))
    check_error("give left_wrist one joint name", tmp_path / "a.csv", joints={"left_wrist": ("a", "b", "c")})
