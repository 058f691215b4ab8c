"""The sensor's error as the recording tells it, against what it really is."""

import numpy as np
import pytest

from drake_blfdmp.demonstration.cleaning import clean
from drake_blfdmp.demonstration.demonstration import KnownDimensions
from drake_blfdmp.demonstration.sensors import VirtualKinect
from drake_blfdmp.demonstration.uncertainty import estimate_error, white_noise
from drake_blfdmp.demonstration.virtual_kinect import record_hold_and_place

FACTOR = 1.75
"""Between the estimated standard deviation and the true one; a take of 8 s holds some five independent errors."""


def true_error(x, truth):
    return np.sqrt(np.mean((x - truth) ** 2, axis=(0, 2)))


@pytest.mark.parametrize("correlation_s", [0.1, 0.8])
def test_within_a_factor_of_the_truth(person, correlation_s):
    t, truth = person
    ratios = []
    for seed in range(4):
        recording, _ = record_hold_and_place(sensor=VirtualKinect(correlation_s=correlation_s), seed=seed)
        demonstration = clean(recording)
        exact = np.stack([np.interp(demonstration.t, t, c) for c in truth.reshape(len(t), -1).T], -1).reshape(-1, 6, 3)
        assert demonstration.uncertainty.shape == (6,)
        ratios.append(demonstration.uncertainty / true_error(demonstration.x, exact))
    assert np.min(ratios) > 1.0 / FACTOR
    assert np.max(ratios) < FACTOR


def test_it_scales_with_the_error(person):
    _, truth = person
    noise = np.cumsum(np.random.default_rng(0).normal(size=truth.shape), axis=0)
    noise -= noise.mean(axis=0)
    small, large = (estimate_error(truth + size * noise).per_point for size in (1e-3, 2e-3))
    np.testing.assert_allclose(large / small, 2.0, rtol=0.1)


def test_a_perfect_sensor_has_none(person):
    assert estimate_error(person[1]).per_point.max() < 1e-3


@pytest.mark.parametrize("size", [0.002, 0.02])
def test_white_noise_is_found_without_the_motion(person, size):
    noise = size * np.array([0.5, 1.0, 2.0, 0.5, 1.0, 2.0])
    x = person[1] + noise[:, None] * np.random.default_rng(1).normal(size=person[1].shape)
    np.testing.assert_allclose(white_noise(x), noise, rtol=0.15)
    error = estimate_error(x)
    np.testing.assert_allclose(error.per_point, noise, rtol=0.35)


def test_known_bones_show_a_bias(person):
    x = person[1]
    error = estimate_error(x, KnownDimensions(upper_arm=0.25, forearm=0.28))
    np.testing.assert_allclose(error.bias, [-0.03, 0.0], atol=1e-6)
    assert error.per_point[1] == pytest.approx(0.03 / np.sqrt(3.0), rel=0.05)


def test_slow_errors_have_a_slow_spectrum_and_what_joints_share_is_seen():
    chain = estimate_error(clean(record_hold_and_place(seed=3)[0]).x)
    assert chain.spectrum[:, :10].min() > chain.spectrum[:, -10:].max()
    share = chain.shared / chain.variance[:2]
    assert share[0] > 0.4
    assert share[1] > 0.9


def test_errors_of_their_own_are_not_shared(person):
    for seed in range(3):
        error = estimate_error(person[1] + 0.01 * np.random.default_rng(seed).normal(size=person[1].shape))
        assert (error.shared < 0.35 * error.variance[:2]).all()
        np.testing.assert_allclose(error.variance, 1e-4, rtol=0.4)
