"""Cases of other starts, goals, durations and boxes: what is changed is what they say, and rows count what was lost."""

import numpy as np
import pytest

from drake_blfdmp.errors import ScenarioError
from drake_blfdmp.evaluation.studies.generalisation_cases import (
    LEARNED,
    STARTS,
    Case,
    Motion,
    best_gains,
    make_cases,
    measure,
    measure_all,
    run_cases,
)
from drake_blfdmp.evaluation.studies.generalisation_metrics import in_normalised_time
from drake_blfdmp.planning.sources import LoadSource
from drake_blfdmp.planning.task import MakeMotion, MakeTask
from drake_blfdmp.skill.geometry import link_lengths
from drake_blfdmp.skill.laws.follower import PublishedGains


@pytest.fixture(scope="module")
def cases(default_scenario):
    source = LoadSource(default_scenario)
    task = MakeTask(default_scenario, source, MakeMotion(default_scenario, source))
    return task, make_cases(default_scenario, source, task, 5)


def test_the_goals_that_are_to_be_reached_can_be(cases):
    """They have the desired lengths; the learned goal and those of single points do not."""
    task, made = cases
    desired = task.bands.desired(task.skill.tau)[0]
    for name, case in made.items():
        error = np.abs(link_lengths(case.goal_at(float(case.tau.max()))) - desired)
        if name in ("unchanged", "goal moved, each point"):
            assert error.max() > 0.01, name
        elif name.startswith("box"):
            wide = case.hands.closed_m + 0.024 + 0.1
            np.testing.assert_allclose(link_lengths(case.goal_at(10.0))[:, 2], wide, atol=1e-9)
        else:
            assert error.max() < 1e-9, name


def test_moving_goals_move_and_the_boxes_are_as_wide_as_they_say(cases):
    _, made = cases
    stops, circle = made["goal moves and stops"], made["goal moves in a circle"]
    np.testing.assert_array_equal(stops.goal_at(0.0), stops.goal_at(0.3 * stops.tau[0]))
    assert np.abs(stops.goal_at(stops.tau[0]) - stops.goal_at(0.0)).max() > 0.05
    quarter = circle.tau[0] / 8.0  # Two turns a duration.
    np.testing.assert_allclose((circle.goal_at(quarter) - circle.goal_at(0.0))[0, 0], [-0.1, 0.1, 0.0], atol=1e-12)
    np.testing.assert_allclose(circle.goal_at(circle.tau[0]), circle.goal_at(0.0), atol=1e-12)
    boxes, durations = made["box 0.20 to 0.45 m"], made["duration x 0.5 to 2"]
    np.testing.assert_allclose(boxes.hands.closed_m[[0, -1]] + 0.024, [0.20, 0.45])
    np.testing.assert_allclose(durations.tau[[0, -1]] / circle.tau[0], [0.5, 2.0])
    np.testing.assert_allclose(durations.hands.close_s / durations.tau, circle.hands.close_s / circle.tau)


def test_cases_run_together_as_they_do_alone(default_scenario, cases):
    """The unchanged problem is one of a batch of all, or of its own; only its share of the batch is handed back."""
    task, made = cases
    told = []
    some = {name: made[name] for name in (LEARNED, STARTS)}
    both = run_cases(default_scenario, task, some, ("none", "default"), 0.005, lambda *say: told.append(say))
    alone = run_cases(default_scenario, task, {LEARNED: made[LEARNED]}, ("default",), 0.005)
    assert list(both) == [(LEARNED, "none"), (LEARNED, "default"), (STARTS, "none"), (STARTS, "default")]
    one, other = both[LEARNED, "default"], alone[LEARNED, "default"]
    np.testing.assert_allclose(one.middle, other.middle, atol=1e-12)
    np.testing.assert_allclose(one.least, other.least, atol=1e-9)
    assert both[STARTS, "default"].end.shape == (5, 6, 3)
    assert {what for what, _ in told} == {"none", "default"}
    rows = measure_all(some, both)
    assert rows[LEARNED, "default"]["profile_least"] == pytest.approx(1.0)
    assert rows[STARTS, "none"]["path_max_m"] == 0.0 < rows[STARTS, "default"]["path_mean_m"]
    assert rows[LEARNED, "none"]["left"] == 1 and rows[LEARNED, "default"]["left"] == 0


def test_steps_that_are_too_long_for_the_gains_are_refused(default_scenario, cases):
    task, made = cases
    with pytest.raises(ScenarioError, match="too long"):
        run_cases(default_scenario, task, {LEARNED: made[LEARNED]}, ("default",), 0.05)


def test_problems_that_diverge_are_counted_and_not_averaged():
    """One of two problems ends nowhere; the row has the other's lengths, and says so."""
    t = np.linspace(0.0, 1.0, 11)
    middle = t[:, None, None] * np.ones((2, 3))
    end = np.ones((2, 6, 3))
    lost = middle.copy()
    lost[5:, 1] = np.nan
    motion = Motion(t, lost, np.ones((11, 2)), np.stack([end[0], np.nan * end[0]]), np.array([0.1, np.nan]))
    case = Case(0.0 * end, end + np.array([0.0, 0.3, 0.4]), np.ones(2), None)
    samples = in_normalised_time(t, middle, 1.0)
    row = measure(case, motion, samples, samples[:, :1])
    assert (row["problems"], row["diverged"], row["left"], row["least_margin"]) == (2, 1, 1, -np.inf)
    assert (row["end_hands_max_m"], row["path_max_m"], row["profile_least"]) == pytest.approx((0.5, 0.0, 1.0))


def test_the_best_gains_leave_the_fewest_bands(default_scenario, cases):
    task, made = cases
    weak, strong = PublishedGains(1.0, 3.0, 0.0, 5.0), PublishedGains()
    best, left = best_gains(task, {LEARNED: made[LEARNED]}, "published", [weak, strong], 0.004)
    assert best is strong and left == [1, 0]


def test_every_nth_problem(cases):
    case = cases[1][STARTS]
    few = case.every(2)
    np.testing.assert_array_equal(few.start, case.start[[0, 2, 4]])
    np.testing.assert_array_equal(few.goal_at(1.0), case.goal_at(1.0)[::2])
    np.testing.assert_array_equal(few.tau, case.tau[::2])
    np.testing.assert_array_equal(few.hands.closed_m, case.hands.closed_m[::2])
