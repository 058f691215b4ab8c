"""`run.py` as a person misuses it: one clear line, status 2, and nothing written is lost; and its help."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from drake_blfdmp.commands import run as command
from drake_blfdmp.skeleton import POINTS

ROOT = Path(__file__).resolve().parents[1]


def python(*arguments, cwd):
    """`python run.py` in a process of its own."""
    command = [sys.executable, str(ROOT / "run.py"), *map(str, arguments)]
    return subprocess.run(command, cwd=cwd, capture_output=True, text=True, timeout=300)


def write_csv(path, t, x, names=POINTS):
    header = ",".join(["time_s", *(f"{name}_{axis}" for name in names for axis in "xyz")])
    np.savetxt(path, np.column_stack([t, x.reshape(len(t), -1)]), delimiter=",", header=header, comments="")
    return path


@pytest.fixture(scope="module")
def files(tmp_path_factory, person):
    """A folder with a good recording, several bad ones, and bad scenarios."""
    folder = tmp_path_factory.mktemp("bad")
    t, x = person
    write_csv(folder / "good.csv", t, x)
    write_csv(folder / "names.csv", t, x, ["nose", *POINTS[1:]])
    write_csv(folder / "nan.csv", t, np.full_like(x, np.nan))
    write_csv(folder / "two.csv", t[:2], x[:2])
    write_csv(folder / "swapped.csv", t, x[:, [3, 4, 5, 0, 1, 2]])
    write_csv(folder / "millimetres.csv", t, 1000.0 * x)
    (folder / "empty.csv").write_bytes(b"")
    (folder / "noise.csv").write_bytes(bytes(range(256)) * 8)
    (folder / "folder").mkdir()
    (folder / "broken.yaml").write_text("box: [1,\n mass: }")
    (folder / "key.yaml").write_text("box:\n  weight: 2\n")
    (folder / "list.yaml").write_text("- 1\n- 2\n")
    (folder / "full").mkdir()
    (folder / "full" / "precious.txt").write_text("keep me")
    return folder


BAD = {
    "missing recording": (["--recording", "nowhere.csv"], ["nowhere.csv", "no such file"]),
    "empty file": (["--recording", "empty.csv"], ["empty.csv", "is empty"]),
    "directory": (["--recording", "folder"], ["is a directory"]),
    "binary noise": (["--recording", "noise.csv"], ["noise.csv", "known formats"]),
    "joint not found": (["--recording", "names.csv"], ["left_shoulder", "nose", "right_wrist"]),
    "mapped to nothing": (
        ["--recording", "good.csv", "--joints", "left_wrist=Hand"], ["'Hand'", "left_wrist", "right_elbow"]
    ),
    "unknown point": (["--recording", "good.csv", "--joints", "hip=left_wrist"], ["'hip'", "left_shoulder"]),
    "bad --joints": (["--recording", "good.csv", "--joints", "left_wrist"], ["--joints left_wrist", "NAME=COLUMN"]),
    "nan everywhere": (["--recording", "nan.csv"], ["nan.csv", "missing in every frame"]),
    "two frames": (["--recording", "two.csv"], ["2-frame recording"]),
    "left and right swapped": (["--recording", "swapped.csv"], ["left and right are swapped"]),
    "millimetres as metres": (["--recording", "millimetres.csv", "--unit", "m"], ["220 m", "--unit mm"]),
    "metres as millimetres": (["--recording", "good.csv", "--unit", "mm"], ["--unit m"]),
    "unknown format": (["--recording", "good.csv", "--format", "vhs"], ["'vhs'", "wide_csv"]),
    "bad --frames": (["--recording", "good.csv", "--frames", "7"], ["--frames 7", "FIRST:LAST"]),
    "words in --frames": (["--recording", "good.csv", "--frames", "a:b"], ["--frames a:b", "FIRST:LAST"]),
    "frames beyond the end": (["--recording", "good.csv", "--frames", "900:950"], ["900:950", "0 to 240"]),
    "frames backwards": (["--recording", "good.csv", "--frames", "90:30"], ["90:30"]),
    "unknown scenario key": (["--scenario", "key.yaml"], ["'box.weight'", "width, depth, height, mass, friction"]),
    "scenario missing": (["--scenario", "nowhere.yaml"], ["nowhere.yaml", "cannot be read"]),
    "scenario is no YAML": (["--scenario", "broken.yaml"], ["broken.yaml", "is not YAML"]),
    "scenario is a list": (["--scenario", "list.yaml"], ["must hold keys and values"]),
    "scenario is a folder": (["--scenario", "folder"], ["cannot be read"]),
    "unknown --set key": (["--set", "box.weight=1"], ["'box.weight'", "mass"]),
    "unknown --set section": (["--set", "crate.mass=1"], ["'crate'", "box"]),
    "--set without a value": (["--set", "box.mass"], ["key.path=value"]),
    "--set of a wrong type": (["--set", "box.mass=heavy"], ["box.mass=heavy"]),
    "negative mass": (["--set", "box.mass=-1"], ["box.mass must be positive"]),
    "unknown law": (["--set", "law=magic"], ["'magic'", "default", "published_loop", "gams"]),
    "a law that diverges": (["--set", "law=published_lagged"], ["published_lagged", "without bound", "another law"]),
    "negative seed": (["--seed", "-1"], ["seed is -1"]),
    "unsafe skill step": (["--set", "simulation.skill_time_step=0.03"], ["0.03 s", "k_1", "use at most"]),
    "unsafe gains": (["--set", "gains.k_2=5000"], ["k_2 = 5000", "use at most"]),
    "coarse plant step": (["--set", "simulation.time_step=0.5"], ["simulation.time_step", "0.01 s"]),
    "no duration": (["--set", "task.duration_scale=0"], ["task.duration_scale must be positive"]),
    "negative tail": (["--set", "task.tail=-1"], ["task.tail"]),
    "negative bone": (["--set", "bands.upper_arm=-1"], ["bands.upper_arm must be positive"]),
    "box wider than the arms reach": (["--set", "box.width=1.5"], ["1.50 m", "narrower box"]),
    "box thinner than the squeeze": (["--set", "box.width=0.03"], ["0.030 m", "too narrow"]),
    "box out of range for the palms": (["--set", "task.grasp_above=0.3"], ["task.grasp_above"]),
    "folder in use": (["--out", "full"], ["--out", "not empty", "nothing is overwritten"]),
    "file as folder": (["--out", "good.csv"], ["--out", "nothing is overwritten"]),
}  # fmt: skip
IN_A_PROCESS = ("missing recording", "joint not found", "unknown scenario key", "folder in use")


def absolute(arguments, files, tmp_path):
    """The arguments with file names in `files`, and a folder for the results where none is given."""
    paths = {"--recording", "--scenario", "--out"}
    result = [
        str(files / value) if before in paths else value
        for before, value in zip([None, *arguments], arguments, strict=False)
    ]
    return result if "--out" in result else [*result, "--out", str(tmp_path / "out")]


def check_refused(status, out, err, words, out_folder):
    assert status == 2
    assert "Traceback" not in out + err
    lines = [line for line in err.splitlines() if not line.endswith(" ...")]  # Without the stages done so far.
    assert len(lines) == 1, err
    assert lines[0].startswith("run.py: ")
    for word in words:
        assert word in lines[0]
    assert out == ""
    assert not out_folder.exists()


@pytest.mark.parametrize("case", BAD)
def test_bad_input_gets_one_line_and_status_2(case, command_line, files, tmp_path, capfd):
    arguments, words = BAD[case]
    before = {path: path.stat().st_mtime_ns for path in files.rglob("*")}
    status = command_line.main(absolute(arguments, files, tmp_path))
    check_refused(status, *capfd.readouterr(), words, tmp_path / "out")
    assert {path: path.stat().st_mtime_ns for path in files.rglob("*")} == before


@pytest.mark.parametrize("case", IN_A_PROCESS)
def test_a_process_of_its_own_answers_the_same(case, files, tmp_path):
    arguments, words = BAD[case]
    done = python(*absolute(arguments, files, tmp_path), cwd=tmp_path)
    check_refused(done.returncode, done.stdout, done.stderr, words, tmp_path / "out")
    assert list(tmp_path.iterdir()) == []
    assert (files / "full" / "precious.txt").read_text() == "keep me"


def test_help_names_every_option(tmp_path):
    done = python("--help", cwd=tmp_path)
    assert done.returncode == 0
    for option in (
        "--scenario",
        "--set",
        "--recording",
        "--frames",
        "--joints",
        "--unit",
        "--out",
        "--seed",
        "--diagram",
        "--meshcat",
    ):
        assert option in done.stdout


def test_an_unknown_option_is_a_usage_error(tmp_path):
    done = python("--colour", "red", cwd=tmp_path)
    assert done.returncode == 2
    assert "--colour" in done.stderr
    assert "Traceback" not in done.stderr


def test_short_options_are_settings():
    options = command.parse(
        ["--recording", "it's.csv", "--frames", "3:9", "--joints", "left_wrist=Hand L", "right_wrist=a,b,c",
         "--unit", "mm", "--seed", "4", "--set", "seed=5"],
        "",
    )  # fmt: skip
    from drake_blfdmp.planning.scenario import ApplySetting, Scenario

    scenario = Scenario()
    for setting in command.settings(options):
        scenario = ApplySetting(scenario, setting)
    assert Path(scenario.recording.file) == Path("it's.csv").resolve()
    assert scenario.recording.frames == [3, 9]
    assert scenario.recording.joints == {"left_wrist": ["Hand L"], "right_wrist": ["a", "b", "c"]}
    assert (scenario.recording.unit, scenario.seed) == ("mm", 5)
