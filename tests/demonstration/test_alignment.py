"""Recordings of one motion at different speeds, with noise, by other persons, of other motions: the maps must tell."""

from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import make_interp_spline

from drake_blfdmp.demonstration.alignment import align, weighted_mean, weighted_spread
from drake_blfdmp.demonstration.cleaning import clean
from drake_blfdmp.demonstration.demonstration import Demonstration
from drake_blfdmp.demonstration.grasp import grasp_and_release
from drake_blfdmp.demonstration.holding import Holding, find_holding
from drake_blfdmp.demonstration.modelled_person import ModelledPerson, hold_and_place
from drake_blfdmp.demonstration.torso_frame import to_torso_frame
from drake_blfdmp.demonstration.virtual_kinect import record_hold_and_place
from drake_blfdmp.errors import RecordingError

PERSON = ModelledPerson()
AROUND = {"lead_s": 0.7, "trail_s": 0.7}


def even(duration):
    """The motion's own time, 0 to 8 s, at every time of a recording that plays it evenly."""
    return lambda t: 8.0 * t / duration


def uneven(duration, sway=0.06):
    """The same for a recording that hurries and dawdles: its speed lies between 0.42 and 1.28 for 10 s."""

    def clock(t):
        u = t / duration
        return 8.0 * (u + sway * np.sin(2 * np.pi * u) + sway / 3 * (np.sin(4 * np.pi * u + 1.0) - np.sin(1.0)))

    return clock


@cache
def motion(person):
    return make_interp_spline(*hold_and_place(person, rate_hz=100.0), k=5)


def played(clock, duration, person=PERSON, rate_hz=30.0):
    """A recording, exact, of the person's motion played by a clock: the demonstration and its held interval."""
    t = np.arange(int(duration * rate_hz) + 1) / rate_hz
    world = Demonstration(t=t, x=motion(person)(np.clip(clock(t), 0.0, 8.0)), source=f"{duration:g} s")
    demonstration = to_torso_frame(world)
    return demonstration, grasp_and_release(demonstration, find_holding(world))


def aligned(takes, weights=None, **changes):
    demonstrations, holdings = zip(*takes, strict=True)
    weights = np.ones(len(takes)) if weights is None else np.asarray(weights)
    return align(demonstrations, holdings, weights, **(AROUND | changes)), demonstrations


def task(alignment):
    """The samples from the approach to the retreat."""
    return (alignment.t >= alignment.start_s - 0.7) & (alignment.t <= alignment.end_s + 0.7)


def apart(x, keep):
    """RMS distance of the first two motions' points, m."""
    return float(np.sqrt(np.mean(np.sum((x[0] - x[1])[keep] ** 2, axis=-1))))


PAIRS = {
    "slower": ((even(8.0), 8.0), (even(5.7), 5.7)),
    "uneven": ((even(8.0), 8.0), (uneven(10.0), 10.0)),
    "both": ((even(5.7), 5.7), (uneven(10.0), 10.0)),
    "against": ((uneven(9.0, 0.05), 9.0), (uneven(9.0, -0.05), 9.0)),
}


@pytest.mark.parametrize("name", PAIRS)
def test_one_motion_at_two_speeds_is_aligned_within_millimetres_and_by_landmarks_alone_it_is_not(name):
    clocks = [clock for clock, _ in PAIRS[name]]
    takes = [played(*pair) for pair in PAIRS[name]]
    alignment, demonstrations = aligned(takes)
    keep = task(alignment)
    x = alignment.shown(demonstrations)
    assert apart(x, keep) < 0.004
    assert np.linalg.norm((x[0] - x[1])[keep], axis=-1).max() < 0.02
    own = np.array([clock(times) for clock, times in zip(clocks, alignment.recorded, strict=True)])
    assert np.abs(own[0] - own[1])[keep].max() < 0.1
    assert alignment.agreement.min() > 0.995

    # Straight lines through grasp and release, and no alignment but one start: what would be without the maps.
    def at(demonstration, times):
        return make_interp_spline(demonstration.t, demonstration.x, k=3)(np.clip(times, 0.0, demonstration.t[-1]))

    held = (alignment.t - alignment.start_s) / (alignment.end_s - alignment.start_s)
    straight = [at(d, h.start_s + held * (h.end_s - h.start_s)) for d, h in takes]
    shifted = [at(d, h.start_s + alignment.t - alignment.start_s) for d, h in takes]
    assert apart(shifted, keep) > 8 * apart(x, keep)
    if name != "slower":  # The straight lines are right where both are even.
        assert apart(straight, keep) > 8 * apart(x, keep)


@pytest.mark.parametrize("name", PAIRS)
def test_the_maps_are_smooth_run_forward_and_their_mean_is_the_clock(name):
    takes = [played(*pair) for pair in PAIRS[name]]
    weights = np.array([0.3, 0.7])
    alignment, demonstrations = aligned(takes, weights)
    mean = weights @ alignment.recorded - alignment.t
    np.testing.assert_allclose(mean, mean[0], atol=1e-6)
    rate = 30.0
    speed = np.diff(alignment.recorded, axis=1) * rate
    assert speed.min() > 0.3 and speed.max() < 2.0
    assert np.abs(np.diff(speed, axis=1)).max() * rate < 2.5  # 1/s; a step of time warping has 30.
    # So velocities stay smooth: those of the aligned points accelerate no more than the motion and its clock do.
    for one, x in zip(demonstrations, alignment.shown(demonstrations), strict=True):
        own = np.abs(np.diff(one.x, 2, axis=0)).max() * rate**2
        assert np.abs(np.diff(x, 2, axis=0)).max() * rate**2 < 2.5 * own


def test_weights_move_the_clock_and_the_landmarks():
    takes = [(played(even(s), s)[0], Holding(2.2 * s / 8.0, 5.8 * s / 8.0, 0.3)) for s in (8.0, 5.0)]
    held = [holding.end_s - holding.start_s for _, holding in takes]
    for share in (0.0, 0.2, 0.5, 1.0):
        alignment, _ = aligned(takes, [share + 1e-9, 1.0 - share + 1e-9])
        assert alignment.end_s - alignment.start_s == pytest.approx(share * held[0] + (1 - share) * held[1], abs=0.01)


def test_the_order_of_the_recordings_does_not_matter():
    takes = [played(even(8.0), 8.0), played(uneven(10.0), 10.0), played(even(6.0), 6.0)]
    (one, first), (other, last) = (aligned(t, w) for t, w in ((takes, [1, 2, 3]), (takes[::-1], [3, 2, 1])))
    np.testing.assert_allclose(one.recorded, other.recorded[::-1], atol=1e-4)
    np.testing.assert_allclose(one.shown(first), other.shown(last)[::-1], atol=1e-3)


def test_another_persons_motion_is_aligned_by_its_shape():
    small = ModelledPerson(shoulder_height=1.3, grasp_height=1.0, lift=0.24, carry_right=0.22, upper_arm=0.2)
    takes = [played(even(8.0), 8.0), played(uneven(10.0), 10.0, small)]
    alignment, _ = aligned(takes)
    keep = task(alignment)
    own = np.array([even(8.0)(alignment.recorded[0]), uneven(10.0)(alignment.recorded[1])])
    assert np.abs(own[0] - own[1])[keep].max() < 0.2
    assert alignment.agreement.min() > 0.98


def test_another_task_is_seen():
    to_the_left = ModelledPerson(carry_right=-0.28)
    takes = [played(even(8.0), 8.0), played(even(7.0), 7.0), played(even(8.0), 8.0, to_the_left)]
    alignment, _ = aligned(takes)
    assert alignment.agreement[:2].min() > 0.85 > 0.65 > alignment.agreement[2]


def test_noise_bends_the_maps_little():
    """Five films of one motion at one speed: whatever the maps do is wrong."""
    takes = []
    for seed in range(5):
        world = clean(record_hold_and_place(seed=seed)[0])
        demonstration = to_torso_frame(world)
        takes.append((demonstration, grasp_and_release(demonstration, find_holding(world))))
    alignment, demonstrations = aligned(takes)
    found = np.array([holding.end_s - holding.start_s for _, holding in takes])
    assert np.std(found) > 0.1  # What the landmarks alone are worth.
    # Where the hands move: up, across and down; who rests may rest at any time.
    x = alignment.shown(demonstrations, 1.2).mean(axis=0)
    speed = np.linalg.norm(np.gradient(x[:, [2, 5]].mean(axis=1), alignment.t, axis=0), axis=-1)
    moving = task(alignment) & (speed > 0.15)
    assert moving.sum() > 50
    assert np.sqrt(np.mean((alignment.recorded - alignment.recorded.mean(axis=0))[:, moving] ** 2)) < 0.06


def test_a_recording_that_begins_at_the_grasp_leaves_no_approach():
    demonstration, holding = played(even(8.0), 8.0)
    late = demonstration.t >= holding.start_s - 0.1
    cut = Demonstration(t=demonstration.t[late] - demonstration.t[late][0], x=demonstration.x[late], source="cut")
    start = float(holding.start_s - demonstration.t[late][0])
    held = Holding(start, start + holding.end_s - holding.start_s, holding.hand_distance)
    alignment, _ = aligned([(demonstration, holding), (cut, held)])
    assert alignment.start_s == pytest.approx(start, abs=0.04)
    assert alignment.recorded.min() > -1e-6
    assert (alignment.recorded[1] <= cut.t[-1] + 1e-6).all()


def test_a_recording_too_slow_for_the_smoothing_is_refused():
    takes = [played(even(8.0), 8.0)] * 2
    with pytest.raises(RecordingError, match="cut-off 20 Hz"):
        aligned(takes, cutoff_hz=20.0)


@given(seed=st.integers(0, 2**32 - 1), count=st.integers(2, 6))
def test_mean_and_spread_of_equal_weights_are_the_usual_ones(seed, count):
    x = np.random.default_rng(seed).normal(size=(count, 4, 6, 3))
    for weights in (np.ones(count), np.full(count, 0.25)):
        np.testing.assert_allclose(weighted_mean(x, weights), x.mean(axis=0), atol=1e-12)
        np.testing.assert_allclose(weighted_spread(x, weights), x.std(axis=0, ddof=1), rtol=1e-10)


def test_the_spread_of_unequal_weights_is_unbiased():
    x = 0.03 * np.random.default_rng(0).normal(size=(4, 50000))
    spread = weighted_spread(x, np.array([1.0, 5.0, 2.0, 0.5]))
    assert np.sqrt(np.mean(spread**2)) == pytest.approx(0.03, rel=0.02)


def test_one_motion_twice_has_no_spread():
    x = np.random.default_rng(0).normal(size=(1, 5, 6, 3)).repeat(3, axis=0)
    np.testing.assert_allclose(weighted_spread(x, np.array([1.0, 2.0, 3.0])), 0.0, atol=1e-15)
