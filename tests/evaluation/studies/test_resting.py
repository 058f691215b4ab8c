import numpy as np
import pytest

from drake_blfdmp.evaluation.studies.resting import pulled_apart, resting_distance_sampled, resting_distance_simulated
from drake_blfdmp.planning.sources import LoadSource
from drake_blfdmp.planning.task import MakeMotion, MakeTask
from drake_blfdmp.skill.laws.gams import resting_distance


@pytest.fixture(scope="module")
def task(default_scenario):
    source = LoadSource(default_scenario)
    return MakeTask(default_scenario, source, MakeMotion(default_scenario, source))


def test_the_goals_are_pulled_apart_about_their_middle(task):
    skill, bands = pulled_apart(task)
    assert np.linalg.norm(skill.goal[5] - skill.goal[2]) == pytest.approx(0.4)
    np.testing.assert_allclose(skill.goal[2] + skill.goal[5], task.skill.goal[2] + task.skill.goal[5])
    np.testing.assert_array_equal(skill.goal[[0, 1, 3, 4]], task.skill.goal[[0, 1, 3, 4]])
    assert (skill.alpha_z, skill.beta_z) == (48.0, 12.0)
    assert bands.desired(7.0)[0][2] == 0.3


@pytest.mark.parametrize("c_k", [30.0, 100.0])
def test_the_continuous_simulation_rests_where_the_closed_form_says(task, c_k):
    formula = resting_distance(0.3, 0.4, 12.0, c_k)
    assert formula == pytest.approx({30.0: 0.3166667, 100.0: 0.3056604}[c_k], abs=1e-7)
    simulated = resting_distance_simulated(task, c_k=c_k, accuracy=1e-5)
    assert simulated == pytest.approx(formula, abs=1e-8)


def test_a_sampled_one_is_off_by_its_step(task):
    formula = resting_distance(0.3, 0.4, 12.0, 100.0)
    off = [resting_distance_sampled(task, h) - formula for h in (0.016, 0.008)]
    assert 1e-5 < abs(off[1]) < abs(off[0])
    assert off[0] / off[1] == pytest.approx(2.0, rel=0.05)
