"""The task's clock: rest to rest in closed form, rests and dwells where they belong, no jump in acceleration."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drake_blfdmp.demonstration.demonstration import Demonstration
from drake_blfdmp.demonstration.holding import Holding
from drake_blfdmp.demonstration.smoothing import smooth
from drake_blfdmp.demonstration.timing import LONGEST_MOTION_S, Timing, free_motion, ramp, rest_to_rest, task_motion
from drake_blfdmp.errors import ScenarioError

lengths = st.floats(0.05, 20.0)
ramps = st.floats(0.1, 2.0)
HOLDING = Holding(2.0, 5.7, 0.3)
TIMING = Timing(approach_s=0.8, retreat_s=0.6, dwell_s=0.9, rest_s=0.4, ramp_s=0.7)


@pytest.fixture(scope="module")
def demonstration(person):
    return Demonstration(t=person[0], x=person[1], source="modelled", synthetic=True)


@pytest.fixture(scope="module")
def motion(demonstration):
    return task_motion(demonstration, HOLDING, TIMING, cutoff_hz=3.0)


def test_the_ramp_is_the_integral_of_the_quintic_step():
    u = np.linspace(0.0, 1.0, 2001)
    speed = u**3 * (10 - 15 * u + 6 * u**2)
    integral = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(u))])
    np.testing.assert_allclose(ramp(u), integral, atol=1e-6)
    assert ramp(1.0) == pytest.approx(0.5)


@given(length=lengths, ramp_s=ramps)
def test_rest_to_rest_goes_the_whole_way_in_the_stated_time(length, ramp_s):
    gone, duration = rest_to_rest(np.array([-1.0, 0.0]), length, ramp_s)
    np.testing.assert_allclose(gone, 0.0, atol=1e-12 * length)
    assert duration == pytest.approx(length + ramp_s if length >= ramp_s else 2 * ramp_s)
    gone, _ = rest_to_rest(np.array([0.5 * duration, duration, duration + 3.0]), length, ramp_s)
    np.testing.assert_allclose(gone, [0.5 * length, length, length], rtol=1e-9)


@given(length=lengths, ramp_s=ramps)
def test_rest_to_rest_is_symmetric_monotonic_and_never_faster_than_the_person(length, ramp_s):
    _, duration = rest_to_rest(0.0, length, ramp_s)
    t = np.linspace(0.0, duration, 801)
    gone, _ = rest_to_rest(t, length, ramp_s)
    np.testing.assert_allclose(gone + gone[::-1], length, atol=1e-9 * length)
    speed = np.diff(gone) / np.diff(t)
    assert speed.min() >= -1e-9
    assert speed.max() <= min(1.0, length / ramp_s) + 1e-6


@pytest.mark.parametrize("length", [0.3, 0.7, 2.5])
def test_rest_to_rest_has_continuous_speed_and_acceleration(length):
    ramp_s = 0.7
    _, duration = rest_to_rest(0.0, length, ramp_s)
    h = 1e-3
    t = np.arange(-0.2, duration + 0.2, h)
    gone, _ = rest_to_rest(t, length, ramp_s)
    speed, acceleration = np.gradient(gone, h), np.gradient(np.gradient(gone, h), h)
    # The quintic step's slope is at most 15/8 and its curvature 10/sqrt(3) per ramp: neither changes by more in a step.
    assert np.abs(np.diff(speed)).max() <= 1.05 * h * 1.875 / ramp_s
    assert np.abs(np.diff(acceleration)).max() <= 1.1 * h * (10 / np.sqrt(3)) / ramp_s**2
    assert abs(speed[0]) == abs(speed[-1]) == 0.0


def test_a_way_of_no_length_takes_no_time():
    gone, duration = rest_to_rest(np.linspace(0, 1, 5), 0.0, 0.7)
    assert duration == 0.0
    np.testing.assert_array_equal(gone, 0.0)


def test_the_clock_rests_at_start_grasp_release_and_end(motion):
    events, t = motion.events, motion.t
    assert events["grasp_end"] - events["grasp"] == pytest.approx(TIMING.dwell_s)
    assert events["release_end"] - events["release"] == pytest.approx(TIMING.dwell_s)
    for start, end, recorded in (
        (0.0, TIMING.rest_s, HOLDING.start_s - TIMING.approach_s),
        (events["grasp"], events["grasp_end"], HOLDING.start_s),
        (events["release"], events["release_end"], HOLDING.end_s),
        (t[-1] - TIMING.rest_s + 0.01, t[-1], HOLDING.end_s + TIMING.retreat_s),
    ):
        inside = (t >= start - 1e-9) & (t <= end + 1e-9)
        assert inside.sum() >= 30
        np.testing.assert_allclose(motion.recorded[inside], recorded, atol=1e-9)
        np.testing.assert_allclose(np.diff(motion.x[inside], axis=0), 0.0, atol=1e-12)


def test_events_come_at_the_times_the_closed_form_gives(motion):
    grasp = TIMING.rest_s + rest_to_rest(0.0, TIMING.approach_s, TIMING.ramp_s)[1]
    release = grasp + TIMING.dwell_s + rest_to_rest(0.0, HOLDING.end_s - HOLDING.start_s, TIMING.ramp_s)[1]
    assert motion.events["grasp"] == pytest.approx(grasp)
    assert motion.events["release"] == pytest.approx(release)
    end = release + TIMING.dwell_s + rest_to_rest(0.0, TIMING.retreat_s, TIMING.ramp_s)[1] + TIMING.rest_s
    assert motion.t[-1] == pytest.approx(end, abs=0.005)
    np.testing.assert_allclose(np.diff(motion.t), 0.01, atol=1e-12)


def test_the_recorded_clock_never_runs_back_and_the_motion_is_the_smoothed_person(demonstration, motion):
    assert np.diff(motion.recorded).min() >= -1e-12
    smoothed = smooth(demonstration.t, demonstration.x, 3.0).reshape(-1, 18)
    expected = np.stack([np.interp(motion.recorded, demonstration.t, column) for column in smoothed.T], -1)
    # Straight lines between samples of 1/30 s err by h^2 x''/8, about 1 mm at a person's 8 m/s^2.
    np.testing.assert_allclose(motion.x.reshape(-1, 18), expected, atol=1.5e-3)


def test_the_motion_is_twice_continuously_differentiable_with_rest_at_both_ends(demonstration):
    """Acceleration changes ever less from sample to sample as the samples come closer: it does not jump."""
    jumps = []
    for rate in (100.0, 200.0, 400.0):
        x = task_motion(demonstration, HOLDING, TIMING, 1.2, rate).x
        acceleration = np.diff(x, 2, axis=0) * rate**2
        jumps.append(np.abs(np.diff(acceleration, axis=0)).max())
        np.testing.assert_allclose(acceleration[[0, -1]], 0.0, atol=1e-8)
    assert jumps[1] < 0.6 * jumps[0]
    assert jumps[2] < 0.6 * jumps[1]


def test_double_speed_halves_the_time_between_the_ramps(demonstration):
    slow = task_motion(demonstration, HOLDING, TIMING)
    fast = task_motion(demonstration, HOLDING, replace(TIMING, speed=2.0))
    for motion, speed in ((slow, 1.0), (fast, 2.0)):
        carry = motion.events["release"] - motion.events["grasp_end"]
        assert carry == pytest.approx((HOLDING.end_s - HOLDING.start_s) / speed + TIMING.ramp_s)
    assert fast.recorded[-1] == pytest.approx(slow.recorded[-1])


def test_what_the_recording_does_not_have_is_not_played(demonstration):
    motion = task_motion(demonstration, HOLDING, replace(TIMING, approach_s=99.0, retreat_s=99.0))
    assert motion.recorded[0] == demonstration.t[0]
    assert motion.recorded[-1] == pytest.approx(demonstration.t[-1])


def test_a_recording_that_starts_with_the_grasp_needs_no_approach(demonstration):
    motion = task_motion(demonstration, replace(HOLDING, start_s=0.0), replace(TIMING, approach_s=0.8))
    assert motion.events["grasp"] == pytest.approx(TIMING.rest_s)
    assert np.all(np.isfinite(motion.x))


@pytest.mark.parametrize("name", ["dwell_s", "ramp_s", "speed"])
@pytest.mark.parametrize("value", [0.0, -1.0, np.nan])
def test_what_must_be_positive_is_named(demonstration, name, value):
    with pytest.raises(ScenarioError, match=f"timing.{name} must be positive"):
        task_motion(demonstration, HOLDING, replace(TIMING, **{name: value}))


@pytest.mark.parametrize("name", ["approach_s", "retreat_s", "rest_s"])
def test_what_must_not_be_negative_is_named(demonstration, name):
    with pytest.raises(ScenarioError, match=f"timing.{name} must not be negative"):
        task_motion(demonstration, HOLDING, replace(TIMING, **{name: -0.1}))


def test_a_box_held_for_an_instant_is_refused(demonstration):
    with pytest.raises(ScenarioError, match=r"held for 0\.20 s only"):
        task_motion(demonstration, Holding(2.0, 2.2, 0.3), TIMING)


def test_without_a_box_an_interval_is_played_in_one_go_from_rest_to_rest(demonstration):
    motion = free_motion(demonstration, 1.0, 6.0, TIMING, cutoff_hz=3.0)
    assert motion.events == {"start": 0.4, "end": pytest.approx(0.4 + 5.0 + TIMING.ramp_s)}
    assert motion.t[-1] == pytest.approx(5.0 + TIMING.ramp_s + 2 * TIMING.rest_s, abs=0.006)
    before, after = motion.t <= 0.4, motion.t >= motion.events["end"]
    np.testing.assert_allclose(motion.recorded[before], 1.0, atol=1e-12)
    np.testing.assert_allclose(motion.recorded[after], 6.0, atol=1e-9)
    speed = np.diff(motion.recorded) * 100.0
    assert speed.min() >= -1e-9 and speed.max() <= 1.0 + 1e-6
    cruising = (motion.t[1:] > 0.4 + 0.7) & (motion.t[1:] < motion.events["end"] - 0.7)
    np.testing.assert_allclose(speed[cruising], 1.0, atol=1e-6)  # No dwell anywhere between.
    smoothed = smooth(demonstration.t, demonstration.x, 3.0)
    shown = np.stack([np.interp(motion.recorded, demonstration.t, c) for c in smoothed.reshape(-1, 18).T], axis=-1)
    np.testing.assert_allclose(motion.x.reshape(-1, 18), shown, atol=1e-3)


def test_without_a_box_speed_shortens_the_motion(demonstration):
    motion = free_motion(demonstration, 1.0, 6.0, replace(TIMING, speed=2.0))
    assert motion.events["end"] - motion.events["start"] == pytest.approx(2.5 + TIMING.ramp_s)


@pytest.mark.parametrize(("start", "end"), [(1.0, 1.2), (0.0, LONGEST_MOTION_S + 0.1), (5.0, 2.0)])
def test_a_motion_too_short_or_too_long_is_refused_in_one_line(demonstration, start, end):
    with pytest.raises(ScenarioError, match=r"^motion: [^\n]* must be 0\.3 to 120 s; choose [^\n]*task\.held[^\n]*$"):
        free_motion(demonstration, start, end, TIMING)
    with pytest.raises(ScenarioError, match=r"timing\.speed must be positive"):
        free_motion(demonstration, 1.0, 6.0, replace(TIMING, speed=0.0))
