"""Shares and tables of outcomes made by hand, and starts inside and outside the published law's bounds."""

import numpy as np

from drake_blfdmp.demonstration.modelled_person import hold_and_place
from drake_blfdmp.evaluation.studies.guarantee_metrics import by_link, by_problem, by_run, outside_axes, violations
from drake_blfdmp.evaluation.studies.random_problems import NEVER, Outcome, draw_problems
from drake_blfdmp.skill.bands import Bands
from drake_blfdmp.skill.learning import learn_skill


def outcome():
    """Of four problems one left two links, another one the hands."""
    least, left_s = np.full((4, 5), 0.3), np.full((4, 5), NEVER)
    least[1, :2], left_s[1, :2] = -0.1, (0.5, 0.4)
    least[3, 2], left_s[3, 2] = -np.inf, 2.0
    return Outcome(least, left_s)


def test_a_problem_counts_once_however_many_links_it_left():
    found = violations(outcome())
    assert (found.count, found.trials) == (2, 4)
    kept = Outcome(np.full((6, 5), 0.2), np.full((6, 5), NEVER))
    table = by_run({"one": outcome(), "other": kept}).columns
    assert list(table["left"]) == [2, 0] and list(table["problems"]) == [4, 6]
    assert list(table["share_percent"]) == [50.0, 0.0] and list(table["least_margin"]) == [-np.inf, 0.2]


def test_every_link_has_its_row():
    table = by_link({"one": outcome()}).columns
    assert list(table["left"]) == [1, 1, 1, 0, 0]
    assert list(table["least_margin"]) == [-0.1, -0.1, -np.inf, 0.3, 0.3]


def test_a_problem_is_left_when_its_first_link_is():
    problems = draw_problems(learn_skill(*hold_and_place()), 4, 0, 0.001)
    table = by_problem(problems, outcome()).columns
    np.testing.assert_array_equal(table["first_left_s"], [NEVER, 0.4, NEVER, 2.0])
    np.testing.assert_array_equal(table["least_margin"], [0.3, -0.1, 0.3, -np.inf])
    # The hands start up to 0.35 m off the distance that is opened to.
    assert np.all(np.abs(table["hands_at_start_m"] - problems.open_m) <= 0.35 + 1e-9)


def test_a_start_outside_the_published_bound_is_seen():
    """Of a skeleton on the desired lengths no axis is outside; filling 0.5 keeps all inside, 0.8 does not."""
    skill = learn_skill(*hold_and_place())
    problems = draw_problems(skill, 200, 0, 0.001)
    bones = np.array([0.22, 0.28, 0.0, 0.28, 0.22])
    assert not outside_axes(problems.start, problems.bands(bones, 3.0, filling=0.5)).any()
    wide: Bands = problems.bands(bones, 3.0, filling=0.8)
    assert outside_axes(problems.start, wide).mean() > 0.9
