"""From the person to the palms: distances, directions, twists against finite differences, rolls, the mirrored elbow."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from drake_blfdmp.robot.retargeting import (
    OUTWARD,
    Retarget,
    box_pose,
    multiply,
    palm_offsets,
    retarget_motion,
    softly_limited,
)
from drake_blfdmp.robot.swivel import swivel_angle, wrap

STEP = 1e-6
POSE = np.array(
    [[-0.2, 0.0, 1.4], [-0.35, 0.1, 1.2], [-0.16, 0.35, 1.13], [0.2, 0.0, 1.4], [0.28, 0.12, 1.16], [0.17, 0.38, 1.17]]
)
MAP = Retarget(
    scale=0.7, person=np.array([0.01, 0.02, 1.4]), world=np.array([0.05, 0.25, 0.9]), rolls=np.array([0.3, -0.7])
)
motions = st.tuples(st.integers(0, 2**32 - 1), st.booleans(), st.booleans(), st.floats(0.3, 1.0))


def drawn(seed, level=True, elbow_up=True, scale=0.7):
    """Points near POSE, velocities up to about 0.5 m/s, and a map."""
    rng = np.random.default_rng(seed)
    x = POSE + rng.uniform(-0.05, 0.05, (6, 3))
    return x, rng.uniform(-0.5, 0.5, (6, 3)), replace(MAP, level=level, elbow_up=elbow_up, scale=scale)


def rotation(pose):
    return Rotation.from_quat(np.roll(pose[..., :4], -1, axis=-1))


@given(motions)
def test_the_palms_are_as_far_apart_as_the_hands_whatever_the_scale(case):
    x, v, retarget = drawn(*case)
    pose, *_ = retarget_motion(x, v, retarget)
    hands = np.linalg.norm(x[5] - x[2])
    assert np.linalg.norm(pose[1, 4:] - pose[0, 4:]) == pytest.approx(hands, abs=1e-12)
    middle = retarget.world + retarget.scale * (0.5 * (x[2] + x[5]) - retarget.person)
    np.testing.assert_allclose(0.5 * (pose[0, 4:] + pose[1, 4:]), middle, atol=1e-12)


@given(motions)
def test_the_palms_face_each_other_along_their_line(case):
    x, v, retarget = drawn(*case)
    pose, *_ = retarget_motion(x, v, retarget)
    line = pose[1, 4:] - pose[0, 4:]
    line /= np.linalg.norm(line)
    np.testing.assert_allclose(np.linalg.norm(pose[:, :4], axis=-1), 1.0, atol=1e-12)
    left, right = rotation(pose).apply([0.0, 0.0, 1.0])
    np.testing.assert_allclose(left, line, atol=1e-12)
    np.testing.assert_allclose(right, -line, atol=1e-12)


@given(motions)
def test_only_a_levelled_line_is_level(case):
    x, v, retarget = drawn(*case)
    pose, twist, *_ = retarget_motion(x, v, retarget)
    if retarget.level:
        assert pose[0, 6] == pytest.approx(pose[1, 6], abs=1e-12)
        assert twist[0, 5] == pytest.approx(twist[1, 5], abs=1e-12)
        np.testing.assert_array_equal(twist[:, :2], 0.0)
    else:
        line, hands = pose[1, 4:] - pose[0, 4:], x[5] - x[2]
        assert line[2] == pytest.approx(hands[2], abs=1e-12)
        # Within the soft limit of yaw the line is the hands' own.
        np.testing.assert_allclose(line, hands, atol=1e-12)


@given(motions)
def test_twists_and_swivel_rates_are_the_derivatives_of_poses_and_angles(case):
    x, v, retarget = drawn(*case)
    _, twist, _, psi_dot = retarget_motion(x, v, retarget)
    before, after = (retarget_motion(x + h * v, v, retarget) for h in (-STEP, STEP))
    turned = (rotation(after[0]) * rotation(before[0]).inv()).as_rotvec()
    np.testing.assert_allclose(twist[:, :3], turned / (2 * STEP), atol=1e-5)
    np.testing.assert_allclose(twist[:, 3:], (after[0] - before[0])[:, 4:] / (2 * STEP), atol=1e-5)
    np.testing.assert_allclose(psi_dot, wrap(after[2] - before[2]) / (2 * STEP), atol=2e-5)


@pytest.mark.parametrize("level", [True, False])
def test_twists_hold_beyond_the_soft_limit_of_yaw(level):
    x, v, retarget = drawn(3, level)
    middle = 0.5 * (x[2] + x[5])
    turn = Rotation.from_euler("z", 36, degrees=True).as_matrix()
    x[[2, 5]] = middle + (x[[2, 5]] - middle) @ turn.T
    pose, twist, *_ = retarget_motion(x, v, retarget)
    line = pose[1, 4:] - pose[0, 4:]
    yaw, asked = np.arctan2(line[1], line[0]), np.arctan2(*(x[5] - x[2])[[1, 0]])
    assert retarget.yaw[0] < yaw < asked
    before, after = (retarget_motion(x + h * v, v, retarget)[0] for h in (-STEP, STEP))
    turned = (rotation(after) * rotation(before).inv()).as_rotvec()
    np.testing.assert_allclose(twist[:, :3], turned / (2 * STEP), atol=1e-5)
    np.testing.assert_allclose(twist[:, 3:], (after - before)[:, 4:] / (2 * STEP), atol=1e-5)


@given(st.floats(-3, 3), st.floats(-3, 3))
def test_rolls_turn_the_palms_about_their_normals_and_do_nothing_else(left, right):
    x, v, retarget = drawn(1)
    plain = retarget_motion(x, v, replace(retarget, rolls=np.zeros(2)))
    rolled = retarget_motion(x, v, replace(retarget, rolls=np.array([left, right])))
    relative = (rotation(plain[0]).inv() * rotation(rolled[0])).as_rotvec()
    np.testing.assert_allclose(relative, [[0, 0, left], [0, 0, right]], atol=1e-9)
    np.testing.assert_array_equal(plain[0][:, 4:], rolled[0][:, 4:])
    for one, other in zip(plain[1:], rolled[1:], strict=True):
        np.testing.assert_array_equal(one, other)


def test_with_no_roll_the_palms_x_axis_is_up():
    x, v, retarget = drawn(2)
    pose, *_ = retarget_motion(x, v, replace(retarget, rolls=np.zeros(2)))
    np.testing.assert_allclose(rotation(pose).apply([1.0, 0.0, 0.0]), [[0, 0, 1], [0, 0, 1]], atol=1e-12)


def swung(outward_degrees):
    """POSE with each elbow swung outward from hanging by the same angle, about the shoulder-wrist axis."""
    x = POSE.copy()
    for arm, (s, e, w) in enumerate(((0, 1, 2), (3, 4, 5))):
        axis = x[w] - x[s]
        turn = OUTWARD[arm] * np.deg2rad(outward_degrees) - swivel_angle(x[s], x[e], x[w])
        x[e] = x[s] + Rotation.from_rotvec(turn * axis / np.linalg.norm(axis)).apply(x[e] - x[s])
    return x


@pytest.mark.parametrize("outward", [-8.0, 0.0, 25.0, 44.0])
def test_within_the_limits_the_elbow_swings_as_far_from_up_as_the_persons_from_down(outward):
    x = swung(outward)
    psi = retarget_motion(x, 0 * x, MAP)[2]
    # Straight up is pi; outward from there is the other way round than outward from straight down.
    np.testing.assert_allclose(wrap(psi - np.pi), -OUTWARD * np.deg2rad(outward), atol=1e-9)
    below = retarget_motion(x, 0 * x, replace(MAP, elbow_up=False))[2]
    np.testing.assert_allclose(below, OUTWARD * np.deg2rad(outward), atol=1e-9)


@pytest.mark.parametrize("outward", [25.0, -8.0])
def test_the_mirrored_elbow_is_the_reflection_in_the_horizontal_plane(outward):
    x = swung(outward)
    psi = retarget_motion(x, 0 * x, MAP)[2]
    for arm, (s, e, w) in enumerate(((0, 1, 2), (3, 4, 5))):
        shoulder, elbow = x[s] * 1.0, x[e] * 1.0
        wrist = np.array([x[w][0], x[w][1], shoulder[2]])  # a level arm, for which the mirror is exactly z -> -z
        level = x.copy()
        level[w] = wrist
        down = retarget_motion(level, 0 * level, replace(MAP, elbow_up=False, swing_out=(3, 4), swing_in=(3, 4)))[2]
        mirrored = swivel_angle(shoulder, np.array([elbow[0], elbow[1], 2 * shoulder[2] - elbow[2]]), wrist)
        up = retarget_motion(level, 0 * level, replace(MAP, swing_out=(3, 4), swing_in=(3, 4)))[2]
        assert down[arm] == pytest.approx(swivel_angle(shoulder, elbow, wrist))
        assert wrap(up[arm] - mirrored) == pytest.approx(0.0, abs=1e-9)
    assert np.all(np.abs(psi) > np.pi / 2)


@pytest.mark.parametrize(("outward", "limits"), [(60.0, MAP.swing_out), (110.0, MAP.swing_out), (-30.0, MAP.swing_in)])
def test_beyond_the_limits_the_elbow_swings_less(outward, limits):
    x = swung(outward)
    swing = np.abs(wrap(retarget_motion(x, 0 * x, MAP)[2] - np.pi))
    assert np.all(swing > limits[0])
    assert np.all(swing < limits[1])


def test_elbows_far_from_the_body_have_the_outward_limits_and_elbows_at_the_breast_the_inward_ones():
    x = POSE.copy()
    x[[1, 4]] = 0.5 * (x[[0, 3]] + x[[2, 5]])
    for aside, limits in ((0.2, MAP.swing_out), (-0.2, MAP.swing_in)):
        # The left arm is the one at negative x.
        x[1, 0], x[4, 0] = -0.18 - aside, 0.18 + aside
        x[[1, 4], 2] = 1.2
        swing = np.abs(wrap(retarget_motion(x, 0 * x, MAP)[2] - np.pi))
        assert np.all((limits[0] < swing) & (swing < limits[1]))


@given(st.floats(-3, 3), st.floats(0.05, 1.0), st.floats(0.05, 1.0))
def test_soft_limits_bound_the_angle_and_have_a_continuous_derivative(angle, start, width):
    limits = (start, start + width)
    value, slope = softly_limited(angle, limits)
    assert abs(value) <= start + width
    if abs(angle) <= start:
        assert (value, slope) == (angle, 1.0)
    difference = (softly_limited(angle + STEP, limits)[0] - softly_limited(angle - STEP, limits)[0]) / (2 * STEP)
    assert slope == pytest.approx(difference, abs=1e-3)
    # C1 at the seam: the slope just beyond it is still 1.
    assert softly_limited(start + 1e-6 * width, limits)[1] == pytest.approx(1.0, abs=1e-9)


@given(motions)
def test_the_box_lies_between_the_palms_along_their_line(case):
    x, v, retarget = drawn(*case)
    pose, *_ = retarget_motion(x, v, retarget)
    box = box_pose(x, retarget)
    np.testing.assert_allclose(box[4:], 0.5 * (pose[0, 4:] + pose[1, 4:]), atol=1e-12)
    in_box = rotation(box).inv().apply(pose[:, 4:] - box[4:])
    half = 0.5 * np.linalg.norm(x[5] - x[2])
    np.testing.assert_allclose(in_box, [[-half, 0, 0], [half, 0, 0]], atol=1e-12)
    # The box keeps its y axis level and its z axis upward.
    assert rotation(box).apply([0.0, 1.0, 0.0])[2] == pytest.approx(0.0, abs=1e-12)
    assert rotation(box).apply([0.0, 0.0, 1.0])[2] > 0.5


def test_a_whole_motion_is_retargeted_as_its_samples():
    cases = [drawn(seed) for seed in range(5)]
    x, v = (np.stack([case[i] for case in cases]) for i in range(2))
    whole = retarget_motion(x, v, MAP)
    given_offsets = retarget_motion(x, v, MAP, palm_offsets(MAP.rolls))
    for k in range(len(x)):
        for together, same, single in zip(whole, given_offsets, retarget_motion(x[k], v[k], MAP), strict=True):
            np.testing.assert_allclose(together[k], single, atol=1e-12)
            np.testing.assert_array_equal(together, same)


@given(st.integers(0, 2**32 - 1))
def test_the_quaternion_product_is_scipys(seed):
    a, b = Rotation.random(2, random_state=np.random.default_rng(seed))
    wxyz = [np.roll(r.as_quat(), 1) for r in (a, b, a * b)]
    product = multiply(wxyz[0], wxyz[1])
    assert abs(product @ wxyz[2]) == pytest.approx(1.0, abs=1e-12)


@given(motions, st.floats(0.3, 1.0))
def test_hands_that_hold_nothing_may_be_nearer_about_the_same_middle(case, share):
    x, v, retarget = drawn(*case)
    (pose, twist, *rest), (near, nearer, *same) = (
        retarget_motion(x, v, each) for each in (retarget, replace(retarget, hands_scale=share))
    )
    np.testing.assert_array_equal(near[:, :4], pose[:, :4])
    np.testing.assert_allclose(near[:, 4:].mean(axis=0), pose[:, 4:].mean(axis=0), atol=1e-12)
    np.testing.assert_allclose(near[1, 4:] - near[0, 4:], share * (pose[1, 4:] - pose[0, 4:]), atol=1e-12)
    np.testing.assert_allclose(nearer[1, 3:] - nearer[0, 3:], share * (twist[1, 3:] - twist[0, 3:]), atol=1e-12)
    np.testing.assert_array_equal(same, rest)
