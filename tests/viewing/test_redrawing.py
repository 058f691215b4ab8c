"""Figures drawn again from a study's file: whole, of other versions, damaged, and of no study at all."""

import json

import numpy as np
import pytest

from drake_blfdmp.errors import BlfDmpError
from drake_blfdmp.recording.mcap_file import McapFile, RecorderError
from drake_blfdmp.recording.plain_data import npz_bytes
from drake_blfdmp.viewing.drawing import Drawing
from drake_blfdmp.viewing.redrawing import draw_study, read_study, redraw_study
from drake_blfdmp.viewing.study_figures.random_problems import first_times

DRAWING = Drawing(first_times, {"none": np.array([0.1, 0.4])})
NEWER = {
    "figures/newer.json": json.dumps({"drawn_by": "study_figures.tomorrow.map", "from": {"map": []}}).encode(),
    "figures/newer.npz": npz_bytes({}),
}
ODD = {
    "figures/odd.json": json.dumps(
        {"drawn_by": "study_figures.random_problems.first_times", "from": {"map": [["relative", {"map": [["x", 1]]}]]}}
    ).encode(),
    "figures/odd.npz": npz_bytes({}),
}


def write(path, *, record="study", others=()):
    file = McapFile(path)
    file.add_metadata(record, {"version_drake_blfdmp": "9.8.7"})
    parts = {name: data for name, (data, _) in DRAWING.attachments("first").items()}
    for some in others:
        parts |= some
    parts |= {name: data for name, (data, _) in DRAWING.attachments("second").items()}
    for name, data in parts.items():
        file.add_attachment(name, data, "application/octet-stream")
    file.close()
    return path


def test_every_figure_is_drawn_as_png_and_svg(tmp_path):
    told = []
    path = write(tmp_path / "study.mcap")
    files = redraw_study(path, tmp_path / "new" / "folder", lambda what, share: told.append((what, share)))
    assert [file.name for file in files] == ["first.png", "first.svg", "second.png", "second.svg"]
    assert all(file.is_file() for file in files)
    assert files[0].read_bytes() == files[2].read_bytes()
    assert told == [("drawing first", 0.0), ("drawing second", 0.5), ("drawing", 1.0)]
    (tmp_path / "drawn").mkdir()
    assert draw_study(read_study(path).attachments, tmp_path / "drawn") == {"first": 3.5, "second": 3.5}
    assert (tmp_path / "drawn" / "first.svg").read_bytes() == files[1].read_bytes()


def test_what_this_version_cannot_draw_is_said_in_one_line_and_the_rest_is_drawn(tmp_path):
    path = write(tmp_path / "study.mcap", others=(NEWER, ODD))
    with pytest.raises(BlfDmpError) as caught:
        redraw_study(path, tmp_path / "out")
    line = str(caught.value)
    assert line.startswith(f"{path}, written by drake_blfdmp 9.8.7: figure 'newer': this version has no drawing ")
    assert "'study_figures.tomorrow.map'; use a newer drake_blfdmp; figure 'odd': TypeError: " in line
    assert "\n" not in line
    names = {file.name for file in (tmp_path / "out").iterdir()}
    assert names == {"first.png", "first.svg", "second.png", "second.svg"}


def test_nothing_is_overwritten(tmp_path):
    path = write(tmp_path / "study.mcap")
    (tmp_path / "second.svg").write_text("mine")
    with pytest.raises(BlfDmpError, match="second.svg: exists already"):
        redraw_study(path, tmp_path)
    assert (tmp_path / "second.svg").read_text() == "mine"
    assert not (tmp_path / "first.png").exists()
    with pytest.raises(BlfDmpError, match="figures cannot be written to"):
        redraw_study(path, tmp_path / "second.svg" / "below")


def test_files_of_no_study_are_refused(tmp_path):
    with pytest.raises(RecorderError, match="holds no study"):
        redraw_study(write(tmp_path / "run.mcap", record="run"), tmp_path / "out")
    with pytest.raises(RecorderError, match="cannot be read"):
        redraw_study(tmp_path / "nowhere.mcap", tmp_path / "out")
    (tmp_path / "text.mcap").write_text("no recording at all")
    with pytest.raises(RecorderError, match="not an MCAP file"):
        redraw_study(tmp_path / "text.mcap", tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_damaged_file_is_said_to_be_damaged_wherever_it_is(tmp_path):
    whole = write(tmp_path / "study.mcap").read_bytes()
    end = whole.rindex(b"figures/second.npz", 0, len(whole) - 600)
    for i, place in enumerate(range(60, end, max(1, end // 40))):
        for kind, data in (("flipped", whole[:place] + bytes([whole[place] ^ 0x10]) + whole[place + 1 :]),
                           ("cut", whole[:place])):  # fmt: skip
            path = tmp_path / f"{kind}-{i}.mcap"
            path.write_bytes(data)
            with pytest.raises(RecorderError) as caught:
                read_study(path)
            assert str(path) in str(caught.value) and "\n" not in str(caught.value)
