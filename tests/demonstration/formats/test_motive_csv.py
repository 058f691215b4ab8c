import numpy as np
import pytest
from synthetic_carry import carry
from text_samples import KINECT, MOTIVE, SHORT, save, write_motive_csv

from drake_blfdmp.demonstration.formats import read_recording
from drake_blfdmp.errors import RecordingError

T, X = carry(duration=1.0)
FBX = ("LeftArm", "LeftForeArm", "LeftHand", "RightArm", "RightForeArm", "RightHand")
UNREAL = ("upperarm_l", "lowerarm_l", "hand_l", "upperarm_r", "lowerarm_r", "hand_r")


def check_error(said, path, **options):
    with pytest.raises(RecordingError) as caught:
        read_recording(path, **options)
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("kind", "names"),
    [("Bone", MOTIVE), ("Bone", FBX), ("Bone", UNREAL), ("Marker", SHORT), ("Rigid Body", KINECT)],
)
@pytest.mark.parametrize(("unit", "scale"), [("Meters", 1.0), ("Centimeters", 100.0), ("Millimeters", 1000.0)])
def test_objects_and_units(tmp_path, kind, names, unit, scale):
    path = write_motive_csv(tmp_path / "a.csv", T, X, kind, names, unit=unit, scale=scale)
    recording = read_recording(path)
    assert (recording.format, recording.up) == ("motive_csv", "y")
    np.testing.assert_allclose(recording.x, X, atol=1e-8)
    np.testing.assert_allclose(recording.t, T, atol=1e-6)
    assert "the file or its format says" in recording.evidence[0]


def test_the_clavicle_is_no_shoulder(tmp_path):
    names = ("LShoulder", "RShoulder", "Hip", *MOTIVE)
    more = np.concatenate([np.full((len(T), 3, 3), 0.7), X], axis=1)
    np.testing.assert_allclose(read_recording(write_motive_csv(tmp_path / "a", T, more, names=names)).x, X, atol=1e-8)


def test_every_skeleton_is_a_person(tmp_path):
    path = write_motive_csv(tmp_path / "a.csv", T, X, people=("Anna", "Bert"))
    np.testing.assert_allclose(read_recording(path).x, X, atol=1e-8)
    np.testing.assert_allclose(read_recording(path, body="Bert").x, 0.9 * X, atol=1e-8)


def test_newer_header_lost_objects_and_missing_times(tmp_path):
    lines = write_motive_csv(tmp_path / "a.csv", T, X, version="1.25").read_bytes().decode().split("\r\n")
    lines.insert(5, ",Parent," + ",".join(["0"] * 42))
    row = lines[10].split(",")
    row[2 + 7 * 2 : 2 + 7 * 3] = [""] * 7
    lines[10] = ",".join(row)
    expected = X.copy()
    expected[2, 2] = np.nan
    np.testing.assert_allclose(read_recording(save(tmp_path / "b.csv", lines)).x, expected, atol=1e-8)
    without = [",".join([line.split(",")[0], "", *line.split(",")[2:]]) for line in lines[8:] if line]
    recording = read_recording(save(tmp_path / "c.csv", [*lines[:8], *without]))
    np.testing.assert_allclose(recording.t, T, atol=1e-9)  # By the export's frame rate.


def test_joints_name_objects(tmp_path):
    path = write_motive_csv(tmp_path / "a.csv", T, X)
    swap = {"left_wrist": "Anna:RHand", "right_wrist": "Anna:LHand"}
    np.testing.assert_allclose(read_recording(path, joints=swap).x[:, [2, 5]], X[:, [5, 2]], atol=1e-8)
    check_error("no joint 'Paw' for left_wrist; the file has Anna:LUArm", path, joints={"left_wrist": "Paw"})


def test_refused(tmp_path):
    path = write_motive_csv(tmp_path / "a.csv", T, X)
    lines = path.read_bytes().decode().split("\r\n")
    check_error("no line begins with Frame", save(path, lines[:6]))
    check_error("no samples", save(path, lines[:7]))
    check_error("nothing is named like left_shoulder", save(path, [*lines[:3], *lines[4:]]))
    check_error("line 9 has 45 columns, expected 44", save(path, [*lines[:8], lines[8] + ",1", *lines[9:]]))
    check_error(
        "line 9, column Time: 'x' is no number", save(path, [*lines[:8], lines[8].replace("0.033333", "x"), *lines[9:]])
    )
