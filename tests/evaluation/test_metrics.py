"""The numbers of the summary on series made by hand, whose answers are known."""

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from drake_blfdmp.evaluation.metrics import (
    box_metrics,
    feedback_metrics,
    largest_barrier_derivative,
    link_metrics,
    rms_distance,
    robot_metrics,
    samples_until_inside,
    slip,
    tilt_deg,
)
from drake_blfdmp.skeleton import LINKS
from drake_blfdmp.skill.bands import make_bands
from drake_blfdmp.skill.profiles import ConstantDistance
from drake_blfdmp.skill.rollout import Rollout
from drake_blfdmp.skill.sampled import Gains

T = np.arange(301) / 100.0
BANDS = make_bands(0.22, 0.28, ConstantDistance(0.30))


def pose(position=(0.0, 0.0, 0.0), rotation=None):
    """(7,) qw qx qy qz x y z."""
    q = (rotation or Rotation.identity()).as_quat()[[3, 0, 1, 2]]
    return np.concatenate([q, position])


def skeleton(lengths):
    """Points (N, 6, 3) of a chain stretched along x with the given link lengths (N, 5)."""
    x = np.zeros((len(lengths), 6, 3))
    for i, link in enumerate(LINKS):
        x[:, link.b] = x[:, link.a]
        x[:, link.b, 0] += lengths[:, i]
    return x


def rollout(lengths, velocity=None):
    x = skeleton(lengths)
    return Rollout(T, x, np.zeros_like(x) if velocity is None else velocity, BANDS.evaluate(T))


def middles():
    return np.tile([0.22, 0.28, 0.30, 0.28, 0.22], (len(T), 1))


def test_rms_is_over_samples_and_points_of_the_distance():
    a = np.zeros((4, 2, 3))
    b = a.copy()
    b[0, 0] = [3.0, 4.0, 0.0]
    assert rms_distance(a, b) == pytest.approx(5.0 / np.sqrt(8.0))
    assert rms_distance(a, a) == 0.0


@pytest.mark.parametrize(
    ("leaves_at", "expected"), [([], 0), ([0], 1), ([0, 1, 2], 1), ([3], 2), ([50], 16), ([299], 90), ([300], None)]
)
def test_samples_count_at_the_recordings_rate_until_inside_for_good(leaves_at, expected):
    """A sample every 10 ms against 30 Hz: what leaves last at k is inside for good from (k + 1)/100 s on."""
    lengths = np.full(len(T), 0.30)
    lengths[leaves_at] = 0.35
    assert samples_until_inside(T, lengths, 0.29 + 0 * T, 0.31 + 0 * T) == expected


def test_a_length_on_the_bands_edge_is_not_inside():
    lengths = np.full(len(T), 0.30)
    lengths[9] = 0.31
    assert samples_until_inside(T, lengths, 0.29 + 0 * T, 0.31 + 0 * T) == 3


def test_rounding_of_times_adds_no_sample():
    t = np.arange(10) / 30.0
    outside = np.where(np.arange(10) < 3, 1.0, 0.0)
    assert samples_until_inside(t, outside, -0.5 + 0 * t, 0.5 + 0 * t) == 3


@given(last=st.integers(0, 299), rate=st.floats(1.0, 200.0))
def test_samples_bound_the_time_from_above_by_less_than_one(last, rate):
    lengths = np.where(np.arange(len(T)) <= last, 1.0, 0.0)
    count = samples_until_inside(T, lengths, -0.5 + 0 * T, 0.5 + 0 * T, rate)
    assert count / rate >= T[last + 1] - 1e-5
    assert (count - 1) / rate < T[last + 1]


def test_links_in_the_middle_of_their_bands_violate_nothing():
    for link, entry in link_metrics(rollout(middles()), BANDS, 1.0).items():
        assert entry["violations"] == 0
        assert entry["largest_excess_m"] == 0.0
        assert entry["samples_until_inside"] == 0
        assert entry["min_m"] == pytest.approx(entry["max_m"]) == pytest.approx(entry["desired_m"])
        assert link in {item.name for item in LINKS}


def test_one_link_that_leaves_its_band_is_found_alone():
    lengths = middles()
    lengths[100:130, 1] = 0.295  # 5 mm outside 0.28 +- 0.01
    entries = link_metrics(rollout(lengths), BANDS, 1.0)
    found = entries["left_forearm"]
    assert found["violations"] == 30
    assert found["largest_excess_m"] == pytest.approx(0.005)
    assert found["max_m"] == pytest.approx(0.295)
    assert found["min_m"] == pytest.approx(0.28)
    assert found["samples_until_inside"] == 39  # Inside for good from 1.30 s on.
    assert found["min_margin"] == pytest.approx(-0.5)
    for name, entry in entries.items():
        assert (entry["violations"] == 0) == (name != "left_forearm")


def test_the_papers_band_judges_how_soon_and_the_funnel_judges_violations():
    lengths = middles()
    lengths[:, 0] += 0.05 * np.exp(-6.0 * T)
    motion = rollout(lengths)
    funnel = BANDS.opened_to(motion.x[0])
    entry = link_metrics(motion, funnel, 1.0)["left_upper_arm"]
    assert entry["violations"] == 0
    # 0.05 exp(-6 t) falls below 0.01 at t = 0.268 s: sample 27 of 100 Hz, 9th of 30 Hz.
    assert entry["samples_until_inside"] == 9


def test_the_barriers_derivative_is_negative_inside_and_zero_in_the_middle():
    gains = Gains(8.0, 20.0)
    assert largest_barrier_derivative(rollout(middles() + 0.004), gains) < 0.0
    lengths = middles()
    lengths[:, 2] += 0.02 * np.exp(-3.0 * T)
    assert largest_barrier_derivative(rollout(middles()), gains) <= 1e-9


def test_tilt_is_the_angle_between_up_axes_and_not_yaw():
    desired = pose(rotation=Rotation.from_euler("z", 0.7))
    for angle in (0.0, 3.0, 90.0, 175.0):
        tilted = pose(rotation=Rotation.from_euler("z", -1.0) * Rotation.from_euler("x", angle, degrees=True))
        assert tilt_deg(tilted, desired) == pytest.approx(angle, abs=1e-5)


def palms(n, slide=0.0, turn=None):
    """Both palms on the faces of a 0.3 m box at the origin; the left one slides by `slide` (n,) along its own x."""
    faces = [Rotation.from_euler("y", 90, degrees=True), Rotation.from_euler("y", -90, degrees=True)]
    turn = turn or Rotation.identity()
    result = np.empty((n, 2, 7))
    for arm, (side, face) in enumerate(zip((-1, 1), faces, strict=True)):
        result[:, arm] = pose(turn.apply([0.15 * side, 0.0, 0.0]), turn * face)
    result[:, 0, 4:] += np.multiply.outer(slide, (turn * faces[0]).apply([1.0, 0.0, 0.0])) if np.ndim(slide) else 0.0
    return result


def test_slip_is_along_the_palm_from_the_first_sample():
    slide = np.linspace(0.0, 0.012, 5)
    box = np.tile(pose(), (5, 1))
    np.testing.assert_allclose(slip(palms(5, slide), box, 0.3), np.stack([slide, 0 * slide], -1), atol=1e-12)
    taken_off_centre = palms(5, 0.03 + slide)
    np.testing.assert_allclose(slip(taken_off_centre, box, 0.3)[:, 0], slide, atol=1e-12)
    pressed = palms(5)
    pressed[:, 0, 4] += slide  # Along the normal: no slip.
    np.testing.assert_allclose(slip(pressed, box, 0.3), 0.0, atol=1e-12)


@given(angles=st.tuples(*[st.floats(-1, 1)] * 3), move=st.tuples(*[st.floats(-1, 1)] * 3))
def test_what_moves_as_one_does_not_slip(angles, move):
    turn = Rotation.from_euler("xyz", angles)
    palm = np.concatenate([palms(1), palms(1, turn=turn)])
    palm[1, :, 4:] += move
    box = np.stack([pose(), pose(move, turn)])
    np.testing.assert_allclose(slip(palm, box, 0.3), 0.0, atol=1e-9)


def log(**changes):
    n = len(T)
    values = dict(
        t=T,
        q=np.full((n, 14), 0.5),
        q_lower=np.full(14, -1.0),
        q_upper=np.full(14, 2.0),
        v=np.full((n, 14), -0.5),
        v_limit=np.full(14, 2.0),
        effort=np.full((n, 14), 10.0),
        effort_limit=np.full(14, 80.0),
        clearance=np.full(n, 0.03),
        palm=palms(n),
        palm_desired=palms(n),
        palm_force=np.full((n, 2), 60.0),
        clock=T,
        tempo=np.ones(n),
        lower=np.tile([0.21, 0.27, 0.29, 0.27, 0.21], (n, 1)),
        upper=np.tile([0.23, 0.29, 0.31, 0.29, 0.23], (n, 1)),
        hands=np.full(n, 0.302),
        box=np.tile(pose((0.0, 0.0, 0.0)), (n, 1)),
        box_desired=np.tile(pose((0.0, 0.0, 0.0)), (n, 1)),
    )
    return SimpleNamespace(**{**values, **changes})


def test_robot_metrics_take_the_worst_joint_and_sample():
    values = log()
    values.q[7, 3], values.v[9, 2], values.effort[11, 13] = -0.98, 1.9, -76.0
    values.clearance[5] = -0.001
    values.palm[:, 1, 4] += 0.003
    found = robot_metrics(values)
    assert found["min_joint_margin_rad"] == pytest.approx(0.02)
    assert found["max_velocity_ratio"] == pytest.approx(0.95)
    assert found["max_effort_ratio"] == pytest.approx(0.95)
    assert found["min_clearance_m"] == pytest.approx(-0.001)
    assert found["palm_tracking_rms_m"] == pytest.approx(0.003 / np.sqrt(2.0))


def test_feedback_metrics_of_a_run_that_nothing_disturbed():
    assert feedback_metrics(log(), 0.5, 3.0) == {
        "finished": True,
        "min_tempo": 1.0,
        "delay_s": 0.0,
        "max_middle_error_m": 0.0,
        "hands_outside_samples": 0,
        "hands_outside_s": 0.0,
        "hands_min_margin": pytest.approx(0.8),
    }


def test_feedback_metrics_count_what_is_outside_after_the_rest_and_what_was_late():
    values = log(clock=0.9 * T)
    values.hands[[10, 100, 101, 200]] = 0.5, 0.315, 0.31, 0.30
    values.tempo[40] = 0.6
    values.palm[120, :, 6] += [0.004, 0.002]
    found = feedback_metrics(values, 0.5, 3.0)
    assert not found["finished"] and found["min_tempo"] == 0.6
    assert found["delay_s"] == pytest.approx(0.3)
    assert found["max_middle_error_m"] == pytest.approx(0.003)
    assert found["hands_outside_samples"] == 2 and found["hands_outside_s"] == pytest.approx(0.02)
    assert found["hands_min_margin"] == pytest.approx(-0.5)


def test_the_hold_goes_by_the_skills_clock():
    force = np.full((len(T), 2), 60.0)
    force[:110], force[221:] = 0.0, 0.0
    assert found_for_box(palm_force=force)["dropped"]
    assert not found_for_box(palm_force=force, clock=T / 1.1)["dropped"]


def found_for_box(**changes):
    return box_metrics(log(**changes), (1.0, 2.0), pose((0.0, 0.0, 0.0)), 0.0, 0.3)


def test_a_box_that_rests_where_it_should_has_nothing_to_report():
    assert found_for_box() == {
        "lifted_m": 0.0,
        "placement_error_m": 0.0,
        "placement_rotation_deg": 0.0,
        "max_tilt_deg": 0.0,
        "dropped": False,
        "max_slip_m": pytest.approx(0.0, abs=1e-12),
        "squeeze_force_n": [60.0, 60.0],
        "squeeze_planned_n": None,
        "squeeze_limit_n": None,
    }


def test_lift_is_the_highest_point_and_the_error_is_at_the_end():
    box = log().box
    box[150, 6], box[-1, 4:] = 0.21, [0.003, 0.0, 0.004]
    found = found_for_box(box=box)
    assert found["lifted_m"] == pytest.approx(0.21)
    assert found["placement_error_m"] == pytest.approx(0.005)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_orientation_at_the_end_counts_whole(sign):
    box = log().box
    turned = Rotation.from_euler("ZX", [3.0, 4.0], degrees=True)
    box[-1, :4] = sign * turned.as_quat()[[3, 0, 1, 2]]
    box[-2, :4] = Rotation.from_euler("Z", 20.0, degrees=True).as_quat()[[3, 0, 1, 2]]
    assert found_for_box(box=box)["placement_rotation_deg"] == pytest.approx(np.rad2deg(turned.magnitude()))


def test_contact_lost_counts_only_while_the_box_is_held():
    force = np.full((len(T), 2), 60.0)
    force[:100], force[201:] = 0.0, 0.0
    assert not found_for_box(palm_force=force)["dropped"]
    force[150, 1] = 0.0
    found = found_for_box(palm_force=force)
    assert found["dropped"]
    assert found["squeeze_force_n"] == [0.0, 60.0]


def test_slip_counts_only_while_the_box_is_held():
    palm = palms(len(T))
    palm[:100, 0, 5] += 0.05
    palm[201:, 0, 5] += 0.05
    assert found_for_box(palm=palm)["max_slip_m"] == pytest.approx(0.0, abs=1e-12)
    palm[180, 0, 5] += 0.007
    assert found_for_box(palm=palm)["max_slip_m"] == pytest.approx(0.007)


def test_a_log_that_ends_before_the_grasp_is_no_success():
    """An interrupted run: nothing was held, so nothing was carried."""
    found = box_metrics(log(), (10.0, 12.0), pose(), 0.0, 0.3)
    assert found["dropped"]
    assert found["squeeze_force_n"] == [0.0, 0.0]
