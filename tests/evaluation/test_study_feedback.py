"""The study of the loop around the palms: its claims against hand-made runs, and a quick run of the whole."""

import importlib.util
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from drake_blfdmp.evaluation.studies.feedback_runs import FeedbackRun, feedback_row
from drake_blfdmp.evaluation.study import StudyContext
from drake_blfdmp.planning.scenario import LoadScenario

STUDIES = Path(__file__).resolve().parents[2] / "studies"
T = np.arange(401) / 100.0
PUSH = 2.0


@pytest.fixture(scope="module")
def script():
    spec = importlib.util.spec_from_file_location("feedback", STUDIES / "feedback.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def run(offset=0.0, force=55.0, tempo=1.0, success=True, dropped=False):
    """Held from 1 to 3 s; offset and tempo are numbers or (401,)."""
    offset, tempo = np.broadcast_to(offset, T.shape), np.broadcast_to(tempo, T.shape)
    log = SimpleNamespace(t=T, tempo=tempo, palm_force=np.full((len(T), 2), force))
    summary = {
        "box": {"placement_error_m": 0.002, "max_tilt_deg": 0.3, "dropped": dropped},
        "feedback": {"min_tempo": float(tempo.min()), "delay_s": 0.1},
        "success": success,
        "failures": [] if success else ["It fell."],
    }
    return FeedbackRun(log, (T >= 1.0) & (T <= 3.0), offset, np.full(T.shape, 0.01), summary)


def outside(*spans):
    """12 mm off in the spans of time, 1 mm otherwise."""
    return np.where(np.any([np.abs(T - 0.5 * (a + b)) <= 0.5 * (b - a) + 1e-9 for a, b in spans], axis=0), 0.012, 0.001)


def test_a_row_counts_what_is_outside_while_the_box_is_held():
    row = feedback_row(run(outside((0.5, 0.8), (1.5, 1.59), (3.5, 3.6)), force=50.0))
    assert row["outside_held_s"] == pytest.approx(0.10)
    assert row["worst_offset_held_m"] == pytest.approx(0.012)
    assert row["force_least_n"] == row["force_mean_n"] == row["force_most_n"] == 50.0


@pytest.mark.parametrize(
    ("closed", "holds"), [({}, True), ({"force": 62.0}, False), ({"offset": outside((1.5, 1.6))}, False)]
)
def test_a_box_of_another_width_needs_band_and_force(script, closed, holds):
    world = "box 10 mm wider"
    (claim,) = script.widths({(world, "open"): run(force=83.0), (world, "closed"): run(**closed)}, 55.0)
    assert claim.holds is holds
    assert "planned 55 N" in claim.measured and "mean 83 N" in claim.measured


def test_pushes_are_answered_by_the_last_sample_outside(script):
    world = "pushed out, 40 N"
    spans = {"open": (2.0, 2.2), "closed": (2.0, 2.05)}
    runs = {(world, loop): run(outside(span)) for loop, span in spans.items()}
    back, kept = script.pushes(runs, PUSH)
    assert back.holds is True and "closed 50 ms, open 200 ms" in back.measured
    assert kept.holds is True
    runs[world, "closed"] = run(outside((2.0, 2.15)), dropped=True)
    back, kept = script.pushes(runs, PUSH)
    assert back.holds is False and kept.holds is False


def test_a_phase_has_to_slow_down_and_resume(script):
    slow = np.where((T > 2.0) & (T < 2.3), 0.8, 1.0)
    runs = {(world, "closed"): run(tempo=slow) for world in script.SLOWED}
    assert script.phase(runs)[0].holds is True
    assert script.phase({**runs, ("as believed", "closed"): run(tempo=slow)})[0].holds is False
    stays = np.where(T > 2.0, 0.8, 1.0)
    assert script.phase({**runs, (script.SLOWED[0], "closed"): run(tempo=stays)})[0].holds is False
    assert script.phase({(world, "closed"): run() for world in script.SLOWED})[0].holds is False


def test_every_world_has_to_succeed_with_the_loop_closed(script):
    runs = {("a", "open"): run(success=False), ("a", "closed"): run()}
    assert script.carried(runs).holds is True
    assert "open: a" in script.carried(runs).measured
    failed = script.carried({**runs, ("a", "closed"): run(success=False)})
    assert failed.holds is False and failed.why == "It fell."


def test_the_quick_study_carries_a_wider_box_with_both_loops(script, redrawn):
    scenario = LoadScenario(STUDIES / "feedback.yaml")
    result = script.study(StudyContext(scenario, True, lambda what, share: None, None))
    assert set(redrawn(result)) == {"bands", "tempo"}
    table = result.tables["runs"].columns
    assert list(table["loop"]) == ["open", "closed"]
    opened, closed = table["force_mean_n"]
    # Ten millimetres more between arms of 0.43 mm/N press with 23 N more, unless the loop takes it back.
    assert opened > 75.0
    assert closed == pytest.approx(55.0, abs=4.0)
