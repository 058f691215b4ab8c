"""`run.py figures` as a person uses it."""

import shutil
from pathlib import Path

import pytest
from rewritten import rewrite

from drake_blfdmp.viewing.figures import FIGURES


@pytest.fixture
def file(default_run, tmp_path):
    """The default run's recording, in a folder of its own."""
    return Path(shutil.copy(default_run.folder / "run.mcap", tmp_path / "old.mcap"))


def test_the_figures_of_the_run_come_out_again_to_the_byte(command_line, default_run, file, capfd):
    assert command_line.main(["figures", str(file)]) == 0
    folder = file.with_name("old-figures")
    assert {path.name for path in folder.iterdir()} == {f"{name}.png" for name in FIGURES}
    for path in folder.iterdir():
        assert path.read_bytes() == (default_run.folder / path.name).read_bytes(), path.name
    assert capfd.readouterr().out == f"{len(FIGURES)} files: {folder}\n"


def refused(command_line, capfd, *arguments) -> str:
    """The one line of a call that is refused, which writes nothing."""
    assert command_line.main(["figures", *map(str, arguments)]) == 2
    out, err = capfd.readouterr()
    lines = [line for line in err.splitlines() if not line.endswith(" ...")]
    assert out == "" and len(lines) == 1 and lines[0].startswith("run.py: ")
    return lines[0]


def test_nothing_is_overwritten(command_line, file, tmp_path, capfd):
    used = tmp_path / "old-figures"
    used.mkdir()
    (used / "mine.txt").write_text("precious")
    assert "old-figures: exists already and is not empty" in refused(command_line, capfd, file)
    assert "--out" in refused(command_line, capfd, file, "--out", used)
    assert "mine.txt: exists already" in refused(command_line, capfd, file, "--out", used / "mine.txt")
    assert [path.name for path in used.iterdir()] == ["mine.txt"]


def test_a_truncated_file_names_the_command_that_repairs_it(command_line, file, capfd):
    content = file.read_bytes()
    file.write_bytes(content[: len(content) // 2])
    line = refused(command_line, capfd, file)
    assert "truncated" in line and f"python run.py recover {file}" in line
    assert not file.with_name("old-figures").exists()


def test_what_is_no_recording_of_ours(command_line, file, tmp_path, capfd):
    foreign = rewrite(
        file,
        tmp_path / "foreign.mcap",
        metadata=lambda name, entries: None,
        message=lambda topic, t_ns, data: (t_ns, data) if t_ns == 0 else None,
    )
    (tmp_path / "text.mcap").write_text("t,x\n0,1\n")
    (tmp_path / "empty.mcap").write_bytes(b"")
    for path, words in (
        (foreign, "not one of this package's recordings (no metadata record 'run'"),
        (tmp_path / "text.mcap", "not an MCAP file"),
        (tmp_path / "none.mcap", "No such file"),
        (tmp_path / "empty.mcap", "truncated"),
        (tmp_path, "Is a directory"),
    ):
        assert words in refused(command_line, capfd, path)
    assert not [path for path in tmp_path.iterdir() if path.name.endswith("-figures")]
