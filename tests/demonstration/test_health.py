import json

import numpy as np
import pytest
from synthetic_carry import BOX, FOREARM, UPPER_ARM, carry, recording
from waving import recorded, wave

from drake_blfdmp.demonstration.health import clock_health, examine, lengths_health
from drake_blfdmp.skeleton import POINTS

T, X = carry()


def test_a_good_recording_is_suited_and_its_figures_are_the_persons():
    examined = examine(recording(T, X))
    health = examined.health
    assert health.suitable and health.reasons == ()
    assert examined.demonstration is not None and examined.holding is not None
    assert health.bones_m == pytest.approx((UPPER_ARM, FOREARM), abs=1e-6)
    assert health.lengths["left_forearm"].mean_m == pytest.approx(FOREARM)
    assert health.lengths["hands"].min_m == pytest.approx(BOX)
    assert health.holding.hand_distance_m == pytest.approx(BOX, abs=0.005)
    assert (health.holding.start_s, health.holding.end_s) == pytest.approx((1.2, 4.6), abs=0.15)
    assert health.holding.wobble_m < 0.005
    assert health.settings == (f"box.width={health.holding.hand_distance_m:.3f}",)
    assert health.walked_m < 0.05


def test_the_clock_is_counted_as_it_was_disturbed():
    keep = np.ones(len(T), dtype=bool)
    keep[[20, 50, 51, 90]] = False
    t = np.insert(T[keep], 10, T[10])  # One repeated.
    t[[30, 31]] = t[[31, 30]]  # One late.
    clock = clock_health(recording(t, np.zeros((len(t), 6, 3))))
    assert (clock.frames, clock.dropped, clock.repeated, clock.out_of_order) == (len(T) - 3, 4, 1, 1)
    assert clock.rate_hz == pytest.approx(30.0)
    assert clock.jitter_s == pytest.approx(0.0, abs=1e-12)
    assert clock.longest_gap_s == pytest.approx(0.1)


def test_jitter_is_the_standard_deviation_of_the_steps():
    steps = 1.0 / 30.0 + 0.002 * np.random.default_rng(0).standard_normal(2000)
    clock = clock_health(recording(np.cumsum(steps), np.zeros((2000, 6, 3))))
    assert clock.jitter_s == pytest.approx(0.002, rel=0.05)


@pytest.mark.parametrize("t", [np.zeros(20), np.array([1.0])])
def test_a_clock_that_stands_still_has_no_rate(t):
    clock = clock_health(recording(t, np.zeros((len(t), 6, 3))))
    assert clock.rate_hz is None and clock.repeated == len(t) - 1
    json.dumps(examine(recording(t, X[: len(t)])).health.as_dict(), allow_nan=False)


def test_missing_and_guessed_points_are_shares_of_the_frames():
    x = X.copy()
    x[:30, 2] = np.nan
    x[30:40, 2] = 0.0  # How a Kinect writes a joint it does not see.
    given = recording(T, x)
    confidence = np.ones((len(T), 6))
    confidence[: len(T) // 2, 4] = 0.5
    given = type(given)(**{**vars(given), "confidence": confidence})
    health = examine(given).health
    assert health.points["left_wrist"].seen == pytest.approx(1 - 40 / len(T))
    assert health.points["right_elbow"].guessed == pytest.approx((len(T) // 2) / len(T))
    assert health.points["right_elbow"].confidence == pytest.approx(0.75, abs=0.01)
    assert any("right_elbow is guessed" in reason for reason in health.reasons)
    assert examine(recording(T, X)).health.points["left_wrist"].guessed is None


def test_impossible_lengths_are_counted_as_jumps():
    x = X.copy()
    x[[10, 60], 2] += [0.0, 0.0, 0.9]
    lengths = lengths_health(x)
    assert lengths["left_forearm"].jumps == 2
    assert lengths["right_forearm"].jumps == 0
    x[:, 0] = np.nan
    assert "left_upper_arm" not in lengths_health(x)


def test_a_recording_that_cleaning_refuses_still_gets_its_report():
    x = X.copy()
    x[:, POINTS.index("right_elbow")] = np.nan
    examined = examine(recording(T, x))
    assert examined.demonstration is None and not examined.health.suitable
    assert examined.health.settings == ()  # What cannot be cleaned cannot be played either.
    assert examined.health.reasons[0].startswith("right_elbow is missing in every frame")
    assert "left_forearm" in examined.health.lengths


def test_one_hand_that_carries_alone_is_named():
    x = X.copy()
    x[:, 3:] = X[:1, 3:]
    health = examine(recording(T, x)).health
    assert not health.suitable and health.holding is None
    assert any("one hand carries" in reason for reason in health.reasons)
    assert health.settings == ("task.kind=motion",)


def test_a_box_too_wide_for_the_arms_is_refused_with_its_width():
    x = X.copy()
    x[:, :3, 0] -= 0.6
    x[:, 3:, 0] += 0.6
    health = examine(recording(T, x)).health
    assert not health.suitable
    assert any("1.5" in reason and "m apart while they hold" in reason for reason in health.reasons)


def test_the_report_is_plain_json():
    text = json.dumps(examine(recording(T, X)).health.as_dict(), allow_nan=False)
    assert json.loads(text)["clock"]["rate_hz"] == pytest.approx(30.0)


def test_a_motion_in_which_nothing_is_held_is_suggested_as_one():
    health = examine(recorded(*wave())).health
    assert not health.suitable and health.holding is None
    assert health.settings == ("task.kind=motion",)
    assert all("task.kind" not in reason for reason in health.reasons)


def test_of_a_long_motion_as_much_is_suggested_as_may_be_played():
    assert examine(recorded(*wave(duration_s=130.0))).health.settings == ("task.kind=motion", "task.held=[0, 120]")


def test_a_second_of_hold_in_a_minute_of_other_motion_is_said_to_be_doubtful():
    still = np.arange(1, 30 * 60) / 30.0
    idle = X[:1] + 0.03 * np.sin(1.3 * still)[:, None, None]
    t, x = np.concatenate([T, T[-1] + still]), np.concatenate([X, X[-1:] - X[:1] + idle])
    long = examine(recording(t, x)).health
    assert long.suitable
    assert any("may be chance" in reason for reason in long.reasons)
    assert not any("may be chance" in reason for reason in examine(recording(T, X)).health.reasons)
