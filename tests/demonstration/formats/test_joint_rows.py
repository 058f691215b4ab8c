import numpy as np
import pytest
from synthetic_carry import carry
from text_samples import WRISTS_FIRST, save, write_joint_rows, write_points18

from drake_blfdmp.demonstration.formats import read_recording
from drake_blfdmp.demonstration.formats.sensor_joints import AZURE_KINECT, KINECT_V1, KINECT_V2
from drake_blfdmp.errors import RecordingError

T, X = carry(duration=2.0)
SENSORS = {
    "kinect_v1_rows": (KINECT_V1, "y"),
    "kinect_v2_rows": (KINECT_V2, "y"),
    "azure_kinect_rows": (AZURE_KINECT, "-y"),
}


def check_error(said, path, **options):
    with pytest.raises(RecordingError) as caught:
        read_recording(path, **options)
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name", SENSORS)
@pytest.mark.parametrize("first", ["", "frame", "ms", "100ns"])
@pytest.mark.parametrize("cells", [3, 4, 7, 8])
def test_layouts(tmp_path, name, first, cells):
    order, up = SENSORS[name]
    recording = read_recording(write_joint_rows(tmp_path / "a.txt", T, X, order, first, cells))
    assert (recording.format, recording.up) == (name, up)
    np.testing.assert_allclose(recording.x, X, atol=1e-8)
    np.testing.assert_allclose(recording.t, T, atol=2e-6)
    if cells in (4, 8):
        np.testing.assert_array_equal(recording.confidence, 1.0)
    else:
        assert recording.confidence is None


@pytest.mark.parametrize("separator", [" ", ",", "\t", ";", ", ", "  "])
@pytest.mark.parametrize("end", [False, True])
def test_separators(tmp_path, separator, end):
    path = write_joint_rows(
        tmp_path / "a.txt", T, X, KINECT_V2, "ms", 4, separator=separator, end=separator if end else ""
    )
    np.testing.assert_allclose(read_recording(path).x, X, atol=1e-8)
    if separator in ";\t":
        path.write_text("# a remark\n" + path.read_text().replace(".", ","))
        np.testing.assert_allclose(read_recording(path).x, X, atol=1e-8)


def test_states_missing_cells_and_people(tmp_path):
    rows = [
        line.split(",")
        for line in write_joint_rows(tmp_path / "a", T, X, KINECT_V2, "ms", 4, separator=",").read_text().splitlines()
    ]
    wrist = 1 + 4 * KINECT_V2.index("WristLeft")
    rows[3][wrist : wrist + 4] = ["", "", "", "0"]
    rows[4][wrist + 3] = "1"
    recording = read_recording(save(tmp_path / "b", [",".join(row) for row in rows]))
    assert np.isnan(recording.x[3, 2]).all() and np.isnan(recording.x).sum() == 3
    np.testing.assert_array_equal(recording.confidence[3:6, 2], [0.0, 0.5, 1.0])
    both = [",".join([row[0], person, *row[1:]]) for row in rows for person in ("1", "0")]
    recording = read_recording(save(tmp_path / "c", both), body="0")
    assert len(recording.t) == len(T)
    np.testing.assert_allclose(recording.t, T, atol=1e-6)


def test_a_frame_number_and_a_time(tmp_path):
    lines = write_joint_rows(tmp_path / "a", T, X, KINECT_V1, "ms").read_text().splitlines()
    recording = read_recording(save(tmp_path / "b", [f"{10 + 2 * i} {line}" for i, line in enumerate(lines)]))
    np.testing.assert_array_equal(recording.frames, 10 + 2 * np.arange(len(T)))
    np.testing.assert_allclose(recording.t, T, atol=1e-6)


def test_frames_are_the_files_own_numbers(tmp_path):
    path = write_joint_rows(tmp_path / "a.txt", T, X, frames=100 + 4 * np.arange(len(T)), end=" ")
    recording = read_recording(path, frames=(104, 140))
    assert recording.format == "kinect_v1_rows"
    np.testing.assert_array_equal(recording.frames, np.arange(104, 141, 4))
    np.testing.assert_allclose(recording.t, recording.frames / 30.0)
    np.testing.assert_allclose(recording.x, X[1:11], atol=1e-8)
    hands = read_recording(path, joints={"left_wrist": "HandLeft"})
    np.testing.assert_allclose(hands.x[:, 2], 0.5)


def test_rows_refused(tmp_path):
    path = write_joint_rows(tmp_path / "a.txt", T, X)
    check_error("frames 0 to 60", path, frames=(70, 80))
    check_error("no joint 'Paw' for left_wrist; the file has HipCenter", path, joints={"left_wrist": "Paw"})
    check_error("give left_wrist one joint name", path, joints={"left_wrist": ("a", "b", "c")})
    lines = path.read_text().splitlines()
    check_error("line 6 has 60 columns, expected 61", save(path, [*lines[:5], lines[5].rsplit(" ", 1)[0], *lines[6:]]))
    check_error("line 62 has 62 columns, expected 61", save(path, [*lines, lines[0] + " 1"]))
    check_error(
        "line 2, column 14: 'x' is no number", save(path, [lines[0], lines[1].replace(lines[1].split()[13], "x", 1)])
    )
    # A damaged first line does not hide the format.
    check_error("line 1 has 3 columns, expected 61", save(path, ["1 2 3", *lines]))


@pytest.mark.parametrize("order", [WRISTS_FIRST, tuple(range(6))])
@pytest.mark.parametrize("first", [False, True])
@pytest.mark.parametrize("separator", [" ", "\t", ",", ";"])
def test_eighteen_numbers(tmp_path, order, first, separator):
    noisy = X + 0.01 * np.random.default_rng(0).normal(size=X.shape)
    recording = read_recording(write_points18(tmp_path / "a.txt", T, noisy, order, first, separator))
    assert recording.format == "points18"
    np.testing.assert_allclose(recording.x, noisy, atol=1e-8)
    np.testing.assert_allclose(recording.t, T, atol=1e-6)
    name = "wrists, elbows, shoulders" if order == WRISTS_FIRST else "left arm, right arm"
    assert any(sentence.startswith(f"order: {name}, in which lengths change by") for sentence in recording.evidence)


def test_the_order_shows_in_few_moving_samples_and_through_jumps(tmp_path):
    still = np.concatenate([np.repeat(X[:1], 3000, axis=0), X])
    still[::50, 2] += 1.0
    t = np.arange(len(still)) / 30.0
    for order in (WRISTS_FIRST, tuple(range(6))):
        np.testing.assert_allclose(read_recording(write_points18(tmp_path / "a", t, still, order)).x, still, atol=1e-8)


def test_missing_points_and_swapped_names_of_eighteen(tmp_path):
    holes = X.copy()
    holes[4] = np.nan
    recording = read_recording(write_points18(tmp_path / "a", T, holes, separator=","))
    np.testing.assert_allclose(recording.x, holes, atol=1e-8)
    swap = {"left_wrist": "right_wrist", "right_wrist": "left_wrist"}
    swapped = read_recording(write_points18(tmp_path / "b", T, X), joints=swap)
    np.testing.assert_allclose(swapped.x[:, 2], X[:, 5], atol=1e-8)
    lines = (tmp_path / "b").read_text().splitlines()
    check_error("line 3 has 19 columns, expected 18", save(tmp_path / "c", [*lines[:2], lines[2] + " 1", *lines[3:]]))
