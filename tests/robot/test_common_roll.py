"""The palms roll together about the line between them: the angle, its limit, the twist, and nothing else."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

from drake_blfdmp.quaternions import from_rotation_vector, multiply
from drake_blfdmp.robot.retargeting import Retarget, box_pose, common_roll, retarget_motion

STEP = 1e-5
POSE = np.array(
    [[-0.2, 0.0, 1.4], [-0.35, 0.1, 1.2], [-0.16, 0.35, 1.13], [0.2, 0.0, 1.4], [0.28, 0.12, 1.16], [0.17, 0.38, 1.17]]
)
MAP = Retarget(
    scale=0.7, person=np.array([0.01, 0.02, 1.4]), world=np.array([0.05, 0.25, 0.9]), rolls=np.array([0.3, -0.7])
)
vectors = arrays(float, 3, elements=st.floats(-0.9, 0.9))


def rotation(pose):
    return Rotation.from_quat(np.roll(pose[..., :4], -1, axis=-1))


def moving(seed, level):
    rng = np.random.default_rng(seed)
    return POSE + rng.uniform(-0.05, 0.05, (6, 3)), rng.uniform(-0.5, 0.5, (6, 3)), replace(MAP, level=level)


@settings(deadline=None)
@given(st.integers(0, 2**32 - 1), st.booleans(), vectors, vectors)
def test_the_twist_is_the_derivative_of_the_pose(seed, level, turn, rate):
    x, v, retarget = moving(seed, level)
    r = from_rotation_vector(turn)

    def at(h):
        return multiply(from_rotation_vector(h * rate), r)

    twist = retarget_motion(x, v, retarget, turn=r, turn_rate=rate)[1]
    # Five points, so that the difference errs by less than what is claimed.
    poses = [retarget_motion(x + h * v, v, retarget, turn=at(h))[0] for h in STEP * np.array([-2, -1, 1, 2])]
    first, second, third, fourth = ((rotation(pose) * rotation(poses[1]).inv()).as_rotvec() for pose in poses)
    turned = (8 * (third - second) - (fourth - first)) / (12 * STEP)
    moved = (8 * (poses[2] - poses[1]) - (poses[3] - poses[0]))[:, 4:] / (12 * STEP)
    np.testing.assert_allclose(twist[:, :3], turned, atol=1e-6)
    np.testing.assert_allclose(twist[:, 3:], moved, atol=1e-6)


@settings(deadline=None)
@given(st.integers(0, 2**32 - 1), st.booleans(), st.floats(-1.0, 1.0))
def test_a_roll_about_the_line_turns_both_palms_and_the_box_by_it(seed, level, angle):
    x, v, retarget = moving(seed, level)
    r = from_rotation_vector(np.array([angle, 0.0, 0.0]))
    plain, rolled = (retarget_motion(x, v, retarget, turn=turn)[0] for turn in (None, r))
    line = rolled[1, 4:] - rolled[0, 4:]
    about_line = angle * line / np.linalg.norm(line)
    np.testing.assert_allclose((rotation(rolled) * rotation(plain).inv()).as_rotvec(), [about_line] * 2, atol=1e-9)
    np.testing.assert_array_equal(rolled[:, 4:], plain[:, 4:])
    boxes = [box_pose(x, retarget, turn) for turn in (None, r)]
    np.testing.assert_allclose((rotation(boxes[1]) * rotation(boxes[0]).inv()).as_rotvec(), about_line, atol=1e-9)
    # Box and palms are one rigid thing while held.
    held = [rotation(pose).inv() * rotation(box) for pose, box in zip((plain, rolled), boxes, strict=True)]
    np.testing.assert_allclose(held[0].as_matrix(), held[1].as_matrix(), atol=1e-12)


def test_no_turn_is_what_it_was_to_the_last_bit():
    x, v, retarget = moving(5, False)
    unrolled = retarget_motion(x, v, retarget)
    for one, other in zip(unrolled, retarget_motion(x, v, retarget, turn=None, turn_rate=None), strict=True):
        np.testing.assert_array_equal(one, other)
    identity = retarget_motion(x, v, retarget, turn=np.array([1.0, 0, 0, 0]), turn_rate=np.zeros(3))
    for one, other in zip(unrolled, identity, strict=True):
        np.testing.assert_allclose(one, other, atol=1e-15)


@settings(deadline=None)
@given(vectors, st.floats(-1.0, 1.0))
def test_what_the_line_itself_turned_is_left_to_the_points(swing, angle):
    """A turn of the line (no component along it) after one about it has the latter's angle."""
    swing = swing * [0.0, 1.0, 1.0]
    r = multiply(from_rotation_vector(swing), from_rotation_vector(np.array([angle, 0.0, 0.0])))
    for sign in (1.0, -1.0):
        assert common_roll(sign * r, np.zeros(3), MAP)[0] == pytest.approx(angle, abs=1e-9)


def test_the_roll_is_softly_limited_with_its_rate():
    def roll(angle, rate=0.0):
        turn = from_rotation_vector(np.array([angle, 0.0, 0.0]))
        return [float(value) for value in common_roll(turn, np.array([rate, 0.0, 0.0]), MAP)]

    start, end = MAP.pitch
    assert roll(0.9 * start, 0.4) == pytest.approx([0.9 * start, 0.4])
    for angle in (start + 0.2, -start - 0.5):
        kept, rate = roll(angle, 0.4)
        assert start < abs(kept) < end and kept * angle > 0
        h = 1e-6
        assert rate == pytest.approx(0.4 * (roll(angle + h)[0] - roll(angle - h)[0]) / (2 * h), abs=1e-6)


def test_leading_axes():
    rng = np.random.default_rng(0)
    x, v = POSE + rng.uniform(-0.05, 0.05, (4, 3, 6, 3)), rng.uniform(-0.5, 0.5, (4, 3, 6, 3))
    turn, rate = from_rotation_vector(rng.uniform(-0.9, 0.9, (4, 3, 3))), rng.uniform(-0.9, 0.9, (4, 3, 3))
    many = retarget_motion(x, v, MAP, turn=turn, turn_rate=rate)
    for k in np.ndindex(4, 3):
        one = retarget_motion(x[k], v[k], MAP, turn=turn[k], turn_rate=rate[k])
        for value, expected in zip(many, one, strict=True):
            np.testing.assert_allclose(value[k], expected, atol=1e-14)
