"""Refusals carry one line and the class they belong to."""

import pickle

import pytest

from drake_blfdmp.errors import BlfDmpError, RecordingError, ScenarioError, SkillError, TaskError


@pytest.mark.parametrize("kind", [BlfDmpError, RecordingError, ScenarioError, SkillError, TaskError])
def test_what_says_nothing_else_is_about_the_input(kind):
    assert kind("a line").reason == "input"


@pytest.mark.parametrize("reason", ["reach", "force", "clearance", "input"])
def test_a_reason_survives_the_way_back_from_a_worker_process(reason):
    error = pickle.loads(pickle.dumps(TaskError("a line", reason=reason)))
    assert (type(error), str(error), error.reason) == (TaskError, "a line", reason)
