"""The primitive of an orientation: unit length, both signs, the scalar primitive, goals, steps, duration."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

from drake_blfdmp.errors import SkillError
from drake_blfdmp.quaternions import angle_between, conjugate, from_rotation_vector, multiply, normalised
from drake_blfdmp.skill.basis import centers_and_widths
from drake_blfdmp.skill.canonical import DEFAULT_GAMMA, phase_at
from drake_blfdmp.skill.orientation import (
    OrientationSkill,
    angular_acceleration,
    angular_velocity,
    error,
    error_rate,
    learn_orientation,
    orientation_step,
    roll_out_orientation,
)
from drake_blfdmp.skill.transformation import step_matrices, uncoupled_step

ALPHA, TAU = 20.0, 2.0
vectors = arrays(float, 3, elements=st.floats(-1.7, 1.7))


def skill(t, q, n=50, tau=None, gamma=DEFAULT_GAMMA, alpha_z=None):
    """What `roll_out_orientation` needs of a skill learned from q (N, 4) at t (N,)."""
    tau = t[-1] - t[0] if tau is None else tau
    alpha_z = 10.0 * tau if alpha_z is None else alpha_z
    centers, widths = centers_and_widths(n, gamma)
    own = learn_orientation(t, q, centers=centers, widths=widths, tau=tau, gamma=gamma, alpha_z=alpha_z)
    return SimpleNamespace(
        orientation=own, centers=centers, widths=widths, tau=tau, gamma=gamma, alpha_z=alpha_z, beta_z=alpha_z / 4
    )


def demonstration(rate=30.0, duration=4.0):
    """A turn about a moving axis, from rest to rest: (t, q)."""
    t = np.arange(round(duration * rate) + 1) / rate
    u = t / duration
    s = u**3 * (10 - 15 * u + 6 * u**2)
    about_x = from_rotation_vector(s[:, None] * [0.9, 0.0, 0.0])
    about_z = from_rotation_vector((np.sin(np.pi * s) ** 2)[:, None] * [0.2, 0.5, -0.7])
    return t, multiply(about_z, about_x)


def as_rotation(q):
    return Rotation.from_quat(np.roll(q, -1, axis=-1))


@settings(deadline=None)
@given(vectors, vectors, st.floats(1e-4, 1.0), vectors)
def test_the_unit_length_is_kept_by_any_step(start, omega, dt, forcing):
    q, goal = from_rotation_vector(start), from_rotation_vector(np.array([0.1, -0.2, 0.3]))
    matrices = step_matrices(dt, TAU, ALPHA, ALPHA / 4)
    for _ in range(5):
        q, omega = orientation_step(q, omega, 10.0 * forcing, goal, TAU, matrices)
        assert np.linalg.norm(q) == pytest.approx(1.0, abs=1e-14)
    assert np.all(np.isfinite(omega))


@settings(deadline=None)
@given(vectors, vectors, vectors, st.sampled_from([1.0, -1.0]), st.sampled_from([1.0, -1.0]))
def test_q_and_minus_q_are_one_orientation(start, omega, goal, sign, goal_sign):
    q, g = from_rotation_vector(start), from_rotation_vector(goal)
    matrices = step_matrices(0.01, TAU, ALPHA, ALPHA / 4)
    f = np.array([1.0, -2.0, 0.5])
    one, other = (
        orientation_step(q, omega, f, g, TAU, matrices),
        orientation_step(sign * q, omega, f, goal_sign * g, TAU, matrices),
    )
    np.testing.assert_allclose(as_rotation(one[0]).as_matrix(), as_rotation(other[0]).as_matrix(), atol=1e-12)
    np.testing.assert_allclose(one[1], other[1], atol=1e-9)
    assert other[0] @ (sign * q) > 0  # No jump of sign on the way.


@settings(deadline=None)
@given(vectors, vectors)
def test_the_error_is_the_shortest_way_and_leads_to_the_goal(start, goal):
    q, g = from_rotation_vector(start), from_rotation_vector(goal)
    e = error(q, g)
    assert np.linalg.norm(e) <= np.pi + 1e-12
    assert angle_between(multiply(from_rotation_vector(e), q), g) < 1e-7
    np.testing.assert_allclose(e, (as_rotation(g) * as_rotation(q).inv()).as_rotvec(), atol=1e-7)


@settings(deadline=None)
@given(vectors, vectors)
def test_error_rate_and_angular_velocity_are_inverse_and_the_derivative_of_the_error(start, omega):
    q, goal = from_rotation_vector(start), from_rotation_vector(np.array([0.3, 0.1, -0.4]))
    e = error(q, goal)
    if np.linalg.norm(e) > 3.0:
        return  # Next to half a turn the difference below would go over the edge.
    rate = error_rate(e, omega)
    np.testing.assert_allclose(angular_velocity(e, rate), omega, atol=1e-9)
    h = 1e-5
    before, after = (error(multiply(from_rotation_vector(s * h * omega), q), goal) for s in (-1, 1))
    np.testing.assert_allclose(rate, (after - before) / (2 * h), atol=1e-5)


@pytest.mark.parametrize("size", [0.0, 1e-12, 1e-6, 0.049, 0.051, 1.0, 3.1])
def test_small_and_large_errors_alike(size):
    """Series and quotients agree where they meet, and nothing is lost at 0 or near half a turn."""
    e, w = size * np.array([2.0, -1.0, 2.0]) / 3.0, np.array([0.3, 0.5, -0.2])
    np.testing.assert_allclose(angular_velocity(e, error_rate(e, w)), w, atol=1e-9)
    expected = -w if size < 1e-9 else None
    if expected is not None:
        np.testing.assert_allclose(error_rate(e, w), expected, atol=1e-10)
    h = 1e-6
    q = conjugate(from_rotation_vector(e))
    after = conjugate(from_rotation_vector(e + h * error_rate(e, w)))
    np.testing.assert_allclose((as_rotation(after) * as_rotation(q).inv()).as_rotvec() / h, w, atol=2e-5)


def test_a_turn_about_one_axis_is_the_scalar_primitive():
    """Closed form: the angle that is left follows (1) with the goal 0."""
    axis, angle = np.array([2.0, -1.0, 2.0]) / 3.0, 2.2
    goal = from_rotation_vector(np.array([0.4, -0.3, 0.8]))
    q = multiply(conjugate(from_rotation_vector(angle * axis)), goal)
    t, rate = np.linspace(0.0, 3.0, 13), ALPHA / (2 * TAU)
    expected = angle * (1 + rate * t) * np.exp(-rate * t)  # Critically damped, from rest.
    omega = np.zeros(3)
    matrices = step_matrices(t[1], TAU, ALPHA, ALPHA / 4)
    scalar = (np.array(angle), np.array(0.0))
    for k, left in enumerate(expected):
        np.testing.assert_allclose(error(q, goal), left * axis, atol=1e-12)
        assert scalar[0] == pytest.approx(left, abs=1e-12)
        np.testing.assert_allclose(omega, -scalar[1] / TAU * axis, atol=1e-12)
        force = 0.0 if k < 12 else 1.0
        q, omega = orientation_step(q, omega, force * axis, goal, TAU, matrices)
        scalar = uncoupled_step(*scalar, force, 0.0, matrices)


def test_the_continuous_primitive_is_the_limit_of_the_step():
    q, omega = from_rotation_vector(np.array([0.9, -1.1, 0.4])), np.array([0.8, 0.3, -1.5])
    goal, f = from_rotation_vector(np.array([-0.3, 0.2, 0.9])), np.array([3.0, -4.0, 2.0])
    rate = angular_acceleration(q, omega, f, goal, TAU, ALPHA, ALPHA / 4)
    h = 1e-6
    _, after = orientation_step(q, omega, f, goal, TAU, step_matrices(h, TAU, ALPHA, ALPHA / 4))
    np.testing.assert_allclose((after - omega) / h, rate, rtol=1e-4, atol=1e-4)


def test_a_demonstration_is_reproduced():
    t, q = demonstration()
    learned = skill(t, q)
    turn, omega = roll_out_orientation(learned, time_step=1 / 300, samples=1201)
    assert np.rad2deg(angle_between(turn[::10], q).max()) < 0.001
    # The angular velocity is the derivative of the orientation.
    between = as_rotation(turn[2:]) * as_rotation(turn[:-2]).inv()
    np.testing.assert_allclose(omega[1:-1], between.as_rotvec() * 150, atol=2e-3)


def test_signs_in_the_demonstration_do_not_matter():
    t, q = demonstration()
    flipped = q * np.where(np.arange(len(t)) % 3 == 1, -1.0, 1.0)[:, None]
    np.testing.assert_allclose(skill(t, flipped).orientation.weights, skill(t, q).orientation.weights, rtol=1e-9)


def test_another_goal_is_reached_by_the_same_kind_of_motion():
    t, q = demonstration()
    learned = skill(t, q)
    goal = multiply(from_rotation_vector(np.array([0.0, 0.4, 0.0])), q[-1])
    turn, omega = roll_out_orientation(learned, time_step=0.01, samples=801, goal=goal)
    assert angle_between(turn[-1], goal) < 1e-3
    assert np.linalg.norm(omega[-1]) < 1e-3
    same, _ = roll_out_orientation(learned, time_step=0.01, samples=801, goal=-q[-1])
    own, _ = roll_out_orientation(learned, time_step=0.01, samples=801)
    np.testing.assert_allclose(same, own, atol=1e-12)


@settings(max_examples=20, deadline=None)
@given(arrays(float, 3, elements=st.floats(-1.7, 1.7)))
def test_it_converges_from_anywhere_and_by_the_shortest_way(start):
    q, goal, omega = from_rotation_vector(start), np.array([1.0, 0.0, 0.0, 0.0]), np.zeros(3)
    matrices = step_matrices(0.02, TAU, ALPHA, ALPHA / 4)
    left = [np.linalg.norm(error(q, goal))]
    for _ in range(200):
        q, omega = orientation_step(q, omega, np.zeros(3), goal, TAU, matrices)
        left.append(np.linalg.norm(error(q, goal)))
    assert np.all(np.diff(left) <= 1e-9)
    assert left[-1] < 1e-6


def test_the_path_does_not_depend_on_the_step():
    t, q = demonstration()
    learned = skill(t, q)
    fine, _ = roll_out_orientation(learned, time_step=0.001, samples=4001)
    for factor, bound in ((10, 2e-5), (2, 1e-6)):
        coarse, _ = roll_out_orientation(learned, time_step=0.001 * factor, samples=4000 // factor + 1)
        assert angle_between(coarse, fine[::factor]).max() < bound


def test_twice_the_duration_is_the_same_path():
    t, q = demonstration()
    learned = skill(t, q)
    slow = SimpleNamespace(**{**vars(learned), "tau": 2 * learned.tau})
    one, omega = roll_out_orientation(learned, time_step=0.005, samples=801)
    other, half = roll_out_orientation(slow, time_step=0.01, samples=801)
    np.testing.assert_allclose(one, other, atol=1e-10)
    np.testing.assert_allclose(0.5 * omega, half, atol=1e-9)


def test_a_batch_is_each_of_its_members():
    learned = skill(*demonstration())
    goals = normalised(np.array([[1.0, 0.1, 0.0, 0.2], [0.9, -0.3, 0.1, 0.0]]))
    both, _ = roll_out_orientation(learned, time_step=0.01, samples=101, goal=goals)
    for k, goal in enumerate(goals):
        np.testing.assert_allclose(
            both[:, k], roll_out_orientation(learned, time_step=0.01, samples=101, goal=goal)[0], atol=1e-13
        )


def test_the_law_of_2014_is_the_same_about_one_axis_and_another_about_several():
    """What Koutras and Doulgeri put right: with e' taken for -omega the error is no longer that of (1)."""
    duration, goal, q = 0.2, np.array([1.0, 0.0, 0.0, 0.0]), from_rotation_vector(np.array([0.0, 0.0, 1.2]))
    matrices = step_matrices(duration, TAU, ALPHA, ALPHA / 4)

    def apart(omega, dt):
        exact, _ = orientation_step(q, omega, np.zeros(3), goal, TAU, matrices)
        turned = q
        for _ in range(round(duration / dt)):
            omega = omega + dt * ALPHA * (ALPHA / 4 * error(turned, goal) - TAU * omega) / TAU**2
            turned = multiply(from_rotation_vector(dt * omega), turned)
        return angle_between(turned, exact)

    along, across = np.array([0.0, 0.0, 6.0]), np.array([6.0, 0.0, 0.0])
    # About one axis only the simple integration errs, in proportion to its step; about two the laws do.
    assert apart(along, 5e-4) == pytest.approx(apart(along, 1e-3) / 2, rel=0.05)
    assert apart(across, 5e-4) > 0.02 > 5 * apart(along, 5e-4)


def test_what_cannot_be_learned_is_refused_in_a_line():
    t, q = demonstration()
    options = {"centers": np.ones(3), "widths": np.ones(3), "tau": 4.0, "gamma": DEFAULT_GAMMA, "alpha_z": 40.0}
    with pytest.raises(SkillError, match="8 orientations"):
        learn_orientation(t[:5], q[:5], **options)
    with pytest.raises(SkillError, match="finite"):
        learn_orientation(t, 0.0 * q, **options)
    round_and_round = from_rotation_vector(t[:, None] * [1.0, 0.0, 0.0])
    with pytest.raises(SkillError, match="shortest way"):
        learn_orientation(t, round_and_round, **options)


def test_a_skill_of_orientations_knows_what_it_holds():
    unit = np.array([1.0, 0.0, 0.0, 0.0])
    own = OrientationSkill(np.zeros((4, 3)), unit, unit)
    np.testing.assert_allclose(own.with_goal([0.0, 2.0, 0.0, 0.0]).goal, [0.0, 1.0, 0.0, 0.0])
    assert own.forcing(phase_at(0.3, 1.0), *centers_and_widths(4, DEFAULT_GAMMA)).shape == (3,)
    for bad in ({"start": 2.0 * unit}, {"goal": unit[:3]}, {"weights": np.full((4, 3), np.nan)}):
        with pytest.raises(SkillError, match=next(iter(bad))):
            replace(own, **bad)
