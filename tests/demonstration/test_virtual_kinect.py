from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import butter, sosfiltfilt
from virtual_sensors import BONES, PERFECT

from drake_blfdmp.demonstration.demonstration import KnownDimensions
from drake_blfdmp.demonstration.modelled_person import ModelledPerson, held_interval, hold_and_place
from drake_blfdmp.demonstration.virtual_kinect import VirtualKinect, film, record_hold_and_place
from drake_blfdmp.errors import RecordingError
from drake_blfdmp.skeleton import HANDS
from drake_blfdmp.skill.geometry import link_lengths

SEEDS = range(40)


@cache
def recordings():
    return [record_hold_and_place(seed=seed) for seed in SEEDS]


def held(t):
    start, end = held_interval()
    return (t >= start) & (t <= end)


def smoothed(recording):
    """Uniform 30 Hz, then a fourth-order zero-phase 1.5 Hz Butterworth: what a learner makes of the file."""
    t, first = np.unique(recording.t, return_index=True)
    clock = np.arange(0.0, t[-1] + 1e-9, 1 / 30)
    flat = recording.x[first].reshape(len(t), -1)
    flat = np.stack([np.interp(clock, t, column) for column in flat.T], axis=-1)
    return clock, sosfiltfilt(butter(4, 1.5, fs=30.0, output="sos"), flat, axis=0).reshape(-1, 6, 3)


def test_is_labelled_synthetic_and_knows_the_person():
    recording, truth = record_hold_and_place(ModelledPerson(box_width=0.28), seed=7)
    assert recording.synthetic is True
    assert recording.source == "virtual Kinect (synthetic), seed 7"
    assert recording.known == KnownDimensions(0.22, 0.28, 0.28)
    assert recording.x.shape == truth.shape == (len(recording.t), 6, 3)
    assert np.isfinite(recording.x).all()


def test_same_seed_same_arrays_other_seed_other_arrays():
    a, b, c = record_hold_and_place(seed=3)[0], record_hold_and_place(seed=3)[0], record_hold_and_place(seed=4)[0]
    for name in ("t", "x", "frames"):
        np.testing.assert_array_equal(getattr(a, name), getattr(b, name))
    n = min(len(a.x), len(c.x))
    assert not np.array_equal(a.x[:n], c.x[:n])


def test_a_sensor_without_errors_returns_the_truth():
    recording, truth = record_hold_and_place(sensor=PERFECT)
    np.testing.assert_allclose(recording.x, truth, atol=1e-12)
    np.testing.assert_array_equal(recording.frames, np.arange(241))
    np.testing.assert_allclose(recording.t, np.arange(241) / 30)


def test_truth_on_another_clock_is_interpolated():
    t, x = hold_and_place(rate_hz=120.0)
    recording = film(PERFECT, t + 5.0, x, seed=0)
    np.testing.assert_allclose(recording.t, 5.0 + np.arange(241) / 30)
    np.testing.assert_allclose(recording.x, x[::4], atol=1e-9)


def test_effects_have_their_own_random_streams():
    noisy = replace(PERFECT, white_m=0.005)
    plain = record_hold_and_place(sensor=noisy, seed=1)[0]
    jumping = record_hold_and_place(sensor=replace(noisy, jump_rate_hz=2.0), seed=1)[0]
    np.testing.assert_array_equal(plain.x[:, [0, 1, 3, 4]], jumping.x[:, [0, 1, 3, 4]])
    changed = np.linalg.norm(plain.x - jumping.x, axis=-1)[:, [2, 5]] > 1e-9
    assert 0.05 < changed.mean() < 0.6


def test_hands_err_more_than_elbows_and_elbows_more_than_shoulders():
    for recording, truth in recordings():
        error = np.sqrt(np.mean(np.sum((recording.x - truth) ** 2, axis=-1), axis=0)).reshape(2, 3).mean(axis=0)
        assert error[0] < error[1] < error[2]
        assert 0.05 < error[2] < 0.11


def test_bones_vary_as_much_as_in_real_kinect_v1_carries():
    # UTKinect-Action3D, 19 carries: standard deviations 0.027 m (upper arm) and 0.035 m (forearm).
    lengths = np.concatenate([link_lengths(recording.x)[held(recording.t)] for recording, _ in recordings()])
    assert lengths[:, [0, 4]].std() == pytest.approx(0.027, rel=0.2)
    assert lengths[:, [1, 3]].std() == pytest.approx(0.035, rel=0.2)
    assert lengths[:, [1, 3]].mean() == pytest.approx(0.264, abs=0.015)


def test_hand_distance_wobbles_while_the_box_is_held():
    wobble = [link_lengths(recording.x)[held(recording.t), HANDS].std() for recording, _ in recordings()]
    assert 0.03 <= np.mean(wobble) <= 0.06
    assert 0.03 <= wobble[0] <= 0.06
    assert max(wobble) < 0.10


def test_hidden_hands_err_more_and_peak_near_fifteen_centimetres():
    seen = VirtualKinect(occlusion_drift_m=0.0, occlusion_pull_m=0.0)
    hidden, free, peaks = [], [], []
    for seed, (recording, truth) in zip(SEEDS, recordings(), strict=True):
        error = np.linalg.norm(recording.x - truth, axis=-1)[:, [2, 5]]
        inside = held(recording.t)
        peaks.append(error[inside].max())
        hidden.append(np.mean(error[inside] ** 2))
        without, _ = record_hold_and_place(sensor=seen, seed=seed)
        free.append(np.mean(np.sum((without.x - truth)[:, [2, 5]] ** 2, axis=-1)[inside]))
        away = (recording.t < 1.2) | (recording.t > 6.9)
        np.testing.assert_array_equal(recording.x[away], without.x[away])
    assert np.mean(hidden) > 1.25 * np.mean(free)
    assert 0.10 < np.median(peaks) < 0.18
    assert max(peaks) < 0.25


def test_starts_with_an_error():
    starts = [np.linalg.norm(recording.x[0] - truth[0], axis=-1).max() for recording, truth in recordings()]
    assert min(starts) > 0.02
    assert max(starts) < 0.16


def test_figure_8_range_survives_smoothing():
    # Fig. 8: elbow-wrist and elbow-shoulder distances within 0.13-0.32 m.
    raw = link_lengths(recordings()[0][0].x)[:, BONES]
    assert 0.12 <= raw.min() <= 0.16
    assert 0.30 <= raw.max() <= 0.345
    smooth = link_lengths(smoothed(recordings()[0][0])[1])[:, BONES]
    assert 0.12 <= smooth.min() <= 0.16
    assert 0.30 <= smooth.max() <= 0.34


def test_other_seeds_are_like_the_default():
    ranges = np.array([[s.min(), s.max()] for r, _ in recordings() for s in [link_lengths(smoothed(r)[1])[:, BONES]]])
    np.testing.assert_allclose(np.median(ranges, axis=0), [0.155, 0.32], atol=0.012)
    assert ranges[:, 0].min() > 0.12
    assert ranges[:, 1].max() < 0.42


def test_holding_and_lifting_stay_visible():
    for recording, _ in recordings():
        t, x = smoothed(recording)
        inside = held(t)
        distance = link_lengths(x)[:, HANDS]
        opened = np.mean([distance[(t > 1.1) & (t < 1.5)].mean(), distance[(t > 6.6) & (t < 7.0)].mean()])
        assert opened - np.median(distance[inside]) > 0.08
        height = x[:, [2, 5], 2].mean(axis=1)[inside]
        assert height.max() - np.mean([height[0], height[-1]]) > 0.2


def test_default_recording_tells_when_the_box_is_held():
    t, x = smoothed(recordings()[0][0])
    distance = link_lengths(x)[:, HANDS]
    below = t[distance < (distance.max() + np.median(distance[held(t)])) / 2]
    start, end = held_interval()
    middle = below[(below > start - 0.6) & (below < end + 0.6)]
    assert middle[0] == pytest.approx(start, abs=0.5)
    assert middle[-1] == pytest.approx(end, abs=0.5)
    assert np.diff(middle).max() < 0.05


@pytest.mark.parametrize(
    ("effect", "untouched"),
    [
        ({"misfit_rate_hz": 1.0}, [0, 3]),
        ({"white_grading": (0.5, 1.0, 2.0)}, [1, 4]),
        ({"absent_share": 0.2}, [0, 1, 2, 3, 4, 5]),
    ],
)
def test_a_further_effect_leaves_the_other_streams_alone(effect, untouched):
    plain = record_hold_and_place(seed=5)[0]
    more = record_hold_and_place(sensor=VirtualKinect(**effect), seed=5)[0]
    np.testing.assert_array_equal(plain.frames, more.frames)
    present = np.isfinite(more.x).all(axis=(1, 2))
    np.testing.assert_array_equal(plain.x[present][:, untouched], more.x[present][:, untouched])
    assert not np.array_equal(plain.x, more.x)


@settings(max_examples=25, deadline=None)
@given(rate=st.floats(5.0, 120.0), correlation=st.floats(1e-3, 1e4), seed=st.integers(0, 2**32))
def test_any_sensor_stays_finite_and_bounded(rate, correlation, seed):
    sensor = VirtualKinect(rate_hz=rate, correlation_s=correlation, jump_rate_hz=0.0)
    recording, truth = record_hold_and_place(sensor=sensor, seed=seed)
    assert np.isfinite(recording.x).all()
    assert np.abs(recording.x - truth).max() < 0.3  # Drift, occlusion and shortening are bounded, white noise is small.


def test_without_a_known_box_hands_are_never_hidden():
    t, x = hold_and_place()
    sensor = replace(PERFECT, occlusion_pull_m=0.05)
    np.testing.assert_allclose(film(sensor, t, x, seed=0).x, x, atol=1e-12)
    pulled = film(sensor, t, x, seed=0, known=KnownDimensions(box_width=0.30))
    np.testing.assert_allclose(link_lengths(pulled.x)[held(t), HANDS], 0.20, atol=1e-9)


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        ({"rate_hz": 0.0}, "rate_hz"),
        ({"correlation_s": 0.0}, "correlation_s"),
        ({"white_m": -0.1}, "white_m"),
        ({"drop_probability": 1.0}, "drop_probability"),
        ({"repeat_probability": np.nan}, "repeat_probability"),
        ({"shortening": 1.0}, "shortening"),
    ],
)
def test_bad_sensor_is_named(arguments, word):
    with pytest.raises(RecordingError, match=word):
        VirtualKinect(**arguments)


def test_bad_truth_is_refused():
    t, x = hold_and_place()
    broken = x.copy()
    broken[5, 2, 1] = np.nan
    for arguments, word in (
        ((t, x[:-1]), "shape|N, 6, 3"),
        ((t, broken), "finite"),
        ((t[::-1], x), "sample 1"),
        ((t[:1], x[:1]), "2 or more"),
    ):
        with pytest.raises(RecordingError, match=word):
            film(VirtualKinect(), *arguments, seed=0)
    with pytest.raises(RecordingError, match="seed is -1"):
        record_hold_and_place(seed=-1)
