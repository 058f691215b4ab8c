"""A run's log from its file alone: the numbers of the summary come out of it again."""

import io
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from rewritten import rewrite

from drake_blfdmp.evaluation.metrics import box_metrics, feedback_metrics, robot_metrics
from drake_blfdmp.recording.mcap_file import RecorderError
from drake_blfdmp.recording.planned_signals import ATTACHMENT, MEASURED, read_planned
from drake_blfdmp.recording.run_log_from_file import read_run_log
from drake_blfdmp.skill.geometry import link_lengths

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def file(default_run):
    return default_run.folder / "run.mcap"


@pytest.fixture(scope="module")
def log(file):
    return read_run_log(file)


@pytest.fixture(scope="module")
def summary(default_run):
    return json.loads((default_run.folder / "summary.json").read_text())


@pytest.fixture(scope="module")
def short(file, tmp_path_factory):
    """The first tenth of a second of it, from which broken ones are quickly made."""
    target = tmp_path_factory.mktemp("short") / "run.mcap"
    return rewrite(file, target, message=lambda topic, t_ns, data: (t_ns, data) if t_ns <= 10**8 else None)


def agree(found, expected):
    assert set(found) == set(expected)
    for key, value in expected.items():
        assert found[key] == pytest.approx(value, rel=1e-4, abs=1e-4), key


def test_the_metrics_of_the_summary_follow_from_the_file(log, default_plan, summary):
    plan = default_plan
    agree(robot_metrics(log, plan.settle_s), summary["robot"])
    agree(feedback_metrics(log, plan.settle_s, plan.duration_s), summary["feedback"])
    box = box_metrics(
        log, plan.task.held, plan.goal, float(plan.start[6]), plan.box.width, plan.squeeze_force,
        plan.scenario.task.force_limit,
    )  # fmt: skip
    tilt, expected = box.pop("max_tilt_deg"), dict(summary["box"])
    assert tilt == pytest.approx(expected.pop("max_tilt_deg"), abs=0.02)  # An arccos of single precision near 1.
    agree(box, expected)
    assert [[name, pytest.approx(t, abs=1e-6)] for name, t in log.recognised] == summary["events"]["recognised"]
    assert {name: pytest.approx(t, abs=1e-9) for name, t in log.events} == summary["events"]["planned"]


def test_what_the_plan_knew_is_there(log, default_plan):
    plan = default_plan
    step = plan.scenario.simulation.skill_time_step
    np.testing.assert_allclose(log.clock, log.t, atol=step)  # Nothing slowed this run, so the clocks agree.
    for k in (0, 400, 1000):
        index = round(log.t[k] / step)
        np.testing.assert_allclose(log.uncoupled[k], plan.uncoupled.x[index], atol=1e-6)
        np.testing.assert_allclose(log.box_desired[k], plan.planned_box()[index], atol=1e-6)
        np.testing.assert_allclose(log.position[k], plan.coupled.x[index], atol=0.02)
    assert log.spread is None
    lengths = link_lengths(log.position)
    assert np.all((lengths > log.lower) & (lengths < log.upper))
    np.testing.assert_allclose(log.demonstrated[-1], plan.task.motion.x[-1], atol=1e-4)


def test_it_is_read_without_drake(file, log, tmp_path):
    code = f"""
import sys
sys.modules["pydrake"] = None
from drake_blfdmp.recording.run_log_from_file import read_run_log
print(repr(float(read_run_log({str(file)!r}).palm.sum())))
"""
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert float(done.stdout) == float(log.palm.sum())


def test_a_long_one_is_thinned_evenly(file, log):
    few = read_run_log(file, most=200)
    assert 100 <= len(few.t) <= 200
    stride = round(len(log.t) / len(few.t))
    for name in ("t", "q", "palm", "box", "uncoupled", "swivel", "clearance"):
        np.testing.assert_array_equal(getattr(few, name), getattr(log, name)[::stride][: len(few.t)])
    for (name, t), (expected, at) in zip(few.events, log.events, strict=True):
        assert name == expected and t == pytest.approx(at, abs=0.01)


def test_a_run_that_was_killed_has_the_events_it_came_to(short):
    log = read_run_log(short)
    assert log.events == () and log.recognised == ()
    assert len(log.t) == 11


def test_without_what_is_measured_at_the_end_the_clearance_is_not_known(short, tmp_path):
    cut = rewrite(short, tmp_path / "a.mcap", attachment=lambda name, data: None if name == MEASURED else data)
    assert np.isnan(read_run_log(cut).clearance).all()


def test_its_attachment_loads_with_numpy_alone(file):
    from drake_blfdmp.recording.read import read_mcap

    data = read_mcap(file).attachments[ATTACHMENT]
    with np.load(io.BytesIO(data), allow_pickle=False) as arrays:
        assert arrays["uncoupled"].shape == (len(arrays["clock"]), 6, 3)
    signals = read_planned(data, "x")
    assert signals.to_bytes() == data


def only(topic, change):
    return lambda name, t_ns, data: change(t_ns, data) if name == topic else (t_ns, data)


@pytest.mark.parametrize(
    ("changes", "line"),
    [
        ({"message": lambda name, t, data: (t, data) if t == 0 else None}, "1 whole sample, so no duration"),
        ({"message": only("/points", lambda t, data: (10**8 - t, data))}, "time goes back from 0.1 s"),
        ({"message": lambda name, t, data: (10**8 - t if t in (10**7, 9 * 10**7) else t, data)}, "time goes back from"),
        ({"message": only("/swivel", lambda t, data: None)}, "has no topic /swivel, which every run has"),
        ({"message": only("/phase", lambda t, data: (t, data[:-8]))}, "/phase: "),
        ({"schema": lambda topic, name: "my/msg/New" if topic == "/hands" else name}, "/hands: its messages are of"),
        ({"metadata": lambda name, entries: None}, "not a recording of a run"),
        ({"metadata": lambda name, entries: {"seed": "0"}}, "recorded by an older version"),
        ({"metadata": lambda name, entries: entries | {"left_palm": "claw"}}, "/tf: the frame 'claw' is missing"),
        ({"attachment": lambda name, data: None}, "planned.npz is missing"),
        ({"attachment": lambda name, data: data[:500]}, "planned.npz is not what a run has"),
        ({"profile": "ros1"}, "profile 'ros1' instead of ros2"),
    ],
)  # fmt: skip
def test_what_is_no_runs_file_is_refused_in_a_line(short, tmp_path, changes, line):
    broken = rewrite(short, tmp_path / "broken.mcap", **changes)
    with pytest.raises(RecorderError) as caught:
        read_run_log(broken)
    assert str(caught.value).startswith(f"{broken}: ") and line in str(caught.value)
    assert "\n" not in str(caught.value) and ";" in str(caught.value)
