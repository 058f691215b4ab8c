import numpy as np
import pytest

from drake_blfdmp.demonstration.clock import SECONDS, find_clock

FRAMES = np.arange(90)


# Ticks of 100 ns are a Kinect's; from 95 Hz on they cannot be told from microseconds.
@pytest.mark.parametrize(
    ("unit", "rate"),
    [(unit, rate) for unit in SECONDS for rate in (15.0, 25.0, 30.0, 60.0, 120.0) if (unit, rate) != ("100ns", 120.0)],
)
def test_the_unit_is_the_one_in_which_the_clock_runs_like_a_sensor(unit, rate):
    t = 1000.0 + FRAMES / rate
    clock = find_clock(t / SECONDS[unit], FRAMES)
    np.testing.assert_allclose(clock.t, t, rtol=1e-9)
    assert f"{rate:g} samples a second" in clock.evidence


def test_frame_numbers_are_told_from_times():
    kept = np.sort(np.random.default_rng(0).permutation(600)[:200])  # A tracker that skips frames.
    clock = find_clock(kept.astype(float), np.arange(200))
    np.testing.assert_allclose(clock.t, kept / 30.0)
    assert "frame numbers" in clock.evidence and "assumed" in clock.evidence
    by_format = find_clock(kept.astype(float), np.arange(200), stated_hz=15.0)
    np.testing.assert_allclose(by_format.t, kept / 15.0)
    assert "assumed" not in by_format.evidence


@pytest.mark.parametrize("rate", [30.0, 60.0, 100.0])
def test_whole_milliseconds_are_no_frame_numbers(rate):
    ms = np.round(1000.0 * FRAMES / rate)
    np.testing.assert_allclose(find_clock(ms, FRAMES).t, ms / 1000.0)


def test_without_a_clock_frames_are_counted_and_the_rate_is_said_to_be_assumed():
    clock = find_clock(None, 7 + FRAMES)
    np.testing.assert_allclose(clock.t, (7 + FRAMES) / 30.0)
    assert "assumed" in clock.evidence
    assert "by its format" in find_clock(None, FRAMES, stated_hz=15.0).evidence


def test_what_is_stated_wins_over_the_guess_and_what_is_set_over_both():
    t = FRAMES / 30.0
    np.testing.assert_allclose(find_clock(t, FRAMES, stated_unit="ms").t, t / 1000.0)
    np.testing.assert_allclose(find_clock(t, FRAMES, stated_unit="ms", time_unit="s").t, t)
    np.testing.assert_allclose(find_clock(t, FRAMES, stated_unit="ms", rate_hz=10.0).t, FRAMES / 10.0)
    np.testing.assert_allclose(find_clock(t, FRAMES, time_unit="frames", stated_hz=60.0).t, t / 60.0)


@pytest.mark.parametrize("t", [np.zeros(5), np.full(5, 7.3), np.array([3.0])])
def test_a_clock_that_stands_still_is_left_as_it_is(t):
    np.testing.assert_array_equal(find_clock(t, np.arange(len(t))).t, t)
