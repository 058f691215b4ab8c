"""The study of Fig. 11: its claims against hand-made rows, and a quick run of the whole."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest

from drake_blfdmp.evaluation.study import StudyContext
from drake_blfdmp.planning.scenario import LoadScenario

STUDIES = Path(__file__).resolve().parents[2] / "studies"


@pytest.fixture(scope="module")
def script():
    spec = importlib.util.spec_from_file_location("two_frankas", STUDIES / "two_frankas.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def quick(script):
    told = []
    scenario = LoadScenario(STUDIES / "two_frankas.yaml")
    context = StudyContext(scenario, True, lambda what, share: told.append((what, share)), None)
    return script.study(context), told


def line(rms, margin=0.4):
    return {
        "swivel_rms_left_deg": rms,
        "swivel_rms_right_deg": 0.5 * rms,
        "swivel_elbow_off_m": 0.002 * rms,
        "joint_margin_min_rad": margin,
    }


def test_postures_are_judged_by_the_worse_arm(script):
    target = script.TARGET_DEG
    rows = {"swivel": line(0.9 * target), "none": line(30.0), "published": line(64.0, 0.1)}
    right, printed = script.postures(rows)
    assert right.holds is True
    assert "30.00 (left)" in right.measured
    assert printed.holds is False
    assert "speed" in printed.why
    assert "0.10 rad in place of 0.40" in printed.measured
    right, printed = script.postures(rows | {"swivel": line(1.1 * target), "published": line(0.5 * target)})
    assert right.holds is False
    assert right.why
    assert printed.holds is True


def test_the_bases_are_the_papers(script):
    claim = script.bases()
    assert claim.holds is True
    assert claim.measured == "[0.2, 0.0, 0.4] and [-0.2, 0.0, 0.4] m"


def test_a_quick_run_carries_the_box_and_judges_what_it_measured(quick):
    study, told = quick
    holds = {claim.paper: claim.holds for claim in study.claims}
    assert list(holds.values()) == [True, True, True, None]
    table = study.tables["settings"].columns
    assert list(table["setting"]) == ["swivel"]
    assert list(table["success"]) == ["yes"]
    assert 0.0 < table["swivel_rms_left_deg"][0] < 2.0
    assert 0.0 < table["palm_tracking_rms_m"][0] < 0.03
    series = study.tables["swivel"].columns
    assert np.abs(np.diff(series["swivel_left_asked_rad"])).max() > 0.0
    assert {"simulating swivel"} < {what for what, _ in told}


def test_a_quick_runs_figures_have_captions_and_content(quick, redrawn):
    study, _ = quick
    figures = redrawn(study)
    assert set(figures) == set(study.captions) == {"stills", "swivel", "squeeze"}
    shown = [axis.get_images()[0].get_array() for axis in figures["stills"].axes]
    assert len(shown) == 6  # Grasp and carry; person, skill and robots.
    for image in shown:
        assert 0.03 < np.mean(np.asarray(image)[..., 3]) < 0.9
    assert [axis.get_ylabel() for axis in figures["swivel"].axes][::2] == [
        "swivel (deg)",
        "elbow off\nits place (mm)",
    ]
