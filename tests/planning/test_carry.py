"""A carry whose highest point is its end: on to a shelf in front, which is to be cleared before it is over it."""

import numpy as np

from drake_blfdmp.demonstration.timing import Timing
from drake_blfdmp.planning.box_path import lacking_room
from drake_blfdmp.planning.plan import MakePlan
from drake_blfdmp.planning.scenario import Scenario, TaskConfig
from drake_blfdmp.planning.scenario_sections import SyntheticConfig


def test_a_box_that_rises_to_its_shelf_is_led_over_it_though_no_part_of_its_way_is_higher():
    task = TaskConfig(take_offset=[-0.087, -0.128, 0.05], place_offset=[-0.108, -0.063, -0.085])
    person = SyntheticConfig(box_width=0.2375, sensor="azure_kinect")
    plan = MakePlan(Scenario(seed=1826168224, synthetic=person, timing=Timing(speed=0.926), task=task))
    assert len(plan.tables) == 2 and plan.goal[6] - plan.start[6] > 0.15
    assert any("straight up, over" in note for note in plan.notes)
    grasped, released = plan.task.held
    held = (plan.coupled.t >= grasped) & (plan.coupled.t <= released)
    way = plan.planned_box()[held]
    assert lacking_room(way, plan.box, plan.tables, [plan.start, plan.goal]).max() <= 0.0
    middle = 0.5 * (plan.coupled.velocity[held, 2] + plan.coupled.velocity[held, 5])
    assert np.linalg.norm(middle, axis=1).max() < 0.8  # It is led there, not thrown.
    assert plan.reach.sound
