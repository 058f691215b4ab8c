"""`run.py inspect` as a person uses it."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from drake_blfdmp.skeleton import POINTS

ROOT = Path(__file__).resolve().parents[1]


def write_csv(path, t, x):
    header = ",".join(["t", *(f"{name}_{axis}" for name in POINTS for axis in "xyz")])
    np.savetxt(path, np.column_stack([t, x.reshape(len(t), -1)]), delimiter=",", header=header, comments="", fmt="%.9f")
    return path


@pytest.fixture(scope="module")
def folder(tmp_path_factory, person):
    folder = tmp_path_factory.mktemp("inspect")
    t, x = person
    x = x + 0.0005 * np.random.default_rng(0).standard_normal(x.shape)
    write_csv(folder / "good.csv", t, x)
    write_csv(folder / "in mm.csv", 1000.0 * t, 1000.0 * x)
    alone = x.copy()
    alone[:, 3:] = alone[:1, 3:]
    write_csv(folder / "one_hand.csv", t, alone + 0.0005 * np.random.default_rng(1).standard_normal(x.shape))
    (folder / "text.csv").write_text("dear diary\n")
    return folder


def test_a_good_recording_gets_its_report_its_verdict_and_a_command_that_is_true(folder, command_line, capsys):
    assert command_line.main(["inspect", str(folder / "in mm.csv"), "--frames", "0:230"]) == 0
    out = capsys.readouterr().out
    assert "verdict: a two-handed skill can be learned" in out
    assert "unit: mm" in out and "clock: ms" in out
    for name in POINTS:
        assert name in out
    command = next(line for line in out.splitlines() if line.startswith("run it:"))
    assert "--recording" in command and "'" in command and "--frames 0:230" in command and "box.width=0.3" in command

    from shlex import split

    from drake_blfdmp.commands.run import parse, settings
    from drake_blfdmp.planning.scenario import ApplySetting, Scenario

    scenario = Scenario()
    for setting in settings(parse(split(command)[4:], "")):
        scenario = ApplySetting(scenario, setting)
    assert Path(scenario.recording.file) == folder / "in mm.csv"
    assert scenario.recording.frames == [0, 230]
    assert scenario.box.width == pytest.approx(0.30, abs=0.01)


def test_json_is_json_alone_and_says_the_same(folder, command_line, capsys):
    assert command_line.main(["inspect", "--json", str(folder / "good.csv"), "--unit", "m"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["suitable"] is True
    assert report["holding"]["hand_distance_m"] == pytest.approx(0.30, abs=0.01)
    assert report["bones_m"] == pytest.approx([0.22, 0.28], abs=0.002)


def test_one_hand_is_status_1_with_the_reason(folder, command_line, capsys):
    assert command_line.main(["inspect", str(folder / "one_hand.csv")]) == 1
    out = capsys.readouterr().out
    assert "verdict: not as it stands" in out and "one hand carries" in out
    assert "run it" not in out
    command = next(line for line in out.splitlines() if line.startswith("as a motion without a box:  python run.py "))
    assert command.endswith(f"--recording {folder / 'one_hand.csv'} --set task.kind=motion")


def test_figure_and_page_are_written_and_never_over_something(folder, command_line, capsys, tmp_path):
    arguments = [
        "inspect",
        str(folder / "good.csv"),
        "--figure",
        str(tmp_path / "a.png"),
        "--html",
        str(tmp_path / "a.html"),
    ]
    assert command_line.main(arguments) == 0
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
    assert "<html" in (tmp_path / "a.html").read_text(encoding="utf-8")[:2000].lower()
    before = (tmp_path / "a.png").read_bytes()
    capsys.readouterr()
    assert command_line.main(arguments) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert "a.png: exists already; nothing is overwritten" in captured.err
    assert (tmp_path / "a.png").read_bytes() == before


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["text.csv"], "text of no known format"),
        (["missing.csv"], "no such file"),
        (["good.csv", "--frames", "5"], "--frames 5: write it as FIRST:LAST"),
        (["good.csv", "--frames", "900:950"], "no frame lies in 900:950"),
        (["good.csv", "--joints", "left_wrist"], "--joints left_wrist: write it as NAME=COLUMN"),
        (["good.csv", "--body", "7"], "holds no person '7'"),
        (["good.csv", "--rate", "0"], "a rate of 0 frames a second"),
        (["good.csv", "--format", "gramophone"], "unknown format 'gramophone'"),
        (["good.csv", "--figure", "nowhere/a.png"], "does not exist; make it first"),
    ],
)
def test_bad_input_is_one_line_and_status_2(folder, command_line, capsys, monkeypatch, arguments, message):
    monkeypatch.chdir(folder)
    assert command_line.main(["inspect", *arguments]) == 2
    err = [line for line in capsys.readouterr().err.splitlines() if line.startswith("run.py: ")]
    assert len(err) == 1 and message in err[0]


def test_in_a_process_of_its_own_it_needs_no_drake(folder):
    """Seconds count at the first contact: the report alone must not load the simulator."""
    code = (
        "import sys, runpy; sys.argv = ['run.py', 'inspect', sys.argv[1]]\n"
        f"try: runpy.run_path({str(ROOT / 'run.py')!r}, run_name='__main__')\n"
        "except SystemExit as end: assert end.code == 0, end.code\n"
        "assert 'pydrake' not in sys.modules"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, str(folder / "good.csv")], capture_output=True, text=True, cwd=ROOT, timeout=120
    )
    assert done.returncode == 0, done.stderr
    assert "verdict" in done.stdout
