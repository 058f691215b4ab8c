"""Open palms beside a box that stands: how near they are, and that a plan whose palms would push it is not taken."""

from pathlib import Path

import numpy as np
import pytest

from drake_blfdmp.errors import TaskError
from drake_blfdmp.evaluation.robustness.tasks import draw_task, task_scenario
from drake_blfdmp.planning import plan as planning
from drake_blfdmp.planning.open_palms import CheckOpenPalms, PalmGaps
from drake_blfdmp.planning.plan import MakePlan
from drake_blfdmp.planning.scenario import LoadScenario, Scenario
from drake_blfdmp.robot.box import BoxParameters
from drake_blfdmp.robot.grasp_force import PALM_RADIUS

BOX = BoxParameters(width=0.3, depth=0.2, height=0.24, mass=1.0, friction=0.8)
UPRIGHT = (1.0, 0.0, 0.0, 0.0)


def gaps(left, right, pose=(*UPRIGHT, 0.0, 0.0, 0.0)):
    palms = np.array([(*UPRIGHT, *left), (*UPRIGHT, *right)])
    return PalmGaps(palms, np.array(pose), BOX)


def test_the_gap_is_to_the_sides_that_the_palms_take():
    np.testing.assert_allclose(gaps((-0.2, 0.0, 0.0), (0.16, 0.05, -0.1)), [0.05, 0.01], atol=1e-15)
    np.testing.assert_allclose(gaps((-0.14, 0.0, 0.0), (0.16, 0.0, 0.0)), [-0.01, 0.01], atol=1e-15)


@pytest.mark.parametrize("axis", [1, 2])
def test_a_pad_that_is_past_an_edge_is_elsewhere(axis):
    half = 0.5 * (BOX.depth, BOX.height)[axis - 1] + PALM_RADIUS
    past, beside = np.zeros(3), np.zeros(3)
    past[[0, axis]], beside[[0, axis]] = (0.1, half + 1e-6), (0.1, -half + 1e-6)
    np.testing.assert_allclose(gaps(past, beside), [np.inf, -0.05])


def test_it_is_measured_in_the_box_and_broadcasts():
    half = np.sqrt(0.5)
    pose = np.array([[half, 0.0, 0.0, half, 0.5, 0.2, 0.3], [*UPRIGHT, 0.5, 0.2, 0.3]])  # Yaw of 90 degrees, and none.
    palms = np.array([(*UPRIGHT, 0.5, 0.2 - 0.2, 0.3), (*UPRIGHT, 0.5, 0.2 + 0.17, 0.3)])
    np.testing.assert_allclose(PalmGaps(palms, pose, BOX), [[0.05, 0.02], [np.inf, np.inf]], atol=1e-12)


def test_the_default_plan_keeps_its_open_palms_off(default_plan):
    CheckOpenPalms(default_plan)
    with pytest.raises(TaskError, match="clearance: (before|after) the hands hold the box one comes [0-9] mm too near"):
        CheckOpenPalms(default_plan, least=0.051)  # They open by 50 mm on each side.


def test_hands_that_wander_after_they_let_go_are_followed_less_far():
    """A recording, as a Kinect v1 makes it, in which they go 80 mm aside, with the box still between them."""
    base = LoadScenario(Path(__file__).resolve().parents[2] / "studies" / "robustness.yaml")
    scenario = task_scenario(base, draw_task(0, 110), "default")
    plan = MakePlan(scenario)
    assert plan.notes[0].startswith("only ")
    CheckOpenPalms(plan)
    with pytest.raises(TaskError, match=r"after the hands hold the box one comes 4\d mm too near .* timing.retreat_s"):
        CheckOpenPalms(MakePlan(scenario, heed_clearance=False))


class Near:
    """A checker to which everything is at one distance, m."""

    def __init__(self, distance):
        self._distance = distance

    def __call__(self, *_, **__):
        return self

    def min_clearance(self, *_):
        return self._distance, ("left_arm", "table")


def test_with_everything_trimmed_arms_may_come_near_to_a_table_but_not_touch_it(monkeypatch):
    monkeypatch.setattr(planning, "TRIMS", (1.0, 0.0))
    monkeypatch.setattr(planning, "SCALES", ())
    monkeypatch.setattr(planning, "ClearanceChecker", Near(0.004))
    assert planning.MakePlan(Scenario()).notes[0].startswith("only 0.0 s before the grasp")
    monkeypatch.setattr(planning, "ClearanceChecker", Near(-0.001))
    with pytest.raises(TaskError, match="clearance: left_arm and table come within -1 mm"):
        planning.MakePlan(Scenario())
