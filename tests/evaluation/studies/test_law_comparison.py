from dataclasses import replace

import numpy as np
import pytest

from drake_blfdmp.evaluation.studies.law_comparison import (
    compare_case,
    compare_laws,
    curves_table,
    epochs_table,
    how_searched,
    laws_table,
    learned,
    told,
    with_constant_distance,
)
from drake_blfdmp.planning.sources import LoadSource
from drake_blfdmp.planning.task import MakeMotion, MakeTask
from drake_blfdmp.skeleton import HANDS
from drake_blfdmp.skill.laws import LAWS
from drake_blfdmp.skill.laws.follower import PublishedGains
from drake_blfdmp.skill.laws.gams import GamsGains

WEAK = PublishedGains(k_z=2.0)


@pytest.fixture(scope="module")
def task(default_scenario):
    source = LoadSource(default_scenario)
    return MakeTask(default_scenario, source, MakeMotion(default_scenario, source))


@pytest.fixture(scope="module")
def runs(default_scenario, task):
    return compare_laws(default_scenario, task, {"published": WEAK}, time_step=0.008)


def test_a_constant_distance_opens_the_funnel_to_the_start(task):
    constant = with_constant_distance(task, 0.31)
    desired = constant.bands.desired(np.linspace(0.0, 9.0, 10))[0][:, HANDS]
    np.testing.assert_array_equal(desired, 0.31)
    lower, upper = constant.bands.evaluate(0.0)[:2, HANDS]
    length = np.linalg.norm(np.diff(task.skill.start[[2, 5]], axis=0))
    assert (length - 0.31) / (0.5 * (upper - lower)) == pytest.approx(0.8)
    assert constant.skill is task.skill


def test_every_law_runs_with_given_gains_or_the_scenarios(runs):
    assert list(runs) == list(LAWS)
    assert runs["published"].gains == WEAK and runs["published_loop"].gains == PublishedGains()
    assert runs["none"].gains is None
    assert runs["default"].result.outside == 0 < runs["published"].result.outside
    assert np.all(np.isfinite(runs["gams"].hands))


def test_what_is_gone_stays_gone(runs, task):
    run = runs["published_lagged"]
    k = int(np.argmax(np.isnan(run.hands)))
    assert 0 < k < 100 and np.all(np.isnan(run.hands[k:]))
    assert np.all(np.abs(run.hands[:k] - task.bands.desired(run.t[:k])[0][:, HANDS]) < 0.4)


@pytest.fixture(scope="module")
def case(default_scenario, task):
    told_of = []
    options = {"time_step": 0.01, "quick": True, "progress": lambda what, share: told_of.append(share)}
    result = compare_case(default_scenario, task, ("gams",), with_best=True, **options)
    assert told_of == sorted(told_of) and told_of[0] >= 0.0 and told_of[-1] <= 1.0
    return result


def test_a_case_runs_with_the_best_of_its_search_and_learns(case, task):
    assert case.runs["gams"].gains == case.best("gams") != GamsGains()
    assert case.runs["published"].gains == PublishedGains()
    assert case.outside("gams") == case.runs["gams"].result.outside
    np.testing.assert_array_equal(case.epochs[0].reference, 0.0)
    t = case.runs["default"].t
    lags = [case.lag(epoch.rollout.lengths[:, HANDS], 1.0) for epoch in case.epochs]
    assert lags[0] == pytest.approx(np.abs(case.epochs[0].error[t >= 1.0]).max()) and lags[2] < 0.2 * lags[0]
    np.testing.assert_array_equal(learned(case), case.epochs[2].rollout.lengths[:, HANDS])


def test_a_case_in_words(case):
    words = how_searched(case, "gams", replace(case.best("gams"), c_k=10.0))
    member = case.searches["gams"].member(replace(case.best("gams"), c_k=10.0))
    assert words.startswith(f"gams ({told(case.best('gams'))}; ")
    assert words.endswith(f", {case.searches['gams'].outside[member]} of 201 with the task's gains")
    assert "task's" not in how_searched(case, "gams", GamsGains(11.0))


def test_the_tables_have_a_row_or_column_a_case_and_law(case):
    cases = {"a": case, "b": replace(case, epochs=case.epochs[:2], runs={"none": case.runs["none"]})}
    rows = laws_table(cases).rows()
    assert [row[:2] for row in rows] == [*(("a", name) for name in LAWS), ("b", "none")]
    assert {row[:2]: row[2] for row in rows}["a", "none"] == "none"
    assert {row[:2]: row[6] for row in rows}["a", "published_lagged"] == "never"
    assert epochs_table(cases).columns["epoch"] == [1, 2]
    t = case.runs["default"].t
    columns = curves_table(t, np.zeros(len(t)), cases).columns
    assert set(columns) >= {"a_gams_m", "b_none_m", "a_gams_learned_m"} and "b_gams_m" not in columns


def test_gains_in_words():
    assert told(PublishedGains(300.0, 0.5, 0.0, 150.0)) == "k_z 300, d_z 0.5, largest_rate 150"
    assert told(GamsGains(300.0, 30.0)) == "c_k 300, c_2 30"
