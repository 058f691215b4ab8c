import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from synthetic_carry import BOX, FOREARM, UPPER_ARM, carry

from drake_blfdmp.demonstration.bones import estimate_bone_lengths, length_jumps, link_lengths
from drake_blfdmp.errors import RecordingError

T, X = carry(duration=4.0)


def test_link_lengths_follow_the_skeleton():
    lengths = link_lengths(X)
    assert lengths.shape == (len(T), 5)
    np.testing.assert_allclose(lengths[:, [0, 4]], UPPER_ARM)
    np.testing.assert_allclose(lengths[:, [1, 3]], FOREARM)
    assert lengths[60, 2] == pytest.approx(BOX)


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 1000), share=st.floats(0.0, 0.3))
def test_estimate_withstands_noise_gaps_and_jumps(seed, share):
    rng = np.random.default_rng(seed)
    x = X + 0.005 * rng.normal(size=X.shape)
    wrong = rng.random(len(T)) < share
    x[wrong, 2] += rng.normal(scale=0.5, size=(wrong.sum(), 3))
    x[rng.random(len(T)) < 0.2, 4] = np.nan
    upper_arm, forearm = estimate_bone_lengths(x)
    assert upper_arm == pytest.approx(UPPER_ARM, abs=0.003)
    assert forearm == pytest.approx(FOREARM, abs=0.004)


def test_jump_test_finds_the_jumps_only():
    lengths = np.full((50, 1), 0.25) + 0.005 * np.sin(np.arange(50))[:, None]
    lengths[[7, 8, 30], 0] = 0.7, 0.01, np.nan
    np.testing.assert_array_equal(np.flatnonzero(length_jumps(lengths)[:, 0]), [7, 8])


def test_no_bone_no_length():
    x = X.copy()
    x[:, [1, 4]] = np.nan
    with pytest.raises(RecordingError, match="both ends of an upper arm"):
        estimate_bone_lengths(x)
