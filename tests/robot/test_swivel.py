"""The swivel angle: closed forms, signs, derivatives, invariance, and what happens where it is undefined."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from drake_blfdmp.robot.swivel import STRAIGHT, swivel_angle, swivel_direction, swivel_jacobians, swivel_rate, wrap

STEP = 1e-6
ORIGIN = np.zeros(3)
coordinates = st.floats(-0.6, 0.6).map(lambda value: round(value, 4))
vectors = st.tuples(coordinates, coordinates, coordinates).map(np.array)


def elbow_at(psi, wrist, *, along=0.4, radius=0.15):
    """The elbow's place relative to the shoulder for a swivel angle: turned by psi about the shoulder-wrist axis."""
    axis = wrist / np.linalg.norm(wrist)
    down = np.array([0.0, 0.0, -1.0])
    down = down - axis * (axis @ down)
    down /= np.linalg.norm(down)
    return along * wrist + radius * Rotation.from_rotvec(psi * axis).apply(down)


def is_well_defined(e, w):
    length, flat = np.linalg.norm(w), np.hypot(w[0], w[1])
    return length > 0.1 and flat > 0.1 * length and np.linalg.norm(np.cross(e, w)) > 0.03 * length


@given(vectors, st.floats(-3.1, 3.1), st.floats(0.02, 0.3))
def test_turning_the_elbow_about_the_axis_turns_the_angle(wrist, psi, radius):
    assume(np.hypot(wrist[0], wrist[1]) > 0.05)
    assert swivel_angle(ORIGIN, elbow_at(psi, wrist, radius=radius), wrist) == pytest.approx(psi, abs=1e-9)


@pytest.mark.parametrize("wrist", [[0.0, 0.5, 0.0], [0.3, 0.4, -0.2], [-0.2, 0.1, 0.4]])
def test_a_hanging_elbow_has_angle_zero_and_a_raised_one_pi(wrist):
    wrist = np.array(wrist)
    middle = 0.5 * wrist
    lift = np.array([0.0, 0.0, 0.2])
    assert swivel_angle(ORIGIN, middle - lift, wrist) == pytest.approx(0.0, abs=1e-12)
    assert abs(swivel_angle(ORIGIN, middle + lift, wrist)) == pytest.approx(np.pi, abs=1e-12)


@pytest.mark.parametrize(("side", "sign"), [(-1.0, 1.0), (1.0, -1.0)])
def test_the_left_elbow_swings_outward_with_a_positive_angle_the_right_with_a_negative_one(side, sign):
    """Hands in front; x is to the right, so the left elbow's way out is -x. Either way the elbow also rises."""
    shoulder, wrist = np.array([0.2 * side, 0.0, 1.4]), np.array([0.2 * side, 0.4, 1.2])
    hanging = shoulder + elbow_at(0.0, wrist - shoulder)
    swung = shoulder + elbow_at(sign * np.deg2rad(40), wrist - shoulder)
    assert sign * swivel_angle(shoulder, swung, wrist) == pytest.approx(np.deg2rad(40))
    assert side * (swung[0] - hanging[0]) > 0.05
    assert swung[2] > hanging[2] + 0.02


@given(vectors, vectors)
def test_jacobians_are_the_angles_derivatives(e, w):
    assume(is_well_defined(e, w))
    je, jw = swivel_jacobians(ORIGIN, e, w)
    for jacobian, at in ((je, lambda d: (e + d, w)), (jw, lambda d: (e, w + d))):
        for axis in range(3):
            d = STEP * np.eye(3)[axis]
            difference = wrap(swivel_angle(ORIGIN, *at(d)) - swivel_angle(ORIGIN, *at(-d))) / (2 * STEP)
            assert jacobian[axis] == pytest.approx(difference, rel=1e-5, abs=1e-5)


@given(vectors, vectors, vectors, st.floats(-np.pi, np.pi), st.floats(0.5, 3.0))
def test_neither_moving_nor_heading_nor_size_changes_the_angle(e, w, shift, yaw, size):
    assume(is_well_defined(e, w))
    turn = Rotation.from_euler("z", yaw)
    moved = [shift + size * turn.apply(point) for point in (ORIGIN, e, w)]
    assert wrap(swivel_angle(*moved) - swivel_angle(ORIGIN, e, w)) == pytest.approx(0.0, abs=1e-9)


@given(vectors, vectors, vectors, vectors, vectors)
def test_the_rate_is_the_angles_time_derivative(e, w, s_dot, e_dot, w_dot):
    assume(is_well_defined(e, w))
    before, after = (swivel_angle(h * s_dot, e + h * e_dot, w + h * w_dot) for h in (-STEP, STEP))
    rate = swivel_rate(ORIGIN, e, w, s_dot, e_dot, w_dot)
    assert rate == pytest.approx(wrap(after - before) / (2 * STEP), rel=1e-5, abs=2e-5)


def test_a_turn_about_the_vertical_axis_has_no_rate():
    e, w, omega = np.array([0.1, 0.2, -0.2]), np.array([0.3, 0.4, 0.1]), np.array([0.0, 0.0, 1.3])
    assert swivel_rate(ORIGIN, e, w, ORIGIN, np.cross(omega, e), np.cross(omega, w)) == pytest.approx(0.0, abs=1e-12)


@given(vectors, vectors)
def test_the_printed_direction_is_the_arm_planes_normal_and_turns_the_angle_down(e, w):
    """(19): U is normal to both bones; an elbow moving along U at r per second, r from the axis, has psi' = -1."""
    assume(is_well_defined(e, w))
    u = swivel_direction(ORIGIN, e, w)
    assert np.linalg.norm(u) == pytest.approx(1.0)
    assert u @ e == pytest.approx(0.0, abs=1e-9)
    assert u @ (w - e) == pytest.approx(0.0, abs=1e-9)
    radius = np.linalg.norm(np.cross(e, w)) / np.linalg.norm(w)
    assert swivel_rate(ORIGIN, e, w, ORIGIN, radius * u, ORIGIN) == pytest.approx(-1.0, abs=1e-9)


@pytest.mark.parametrize(
    ("e", "w"),
    [
        ([0.0, 0.25, 0.0], [0.0, 0.5, 0.0]),  # straight
        ([0.0, 0.25, 0.1 * STRAIGHT], [0.0, 0.5, 0.0]),  # as good as straight
        ([0.1, 0.0, -0.25], [0.0, 0.0, -0.5]),  # pointing straight down
        ([0.1, 0.0, 0.25], [0.0, 0.0, 0.5]),  # straight up
        ([0.1, 0.2, -0.2], [0.0, 0.0, 0.0]),  # hand at the shoulder
        ([0.0, 0.0, 0.0], [0.0, 0.0, 0.0]),
    ],
)
@pytest.mark.filterwarnings("error")
def test_an_undefined_angle_stands_still_and_everything_stays_finite(e, w):
    e, w = np.array(e), np.array(w)
    assert np.isfinite(swivel_angle(ORIGIN, e, w))
    assert np.all(np.isfinite(swivel_direction(ORIGIN, e, w)))
    for jacobian in swivel_jacobians(ORIGIN, e, w):
        np.testing.assert_array_equal(jacobian, 0.0)
    assert swivel_rate(ORIGIN, e, w, ORIGIN, np.ones(3), np.ones(3)) == 0.0


def test_stacks_of_arms_are_computed_as_single_ones():
    rng = np.random.default_rng(0)
    s, e, w, *rates = rng.normal(size=(6, 4, 2, 3))
    angle, rate, u = swivel_angle(s, e, w), swivel_rate(s, e, w, *rates), swivel_direction(s, e, w)
    assert angle.shape == rate.shape == (4, 2)
    for k in np.ndindex(4, 2):
        assert angle[k] == pytest.approx(swivel_angle(s[k], e[k], w[k]))
        assert rate[k] == pytest.approx(swivel_rate(s[k], e[k], w[k], *(r[k] for r in rates)))
        np.testing.assert_allclose(u[k], swivel_direction(s[k], e[k], w[k]))


@given(st.floats(-50, 50))
def test_wrapping_changes_whole_turns_only(angle):
    wrapped = wrap(angle)
    assert -np.pi <= wrapped <= np.pi
    turns = (angle - wrapped) / (2 * np.pi)
    assert turns == pytest.approx(round(turns), abs=1e-9)
