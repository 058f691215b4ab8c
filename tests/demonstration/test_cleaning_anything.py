"""Whatever comes is cleaned or refused in one line."""

import warnings
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from synthetic_carry import carry, recording

from drake_blfdmp.demonstration.cleaning import CleaningOptions, clean
from drake_blfdmp.errors import RecordingError
from drake_blfdmp.skeleton import POINTS

_, X = carry()
NUMBERS = st.floats(-2.0, 2.0) | st.sampled_from([0.0, np.nan, np.inf, -np.inf, 1e-300, 1e5, 1e7, 1e200, -1e308])
CLOCKS = {
    "even": lambda n, rng: np.arange(n) / 30.0,
    "uneven": lambda n, rng: np.sort(rng.uniform(0.0, 5.0, n)),
    "backwards": lambda n, rng: -np.arange(n) / 30.0,
    "shuffled": lambda n, rng: rng.permutation(n) / 30.0,
    "constant": lambda n, rng: np.full(n, 7.0),
    "doubled": lambda n, rng: np.arange(n) // 2 / 15.0,
    "huge": lambda n, rng: 1e9 + np.arange(n) / 30.0,
    "hopeless": lambda n, rng: 10.0 ** rng.uniform(-300, 300, n),
    "negative": lambda n, rng: -1e6 + np.arange(n) / 30.0,
    "bursts": lambda n, rng: np.cumsum(10.0 ** rng.uniform(-9, 0, n)),
}
OPTIONS = [
    CleaningOptions(),
    CleaningOptions(smoothing="auto", restore_bones=True, restore_hold=True),
    CleaningOptions(remove_jumps=False, undo_swaps=False, drop_repeats=False, interpolation="linear", up="-x"),
    CleaningOptions(redo_depths=True, smoothing="spline", max_gap_s=100.0, up="y"),
]


@settings(max_examples=150, deadline=None)
@given(
    count=st.integers(0, 12) | st.integers(30, 60),
    clock=st.sampled_from(sorted(CLOCKS)),
    like_a_person=st.booleans(),
    spoiled=st.lists(st.tuples(st.integers(0, 59), st.integers(0, 6), st.integers(1, 30), NUMBERS), max_size=5),
    options=st.sampled_from(OPTIONS),
    seed=st.integers(0, 1000),
)
def test_whatever_comes_is_cleaned_or_refused(count, clock, like_a_person, spoiled, options, seed):
    rng = np.random.default_rng(seed)
    x = X[60 : 60 + count].copy() if like_a_person else rng.normal(scale=0.15, size=(count, 6, 3))
    for start, point, length, number in spoiled:
        x[start : start + length, point if point < 6 else slice(None)] = number
    given_recording = replace(
        recording(CLOCKS[clock](count, rng), x), confidence=rng.choice([0.0, 0.5, 1.0], (count, 6), p=[0.02, 0.1, 0.88])
    )
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            demonstration = clean(given_recording, options)
        except RecordingError as error:
            assert str(error).startswith("test.csv: ")
            assert "\n" not in str(error)
            return
    assert np.isfinite(demonstration.x).all()
    assert demonstration.x.shape == (len(demonstration.t), len(POINTS), 3)
    np.testing.assert_allclose(np.diff(demonstration.t), 1.0 / demonstration.rate_hz, rtol=1e-3)
    assert demonstration.t[0] == 0.0
    assert np.isfinite(demonstration.uncertainty).all()
    assert min(demonstration.repairs.values()) >= 0


@pytest.mark.parametrize("seed", range(3))
def test_a_long_recording_of_everything_at_once(seed):
    rng = np.random.default_rng(seed)
    x = np.concatenate([X, X[-2:0:-1]] * 12) + 0.004 * rng.normal(size=(12 * (2 * len(X) - 2), 6, 3))
    t, truth = np.arange(len(x)) / 30.0, x.copy()
    for start in range(100, len(x) - 100, 60):
        kind, point = rng.integers(3), rng.integers(6)
        stretch = slice(start, start + 1 + rng.integers(8))
        if kind == 0:
            x[stretch, point] += [0.5, 0.3, 0.4]
        elif kind == 1:
            x[stretch, point] = np.nan
        else:
            x[stretch, [2, 5]] = x[stretch, [5, 2]]
    demonstration = clean(recording(t, x))
    assert demonstration.repairs["swaps_undone"] > 0
    assert demonstration.repairs["jumps_removed"] > 0
    assert demonstration.repairs["missing_samples_filled"] > 0
    assert np.abs(demonstration.x - truth).max() < 0.06
