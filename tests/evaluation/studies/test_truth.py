"""The truth beside a motion: a sensor that does not err finds it, one that does misses it by what it errs."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from drake_blfdmp.demonstration.virtual_kinect import VirtualKinect, record_hold_and_place
from drake_blfdmp.evaluation.studies.truth import against_truth, by_kind, true_points
from drake_blfdmp.planning import sources
from drake_blfdmp.planning.scenario import LoadScenario
from drake_blfdmp.planning.sources import LoadSource

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


def silent(person=None, sensor=None, seed=0, film=record_hold_and_place):
    """Films with the silent sensor, or the one a test asks for, whatever the scenario names."""
    return film(person=person, sensor=sensor or SILENT, seed=seed)


def test_with_a_sensor_that_does_not_err_the_original_is_the_truth(monkeypatch):
    """Clock, frame and shift of the truth are the motion's own: what is left is the smoothing."""
    monkeypatch.setattr(sources, "record_hold_and_place", silent)
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


@pytest.mark.parametrize("frame", ["torso", "world"])
def test_several_takes_have_the_mean_of_their_truths(monkeypatch, frame):
    monkeypatch.setattr(sources, "record_hold_and_place", silent)
    settings = ["synthetic.takes=2", f"recording.frame={frame}"]
    table = against_truth(LoadScenario(STUDIES / "trajectories.yaml", settings), range(1)).columns
    for kind, smoothing in (("shoulders", 0.0005), ("elbows", 0.003), ("hands", 0.004)):
        assert np.max(table[f"original_{kind}_rms_m"]) < smoothing


def test_a_person_found_late_is_compared_from_then_on(monkeypatch):
    """Azure's first frames hold no body; the cleaned clock starts after them."""
    late = replace(SILENT, absent_share=0.06)
    monkeypatch.setattr(sources, "record_hold_and_place", lambda person, sensor, seed: silent(person, late, seed))
    table = against_truth(LoadScenario(STUDIES / "trajectories.yaml", ["seed=1"]), range(1, 2)).columns
    recording, _ = record_hold_and_place(sensor=late, seed=1)
    assert np.isnan(recording.x[:3]).all()
    assert np.max(table["original_hands_rms_m"]) < 0.004


def test_the_truth_is_put_into_the_frame_of_the_recording_as_it_was_cleaned():
    """Restored bones move the shoulders, and with them the torso's frame."""
    settings = ["recording.cleaning.restore_bones=true", "seed=3"]
    scenarios = [LoadScenario(STUDIES / "trajectories.yaml", each) for each in (settings, settings[1:])]
    restored, plain = (true_points(each, LoadSource(each)) for each in scenarios)
    assert 1e-4 < np.abs(restored - plain).max() < 0.1
