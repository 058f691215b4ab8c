"""The truth beside a motion: a sensor that does not err finds it, one that does misses it by what it errs."""

from functools import partial
from pathlib import Path

import numpy as np

from drake_blfdmp.demonstration.virtual_kinect import VirtualKinect, record_hold_and_place
from drake_blfdmp.evaluation.studies.truth import against_truth, by_kind
from drake_blfdmp.planning import sources
from drake_blfdmp.planning.scenario import LoadScenario

STUDIES = Path(__file__).resolve().parents[3] / "studies"
SILENT = VirtualKinect(
    shoulder_drift_m=0,
    elbow_drift_m=0,
    wrist_drift_m=0,
    occlusion_drift_m=0,
    occlusion_pull_m=0,
    shortening=0,
    white_m=0,
    jump_rate_hz=0,
)


def test_with_a_sensor_that_does_not_err_the_original_is_the_truth(monkeypatch):
    """Clock, frame and shift of the truth are the motion's own: what is left is the smoothing."""
    monkeypatch.setattr(sources, "record_hold_and_place", partial(record_hold_and_place, sensor=SILENT))
    scenario = LoadScenario(STUDIES / "trajectories.yaml")
    table = against_truth(scenario, range(1)).columns
    for kind, smoothing in (("shoulders", 0.0005), ("elbows", 0.003), ("hands", 0.004)):
        assert np.max(table[f"original_{kind}_rms_m"]) < smoothing


def test_a_sensor_that_errs_is_off_by_more_where_it_errs_more(default_scenario):
    told = []
    table = against_truth(default_scenario, range(2), lambda what, share: told.append((what, share))).columns
    assert list(table["seed"]) == [0, 1]
    assert told == [("seed 0", 0.0), ("seed 1", 0.5)]
    shoulders, elbows, hands = (np.mean(table[f"original_{kind}_rms_m"]) for kind in ("shoulders", "elbows", "hands"))
    assert 0.002 < shoulders < elbows < hands < 0.1
    assert np.ptp(table["original_hands_rms_m"]) > 1e-4  # Every seed films anew.


def test_distances_are_those_of_the_kinds_points():
    a = np.zeros((4, 6, 3))
    b = a + np.array([1.0, 2.0, 3.0, 1.0, 2.0, 3.0])[:, None] * [0.0, 0.6, 0.8]
    assert by_kind(a, b) == {"shoulders": 1.0, "elbows": 2.0, "hands": 3.0}
