"""How many frames a scene gets."""

from types import SimpleNamespace

import pytest

from drake_blfdmp.evaluation.carry_out import MOST_SCENE_FRAMES, SceneRate
from drake_blfdmp.planning.scenario import Scenario


def rate_of(duration_s):
    return SceneRate(SimpleNamespace(scenario=Scenario(), duration_s=duration_s))


def test_a_short_scene_has_the_scenarios_rate_and_a_long_one_as_many_frames_as_a_page_bears():
    assert rate_of(16.4) == Scenario().simulation.scene_rate_hz
    assert rate_of(170.0) * 170.0 == pytest.approx(MOST_SCENE_FRAMES)
    assert rate_of(170.0) < Scenario().simulation.scene_rate_hz
