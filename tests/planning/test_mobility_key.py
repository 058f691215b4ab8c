"""bands.mobility and bands.weigh_by_uncertainty: from the scenario to the law, in the rollout and in the diagram."""

from dataclasses import replace

import numpy as np
import pytest

from drake_blfdmp.errors import ScenarioError
from drake_blfdmp.planning.scenario import ApplySetting, CheckScenario, DumpScenario, LoadScenario, Scenario
from drake_blfdmp.planning.sources import LoadSource
from drake_blfdmp.planning.task import MakeMotion, MakeTask, RollOutTask
from drake_blfdmp.skill.reshaper import mobility_from_uncertainty

SIGMA = np.array([0.01, 0.02, 0.04, 0.01, 0.02, 0.03])


@pytest.fixture(scope="module")
def source():
    found = LoadSource(Scenario())
    return replace(found, demonstration=replace(found.demonstration, uncertainty=SIGMA))


@pytest.fixture(scope="module")
def motion(source):
    return MakeMotion(Scenario(), source)


def with_setting(*settings):
    scenario = Scenario()
    for setting in settings:
        scenario = ApplySetting(scenario, setting)
    CheckScenario(scenario)
    return scenario


def test_given_weights_reach_the_skill_and_change_the_rollout(source, motion):
    scenario = with_setting("bands.mobility=[1, 1, 1, 1, 1, 3]")
    task = MakeTask(scenario, source, motion)
    np.testing.assert_array_equal(task.skill.mobility, [1, 1, 1, 1, 1, 3])
    plain, weighed = RollOutTask(Scenario(), MakeTask(Scenario(), source, motion)), RollOutTask(scenario, task)
    assert np.abs(plain.x - weighed.x).max() > 1e-3
    assert weighed.margins.min() > 0.0


def test_the_recordings_uncertainty_decides_where_it_is_asked_to(source, motion):
    scenario = with_setting("bands.weigh_by_uncertainty=true")
    task = MakeTask(scenario, source, motion)
    np.testing.assert_array_equal(task.skill.mobility, mobility_from_uncertainty(SIGMA))
    assert MakeTask(Scenario(), source, motion).skill.mobility is None
    assert RollOutTask(scenario, task).margins.min() > 0.0


def test_without_an_uncertainty_there_is_nothing_to_weigh_by(source, motion):
    unknown = replace(source, demonstration=replace(source.demonstration, uncertainty=None))
    with pytest.raises(ScenarioError, match=r"bands\.weigh_by_uncertainty: .* give bands\.mobility"):
        MakeTask(with_setting("bands.weigh_by_uncertainty=true"), unknown, motion)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        (["bands.mobility=[1, 2]"], r"bands\.mobility must have 6 numbers .*, not 2"),
        (["bands.mobility=[1, 1, 1, 1, 1, 0]"], r"bands\.mobility\[5\] must be positive"),
        (["bands.mobility=[1, 1, .nan, 1, 1, 1]"], r"bands\.mobility\[2\] must be positive"),
        (["bands.mobility=[1, 1, 1, 1, 1, 1]", "bands.weigh_by_uncertainty=true"], "exclude each other"),
        (["bands.mobility=[1, 1, 1, 1, 1, 1]", "law=gams"], r"bands\.mobility is for the default law alone"),
        (["bands.weigh_by_uncertainty=true", "law=none"], r"bands\.weigh_by_uncertainty is for the default law alone"),
    ],
)
def test_weights_that_mean_nothing_are_refused(settings, message):
    with pytest.raises(ScenarioError, match=message):
        with_setting(*settings)


def test_the_keys_survive_dumping(tmp_path):
    scenario = with_setting("bands.mobility=[1, 2, 3, 4, 5, 0.1]")
    (tmp_path / "s.yaml").write_text(DumpScenario(scenario))
    assert LoadScenario(tmp_path / "s.yaml") == scenario
