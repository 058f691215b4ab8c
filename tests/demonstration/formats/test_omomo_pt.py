import zipfile

import numpy as np
import pytest
from file_samples import write_omomo_pt
from synthetic_carry import SHARED, carry

from drake_blfdmp.demonstration.bones import link_lengths
from drake_blfdmp.demonstration.formats import read_recording
from drake_blfdmp.demonstration.formats.mocap.omomo_pt import JOINTS
from drake_blfdmp.errors import RecordingError

T, X = carry(duration=2.0)
X[7, 2] = np.nan


def check_error(text, path, **options):
    with pytest.raises(RecordingError) as caught:
        read_recording(path, **options)
    assert text in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("order", ["<", ">"])
def test_round_trip(tmp_path, order):
    recording = read_recording(write_omomo_pt(tmp_path / "a", T, X, order=order))
    assert (recording.format, recording.up) == ("omomo_pt", "z")
    np.testing.assert_allclose(recording.x, X, atol=1e-7)
    np.testing.assert_allclose(recording.t, T)
    assert "unit: m, the file or its format says" in recording.evidence[0]
    assert "30 a second, by its format" in recording.evidence[1]


def test_joints():
    assert len(JOINTS) == 52
    assert [JOINTS.index(f"{side}_{part}") for side in "LR" for part in ("Shoulder", "Elbow", "Wrist")] == [
        *range(15, 18),
        *range(34, 37),
    ]


def test_joints_by_name(tmp_path):
    recording = read_recording(write_omomo_pt(tmp_path / "a", T, X), joints={"left_wrist": "R_Wrist"})
    np.testing.assert_array_equal(recording.x[:, 2], recording.x[:, 5])


def test_refused(tmp_path):
    path = tmp_path / "a"
    check_error("only the layout of OMOMO", write_omomo_pt(path, T, X, columns=590))
    check_error("only the layout of OMOMO", write_omomo_pt(path, T, X, storage="DoubleStorage"))
    check_error("only the layout of OMOMO", write_omomo_pt(path, T[:0], X[:0]))
    check_error("a compressed archive", write_omomo_pt(path, T, X, compression=zipfile.ZIP_DEFLATED))
    check_error("no joint 'Paw'", write_omomo_pt(path, T, X), joints={"left_wrist": "Paw"})
    data = path.read_bytes()
    path.write_bytes(data[: len(data) // 2])
    check_error("damaged PyTorch file", path)
    flipped = bytearray(data)
    flipped[len(data) // 2] ^= 1
    path.write_bytes(flipped)
    check_error("damaged PyTorch file (BadZipFile: Bad CRC-32", path)
    with zipfile.ZipFile(write_omomo_pt(path, T, X), "a") as archive:
        archive.writestr("a/data/1", b"1234")
    check_error("no PyTorch file of one tensor", path)
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("word/document.xml", "<a/>")
    check_error("no known format", path)


def test_the_pickle_is_never_executed(tmp_path):
    path, canary = tmp_path / "a", tmp_path / "canary"
    program = b"cos\nsystem\n(S'touch " + str(canary).encode() + b"'\ntR.FloatStorage"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("a/data.pkl", program)
        archive.writestr("a/data/0", np.ones((4, 591), "<f4").tobytes())
    assert len(read_recording(path).t) == 4
    assert not canary.exists()


def test_real_file_is_its_own_csv():
    folder = SHARED / "omomo_largebox"
    if not folder.is_dir():
        pytest.skip(f"{folder} is not here")
    recording = read_recording(folder / "sub3_largebox_003.pt")
    table = read_recording(folder / "sub3_largebox_003_extracted.csv")
    assert recording.x.shape == (196, 6, 3)
    np.testing.assert_allclose(recording.x, table.x, atol=6e-6)
    np.testing.assert_allclose(recording.t, table.t, atol=1e-5)
    lengths = link_lengths(recording.x)
    np.testing.assert_allclose(np.ptp(lengths[:, [0, 1, 3, 4]], axis=0), 0.0, atol=2e-6)
    held = lengths[recording.x[:, [2, 5], 2].min(axis=1) > 1.0, 2]
    assert abs(held.mean() - 0.385) < 0.008
