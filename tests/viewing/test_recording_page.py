import numpy as np
import pytest
from browser import needs_browser, open_at
from synthetic_carry import carry, recording

from drake_blfdmp.demonstration.cleaning import CleaningOptions
from drake_blfdmp.demonstration.health import examine
from drake_blfdmp.errors import RecordingError
from drake_blfdmp.viewing.meshcat_scene import start_meshcat
from drake_blfdmp.viewing.recording_page import write_recording_page

T, X = carry()


@pytest.fixture(scope="module")
def meshcat():
    return start_meshcat(port=0)


@pytest.fixture(scope="module")
def page(meshcat, tmp_path_factory):
    x = X.copy()
    stretched = (T > 4.9) & (T < 5.6)  # The left forearm grows by a fifth, gently: no jump, but off.
    x[stretched, 2] += 0.2 * (x[stretched, 2] - x[stretched, 1])
    examined = examine(recording(T, x), CleaningOptions(speed_limit=1000.0))
    return write_recording_page(examined, tmp_path_factory.mktemp("page") / "a.html", meshcat)


def test_it_is_one_small_page_that_says_what_it_shows(page):
    text = page.read_text(encoding="utf-8")
    assert page.stat().st_size < 5e6
    assert "test.csv: held in both hands" in text and "bone at its usual length" in text


@needs_browser
def test_the_box_is_there_only_while_it_is_held_and_a_bone_off_its_length_is_marked(page, tmp_path):
    seen = {}
    for time in (0.1, 3.0, 5.3):
        directory = tmp_path / str(time)
        directory.mkdir()
        pixels, errors = open_at(page, time, directory)
        assert not errors
        assert pixels.std() > 0.05, "blank"
        seen[time] = pixels[30:, 240:]
    warm = {time: int(np.sum(pixels[..., 0] - pixels[..., 2] > 0.1)) for time, pixels in seen.items()}  # Box, marks.
    green = {time: int(np.sum(pixels[..., 1] - pixels[..., 0] > 0.2)) for time, pixels in seen.items()}
    assert min(green.values()) > 200, "no skeleton"
    assert warm[0.1] < 20, "a box before it is held, or a mark on a good bone"
    assert warm[3.0] > 2000, "no box while it is held"
    assert 50 < warm[5.3] < 1000, "the long forearm is not marked, or the box is still there"


def test_a_recording_that_was_refused_has_no_page(meshcat, tmp_path):
    x = X.copy()
    x[:, 4] = np.nan
    with pytest.raises(RecordingError, match=r"^test.csv: no page: right_elbow is missing in every frame"):
        write_recording_page(examine(recording(T, x)), tmp_path / "a.html", meshcat)
    assert not (tmp_path / "a.html").exists()
