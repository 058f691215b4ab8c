"""`python run.py studies` as a person uses it."""

import os
import re
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
GOOD = '''"""Says {name}."""

from drake_blfdmp.evaluation.study import Claim, Study, Table


def study(context):
    context.progress("thinking", 0.5)
    claims = [Claim("a", f"seed {{context.scenario.seed}}", True), Claim("b", f"{{context.quick}}", False, "so it is")]
    return Study(claims=claims, figures={{}}, captions={{}}, tables={{"t": Table({{"a": [1]}})}})
'''
DRAWS = '''"""Draws."""

import numpy as np

from drake_blfdmp.evaluation.study import Study
from drake_blfdmp.viewing.drawing import Drawing
from drake_blfdmp.viewing.study_figures.random_problems import first_times


def study(context):
    drawing = Drawing(first_times, {"none": np.random.default_rng(context.scenario.seed).uniform(0.1, 1.0, 20)})
    return Study(claims=[], figures={"times": drawing}, captions={"times": "Times."}, tables={})
'''
FAILS = '"""Fails."""\n\n\ndef study(context):\n    raise ValueError("two\\nlines")\n'
WAITS = (
    '"""Waits."""\n\nimport time\n\n\ndef study(context):\n    context.progress("waiting", 0.0)\n    time.sleep(600)\n'
)


def add(folder, name, script):
    (folder / f"{name}.py").write_text(script, encoding="utf-8")
    (folder / f"{name}.yaml").write_text(f"name: {name}\n", encoding="utf-8")


@pytest.fixture
def checkout(tmp_path, command_line, monkeypatch):
    """A checkout whose studies are `trajectories` and `alone`; the current folder is beside it."""
    folder = tmp_path / "checkout" / "studies"
    folder.mkdir(parents=True)
    for name in ("alone", "trajectories"):
        add(folder, name, GOOD.format(name=name))
    monkeypatch.setattr(command_line, "ROOT", folder.parent)
    monkeypatch.chdir(tmp_path)
    return folder.parent


def states(markdown):
    return re.findall(r"^\| \[(\w+)\]\(#.*\| ([\w ]+) \|$", markdown, re.MULTILINE)


def test_lists_the_real_studies_a_line_each(command_line, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert command_line.main(["studies"]) == 0
    out, err = capsys.readouterr()
    names = [line.split(" - ")[0].strip() for line in out.splitlines()]
    folder = ROOT / "studies"
    pairs = {path.stem for path in folder.glob("*.yaml") if path.with_suffix(".py").is_file()}
    assert set(names) == pairs or (out == "no studies\n" and not pairs)
    assert not {"hold_and_place", "benchmark_realtime"} & set(names)
    assert "does not parse" not in out and "no description" not in out
    assert err == ""
    assert list(tmp_path.iterdir()) == []


def test_runs_one_and_says_where_the_report_is(checkout, command_line, capsys, tmp_path):
    assert command_line.main(["studies", "alone", "--seed", "5", "--out", "there", "--quick"]) == 0
    out, err = capsys.readouterr()
    assert re.search(r"^alone +1 +1 +0 +[\d.]+ s$", out, re.MULTILINE)
    assert f"report: {Path('there') / 'report.html'}" in out
    assert "[1/1] alone: thinking" in err
    assert {path.name for path in (tmp_path / "there").iterdir()} == {"report.html", "report.md", "alone"}
    report = (tmp_path / "there" / "report.md").read_text(encoding="utf-8")
    assert "seed 5" in report
    assert "Quick version" in report
    assert "    python run.py studies alone --seed 5 --out there --quick\n" in report


def test_figures_are_drawn_again_from_the_file_alone(checkout, command_line, capsys, tmp_path):
    add(checkout / "studies", "sampling", DRAWS)
    assert command_line.main(["studies", "sampling", "--out", "there"]) == 0
    script = checkout / "studies" / "sampling.py"
    script.unlink()
    file = Path("there") / "sampling" / "study.mcap"
    before = file.read_bytes()
    for arguments, folder in (([], file.parent / "study-figures"), (["--out", "again"], Path("again"))):
        capsys.readouterr()
        assert command_line.main(["figures", str(file), *arguments]) == 0
        assert f": {folder}\n" in capsys.readouterr().out
        assert {path.name for path in folder.iterdir()} == {"times.png", "times.svg"}
        for path in folder.iterdir():
            assert path.read_bytes() == (file.parent / path.name).read_bytes()
    for arguments, words in (
        ([str(file), "--out", "again"], "again: exists already"),
        ([str(file)], "study-figures: exists already"),
        (["nowhere.mcap"], "nowhere.mcap: "),
        ([str(file.parent / "scenario.yaml")], "scenario.yaml: not an MCAP file"),
    ):
        assert command_line.main(["figures", *arguments]) == 2
        out, err = capsys.readouterr()
        assert out == "" and err.startswith("run.py: ") and words in err and err.count("\n") == 1
    assert file.read_bytes() == before
    assert not (tmp_path / "runs").exists()


def test_runs_all_in_order_into_a_folder_of_its_own(checkout, command_line, capsys, tmp_path):
    for _ in range(2):
        assert command_line.main(["studies", "--all", "--set", "seed=2"]) == 0
    folders = sorted((tmp_path / "runs").iterdir())
    assert len(folders) == 2
    assert all(re.fullmatch(r"studies-\d{8}-\d{6}(-\d+)?", folder.name) for folder in folders)
    report = (folders[0] / "report.md").read_text(encoding="utf-8")
    assert states(report) == [("trajectories", "done"), ("alone", "done")]
    assert "[2/2] alone: thinking" in capsys.readouterr().err


def test_the_command_of_the_report_repeats_the_study(checkout, command_line, tmp_path):
    arguments = ["studies", "--all", "--seed", "3", "--set", "box.mass=2", "--quick", "--recordings", str(tmp_path)]
    assert command_line.main([*arguments, "--out", "a"]) == 0
    report = (tmp_path / "a" / "report.md").read_text(encoding="utf-8")
    (command,) = re.findall(r"^    python run.py (studies alone .*)$", report, re.MULTILINE)
    assert command_line.main([*command.split(), "--out", "b"]) == 0
    for name in ("scenario.yaml", "t.csv"):
        assert (tmp_path / "a" / "alone" / name).read_bytes() == (tmp_path / "b" / "alone" / name).read_bytes()


def test_a_study_that_fails_gives_status_1_and_the_others_run(checkout, command_line, capsys, tmp_path):
    add(checkout / "studies", "sampling", FAILS)
    assert command_line.main(["studies", "--all", "--out", "o"]) == 1
    out, err = capsys.readouterr()
    assert "failed: sampling: ValueError: two lines\n" in out
    assert "Traceback" not in out + err
    report = (tmp_path / "o" / "report.md").read_text(encoding="utf-8")
    assert states(report) == [("trajectories", "done"), ("sampling", "failed"), ("alone", "done")]


BAD = {
    "unknown name": (["alone", "nonsense"], ["'nonsense'", "trajectories, alone"]),
    "names and --all": (["alone", "--all"], ["names or --all"]),
    "negative seed": (["alone", "--seed", "-1"], ["seed is -1"]),
    "negative seed as a setting": (["alone", "--set", "seed=-1"], ["seed is -1"]),
    "unknown key": (["--all", "--set", "box.weight=2"], ["'box.weight'", "mass"]),
    "setting without a value": (["--all", "--set", "box.mass"], ["key.path=value"]),
    "recordings that are nowhere": (["alone", "--recordings", "nowhere"], ["--recordings", "nowhere", "no folder"]),
    "recordings that are a file": (["alone", "--recordings", "used/kept.txt"], ["--recordings", "no folder"]),
    "no workers": (["alone", "--workers", "0"], ["--workers 0"]),
    "used folder": (["alone", "--out", "used"], ["--out used", "nothing is overwritten"]),
    "file as folder": (["alone", "--out", "used/kept.txt"], ["nothing is overwritten"]),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_input_gets_one_line_and_status_2_before_anything_runs(case, checkout, command_line, capsys, tmp_path):
    arguments, words = BAD[case]
    (tmp_path / "used").mkdir()
    (tmp_path / "used" / "kept.txt").write_text("kept")
    assert command_line.main(["studies", *arguments]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    assert err.startswith("run.py: ")
    assert all(word in err for word in words)
    assert {path.name for path in tmp_path.iterdir()} == {"checkout", "used"}
    assert [path.name for path in (tmp_path / "used").iterdir()] == ["kept.txt"]


def test_no_studies_at_all(checkout, command_line, capsys):
    shutil.rmtree(checkout / "studies")
    assert command_line.main(["studies"]) == 0
    assert command_line.main(["studies", "--all"]) == 2
    assert command_line.main(["studies", "alone"]) == 2
    out, err = capsys.readouterr()
    assert out == "no studies\n"
    assert "none to run" in err and "'alone'" in err


def help_of(command_line, capsys, *arguments):
    with pytest.raises(SystemExit) as caught:
        command_line.main([*arguments, "--help"])
    assert caught.value.code == 0
    return capsys.readouterr().out


def test_help_names_the_studies_and_their_every_option(command_line, capsys):
    assert "run.py studies" in help_of(command_line, capsys)
    text = help_of(command_line, capsys, "studies")
    for option in ("NAME", "--all", "--out", "--seed", "--set", "--quick", "--recordings", "--workers", "Exit status"):
        assert option in text


@pytest.mark.parametrize("arguments", [["studies", "--colour"], ["studies", "--seed", "x"], ["--seed", "3", "studies"]])
def test_a_usage_error_is_argparses(arguments, command_line, capsys):
    with pytest.raises(SystemExit) as caught:
        command_line.main(arguments)
    assert caught.value.code == 2
    assert "Traceback" not in capsys.readouterr().err


def test_ctrl_c_leaves_a_whole_report_and_status_130(checkout, tmp_path):
    """In a process of its own, with a real signal, sent once the study says that it waits."""
    add(checkout / "studies", "sampling", WAITS)
    shutil.copy(ROOT / "run.py", checkout)
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    command = [sys.executable, str(checkout / "run.py"), "studies", "--all", "--out", "o"]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True, env=environment, cwd=tmp_path) as process:
        try:
            seen = next((line for line in process.stderr if "sampling: waiting" in line), None)
            process.send_signal(signal.SIGINT)
            out, err = process.communicate(timeout=60)
        finally:
            process.kill()
    assert seen is not None
    assert process.returncode == 130
    assert err == "run.py: interrupted\n"
    assert f"report so far: {Path('o') / 'report.html'}" in out
    report = (tmp_path / "o" / "report.md").read_text(encoding="utf-8")
    assert states(report) == [("trajectories", "done"), ("sampling", "interrupted"), ("alone", "not run")]
    assert (tmp_path / "o" / "report.html").read_text(encoding="utf-8").endswith("</html>\n")
