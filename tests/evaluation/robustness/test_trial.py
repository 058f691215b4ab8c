"""Trials from the task to the row, and a failed one that is run again from its file."""

import json
from dataclasses import replace
from types import SimpleNamespace

import pytest

from drake_blfdmp.errors import BlfDmpError, TaskError
from drake_blfdmp.evaluation.robustness import trial as module
from drake_blfdmp.evaluation.robustness.campaign import run_jobs
from drake_blfdmp.evaluation.robustness.quick import quick_base
from drake_blfdmp.evaluation.robustness.trial import Trial, make_harder_trials, make_trials, write_failures
from drake_blfdmp.planning.scenario import Scenario


@pytest.fixture(scope="module")
def slippery():
    """A trial whose box is far more slippery than the plan believes: it must fall."""
    (trial,) = make_trials(quick_base(Scenario()), "default", 1)
    return replace(
        trial, scenario=replace(trial.scenario, reality=replace(trial.scenario.reality, friction_scale=0.05))
    )


@pytest.fixture(scope="module")
def fallen(slippery, tmp_path_factory):
    """Its row, made in a process of its own."""
    path = tmp_path_factory.mktemp("trial") / "rows.jsonl"
    (row,) = run_jobs([slippery], path, workers=1, timeout_s=600.0)
    assert json.loads(path.read_text(encoding="utf-8")) == row
    return row


def test_a_box_that_is_too_slippery_is_dropped(fallen):
    assert fallen["verdict"] == "failure" and fallen["classes"][0] == "dropped"
    assert "dropped" in fallen["message"]
    assert fallen["measured"]["dropped"] is True and fallen["measured"]["violations"] == 0


def test_a_failed_trial_is_replayed_from_its_file(slippery, fallen, command_line, tmp_path):
    (file,) = write_failures(tmp_path / "failures", [slippery], [fallen])
    assert file.name == "robustness-0-0000-default.yaml"
    assert file.read_text(encoding="utf-8").startswith("# failure (dropped")
    assert command_line.main(["--scenario", str(file), "--out", str(tmp_path / "run")]) == 1
    summary = json.loads((tmp_path / "run" / "summary.json").read_text(encoding="utf-8"))
    assert " ".join(summary["failures"]) == fallen["message"]
    for name in ("placement_error_m", "max_tilt_deg", "lifted_m"):
        assert summary["box"][name] == fallen["measured"][name]


def test_what_the_planner_refuses_is_a_row_with_its_reason(slippery, monkeypatch):
    def refuse(scenario):
        raise TaskError("reach: too far", reason="reach")

    monkeypatch.setattr(module, "MakePlan", refuse)
    row = slippery.run()
    assert (row["verdict"], row["classes"], row["message"]) == ("refused", ["reach"], "reach: too far")
    assert row["measured"] is None and row["plan_s"] >= 0.0 and row["run_s"] is None


def test_a_simulation_that_cannot_go_on_is_a_failure_of_its_own(slippery, monkeypatch):
    def stop(plan):
        raise BlfDmpError("ik, position: not finite at 1.2 s")

    monkeypatch.setattr(module, "MakePlan", lambda scenario: None)
    monkeypatch.setattr(module, "Judge", stop)
    row = slippery.run()
    assert (row["verdict"], row["classes"]) == ("failure", ["diverged"])
    assert row["message"].startswith("ik, position") and row["measured"] is None and row["run_s"] >= 0.0


def test_keys_differ_with_the_task_the_law_and_every_setting():
    base = Scenario()
    trials = [
        *make_trials(base, "default", 2),
        *make_trials(base, "none", 1),
        *make_trials(replace(base, seed=1), "default", 1),
        *make_trials(replace(base, box=replace(base.box, depth=0.21)), "default", 1),
    ]
    assert len({trial.key for trial in trials}) == len(trials)
    more = make_trials(replace(base, robustness=replace(base.robustness, tasks={"default": 1000})), "default", 2)
    assert [trial.key for trial in more] == [trial.key for trial in trials[:2]]


def test_harder_tasks_are_only_planned_and_leave_a_file_where_they_are_refused(tmp_path, monkeypatch):
    easy, heavy = make_harder_trials(Scenario(), 2)

    def plan(scenario):
        if scenario == heavy.scenario:
            raise TaskError("box: too heavy", reason="force")
        return SimpleNamespace(notes=("raised",))

    monkeypatch.setattr(module, "MakePlan", plan)
    rows = [easy.run(), heavy.run()]
    assert [(row["verdict"], row["classes"]) for row in rows] == [("planned", []), ("refused", ["force"])]
    assert rows[0]["run_s"] is None and rows[0]["notes"] == ["raised"]
    (file,) = write_failures(tmp_path / "refused", [easy, heavy], rows)
    assert file.name == "harder-0-0001.yaml" and "refused (force)" in file.read_text(encoding="utf-8")
    assert easy.key != replace(easy, planned_only=False).key and easy.key.startswith("harder-0-0000-")


def test_a_success_leaves_no_file_and_a_crash_does(tmp_path):
    first, second = make_trials(Scenario(), "default", 2)
    rows = [{"verdict": "success"}, second.crashed("no end after 9 s, killed")]
    assert write_failures(tmp_path / "none", [first], rows[:1]) == [] and not (tmp_path / "none").exists()
    (file,) = write_failures(tmp_path / "some", [first, second], rows)
    assert file.read_text(encoding="utf-8").startswith("# crash (crash): no end after 9 s, killed\n")
    assert isinstance(second, Trial)
