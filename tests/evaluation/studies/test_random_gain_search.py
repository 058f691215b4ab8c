import numpy as np
import pytest

from drake_blfdmp.demonstration.modelled_person import hold_and_place
from drake_blfdmp.evaluation.studies.random_gain_search import search_on_problems
from drake_blfdmp.evaluation.studies.random_problems import Job, Spread, draw_problems, run_job
from drake_blfdmp.skeleton import HANDS
from drake_blfdmp.skill.laws.follower import PublishedGains
from drake_blfdmp.skill.laws.gams import GamsGains
from drake_blfdmp.skill.learning import learn_skill

SPREAD = Spread(tau=(0.3, 0.35), goal_m=0.02, hands_error_m=0.1)


@pytest.fixture(scope="module")
def base():
    skill = learn_skill(*hold_and_place())
    problems = draw_problems(skill, 6, 3, 0.004, SPREAD)
    return Job(skill, np.array([0.22, 0.28, 0.0, 0.28, 0.22]), 3.0, problems, "default", 0.004)


def test_the_fewest_problems_count_and_of_equals_the_first(base):
    tight, loose, diverging = (GamsGains(c_k, 0.0) for c_k in (300.0, 1.0, 1e9))
    published = [PublishedGains(300.0, 0.1, 0.0, 200.0)] * 2
    best, table = search_on_problems(base, base.problems, {"gams": [diverging, loose, tight], "published": published})
    assert best == {"gams": tight, "published": published[0]} and best["published"] is published[0]
    left = list(table.columns["left"])
    assert left[0] == len(base.problems) and left[2] < left[1] <= left[0]
    assert table.columns["gains"][2] == "c_k 300, c_2 0, lf_1 1, lf_2 1"


def test_gams_is_judged_by_the_hands_alone(base):
    from dataclasses import replace

    gains = GamsGains(300.0, 0.0)
    outcome = run_job(replace(base, law="gams", gains=gains))
    _, table = search_on_problems(base, base.problems, {"gams": [gains]})
    assert table.columns["left"][0] == outcome.left[:, HANDS].sum() < outcome.left.any(axis=1).sum()
