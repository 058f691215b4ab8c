"""From hands' orientations to how what they hold turns: cleaned, free of axes and frames, level at the end."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from synthetic_carry import recording

from drake_blfdmp.demonstration.cleaning import clean
from drake_blfdmp.demonstration.demonstration import Demonstration, as_recording
from drake_blfdmp.demonstration.hand_orientation import (
    MOST_DISAGREEMENT,
    disagreement,
    ended_level,
    hand_turns,
    line_quaternions,
    mean_orientations,
    turn_since,
)
from drake_blfdmp.demonstration.health import examine
from drake_blfdmp.demonstration.holding import Holding
from drake_blfdmp.demonstration.modelled_person import (
    ModelledPerson,
    hand_orientations,
    held_interval,
    hold_and_place,
    minimum_jerk,
)
from drake_blfdmp.demonstration.orientation_cleaning import clean_orientations
from drake_blfdmp.demonstration.timing import Timing, free_motion, task_motion
from drake_blfdmp.demonstration.torso_frame import to_torso_frame
from drake_blfdmp.demonstration.virtual_kinect import record_hold_and_place
from drake_blfdmp.errors import RecordingError
from drake_blfdmp.quaternions import angle_between, from_rotation_vector, multiply, rotated

PITCH = 0.6
PERSON = ModelledPerson(box_pitch=PITCH)
T, X = hold_and_place(PERSON)
Q = hand_orientations(PERSON, T)
HELD = held_interval()
vectors = arrays(float, 3, elements=st.floats(-1.5, 1.5))


def demonstration(q=Q, x=X):
    return Demonstration(T, x, "test", orientations=q)


def angle(turn):
    """About the line, rad."""
    return 2.0 * np.arctan2(turn[..., 1], turn[..., 0])


def truth():
    """The box's pitch at T by the modelled person's own account: exact orientation of the left hand, in the line."""
    return angle(turn_since(demonstration(), T, HELD[0], None))


def test_the_line_frame_lies_along_the_line_with_a_level_y_axis():
    q = line_quaternions(X)
    line = X[:, 5] - X[:, 2]
    line /= np.linalg.norm(line, axis=-1, keepdims=True)
    np.testing.assert_allclose(rotated(q, np.array([1.0, 0.0, 0.0])), line, atol=1e-12)
    np.testing.assert_allclose(rotated(q, np.array([0.0, 1.0, 0.0]))[:, 2], 0.0, atol=1e-12)


def test_the_modelled_persons_box_is_tipped_and_put_down_level():
    pitch = truth()
    assert pitch.max() == pytest.approx(PITCH, abs=1e-3)
    held = (HELD[0] <= T) & (HELD[1] >= T)
    np.testing.assert_allclose(pitch[held][[0, -1]], 0.0, atol=1e-9)
    # Positive brings the top towards the person: the box's up axis leans back.
    turn = turn_since(demonstration(), T, HELD[0], None)
    assert rotated(turn[np.argmax(pitch)], np.array([0.0, 0.0, 1.0]))[1] < -0.5
    np.testing.assert_allclose(hand_orientations(ModelledPerson(), T)[0], hand_orientations(PERSON, T)[0])


@settings(max_examples=15, deadline=None)
@given(vectors, vectors, vectors, st.sampled_from([1.0, -1.0]))
def test_neither_the_sensors_axes_nor_the_frame_nor_the_sign_matter(left, right, heading, sign):
    axes = from_rotation_vector(np.stack([left, right]))
    other = multiply(sign * Q, axes)
    turn = turn_since(demonstration(), T, HELD[0], None)
    assert angle_between(turn_since(demonstration(other), T, HELD[0], None), turn).max() < 1e-6
    about_z = from_rotation_vector(np.array([0.0, 0.0, heading[2]]))
    moved = replace(demonstration(multiply(about_z, Q)), x=rotated(about_z, X))
    assert angle_between(turn_since(moved, T, HELD[0], None), turn).max() < 1e-6


def test_one_hand_is_enough_and_two_are_averaged():
    turn = turn_since(demonstration(), T, HELD[0], None)
    only = Q.copy()
    only[:, 0] = np.nan
    assert angle_between(turn_since(demonstration(only), T, HELD[0], None), turn).max() < 1e-6
    assert turn_since(demonstration(None), T, HELD[0], None) is None
    # Errors of opposite sense about the line leave the mean where it was.
    grown = np.linspace(0.0, 1.0, len(T))[:, None, None] * [[0.2, 0.0, 0.0], [-0.2, 0.0, 0.0]]
    in_line = multiply(line_quaternions(X)[:, None] * [1, -1, -1, -1], Q)
    opposed = multiply(line_quaternions(X)[:, None], multiply(from_rotation_vector(grown), in_line))
    plain, both = (turn_since(demonstration(q), T, T[0], None) for q in (Q, opposed))
    assert angle_between(both, plain).max() < 1e-6


def test_the_torso_frame_turns_them_with_the_points():
    before = turn_since(demonstration(), T, HELD[0], None)
    torso = to_torso_frame(demonstration())
    assert angle_between(turn_since(torso, T, HELD[0], None), before).max() < 1e-6
    assert angle_between(torso.orientations[:, 0], Q[:, 0]).max() > 0.0


def test_what_is_left_at_the_end_is_taken_out():
    turn = from_rotation_vector(np.linspace(0.0, 0.2, 50)[:, None] * [1.0, 0.3, 0.0])
    share = np.linspace(0.0, 1.0, 50)
    level, left = ended_level(turn, share)
    assert left == pytest.approx(0.2, abs=5e-3)
    np.testing.assert_allclose(level[[0, -1]], [[1.0, 0.0, 0.0, 0.0]] * 2, atol=1e-12)


def test_the_task_turns_between_grasp_and_release_alone():
    motion = task_motion(demonstration(), Holding(*HELD, 0.3), Timing())
    still = (motion.t <= motion.events["grasp_end"]) | (motion.t >= motion.events["release"])
    np.testing.assert_allclose(motion.turn[still], [[1.0, 0.0, 0.0, 0.0]] * int(still.sum()), atol=1e-9)
    assert angle(motion.turn).max() == pytest.approx(PITCH, abs=0.02)  # Less by what the smoothing takes.
    assert free_motion(demonstration(), 0.5, 7.0, Timing()).turn is None
    assert task_motion(demonstration(None), Holding(*HELD, 0.3), Timing()).turn is None


def test_hands_that_turn_it_differently_are_not_followed():
    """Two hands on one rigid thing turn alike; where they do not, their orientations are worth nothing."""
    grown = minimum_jerk((T - HELD[0]) / 2.0)[:, None, None] * [[0.0] * 3, [1.0, 0.0, 0.0]]
    line = line_quaternions(X)[:, None]
    apart = multiply(line, multiply(from_rotation_vector(grown), multiply(line * [1, -1, -1, -1], Q)))
    held = T[(HELD[0] <= T) & (HELD[1] >= T)]
    found = disagreement(hand_turns(demonstration(apart), held, HELD[0], None))
    assert found == pytest.approx(np.sqrt(np.mean(minimum_jerk((held - HELD[0]) / 2.0) ** 2)), abs=1e-4)
    motion = task_motion(demonstration(apart), Holding(*HELD, 0.3), Timing())
    assert motion.turn is None and motion.disagreeing > MOST_DISAGREEMENT
    assert task_motion(demonstration(), Holding(*HELD, 0.3), Timing()).disagreeing < 1e-6
    assert disagreement([]) == 0.0


def spoiled(rng):
    q = Q * rng.choice([-1.0, 1.0], (len(T), 2, 1))
    q *= rng.uniform(0.5, 2.0, (len(T), 2, 1))
    q[20:26, 0] = np.nan
    q[60, 1] = 0.0
    jumps = ([35, 90, 150], [0, 1, 0])
    q[jumps] = multiply(from_rotation_vector(np.array([1.2, -0.5, 0.9])), q[jumps])
    return q


def test_cleaning_repairs_signs_lengths_gaps_and_outliers():
    cleaned = clean_orientations(T, spoiled(np.random.default_rng(1)), T, 1.5)
    assert cleaned.removed == 3
    assert cleaned.notes == ()
    np.testing.assert_allclose(np.linalg.norm(cleaned.q, axis=-1), 1.0, atol=1e-12)
    assert np.all(np.sum(cleaned.q[1:] * cleaned.q[:-1], axis=-1) > 0)
    assert angle_between(cleaned.q, Q).max() < np.deg2rad(1.0)
    untouched = np.ones(len(T), bool)
    untouched[[*range(20, 26), 35, 150]] = False
    assert angle_between(cleaned.q[untouched, 0], Q[untouched, 0]).max() < 1e-7


def test_a_hand_that_is_hardly_seen_is_left_out_and_said():
    q = Q.copy()
    q[50:200, 1] = np.nan
    cleaned = clean_orientations(T, q, T, 1.5)
    assert np.isnan(cleaned.q[:, 1]).all() and np.isfinite(cleaned.q[:, 0]).all()
    assert "right hand left out" in cleaned.notes[0]
    assert "longest gap 5.03 s" in cleaned.notes[0]
    q[50:200] = np.nan
    assert clean_orientations(T, q, T, 1.5).q is None


@pytest.mark.parametrize("up", ["z", "y", "-y"])
def test_cleaning_keeps_them_with_the_points_whatever_is_up(up):
    from drake_blfdmp.demonstration.upright import rotation_to_z_up
    from drake_blfdmp.quaternions import conjugate, from_matrix

    back = rotation_to_z_up(up)
    tilted = replace(
        recording(T, X @ back), orientations=multiply(conjugate(from_matrix(back)), spoiled(np.random.default_rng(2)))
    )
    cleaned = clean(tilted)
    assert cleaned.repairs["orientations_removed"] == 3
    pitch = np.interp(cleaned.t, T, truth())
    found = angle(turn_since(cleaned, cleaned.t, HELD[0], None))
    held = (cleaned.t >= HELD[0]) & (cleaned.t <= HELD[1])
    assert np.abs(found - pitch)[held].max() < np.deg2rad(2.0)
    assert as_recording(cleaned).orientations is cleaned.orientations
    with pytest.raises(RecordingError, match="orientations are"):
        clean(replace(tilted, orientations=Q[:5]))


def test_the_virtual_kinect_films_them_with_an_error_of_a_few_degrees():
    filmed, _ = record_hold_and_place(PERSON, seed=1)
    exact = hand_orientations(PERSON, filmed.t)
    off = np.rad2deg(angle_between(filmed.orientations, exact))
    assert 1.0 < np.sqrt(np.nanmean(off**2)) < 8.0
    plain, _ = record_hold_and_place(ModelledPerson(), seed=1)
    assert plain.orientations is None
    np.testing.assert_array_equal(filmed.x, plain.x)  # Their errors are drawn apart from the points'.


def test_inspect_says_whether_they_are_there():
    health = examine(record_hold_and_place(PERSON, seed=1)[0]).health
    assert health.orientations == (1.0, 1.0)
    assert health.holding.turn_deg == pytest.approx(np.rad2deg(PITCH), abs=8.0)
    plain = examine(record_hold_and_place(ModelledPerson(), seed=1)[0]).health
    assert plain.orientations is None and plain.holding.turn_deg is None


def test_the_mean_of_recordings_turns_as_they_do_on_average():
    other = hand_orientations(ModelledPerson(box_pitch=0.2), T)
    axes = from_rotation_vector(np.array([0.5, 1.0, -0.7]))  # Another sensor.
    ones = [demonstration(), demonstration(multiply(other, axes)), demonstration(None)]
    q = mean_orientations(X, ones, np.stack([T] * 3), [HELD[0]] * 3, np.array([0.25, 0.25, 0.5]))
    found = angle(turn_since(demonstration(q), T, HELD[0], None))
    np.testing.assert_allclose(found, truth() * (0.4 / PITCH), atol=2e-3)
    assert mean_orientations(X, ones[2:], T[None], [HELD[0]], np.ones(1)) is None
