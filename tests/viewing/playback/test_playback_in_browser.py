"""A played file, opened in a headless browser as a person would open it."""

import shutil
import subprocess

import numpy as np
import pytest
from browser import coloured, needs_browser, open_at

from drake_blfdmp.viewing.playback.page import render_page
from drake_blfdmp.viewing.playback.player import make_sheet
from drake_blfdmp.viewing.playback.reading import read_played
from drake_blfdmp.viewing.playback.video import find_browser, write_video

# What a person does with the bar, done by the page's own elements; what goes wrong is reported as an error.
_USE_THE_BAR = """
const expect = (what, is, should) => { if (is !== should) console.error(what + ": " + is + ", not " + should); };
const bar = (id) => document.getElementById(id);
playback.pause();
bar("time").value = 3;
bar("time").dispatchEvent(new Event("input"));
expect("time after the slider", playback.time(), 3);
expect("mixer", viewer.animator.actions[0].time, 3);
expect("caption", bar("caption").textContent, "let go");
expect("clock", bar("clock").textContent, "3.00 / 4.00 s");
expect("marks", bar("marks").children.length, 2);
bar("marks").children[0].click();
expect("time after a mark", playback.time(), 0.5);
expect("caption", bar("caption").textContent, "contact");
bar("speed").value = "2";
bar("speed").dispatchEvent(new Event("change"));
expect("speed", viewer.animator.mixer.timeScale, 2);
bar("play").click();
expect("playing", viewer.animator.playing, true);
bar("play").click();
expect("playing", viewer.animator.playing, false);
window.dispatchEvent(new KeyboardEvent("keydown", { key: "End" }));
document.body.dispatchEvent(new KeyboardEvent("keydown", { key: "End", bubbles: true }));
expect("time after End", playback.time(), playback.duration);
const tool = viewer.scene_tree.find(["0", "robot0", "tool"]).object.getWorldPosition(new MeshCat.THREE.Vector3());
playback.seek(0);
const before = viewer.scene_tree.find(["0", "robot0", "tool"]).object.getWorldPosition(new MeshCat.THREE.Vector3());
if (tool.distanceTo(before) < 0.4) console.error("the tool moved by " + tool.distanceTo(before));
const asked = performance.getEntriesByType("resource").map((entry) => entry.name);
expect("requests", asked.filter((name) => !name.startsWith("data:")).join(), "");
"""


@pytest.fixture(scope="module")
def page(poked, tmp_path_factory):
    path = tmp_path_factory.mktemp("page") / "page.html"
    path.write_text(render_page(make_sheet([read_played(poked)])[0]), encoding="utf-8")
    return path


@needs_browser
def test_the_arm_moves_and_the_hands_link_leaves_its_band(page, tmp_path):
    seen = []
    for time in (0.2, 3.8):
        directory = tmp_path / str(time)
        directory.mkdir()
        # Legend and captions have the links' colours too.
        script = 'for (const id of ["legend", "caption"]) document.getElementById(id).remove();'
        pixels, errors = open_at(page, time, directory, script=script)
        assert not errors
        assert pixels.std() > 0.05, "blank"
        seen.append(pixels[30:-76])
    early, late = seen
    arm = [(p[..., 0] > 0.4) & (p[..., 1] < 0.12) & (p[..., 2] < 0.12) for p in seen]  # And the link outside, red too.
    assert min(mask.sum() for mask in arm) > 300, "no arm"
    assert np.mean(arm[0] != arm[1]) > 0.003, "the arm does not move"
    green = [(p[..., 1] > p[..., 0] + 0.25) & (p[..., 1] > p[..., 2] + 0.05) for p in seen]
    amber = [(p[..., 0] > p[..., 1] + 0.12) & (p[..., 1] > p[..., 2] + 0.3) for p in seen]
    sleeves = [(p[..., 2] > p[..., 0] + 0.25) & (p[..., 2] > p[..., 1] + 0.08) for p in seen]
    assert green[0].sum() > green[1].sum() + 40, "the hands' link stays green"
    assert min(mask.sum() for mask in amber) > 40, "no link near its band's edge"
    assert min(mask.sum() for mask in sleeves) > 100, "no sleeves"
    assert coloured(late, 1, 0, 1) > coloured(early, 1, 0, 1) + 30, "no arrow"


@needs_browser
def test_the_bar_works_and_nothing_is_asked_of_the_network(page, tmp_path):
    _, errors = open_at(page, 0.0, tmp_path, script=_USE_THE_BAR)
    assert not errors


@pytest.mark.skipif(shutil.which("ffmpeg") is None, reason="ffmpeg is not on the path")
@pytest.mark.skipif(find_browser() is None, reason="no browser on the path")
def test_a_gif_is_drawn_frame_by_frame(poked, tmp_path):
    sheet, _ = make_sheet([read_played(poked, start=0.0, end=4.0)], speed=16.0)
    path = tmp_path / "poke.gif"
    assert write_video(sheet, path) == 4
    done = subprocess.run(
        ["ffmpeg", "-v", "error", "-i", str(path), "-f", "rawvideo", "-pix_fmt", "rgb24", "-"],
        capture_output=True,
        check=True,
    )
    frames = np.frombuffer(done.stdout, dtype=np.uint8).reshape(-1, 404, 720, 3) / 255
    assert len(frames) == 4 and frames[0].std() > 0.05
    assert np.mean(np.abs(frames[0] - frames[3]).max(axis=-1) > 0.2) > 0.01, "nothing moves"
