import numpy as np
import pytest
from synthetic_carry import carry
from text_samples import save, write_ntu_skeleton

from drake_blfdmp.demonstration.formats import read_recording
from drake_blfdmp.errors import RecordingError

T, X = carry(duration=1.0)
FRAME = 28  # Lines of a frame with one person.


def check_error(said, path, **options):
    with pytest.raises(RecordingError) as caught:
        read_recording(path, **options)
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


def test_one_person_with_states(tmp_path):
    recording = read_recording(write_ntu_skeleton(tmp_path / "a.skeleton", T, X))
    assert (recording.format, recording.up) == ("ntu_skeleton", "y")
    np.testing.assert_allclose(recording.x, X, atol=1e-8)
    np.testing.assert_allclose(recording.t, T)
    np.testing.assert_array_equal(recording.confidence, np.tile([1, 1, 0.5, 1, 1, 1], (len(T), 1)))


def test_several_people_and_frames_without(tmp_path):
    path = write_ntu_skeleton(tmp_path / "a", T, X, people=("72057594037931101", "72057594037931102"), empty=(0, 1, 5))
    recording = read_recording(path)
    present = np.array([frame for frame in range(len(T)) if frame not in (0, 1, 5)])
    np.testing.assert_array_equal(recording.frames, present)
    np.testing.assert_allclose(recording.t, present / 30.0)
    np.testing.assert_allclose(recording.x, X[present], atol=1e-8)
    assert "3 frames hold no person" in recording.evidence
    assert any("person: 72057594037931101 of 2" in sentence for sentence in recording.evidence)
    np.testing.assert_allclose(read_recording(path, body="72057594037931102").x, 0.9 * X[present], atol=1e-8)


def test_nobody(tmp_path):
    check_error("holds no person", write_ntu_skeleton(tmp_path / "a", T, X, empty=range(len(T))))


def test_joints_can_be_named(tmp_path):
    path = write_ntu_skeleton(tmp_path / "a", T, X)
    np.testing.assert_allclose(read_recording(path, joints={"left_wrist": "HandTipLeft"}).x[:, 2], 0.5)
    check_error("no joint 'Paw'", path, joints={"left_wrist": "Paw"})
    check_error("give left_wrist one joint name", path, joints={"left_wrist": ("a", "b", "c")})


def test_refused(tmp_path):
    path = write_ntu_skeleton(tmp_path / "a", T, X)
    lines = path.read_bytes().decode().split("\r\n")[:-1]
    assert len(lines) == 1 + FRAME * len(T)

    def changed(number, line):
        return save(path, [*lines[: number - 1], *([line] if line is not None else []), *lines[number:]])

    check_error("ends after line 100, expected the lines of 25 joints", save(path, lines[:100]))
    check_error("expected the number of people in frame 31 of 2147483648", changed(1, "2147483648"))
    check_error("more lines follow the 30 frames that the file promises", changed(1, "30"))
    check_error("line 1: '-1' is not the number of frames", changed(1, "-1"), format="ntu_skeleton")
    check_error(f"line 1: '{'9' * 40}' is not the number of frames", changed(1, "9" * 400), format="ntu_skeleton")
    check_error("line 32: a person of other than 25 joints", changed(32, "24"))
    check_error("line 37: 2 cells, expected a joint's 12 numbers", changed(37, "0.1 0.2"))
    check_error("line 37: not the 12 numbers of ShoulderLeft", changed(37, "  ".join(lines[36].split()[1:3]) + 9 * " "))
    check_error("line 40: 11 cells, expected a joint's 12 numbers", changed(40, lines[39].rsplit(" ", 1)[0]))
    check_error("line 37: not the 12 numbers of ShoulderLeft", changed(37, lines[36].replace("0.", "O.", 1)))
    check_error("line 31: 9 cells, expected a person's ten numbers", changed(31, lines[30].rsplit(" ", 1)[0]))
    assert len(read_recording(changed(40, lines[39].replace(" ", "\t "))).t) == len(T)
    check_error("line 57: 1 cells, expected a joint's 12 numbers", changed(40, None))
    save(path, [*lines[:39], lines[38], *lines[39:]])
    check_error("line 58: 12 cells, expected the number of people in frame 2", path)
