"""`run.py convert` as a person uses it."""

import numpy as np
import pytest
from text_samples import write_trc

from drake_blfdmp.demonstration.formats import read_recording


@pytest.fixture
def motion(tmp_path, person):
    t, x = person
    x = x.copy()
    x[20:25, 1] = np.nan
    return write_trc(tmp_path / "motion.trc", t, x), t, x


@pytest.mark.parametrize("suffix", [".csv", ".mcap"])
def test_what_was_recorded_is_what_is_written(motion, suffix, tmp_path, command_line, capsys):
    path, t, x = motion
    out = tmp_path / f"out{suffix}"
    assert command_line.main(["convert", str(path), str(out), "--frames", "5:200"]) == 0
    said = capsys.readouterr().out
    assert "unit: mm" in said and f"{out}: 196 frames" in said
    written = read_recording(out)
    np.testing.assert_allclose(written.x, x[4:200], atol=1e-6)
    np.testing.assert_allclose(written.t, t[4:200], atol=1e-6)
    np.testing.assert_array_equal(written.frames, np.arange(5, 201))


def test_a_cleaned_copy_has_no_gaps(motion, tmp_path, command_line):
    path, _, x = motion
    assert command_line.main(["convert", str(path), str(tmp_path / "out.csv"), "--clean"]) == 0
    cleaned = read_recording(tmp_path / "out.csv")
    assert np.isfinite(cleaned.x).all()
    np.testing.assert_allclose(cleaned.x[60], x[60], atol=1e-6)


def test_nothing_is_overwritten_and_odd_names_are_refused(motion, tmp_path, command_line, capsys):
    path, _, _ = motion
    before = path.read_bytes()
    for out, message in (
        (path, "give a name that ends in .csv or .mcap"),
        (tmp_path / "a.xlsx", "give a name that ends in .csv or .mcap"),
        (tmp_path / "nowhere" / "a.csv", "make it first"),
    ):
        assert command_line.main(["convert", str(path), str(out)]) == 2
        said = [line for line in capsys.readouterr().err.splitlines() if line.startswith("run.py: ")]
        assert len(said) == 1 and message in said[0]
    (tmp_path / "there.csv").write_text("mine")
    assert command_line.main(["convert", str(path), str(tmp_path / "there.csv")]) == 2
    assert "nothing is overwritten" in capsys.readouterr().err
    assert (tmp_path / "there.csv").read_text() == "mine" and path.read_bytes() == before
