"""The study of success under variation, quick, from the tasks to the report's parts."""

import json
from dataclasses import replace

import pytest

from drake_blfdmp.errors import ScenarioError
from drake_blfdmp.evaluation.robustness.campaign import append_row
from drake_blfdmp.evaluation.robustness.quick import quick_base
from drake_blfdmp.evaluation.robustness.trial import make_trials
from drake_blfdmp.evaluation.study import StudyContext
from drake_blfdmp.evaluation.study_runner import FindStudies, LoadStudy
from drake_blfdmp.planning.scenario import LoadScenario


@pytest.fixture(scope="module")
def script(command_line):
    return FindStudies(command_line.ROOT / "studies")["robustness"]


def context(scenario, folder, told=None):
    def progress(what, share):
        if told is not None:
            told.append((what, share))

    return StudyContext(scenario, True, progress, None, 2, folder)


@pytest.fixture(scope="module")
def quick(script, tmp_path_factory):
    """(study, its folder, what was told of the progress)."""
    folder, told = tmp_path_factory.mktemp("robustness"), []
    return LoadStudy(script)(context(LoadScenario(script.scenario), folder, told)), folder, told


def test_a_quick_run_judges_both_laws_and_keeps_every_row(quick, redrawn):
    study, folder, told = quick
    rows = [json.loads(line) for line in (folder / "results.jsonl").read_text(encoding="utf-8").splitlines()]
    assert sorted(row["law"] for row in rows) == ["default", "none"]
    assert {row["law"]: row["verdict"] for row in rows} == {"default": "success", "none": "failure"}
    assert study.tables["laws"].columns["law"] == ["default", "none"]
    assert study.tables["tasks"].columns["verdict"] == ["success", "failure"]
    assert set(redrawn(study)) == set(study.captions) == {"success", "classes", "where", "accuracy"}
    # One task is too few for a share, and enough for what must never happen.
    assert [claim.holds for claim in study.claims[:6]] == [None, True, True, True, True, True]
    (file,) = (folder / "failures").iterdir()
    assert file.name == "robustness-0-0000-none.yaml"
    assert [share for what, share in told if what == "2 trials"] == [0.0, 0.5, 1.0]


def test_what_is_there_is_not_run_again_and_a_refusal_is_looked_at(script, quick, tmp_path, monkeypatch):
    """Every row is taken from a file, as after an interruption: nothing is planned or simulated."""
    _, folder, _ = quick
    path = tmp_path / "rows.jsonl"
    scenario = LoadScenario(script.scenario)
    trials = {law: make_trials(quick_base(scenario), law, 1)[0] for law in ("default", "none")}
    before = {row["law"]: row for row in map(json.loads, (folder / "results.jsonl").read_text().splitlines())}
    assert {law: row["key"] for law, row in before.items()} == {law: trial.key for law, trial in trials.items()}
    append_row(path, before["none"])
    append_row(path, before["default"] | {"verdict": "refused", "classes": ["reach"], "measured": None})
    checked = {"task": "robustness-0-0000-default", "reason": "reach", "right": True, "evidence": "no posture at all"}
    append_row(path, {"key": f"{trials['default'].key}-reach-refusal"} | checked)
    settings = replace(scenario.robustness, results=str(path), refusals=5)
    size = path.stat().st_size
    study = LoadStudy(script)(context(replace(scenario, robustness=settings), tmp_path))
    assert path.stat().st_size == size
    assert study.tables["refusals"].rows() == [("robustness-0-0000-default", "reach", True, "no posture at all")]
    refused = study.claims[6]
    assert "refusals" in refused.paper and refused.holds is None and "1 of 1" in refused.measured
    assert study.tables["laws"].columns["feasible"] == [0, 0]


def test_numbers_of_tasks_are_a_setting_and_checked(script):
    scenario = LoadScenario(script.scenario, ["robustness.tasks.default=1000"])
    assert scenario.robustness.tasks["default"] == 1000 and scenario.robustness.tasks["gams"] > 0
    for setting, named in (
        ("robustness.tasks={defualt: 3}", "defualt"),
        ("robustness.tasks.default=0", "at least 1"),
        ("robustness.tasks.gams=-1", "robustness.tasks.gams"),
        ("robustness.refusals=-1", "robustness.refusals"),
        ("robustness.timeout_s=0", "robustness.timeout_s"),
    ):
        with pytest.raises(ScenarioError, match=named):
            LoadScenario(script.scenario, [setting])
