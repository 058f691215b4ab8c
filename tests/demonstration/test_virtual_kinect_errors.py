"""Each of the virtual Kinect's errors alone: it is as large as it says, and moves what it says."""

from dataclasses import replace

import numpy as np
import pytest
from virtual_sensors import BONES, PERFECT

from drake_blfdmp.demonstration.modelled_person import hold_and_place
from drake_blfdmp.demonstration.virtual_kinect import (
    VirtualKinect,
    film,
    record_hold_and_place,
    rough_noise,
    slow_noise,
)
from drake_blfdmp.skill.geometry import link_lengths


def test_frames_are_dropped_and_repeated_at_the_stated_rates():
    sensor = VirtualKinect(drop_probability=0.10, repeat_probability=0.05)
    t, x = hold_and_place(rate_hz=30.0, duration_s=400.0)
    recording = film(sensor, t, x, seed=0)
    present = np.unique(recording.frames)
    assert 1 - len(present) / len(t) == pytest.approx(0.10, abs=0.015)
    repeated = np.flatnonzero(np.diff(recording.frames) == 0)
    assert len(repeated) / len(present) == pytest.approx(0.05, abs=0.01)
    np.testing.assert_array_equal(recording.x[repeated], recording.x[repeated + 1])
    np.testing.assert_array_equal(recording.t[repeated], recording.t[repeated + 1])
    assert (np.diff(recording.frames) >= 0).all()
    np.testing.assert_allclose(recording.t, recording.frames / 30)


def test_slow_noise_has_the_stated_covariance():
    noise = slow_noise(np.random.default_rng(0), 600, (2000,), 1 / 30, correlation_s=0.8)
    np.testing.assert_allclose(noise.var(axis=1).mean(), 1.0, atol=0.02)
    for lag in (3, 12, 30, 60):
        h = 2 / 0.8 * lag / 30
        assert np.mean(noise[:-lag] * noise[lag:]) == pytest.approx((1 + h) * np.exp(-h), abs=0.02)


def test_rough_noise_has_the_stated_covariance():
    noise = rough_noise(np.random.default_rng(0), 600, (2000,), 1 / 30, correlation_s=0.8)
    np.testing.assert_allclose(noise.var(axis=1), 1.0, atol=0.15)
    for lag in (1, 3, 12, 30, 60):
        assert np.mean(noise[:-lag] * noise[lag:]) == pytest.approx(np.exp(-lag / 30 / 0.8), abs=0.02)


def test_rough_errors_have_the_same_size_and_more_jitter():
    smooth = replace(PERFECT, elbow_drift_m=0.03)
    sizes, jitters = [], []
    for sensor in (smooth, replace(smooth, rough=True)):
        takes = [record_hold_and_place(None, sensor, seed) for seed in range(30)]
        errors = np.stack([(recording.x - truth)[:, [1, 4]] for recording, truth in takes])
        sizes.append(errors.std())
        jitters.append(np.diff(errors, n=2, axis=1).std())
    np.testing.assert_allclose(sizes, 0.03, rtol=0.1)
    one, two = np.exp(-np.array([1, 2]) / 30 / smooth.correlation_s)
    assert jitters[1] == pytest.approx(0.03 * np.sqrt(6 - 8 * one + 2 * two), rel=0.05)
    assert jitters[0] < 0.3 * jitters[1]


def test_a_misfitted_arm_keeps_its_shoulder_and_bones_and_says_so():
    sensor = replace(PERFECT, misfit_rate_hz=0.3, misfit_angle=0.8, misfit_confidence=0.5)
    takes = [record_hold_and_place(sensor=sensor, seed=seed) for seed in range(20)]
    for recording, truth in takes:
        np.testing.assert_allclose(recording.x[:, [0, 3]], truth[:, [0, 3]], atol=1e-12)
        np.testing.assert_allclose(link_lengths(recording.x)[:, BONES], link_lengths(truth)[:, BONES], atol=1e-12)
    off = np.concatenate([np.linalg.norm(recording.x - truth, axis=-1) for recording, truth in takes])
    confidence = np.concatenate([recording.confidence for recording, _ in takes])
    assert off[:, [2, 5]].max() > 0.3
    assert set(np.unique(confidence)) == {0.5, 1.0}
    assert (confidence[:, [0, 3]] == 1).all()
    np.testing.assert_array_equal(confidence[:, [1, 4]], confidence[:, [2, 5]])
    guessed = confidence[:, [2, 5]] < 1
    assert 0.05 < guessed.mean() < 0.5
    assert off[:, [2, 5]][guessed].min() > off[:, [2, 5]][~guessed].mean()


def test_an_inferred_wrist_says_so():
    sensor = replace(PERFECT, jump_rate_hz=1.0, jump_m=0.05, jump_duration_s=0.2)
    recording, truth = record_hold_and_place(sensor=sensor, seed=2)
    moved = np.linalg.norm(recording.x - truth, axis=-1) > 1e-9
    assert 0.05 < moved[:, [2, 5]].mean() < 0.5
    np.testing.assert_array_equal(recording.confidence, np.where(moved, 0.5, 1.0))
    assert recording.up == "z"


def test_a_rigid_body_errs_in_direction_only():
    sensor = replace(PERFECT, elbow_drift_m=0.03, wrist_drift_m=0.03, white_m=0.01, rigid=True)
    recording, truth = record_hold_and_place(sensor=sensor)
    np.testing.assert_allclose(link_lengths(recording.x)[:, BONES], link_lengths(truth)[:, BONES], atol=1e-12)
    assert np.linalg.norm(recording.x - truth, axis=-1)[:, [2, 5]].mean() > 0.02


def test_body_scale_stretches_all_bones_and_the_shoulders_alike():
    sensor = replace(PERFECT, body_scale=0.05)
    scales = []
    for seed in range(40):
        recording, truth = record_hold_and_place(sensor=sensor, seed=seed)
        ratio = link_lengths(recording.x)[:, BONES] / link_lengths(truth)[:, BONES]
        across = np.linalg.norm(recording.x[:, 3] - recording.x[:, 0], axis=-1) / 0.36
        np.testing.assert_allclose(ratio, np.repeat(across[:, None], 4, axis=1), rtol=1e-9)
        scales.append(ratio[:, 0])
    assert np.std(scales) == pytest.approx(0.05, rel=0.15)
    assert np.mean(scales) == pytest.approx(1.0, abs=0.01)


def test_frames_without_a_body_stand_at_the_ends_and_hold_nothing():
    sensor = replace(PERFECT, absent_share=0.1)
    before = []
    for seed in range(30):
        recording, _ = record_hold_and_place(sensor=sensor, seed=seed)
        empty = np.isnan(recording.x).all(axis=(1, 2))
        assert empty.sum() == 24 and not np.isnan(recording.x[~empty]).any()
        np.testing.assert_array_equal(recording.confidence, np.repeat(np.where(empty, 0.0, 1.0)[:, None], 6, axis=1))
        kept = np.flatnonzero(~empty)
        assert (np.diff(kept) == 1).all()
        before.append(kept[0])
    assert min(before) < 6 and max(before) > 18


def test_a_take_of_two_frames_keeps_them():
    t, x = hold_and_place()
    recording = film(replace(PERFECT, rate_hz=0.2, absent_share=0.9), t, x, seed=0)
    assert len(recording.t) == 2 and np.isfinite(recording.x).all()


def test_white_noise_is_graded():
    sensor = replace(PERFECT, white_m=0.01, white_grading=(0.5, 1.0, 2.0))
    recording, truth = record_hold_and_place(sensor=sensor)
    found = (recording.x - truth).std(axis=(0, 2))
    np.testing.assert_allclose(found, np.tile([0.005, 0.01, 0.02], 2), rtol=0.1)
