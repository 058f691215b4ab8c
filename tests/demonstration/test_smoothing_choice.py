"""The smoothing that the data choose leaves hardly more error than the best that the truth would choose."""

import numpy as np
import pytest
from scipy.interpolate import make_smoothing_spline

from drake_blfdmp.demonstration.cleaning import clean
from drake_blfdmp.demonstration.sensors import VirtualKinect
from drake_blfdmp.demonstration.smoothing import smooth
from drake_blfdmp.demonstration.smoothing_choice import (
    KINDS,
    METHODS,
    apply_smoothing,
    choose_smoothing,
    describe_smoothing,
)
from drake_blfdmp.demonstration.uncertainty import estimate_error
from drake_blfdmp.demonstration.virtual_kinect import record_hold_and_place

CUTOFFS = np.geomspace(0.4, 12.0, 20)
STILL = {"occlusion_drift_m": 0.0, "occlusion_pull_m": 0.0, "jump_rate_hz": 0.0, "shortening": 0.0}
NO_DRIFT = {"shoulder_drift_m": 0.0, "elbow_drift_m": 0.0, "wrist_drift_m": 0.0} | STILL
SENSORS = {
    "white": VirtualKinect(white_m=0.01, **NO_DRIFT),
    "fast": VirtualKinect(correlation_s=0.08, **STILL),
    "slow": VirtualKinect(correlation_s=0.8, **STILL),
}


def filmed(sensor, person, seed):
    """(demonstration, truth on its clock)."""
    t, truth = person
    demonstration = clean(record_hold_and_place(sensor=sensor, seed=seed)[0])
    exact = np.stack([np.interp(demonstration.t, t, c) for c in truth.reshape(len(t), -1).T], -1).reshape(-1, 6, 3)
    return demonstration, exact


def rms(x, truth, kind):
    return float(np.sqrt(np.mean((x - truth)[:, KINDS[kind]] ** 2)))


def chosen_error(demonstration, truth, kind, methods=METHODS):
    error = estimate_error(demonstration.x)
    chosen = choose_smoothing(demonstration.x, demonstration.rate_hz, error, methods)
    return rms(apply_smoothing(demonstration.t, demonstration.x, chosen), truth, kind)


@pytest.mark.parametrize("name", list(SENSORS))
def test_nearly_as_good_as_chosen_by_the_truth(person, name):
    auto, best, raw = [], [], []
    for seed in range(3):
        demonstration, truth = filmed(SENSORS[name], person, seed)
        auto.append(chosen_error(demonstration, truth, "wrists"))
        filtered = [smooth(demonstration.t, demonstration.x, cutoff) for cutoff in CUTOFFS]
        best.append(min(rms(x, truth, "wrists") for x in filtered))
        raw.append(rms(demonstration.x, truth, "wrists"))
    assert np.mean(auto) < 1.15 * np.mean(best)
    assert np.mean(auto) < {"white": 0.45, "fast": 0.65, "slow": 1.02}[name] * np.mean(raw)


def test_cross_validation_keeps_an_error_that_is_slow(person):
    """Why the bones are asked: between neighbours a slow error looks like motion."""
    demonstration, truth = filmed(VirtualKinect(correlation_s=0.15, **STILL), person, 0)
    columns = demonstration.x[:, KINDS["wrists"]].reshape(len(demonstration.t), -1).T
    crossed = demonstration.x.copy()
    crossed[:, KINDS["wrists"]] = np.stack(
        [make_smoothing_spline(demonstration.t, column)(demonstration.t) for column in columns], axis=-1
    ).reshape(-1, 2, 3)
    assert chosen_error(demonstration, truth, "wrists") < 0.8 * rms(crossed, truth, "wrists")


@pytest.mark.parametrize("method", METHODS)
def test_each_method_alone(person, method):
    demonstration, truth = filmed(SENSORS["white"], person, 1)
    error = estimate_error(demonstration.x)
    chosen = choose_smoothing(demonstration.x, demonstration.rate_hz, error, (method,))
    assert {choice.method for choice in chosen.values()} == {method}
    assert chosen_error(demonstration, truth, "wrists", (method,)) < 0.5 * rms(demonstration.x, truth, "wrists")
    assert method in describe_smoothing(chosen, error)


def test_the_estimated_error_is_about_right(person):
    for name in ("white", "fast"):
        demonstration, truth = filmed(SENSORS[name], person, 0)
        error = estimate_error(demonstration.x)
        chosen = choose_smoothing(demonstration.x, demonstration.rate_hz, error)
        left = rms(apply_smoothing(demonstration.t, demonstration.x, chosen), truth, "wrists")
        assert 0.5 < chosen["wrists"].error_m / left < 2.0


def test_ends_and_straight_lines_stay():
    t = np.arange(200) / 30.0
    line = (0.3 + 0.2 * t)[:, None, None] * np.ones((6, 3))
    x = line + 0.005 * np.random.default_rng(0).normal(size=line.shape)
    error = estimate_error(x + np.arange(18).reshape(6, 3))  # Bones of some length.
    y = apply_smoothing(t, x, choose_smoothing(x, 30.0, error))
    assert np.abs(y - line).max() < 0.006
    assert np.sqrt(np.mean((y - line) ** 2)) < 0.5 * np.sqrt(np.mean((x - line) ** 2))


def test_nothing_is_smoothed_where_nothing_errs():
    t = np.arange(200) / 30.0
    x = np.sin(t)[:, None, None] * np.ones((6, 3)) + np.arange(18).reshape(6, 3)
    chosen = choose_smoothing(x, 30.0, estimate_error(x))
    y = apply_smoothing(t, x, chosen)
    assert np.abs(y - x).max() < 1e-3
