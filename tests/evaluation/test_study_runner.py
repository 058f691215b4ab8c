"""Finding, loading and running studies of a folder made here."""

import matplotlib
import numpy as np
import pytest
from matplotlib.image import imread

from drake_blfdmp import interruption
from drake_blfdmp.errors import BlfDmpError, ScenarioError
from drake_blfdmp.evaluation.study import Study, StudyContext
from drake_blfdmp.evaluation.study_runner import (
    ORDER,
    CheckOptions,
    ChooseStudies,
    FindStudies,
    LoadStudy,
    RunStudies,
    StudyOptions,
    listing,
    summary_table,
)
from drake_blfdmp.planning.scenario import LoadScenario
from drake_blfdmp.viewing.redrawing import redraw_study

GOOD = '''"""What it is.

More of it.
"""

import numpy as np

from drake_blfdmp.evaluation.study import Claim, Study, Table
from drake_blfdmp.viewing.drawing import Drawing
from drake_blfdmp.viewing.study_figures.random_problems import first_times


def study(context):
    values = np.random.default_rng(context.scenario.seed).normal(size=5)
    context.progress("counting", 0.5)
    return Study(
        claims=[Claim("a mass", f"{context.scenario.box.mass:g} kg, quick {context.quick}", True)],
        figures={"noise": Drawing(first_times, {"none": np.abs(values)})},
        captions={"noise": f"{context.workers} workers, {context.recordings}"},
        tables={"noise": Table({"sample": range(5), "value_m": values})},
        notes=["A note."],
        shown=["noise"],
    )
'''


def add_study(folder, name, script=GOOD, scenario=None):
    folder.mkdir(exist_ok=True)
    (folder / f"{name}.py").write_text(script, encoding="utf-8")
    (folder / f"{name}.yaml").write_text(f"name: {name}\n" if scenario is None else scenario, encoding="utf-8")


def failing(statement):
    return f'"""Fails."""\n\n\ndef study(context):\n    {statement}\n'


def run(folder, tmp_path, options=None, progress=lambda what, share: None):
    """Every study of `folder`, run; the folder of the results and the results by name."""
    out = tmp_path / "out"
    out.mkdir()
    found = FindStudies(folder)
    results = RunStudies(list(found.values()), out, options or StudyOptions(), progress)
    return out, {result.name: result for result in results}


# Finding and loading.


def test_finds_pairs_with_a_function_study_in_the_papers_order_without_importing_them(tmp_path):
    for name in ("zebra", "sampling", "aardvark", "trajectories", "measurement_noise"):
        add_study(tmp_path, name, failing("pass") + "\nraise RuntimeError('imported')\n")
    add_study(tmp_path, "tool", '"""No study."""\n\n\ndef main():\n    pass\n')
    add_study(tmp_path, "silent", "def study(context):\n    pass\n")
    add_study(tmp_path, "broken", "def study(context)\n")
    (tmp_path / "scenario_alone.yaml").write_text("name: a\n")
    (tmp_path / "script_alone.py").write_text(GOOD)
    found = FindStudies(tmp_path)
    expected = ["measurement_noise", "trajectories", "sampling", "aardvark", "broken", "silent", "zebra"]
    assert list(found) == expected
    assert found["zebra"].description == "Fails."
    assert "no description" in found["silent"].description
    assert "does not parse" in found["broken"].description
    assert len(listing(found).splitlines()) == len(expected)
    assert "zebra             - Fails." in listing(found).splitlines()


def test_an_empty_or_missing_folder_has_no_studies(tmp_path):
    assert FindStudies(tmp_path) == FindStudies(tmp_path / "nowhere") == {}
    assert listing({}) == "no studies"
    with pytest.raises(BlfDmpError, match="none to run"):
        ChooseStudies({}, [])


def test_the_order_names_each_study_once():
    assert len(set(ORDER)) == len(ORDER)


def test_chooses_each_once_in_order_and_refuses_the_unknown(tmp_path):
    for name in ("b", "a"):
        add_study(tmp_path, name)
    found = FindStudies(tmp_path)
    assert [script.name for script in ChooseStudies(found, ["b", "a", "b"])] == ["a", "b"]
    with pytest.raises(BlfDmpError, match="there is no 'c'; choose from a, b"):
        ChooseStudies(found, ["a", "c"])


def test_a_script_may_define_dataclasses_of_its_own(tmp_path):
    script = GOOD.replace(
        "import numpy", "from __future__ import annotations\n\nfrom dataclasses import dataclass\nimport numpy"
    )
    script += "\n\n@dataclass\nclass Row:\n    a: float\n"
    add_study(tmp_path, "good", script)
    study = LoadStudy(FindStudies(tmp_path)["good"])
    context = StudyContext(LoadScenario(tmp_path / "good.yaml"), True, lambda what, share: None, None)
    assert isinstance(study(context), Study)


# Options.


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"settings": ["box.weight=1"]}, "'box.weight'"),
        ({"settings": ["box.mass=-1"]}, "box.mass must be positive"),
        ({"settings": ["seed=-1"]}, "the seed is -1"),
        ({"workers": 0}, "--workers 0"),
    ],
)
def test_options_that_no_study_can_run_with_are_refused(options, words, tmp_path):
    add_study(tmp_path, "good")
    add_study(tmp_path, "odd", scenario="law: magic\n")
    scripts = list(FindStudies(tmp_path).values())
    CheckOptions(scripts, StudyOptions())  # The broken scenario is not the options' fault.
    with pytest.raises(BlfDmpError) as caught:
        CheckOptions(scripts, StudyOptions(**options))
    assert words in str(caught.value)


def test_recordings_must_be_a_folder(tmp_path):
    add_study(tmp_path, "good")
    scripts = list(FindStudies(tmp_path).values())
    CheckOptions(scripts, StudyOptions(recordings=tmp_path))
    for wrong in (tmp_path / "nowhere", tmp_path / "good.py"):
        with pytest.raises(BlfDmpError, match="is no folder"):
            CheckOptions(scripts, StudyOptions(recordings=wrong))


# Running.


def test_a_study_leaves_figures_tables_and_its_scenario(tmp_path):
    add_study(tmp_path / "studies", "good")
    seen = []
    options = StudyOptions(settings=["seed=7", "box.mass=2"], quick=True, recordings=tmp_path, workers=3)
    out, results = run(tmp_path / "studies", tmp_path, options, lambda what, share: seen.append((what, share)))
    result = results["good"]
    files = ("noise.csv", "noise.png", "noise.svg", "scenario.yaml", "study.mcap")
    assert tuple(sorted(path.name for path in (out / "good").iterdir())) == result.files == files
    assert result.state == "done"
    assert result.seed == 7
    assert result.seconds > 0
    assert result.claims[0].measured == "2 kg, quick True"
    assert result.figures["noise"].caption == f"3 workers, {tmp_path}"
    assert result.figures["noise"].width == 3.5
    assert result.command == f"python run.py studies good --quick --set seed=7 --set box.mass=2 --recordings {tmp_path}"
    scenario = LoadScenario(out / "good" / "scenario.yaml")
    assert (scenario.name, scenario.seed, scenario.box.mass) == ("good", 7, 2.0)
    drawn = np.genfromtxt(out / "good" / "noise.csv", delimiter=",", names=True)
    np.testing.assert_array_equal(drawn["value_m"], np.random.default_rng(7).normal(size=5))
    assert imread(out / "good" / "noise.png").shape[1] > 600
    assert ("[1/1] good: counting", 0.5) in seen
    for name in ("report.html", "report.md"):
        assert (out / name).is_file()


def test_the_same_study_twice_gives_the_same_bytes(tmp_path):
    add_study(tmp_path / "studies", "good")
    folders = []
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        folders.append(run(tmp_path / "studies", tmp_path / name)[0] / "good")
    for path in folders[0].iterdir():
        assert path.read_bytes() == (folders[1] / path.name).read_bytes(), path.name
    svg = (folders[0] / "noise.svg").read_text(encoding="utf-8")
    assert "<dc:date>" not in svg and matplotlib.__version__ not in svg


def test_figures_drawn_again_from_the_file_are_the_same(tmp_path):
    add_study(tmp_path / "studies", "good")
    folder = run(tmp_path / "studies", tmp_path)[0] / "good"
    for path in redraw_study(folder / "study.mcap", tmp_path / "again"):
        assert path.read_bytes() == (folder / path.name).read_bytes(), path.name
    assert {path.name for path in (tmp_path / "again").iterdir()} == {"noise.png", "noise.svg"}


def test_a_figure_that_cannot_be_kept_fails_its_study_and_says_from_what(tmp_path):
    add_study(tmp_path / "studies", "good", GOOD.replace("np.abs(values)", "{1, 2}"))
    out, results = run(tmp_path / "studies", tmp_path)
    assert results["good"].state == "failed"
    assert "plain data: relative > none is of the kind 'set'" in results["good"].error
    assert results["good"].files == ("error.txt", "scenario.yaml")
    assert (out / "report.html").is_file()


def test_what_is_written_before_a_figure_fails_stays(tmp_path):
    add_study(tmp_path / "studies", "good", GOOD.replace("np.abs(values)", "None"))
    _, results = run(tmp_path / "studies", tmp_path)
    assert results["good"].state == "failed"
    assert results["good"].files == ("error.txt", "noise.csv", "scenario.yaml", "study.mcap")


FAILURES = {
    "key": (failing("return {}['gain']"), "KeyError: 'gain'"),
    "lines": (failing("raise TypeError('out of\\n reach')"), "TypeError: out of reach"),
    "nothing": (failing("pass"), "BlfDmpError: {script}: study() returned a NoneType; return a Study"),
    "exits": (failing("raise SystemExit(3)"), "SystemExit: 3"),
    "wordless": (failing("raise ValueError"), "ValueError"),
    "syntax": ("def study(context)\n", "SyntaxError: "),
    "imports": ('"""Fails."""\nimport no_such_module\n\n\ndef study(context):\n    pass\n', "ModuleNotFoundError: "),
    "vanished": (failing("pass") + "\n\ndel study\n", "BlfDmpError: {script}: has no function study(context)"),
}  # fmt: skip


def test_a_study_that_fails_says_so_in_one_line_and_stops_no_other(tmp_path):
    for name, (script, _) in FAILURES.items():
        add_study(tmp_path / "studies", name, script)
    add_study(tmp_path / "studies", "zz_good")
    add_study(tmp_path / "studies", "zz_odd", scenario="law: magic\n")
    out, results = run(tmp_path / "studies", tmp_path)
    for name, (_, expected) in FAILURES.items():
        assert results[name].state == "failed"
        assert results[name].error.startswith(expected.format(script=tmp_path / "studies" / f"{name}.py"))
        assert "\n" not in results[name].error
        assert "Traceback" in (out / name / "error.txt").read_text()
        assert not results[name].claims
    assert results["zz_good"].state == "done"
    assert results["zz_odd"].error.startswith(f"{ScenarioError.__name__}: ")
    text = summary_table(list(results.values()))
    assert text.count("failed") == len(FAILURES) + 1
    assert len(text.splitlines()) == len(results) + 1


def test_the_report_is_written_after_each_study(tmp_path):
    probe = failing("raise ValueError(open(context.scenario.recording.file).read().count('not run'))")
    add_study(tmp_path / "studies", "a")
    for name in ("b", "c"):
        add_study(tmp_path / "studies", name, probe, f"recording: {{file: '{tmp_path / 'out' / 'report.md'}'}}\n")
    _, results = run(tmp_path / "studies", tmp_path)
    # After `a`, two studies are not run yet, each named twice: in the summary and in its section.
    assert results["b"].error == "ValueError: 4"
    assert results["c"].error == "ValueError: 2"


@pytest.mark.parametrize("error", ["KeyboardInterrupt", "TypeError"])  # The second as bindings make it of the first.
def test_an_interruption_is_passed_on_and_the_report_is_whole(tmp_path, monkeypatch, error):
    monkeypatch.setattr(interruption, "_received", [])
    note = "from drake_blfdmp import interruption; interruption._received.append(2)"
    add_study(tmp_path / "studies", "a")
    add_study(tmp_path / "studies", "b", failing(f"{note}; raise {error}"))
    add_study(tmp_path / "studies", "c")
    with pytest.raises(KeyboardInterrupt):
        run(tmp_path / "studies", tmp_path)
    lines = (tmp_path / "out" / "report.md").read_text().splitlines()
    states = {
        line.split("|")[1].split("]")[0].strip(" ["): line.split("|")[-2].strip()
        for line in lines[4:9]
        if "#study-" in line
    }
    assert states == {"a": "done", "b": "interrupted", "c": "not run"}
    assert (tmp_path / "out" / "report.html").read_text().rstrip().endswith("</html>")
    assert not (tmp_path / "out" / "c").exists()
