import sys

import numpy as np
import pytest
from file_samples import write_c3d
from synthetic_carry import carry

from drake_blfdmp.demonstration.formats import read_recording
from drake_blfdmp.demonstration.formats.mocap.c3d_markers import C3dMarkers
from drake_blfdmp.demonstration.formats.mocap.marker_pairs import between, find_pairs
from drake_blfdmp.errors import RecordingError

T, X = carry(duration=2.0, rate=100.0)
HOLES = X.copy()
HOLES[5, 2] = HOLES[9] = np.nan
PLUG_IN_GAIT = ("LSHO", "LELB", "LWRA", "LWRB", "RSHO", "RELB", "RWRA", "RWRB")


def said(recording):
    return " | ".join(recording.evidence)


def check_error(text, path, **options):
    with pytest.raises(RecordingError) as caught:
        read_recording(path, **options)
    assert text in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("analog", [0, 3])
@pytest.mark.parametrize(("integers", "error"), [(False, 1e-6), (True, 6e-5)])
def test_round_trip(tmp_path, integers, error, analog):
    pytest.importorskip("c3d")
    path = write_c3d(tmp_path / "a", T, HOLES, integers=integers, analog=analog, first=17)
    recording = read_recording(path)
    assert (recording.format, recording.up) == ("c3d", "z")
    np.testing.assert_allclose(recording.x, HOLES, atol=error)
    np.testing.assert_allclose(recording.t - recording.t[0], T, atol=1e-6)
    np.testing.assert_array_equal(recording.frames, 17 + np.arange(len(T)))
    assert "unit: mm, the file or its format says" in said(recording)
    assert "frame numbers at 100 a second, by its format" in said(recording)


def test_files_that_contradict_themselves(tmp_path):
    pytest.importorskip("c3d")
    recording = read_recording(write_c3d(tmp_path / "a", T, X, header_rate=99.5, promised=250, y_screen="up"))
    np.testing.assert_allclose(recording.x, X, atol=1e-6)
    assert recording.up is None
    assert "promises 250 frames, the file holds 201" in said(recording)
    metres = read_recording(write_c3d(tmp_path / "b", T, X, unit="mm", scale=1.0))
    np.testing.assert_allclose(metres.x, X, atol=1e-6)
    assert "unit: m, for upper arms" in said(metres)


@pytest.mark.parametrize("dimensions", [6, 3])
@pytest.mark.parametrize("changed", [{0: 0}, {2: 0}], ids=["no bytes each", "no characters each"])
def test_labels_that_promise_more_than_there_is(tmp_path, dimensions, changed):
    """Letters taken for dimensions promise 3e9 labels of no bytes, which would fill any memory before they end."""
    pytest.importorskip("c3d")
    path = write_c3d(tmp_path / "a", T, X)
    content = bytearray(path.read_bytes())
    start = content.index(b"LABELS") + len(b"LABELS") + 2  # Bytes each, number of dimensions, dimensions.
    for place, value in {1: dimensions, **changed}.items():
        content[start + place] = value
    path.write_bytes(content)
    check_error("POINT:LABELS of ", path)


def test_wrists_between_two_markers(tmp_path):
    pytest.importorskip("c3d")
    half = np.array([0.03, 0.0, 0.01])
    x = np.stack([X[:, 0], X[:, 1], X[:, 2] + half, X[:, 2] - half, *X[:, 3:5].swapaxes(0, 1)], axis=1)
    x = np.concatenate([x, X[:, 5:] + half, X[:, 5:] - half], axis=1)
    x[8, 2] = np.nan
    labels = tuple(f"Anna:{label}" for label in PLUG_IN_GAIT)
    recording = read_recording(write_c3d(tmp_path / "a", T, x, labels))
    expected = X.copy()
    expected[8, 2] = np.nan
    np.testing.assert_allclose(recording.x, expected, atol=1e-6)
    assert "left_wrist between Anna:LWRA and Anna:LWRB" in said(recording)
    alone = read_recording(tmp_path / "a", joints={"left_wrist": "Anna:LWRB"})
    np.testing.assert_allclose(alone.x[:, 2], X[:, 2] - half, atol=1e-6)
    np.testing.assert_allclose(alone.x[:, 5], X[:, 5], atol=1e-6)


def test_a_pair_rarely_seen_whole_is_its_better_marker():
    a, b = np.zeros((10, 3)), np.ones((10, 3))
    np.testing.assert_array_equal(between(a, b), 0.5)
    b[2:] = np.nan
    np.testing.assert_array_equal(between(a, b), a)
    np.testing.assert_array_equal(between(b, a), a)


def test_pairs_of_other_marker_sets():
    names = ("L_WRIST_IN", "L_WRIST_OUT", "RRSP", "RUSP", "Left_Elbow_Lat", "Left_Elbow_Med", "RWRA")
    assert find_pairs(names) == {
        "left_wrist": ("L_WRIST_IN", "L_WRIST_OUT"),
        "right_wrist": ("RRSP", "RUSP"),
        "left_elbow": ("Left_Elbow_Lat", "Left_Elbow_Med"),
    }


def test_several_people_and_hundreds_of_markers(tmp_path):
    pytest.importorskip("c3d")
    arm = ("LSHO", "LELB", "LWRI", "RSHO", "RELB", "RWRI")
    still = np.broadcast_to(X[:1], X.shape) + 1.0
    labels = (*(f"*{i}" for i in range(300)), *(f"{who}:{name}" for who in ("Ben", "Anna") for name in arm))
    x = np.concatenate([np.ones((len(T), 300, 3)), still, X], axis=1)
    path = write_c3d(tmp_path / "a", T, x, labels)
    recording = read_recording(path)
    np.testing.assert_allclose(recording.x, X, atol=1e-6)
    assert "person: Anna of 2" in said(recording)
    np.testing.assert_allclose(read_recording(path, body="Ben").x, still, atol=1e-6)


def test_refused(tmp_path, monkeypatch):
    pytest.importorskip("c3d")
    path = write_c3d(tmp_path / "a", T, X)
    check_error(
        "nothing is named like left_wrist",
        write_c3d(tmp_path / "b", T, X, ("LSHO", "LELB", "Paw", "RSHO", "RELB", "RWRI")),
    )
    check_error("no joint 'Paw' for left_wrist; the file has LSHO", path, joints={"left_wrist": "Paw"})
    check_error("give left_wrist one name", path, joints={"left_wrist": ("LSHO", "LELB", "RELB")})
    data = path.read_bytes()
    path.write_bytes(data[:700])
    check_error("damaged C3D", path)
    path.write_bytes(data[:1024])
    check_error("no samples", path)
    path.write_bytes(data[:2] + b"\0\0" + data[4:])
    assert read_recording(path).x.shape == X.shape  # The parameters count, not the header.
    monkeypatch.setitem(sys.modules, "c3d", None)
    check_error("pip install 'drake_blfdmp[c3d]'", path)


def test_sniff():
    sniff = C3dMarkers().sniff
    assert not sniff(b"\x02\x50" + b"\0" * 400)
    assert not sniff(b"\x02\x50" + b"\0" * 1000)
    assert sniff(b"\x02\x50" + b"\0" * 510 + b"\1\x50\3\x54" + b"\0" * 10)
    assert not sniff(b"HP text " * 200)
