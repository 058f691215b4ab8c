import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from synthetic_carry import carry, turn

from drake_blfdmp.demonstration.demonstration import Demonstration
from drake_blfdmp.demonstration.torso_frame import into_frames, low_pass, to_torso_frame, torso_frames
from drake_blfdmp.errors import RecordingError

T, X = carry()
STANDING = X - np.array([0.0, 1.0, 0.0]) * X[:, [0], :]  # Without the breath: shoulders fixed over the origin.


def demonstration(x, rate=30.0):
    return Demonstration(np.arange(len(x)) / rate, x, "test")


@settings(max_examples=30)
@given(
    heading=st.floats(-np.pi, np.pi),
    velocity=st.tuples(st.floats(-2, 2), st.floats(-2, 2)),
    start=st.tuples(st.floats(-5, 5), st.floats(-5, 5)),
)
def test_a_rigid_walk_is_removed_exactly(heading, velocity, start):
    walk = np.zeros((len(T), 1, 3))
    walk[:, 0, :2] = np.array(start) + T[:, None] * np.array(velocity)
    np.testing.assert_allclose(to_torso_frame(demonstration(turn(STANDING, heading) + walk)).x, STANDING, atol=1e-9)


def test_turning_is_removed_and_bending_stays():
    angle = 0.5 * T
    turning = np.stack([turn(x, a) for x, a in zip(STANDING, angle, strict=True)])
    interior = slice(20, -20)  # Odd reflection continues a turn at the ends only to first order.
    out = to_torso_frame(demonstration(turning)).x
    np.testing.assert_allclose(out[interior], STANDING[interior], atol=1e-6)
    lowered = STANDING - [0.0, 0.0, 0.3]
    np.testing.assert_array_equal(to_torso_frame(demonstration(lowered)).x[..., 2], lowered[..., 2])


def test_axes_are_right_forward_up():
    x = to_torso_frame(demonstration(turn(X, 2.0) + np.array([3.0, 1.0, 0.0]))).x
    assert (x[:, 3, 0] > 0.1).all() and (x[:, 0, 0] < -0.1).all()
    assert (x[:, [2, 5], 1] > 0.2).all()


def test_noise_of_the_shoulders_does_not_shake_the_hands():
    rng = np.random.default_rng(1)
    noisy = STANDING.copy()
    noisy[:, [0, 3]] += 0.02 * rng.normal(size=(len(T), 2, 3))
    shaken = to_torso_frame(demonstration(noisy), cutoff_hz=1000.0).x[:, 2] - STANDING[:, 2]
    filtered = to_torso_frame(demonstration(noisy)).x[:, 2] - STANDING[:, 2]
    assert np.std(filtered) < 0.4 * np.std(shaken)
    assert np.std(np.diff(filtered, axis=0)) < 0.05 * np.std(np.diff(shaken, axis=0))


def test_lengths_stay_and_the_frames_are_for_others_too():
    frames = torso_frames(X, 30.0)
    np.testing.assert_allclose(np.linalg.norm(frames.x_axis, axis=1), 1.0)
    inside = into_frames(X, frames)
    np.testing.assert_allclose(
        np.linalg.norm(inside[:, :, None] - inside[:, None], axis=-1),
        np.linalg.norm(X[:, :, None] - X[:, None], axis=-1),
    )


def test_low_pass_has_its_cutoff_and_no_phase():
    t = np.arange(3000) / 100.0
    for frequency, gain in ((0.1, 0.9966), (1.0, np.sqrt(0.5)), (4.0, 0.0039)):
        wave = np.sin(2 * np.pi * frequency * t)
        out = low_pass(wave, 100.0, 1.0)[500:-500]
        assert out @ wave[500:-500] / (wave[500:-500] @ wave[500:-500]) == pytest.approx(gain, abs=2e-3)


def test_shoulders_above_each_other_have_no_heading():
    x = STANDING.copy()
    x[:, 0, :2] = x[:, 3, :2]
    with pytest.raises(RecordingError, match="too little for a heading"):
        to_torso_frame(demonstration(x))
