"""Shape, ends and normalised time on motions whose answers are known in closed form."""

import numpy as np
import pytest

from drake_blfdmp.demonstration.modelled_person import hold_and_place
from drake_blfdmp.evaluation.studies.generalisation_metrics import (
    end_errors,
    hands_middle,
    in_normalised_time,
    path_distance,
    profile_correlation,
)
from drake_blfdmp.skill.learning import learn_skill
from drake_blfdmp.skill.rollout import roll_out

SKILL = learn_skill(*hold_and_place())
T = np.linspace(0.0, 4.0, 4001)
U = np.linspace(0.0, 1.0, 501)


def circle(turns, radius=1.0):
    """Two members (N, 2, 3) that turn `turns` times in 4 s and, the second, in 2 s."""
    angle = 2.0 * np.pi * turns * np.stack([T / 4.0, T / 2.0], axis=-1)
    return radius * np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=-1)


def carried(reference, start_shift, goal_shift, alpha_z):
    """What an uncoupled primitive, critically damped, makes of a reference from another start to another goal.

    reference + dg + (dx_0 - dg) (1 + c u) exp(-c u),   u = t / tau, c = alpha_z / 2
    """
    u = np.linspace(0.0, 1.0, len(reference))
    decay = (1.0 + 0.5 * alpha_z * u) * np.exp(-0.5 * alpha_z * u)
    decay = decay.reshape(-1, *([1] * np.ndim(goal_shift)))
    return reference + goal_shift + (np.asarray(start_shift) - goal_shift) * decay


def test_normalised_time_takes_the_duration_out():
    path = in_normalised_time(T, circle(1), np.array([4.0, 2.0]))
    angle = 2.0 * np.pi * U
    expected = np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=-1)
    for member in range(2):
        np.testing.assert_allclose(path[:, member], expected, atol=1e-5)


def test_after_its_end_a_motion_rests():
    path = in_normalised_time(T, T[:, None, None] * np.ones(3), 8.0)
    np.testing.assert_allclose(path[:, 0, 0], np.minimum(8.0 * U, 4.0), atol=1e-12)


def test_distances_of_paths():
    path = in_normalised_time(T, circle(1), np.array([4.0, 2.0]))
    np.testing.assert_allclose(path_distance(path, path), 0.0)
    np.testing.assert_allclose(path_distance(path, path + np.array([0.03, 0.0, 0.04])), 0.05)
    np.testing.assert_allclose(path_distance(2.0 * path, path), 1.0, atol=1e-5)
    # Points are averaged over: one of two is 1 m away.
    pair = np.stack([path, path], axis=2)
    other = pair + np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    np.testing.assert_allclose(path_distance(pair, other), np.sqrt(0.5))


def test_correlation_of_profiles():
    path = in_normalised_time(T, circle(1), np.array([4.0, 2.0]))
    np.testing.assert_allclose(profile_correlation(path, path), 1.0)
    np.testing.assert_allclose(profile_correlation(3.0 * path + 7.0, path), 1.0)
    np.testing.assert_allclose(profile_correlation(-path, path), -1.0)
    twice = in_normalised_time(T, circle(2), np.array([4.0, 2.0]))
    np.testing.assert_allclose(profile_correlation(twice, path), 0.0, atol=1e-9)
    # Straight along x against 45 degrees in the x-y plane.
    a = U[:, None, None] * np.array([1.0, 0.0, 0.0])
    b = U[:, None, None] * np.array([1.0, 1.0, 0.0])
    np.testing.assert_allclose(profile_correlation(a, b), np.sqrt(0.5))


@pytest.mark.parametrize("tau", [0.5 * SKILL.tau, 1.7 * SKILL.tau])
def test_the_uncoupled_primitive_is_carried_as_the_formula_says(tau):
    """Other start, goal and duration at once; and the formula's parts are seen if one is left out."""
    rng = np.random.default_rng(0)
    start, goal = 0.1 * rng.normal(size=(1, 6, 3)), 0.2 * rng.normal(size=(1, 6, 3))
    home = roll_out(SKILL, time_step=0.002, start=SKILL.start[None])
    away = roll_out(SKILL, time_step=0.002, duration=tau, start=SKILL.start + start, goal=SKILL.goal + goal, tau=tau)
    reference = in_normalised_time(home.t, home.x, SKILL.tau)
    path = in_normalised_time(away.t, away.x, tau)
    assert path_distance(path, carried(reference, start, goal, SKILL.alpha_z)) < 1e-4
    assert path_distance(path, carried(reference, 0.0 * start, goal, SKILL.alpha_z)) > 5e-3
    assert path_distance(path, carried(reference, start, 0.0 * goal, SKILL.alpha_z)) > 5e-2


def test_a_carried_motion_begins_and_ends_where_it_should():
    reference = np.zeros((501, 1, 3))
    moved = carried(reference, np.full((1, 3), 1.0), np.full((1, 3), 2.0), 60.0)
    np.testing.assert_allclose(moved[0], 1.0)
    np.testing.assert_allclose(moved[-1], 2.0, atol=1e-9)


def test_end_errors_tell_hands_from_points():
    goal = np.zeros((1, 6, 3))
    x = goal.copy()
    x[0, 2, 0], x[0, 5, 0] = 0.1, -0.1  # The hands apart: their middle is at its goal.
    error = end_errors(x, goal)
    assert error.hands == pytest.approx(0.0)
    assert error.points == pytest.approx(0.1 * np.sqrt(2.0 / 6.0))
    error = end_errors(goal + np.array([0.0, 0.3, 0.4]), goal)
    assert (error.hands[0], error.points[0]) == pytest.approx((0.5, 0.5))


def test_the_middle_is_between_the_hands():
    x = np.arange(18.0).reshape(6, 3)
    np.testing.assert_array_equal(hands_middle(x), 0.5 * (x[2] + x[5]))
