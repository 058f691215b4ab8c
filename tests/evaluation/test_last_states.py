"""A run that meets a number that is not finite: one line, status 1, and a recording that reads up to then."""

import json
from dataclasses import replace

import numpy as np
import pytest
from poisoned import BreakingSkill

from drake_blfdmp.errors import NonFiniteError, SimulationError
from drake_blfdmp.evaluation import carry_out
from drake_blfdmp.evaluation.last_states import LastStatesKept
from drake_blfdmp.recording.mcap_recorder import McapRecorder
from drake_blfdmp.recording.read import read_mcap


@pytest.fixture(scope="module")
def broken(default_plan, command_line, tmp_path_factory):
    """The default run with a forcing that breaks at 0.1 s: status, folder, output."""
    plan = replace(default_plan, task=replace(default_plan.task, skill=BreakingSkill.of(default_plan.task.skill)))
    folder = tmp_path_factory.mktemp("broken") / "run"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(carry_out, "MakePlan", lambda scenario, progress: plan)
        yield folder, command_line, ["--out", str(folder)]


def test_the_run_stops_with_one_line_that_names_system_port_time_and_file(broken, capfd):
    folder, command_line, arguments = broken
    assert command_line.main(arguments) == 1
    out, err = capfd.readouterr()
    lines = [line for line in err.splitlines() if not line.endswith(" ...")]
    assert len(lines) == 1 and lines[0].startswith("run.py: "), err
    for word in ("'forcing'", "nan in 18 of 18", "t = 0.1", str(folder / "run.mcap")):
        assert word in lines[0]
    assert "success" not in out
    assert not (folder / "summary.json").exists()


def test_the_recording_holds_the_finite_states_up_to_then(broken):
    folder, *_ = broken
    run = read_mcap(folder / "run.mcap")
    assert run.damage == ""
    states = json.loads(run.attachments["last_states.json"])
    assert states["time_s"] == pytest.approx(0.1, abs=0.005)
    assert states["not_finite"] == {"system": "forcing", "port": "forcing"}
    *_, (event, t) = run.events
    assert event == "non_finite forcing forcing"
    assert t == pytest.approx(states["time_s"])
    for topic in ("/joint_states", "/tf", "/points"):
        series = run.series[topic]
        assert t - 0.011 <= series.t[-1] <= t + 1e-9
        assert np.isfinite(series.values).all(), topic
    x = np.array(states["states"]["transformation"]["discrete"][0])
    assert np.abs(x - run.series["/points"].values[-1]).max() < 0.02
    assert {"plant", "canonical", "ik"} <= set(states["states"])
    assert run.attachments["scenario.yaml"] == (folder / "scenario.yaml").read_bytes()


def test_another_error_leaves_the_recording_to_others(tmp_path):
    with (
        McapRecorder(filename=tmp_path / "run.mcap") as recorder,
        pytest.raises(ZeroDivisionError),
        LastStatesKept([recorder], {"scenario.yaml": ""}),
    ):
        raise ZeroDivisionError
    assert read_mcap(tmp_path / "run.mcap").attachments == {}


def test_a_simulation_that_stops_for_another_reason_says_where_its_recording_is(tmp_path):
    recorder = McapRecorder(filename=tmp_path / "run.mcap")
    with (
        pytest.raises(
            SimulationError, match=rf"^no way on; the states up to then are in {tmp_path / 'run.mcap'}$"
        ) as caught,
        LastStatesKept([recorder], {"scenario.yaml": "seed: 0\n"}),
    ):
        raise SimulationError("no way on")
    assert not isinstance(caught.value, NonFiniteError)
    run = read_mcap(tmp_path / "run.mcap")
    assert run.events == () and set(run.attachments) == {"scenario.yaml"}
