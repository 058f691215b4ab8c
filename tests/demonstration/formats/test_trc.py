import numpy as np
import pytest
from synthetic_carry import carry
from text_samples import SHORT, TURKISH, save, write_trc

from drake_blfdmp.demonstration.formats import read_recording
from drake_blfdmp.errors import RecordingError
from drake_blfdmp.skeleton import POINTS

T, X = carry(duration=2.0)
VICON = ("Anna:LSHO", "Anna:LELB", "Anna:LWRA", "Anna:RSHO", "Anna:RELB", "Anna:RWRA")
MOTIVE = ("LShoulderTop", "LElbowOut", "LWristOut", "RShoulderTop", "RElbowOut", "RWristOut")


def check_error(said, path, **options):
    with pytest.raises(RecordingError) as caught:
        read_recording(path, **options)
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("header", [False, True])
@pytest.mark.parametrize("names", [TURKISH, SHORT, POINTS, VICON, MOTIVE])
@pytest.mark.parametrize("spaced", [False, True])
def test_trc(tmp_path, header, names, spaced):
    holes = X.copy()
    holes[3:9, 4] = np.nan
    holes[20, 5] = np.nan
    recording = read_recording(write_trc(tmp_path / "a.trc", T, holes, names, header, spaced=spaced))
    assert recording.format == "trc"
    np.testing.assert_allclose(recording.x, holes, atol=1e-8)
    np.testing.assert_allclose(recording.t, T, atol=1e-8)
    np.testing.assert_array_equal(recording.frames, np.arange(1, len(T) + 1))


@pytest.mark.parametrize(("unit", "scale"), [("m", 1.0), ("cm", 100.0), ("mm", 1000.0), ("meters", 1.0)])
def test_units(tmp_path, unit, scale):
    recording = read_recording(write_trc(tmp_path / "a", T, X, unit=unit, scale=scale))
    np.testing.assert_allclose(recording.x, X, atol=1e-8)
    assert "the file or its format says" in recording.evidence[0]


def test_lost_last_cells_and_unnamed_markers(tmp_path):
    path = write_trc(tmp_path / "a.trc", T, X, header=False)
    lines = path.read_text().splitlines()
    lines[4] = "\t".join(lines[4].split("\t")[:-3])
    recording = read_recording(save(path, lines))
    assert np.isnan(recording.x[2, 5]).all() and np.isnan(recording.x).sum() == 3
    # A marker without a name between the others, and one after them.
    lines = path.read_text().splitlines()
    for row, line in enumerate(lines):
        cells = line.split("\t") + [""] * (20 - len(line.split("\t")))
        more = ["", "", ""] if row == 0 else ["X9", "Y9", "Z9"] if row == 1 else ["7", "8", "9"]
        lines[row] = "\t".join(cells[:5] + more + cells[5:] + more)
    np.testing.assert_allclose(read_recording(save(path, lines)).x, recording.x)


def test_the_data_rate_is_the_clock_without_times(tmp_path):
    t, x = carry(duration=1.0, rate=120.0)
    recording = read_recording(write_trc(tmp_path / "a.trc", t, x, times=False))
    np.testing.assert_allclose(recording.t, recording.frames / 120.0)
    lines = (tmp_path / "a.trc").read_text().splitlines()
    no_column = [line.replace("Frame#\tTime\t", "Frame#\t").replace("\t\t", "\t", 1) for line in lines]
    recording = read_recording(save(tmp_path / "b.trc", no_column))
    np.testing.assert_allclose(recording.t, recording.frames / 120.0)
    np.testing.assert_allclose(recording.x, x, atol=1e-8)


def test_blanks_for_tabs_and_no_labels(tmp_path):
    path = write_trc(tmp_path / "a.trc", T, X, labels=False)
    np.testing.assert_allclose(read_recording(path).x, X, atol=1e-8)
    path.write_text(path.read_text().replace("\t", "   "))
    recording = read_recording(path)
    assert recording.format == "trc"
    np.testing.assert_allclose(recording.x, X, atol=1e-8)


def test_a_table_that_begins_with_frame_and_time_is_no_trc(tmp_path):
    names = [f"{name} {axis}" for name in SHORT for axis in "XYZ"]
    rows = ["\t".join([str(i), repr(float(T[i])), *map(repr, map(float, X[i].ravel()))]) for i in range(len(T))]
    recording = read_recording(save(tmp_path / "a.tsv", ["\t".join(["Frame", "Time", *names]), *rows]))
    assert recording.format == "wide_csv"
    np.testing.assert_array_equal(recording.x, X)


def test_refused(tmp_path):
    path = write_trc(tmp_path / "a.trc", T, X, header=False)
    check_error("no joint 'kol'", path, joints={"left_wrist": "kol"})
    check_error("give left_wrist one name", path, joints={"left_wrist": ("a", "b", "c")})
    check_error("frames 1 to 61", path, frames=(0, 0))
    lines = path.read_text().splitlines()
    check_error("line 64 has 21 columns, expected 20", save(path, [*lines, lines[-1] + "\t7"]))
    check_error("line 64, column Time: 'x", save(path, [*lines, lines[-1].replace("\t", "\tx", 1)]))
    check_error("line 64, column Frame#: no whole number", save(path, [*lines, lines[-1].replace("61", "1e300", 1)]))
    check_error("no samples", save(path, lines[:2]))
