"""`run.py playback` as a person uses it."""

import os
import re
import signal
import subprocess
import sys
import urllib.request
from pathlib import Path

import pytest
from made_files import poke

from drake_blfdmp.errors import BlfDmpError
from drake_blfdmp.viewing.playback import video
from drake_blfdmp.viewing.playback.server import PageServer

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    return poke(tmp_path_factory.mktemp("play") / "poke.mcap", 1.0)


def refused(command_line, capsys, *arguments):
    """The one line that a command is refused with."""
    assert command_line.main(["playback", *map(str, arguments)]) == 2
    lines = [line for line in capsys.readouterr().err.splitlines() if not line.endswith(" ...")]
    assert len(lines) == 1 and lines[0].startswith("run.py: "), lines
    return lines[0]


def test_a_page_is_written_and_nothing_is_served(command_line, capsys, file, tmp_path):
    page = tmp_path / "page.html"
    assert command_line.main(["playback", str(file), "--html", str(page), "--speed", "0.5"]) == 0
    assert capsys.readouterr().out.startswith(f"page: {page}, ")
    assert '"speed":0.5' in page.read_text(encoding="utf-8")


def test_a_run_s_page_is_small_and_shows_all_of_it(command_line, default_run, tmp_path):
    page = tmp_path / "page.html"
    assert command_line.main(["playback", str(default_run.folder / "run.mcap"), "--html", str(page)]) == 0
    assert page.stat().st_size < 5e6
    text = page.read_text(encoding="utf-8")
    for part in (
        "left_arm_palm",
        "right_arm_palm",
        "/box/",
        "/table/",
        "person/left_wrist",
        "band/left/sleeve",
        '"text":"lift"',
    ):
        assert part in text, part


def test_bad_input_gets_one_line(command_line, capsys, file, tmp_path, monkeypatch):
    (tmp_path / "text.mcap").write_text("no recording")
    assert "is no MCAP file" in refused(command_line, capsys, tmp_path / "text.mcap", "--html", tmp_path / "a.html")
    assert "No such file" in refused(command_line, capsys, tmp_path / "none.mcap", "--no-open")
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(file.read_bytes()[:-2000])
    assert f"python run.py recover {cut}" in refused(command_line, capsys, cut, "--no-open")
    taken = tmp_path / "taken.html"
    taken.write_text("mine")
    assert "exists already" in refused(command_line, capsys, file, "--html", taken)
    assert taken.read_text() == "mine"
    assert "does not exist" in refused(command_line, capsys, file, "--html", tmp_path / "none" / "page.html")
    assert "is not before" in refused(
        command_line, capsys, file, "--from", 0.5, "--to", 0.25, "--html", tmp_path / "a.html"
    )
    assert "out of range" in refused(command_line, capsys, file, "--speed", -1, "--html", tmp_path / "a.html")
    assert "port" in refused(command_line, capsys, file, "--port", 70000, "--no-open")
    assert ".mp4 or .gif" in refused(command_line, capsys, file, "--video", tmp_path / "a.avi")
    monkeypatch.setenv("PATH", str(tmp_path))
    assert "ffmpeg is not on the path" in refused(command_line, capsys, file, "--video", tmp_path / "a.mp4")
    assert not list(tmp_path.glob("a.*"))


def test_a_partial_file_plays_with_a_warning(command_line, capsys, file, tmp_path):
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(file.read_bytes()[:-20000])
    assert command_line.main(["playback", str(cut), "--partial", "--html", str(tmp_path / "page.html")]) == 0
    assert "warning: " in (error := capsys.readouterr().err) and "what stands before is played" in error


@pytest.mark.skipif(os.name == "nt", reason="no signals there")
def test_it_serves_this_machine_until_it_is_interrupted(file):
    command = [sys.executable, str(ROOT / "run.py"), "playback", str(file), "--no-open", "--port", "0"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        said = process.stdout.readline()
        url = re.search(r"http://127\.0\.0\.1:\d+/", said).group()
        with urllib.request.urlopen(url, timeout=30) as answer:
            assert answer.headers["Content-Type"].startswith("text/html")
            assert b'id="recording"' in answer.read()
        with pytest.raises(urllib.error.HTTPError, match="404"):
            urllib.request.urlopen(url + "../etc/passwd", timeout=30)
        process.send_signal(signal.SIGINT)
        process.wait(30)
        assert process.returncode == 0 and "Traceback" not in process.stderr.read()
    finally:
        process.kill()
        process.communicate()


def test_a_port_that_is_taken_is_refused():
    with PageServer("page", 0) as server, pytest.raises(BlfDmpError, match="name another with --port"):
        PageServer("page", server.server_address[1])


def test_a_video_needs_a_browser_too(file, tmp_path, monkeypatch):
    monkeypatch.setattr(video, "find_browser", lambda: None)
    monkeypatch.setattr(video.shutil, "which", lambda name: "/bin/true")
    with pytest.raises(BlfDmpError, match="no browser on the path"):
        video.check_video(tmp_path / "a.gif")
