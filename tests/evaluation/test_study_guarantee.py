"""The study of random problems, quickly: its figures agree with its tables, and its claims with both."""

import numpy as np
import pytest

from drake_blfdmp.evaluation.study import StudyContext
from drake_blfdmp.evaluation.study_runner import FindStudies, LoadStudy
from drake_blfdmp.planning.scenario import LoadScenario
from drake_blfdmp.skill.laws import LAWS


@pytest.fixture(scope="module")
def script(command_line):
    return FindStudies(command_line.ROOT / "studies")["guarantee"]


@pytest.fixture(scope="module")
def told():
    return []


@pytest.fixture(scope="module")
def study(script, told):
    scenario = LoadScenario(script.scenario)
    context = StudyContext(scenario, True, lambda what, share: told.append((what, share)), None, 1)
    return LoadStudy(script)(context)


def column(study, table, name):
    return np.array(study.tables[table].columns[name])


def test_every_law_is_judged_on_every_link(study, redrawn):
    laws = list(study.tables["violations"].columns["law"])
    assert set(LAWS) <= set(laws)
    assert len(study.tables["links"].columns["link"]) == 5 * len(laws)
    assert set(redrawn(study)) == {"violations", "least_margins", "first_times"}


def test_shares_lie_in_their_intervals(study):
    share, lower, upper = (column(study, "violations", f"{name}_percent") for name in ("share", "lower", "upper"))
    assert np.all((lower <= share) & (share <= upper) & (upper > lower))
    left, problems = column(study, "violations", "left"), column(study, "violations", "problems")
    np.testing.assert_allclose(share, 100.0 * left / problems)


def test_tables_agree(study):
    """A band is left where a margin is not positive, and of a law no more often on one link than on any."""
    left, least = column(study, "violations", "left"), column(study, "violations", "least_margin")
    np.testing.assert_array_equal(left > 0, ~(least > 0.0))
    by_link = column(study, "links", "left").reshape(-1, 5)
    assert np.all(by_link.max(axis=1) <= left) and np.all(by_link.sum(axis=1) >= left)
    np.testing.assert_array_equal(column(study, "links", "least_margin").reshape(-1, 5).min(axis=1), least)
    problems = column(study, "problems", "least_margin")
    assert len(problems) == column(study, "violations", "problems")[0]
    assert problems.min() == least[0]


def test_the_default_law_keeps_all_and_no_coupling_none(study):
    laws = list(study.tables["violations"].columns["law"])
    left = column(study, "violations", "left")
    assert left[laws.index("default")] == 0
    assert left[laws.index("none")] == column(study, "violations", "problems")[laws.index("none")]
    assert [claim.holds for claim in study.claims[:2]] == [True, True]


def test_progress_is_told(told, study):
    running = [share for what, share in told if what == "running"]
    assert running == sorted(running) and running[-1] == pytest.approx(1.0)
