"""How far a plan's goal may be moved while it is carried out, and when."""

from dataclasses import replace

import numpy as np
import pytest
from waving import recorded, wave

from drake_blfdmp.planning import goal_range
from drake_blfdmp.planning.free_plan import MakeFreePlan
from drake_blfdmp.planning.goal_range import FARTHEST, GOAL_STEP, ON_TABLE, GoalRange, GoalWindow
from drake_blfdmp.planning.scenario import RetargetConfig, Scenario, TaskConfig
from drake_blfdmp.planning.sources import MakeSource
from drake_blfdmp.robot.box import TableParameters


@pytest.fixture(scope="module")
def ranges(default_plan):
    return GoalRange(default_plan)


def test_there_is_room_and_the_box_stays_on_its_table(default_plan, ranges):
    (table,) = default_plan.tables
    assert ranges.shape == (2, 2)
    assert (ranges[:, 0] < 0).all() and (ranges[:, 1] > 0).all() and np.abs(ranges).max() <= FARTHEST
    np.testing.assert_allclose(ranges / GOAL_STEP, np.round(ranges / GOAL_STEP), atol=1e-9)
    ends = default_plan.goal[4:6, None] + ranges
    edge = np.array(table.top_center[:2])[:, None] + 0.5 * np.array(table.size)[:, None] * [-1.0, 1.0]
    assert (ends[:, 0] >= edge[:, 0] + ON_TABLE - 1e-9).all() and (ends[:, 1] <= edge[:, 1] - ON_TABLE + 1e-9).all()


def test_a_smaller_table_leaves_less(default_plan, ranges):
    (table,) = default_plan.tables
    goal = default_plan.goal
    small = replace(table, top_center=(*map(float, goal[4:6]), table.top_center[2]), size=(0.12, 0.11))
    np.testing.assert_allclose(GoalRange(replace(default_plan, tables=[small])), [[-0.02, 0.02], [-0.015, 0.015]])


def test_another_table_in_the_boxs_way_down_is_kept_clear_of(default_plan, ranges):
    goal, box = default_plan.goal, default_plan.box
    edge = float(goal[5]) + 0.5 * np.hypot(box.depth, box.width) - 0.02  # Where the turned box nearly ends.
    wall = TableParameters("wall", (float(goal[4]), edge + 0.08, float(goal[6])), (0.6, 0.12))
    narrowed = GoalRange(replace(default_plan, tables=[wall, *default_plan.tables]))
    assert narrowed[1, 1] < ranges[1, 1]


def test_what_the_arms_do_not_reach_is_left_out(default_plan, ranges):
    (table,) = default_plan.tables
    large = replace(table, size=(0.6, 1.6))
    wide = GoalRange(replace(default_plan, tables=[large]))
    assert wide[1, 1] < FARTHEST  # Forward is the end of the arms, and no table's.


def test_it_moves_only_while_the_box_is_up_and_has_time_to_settle(default_plan):
    opens, closes = GoalWindow(default_plan)
    events, skill = default_plan.task.skill.events, default_plan.task.skill
    assert events["grasp_end"] < opens < closes < events["release"]
    height = default_plan.planned_box()[:, 6] - max(default_plan.start[6], default_plan.goal[6])
    inside = (default_plan.coupled.t >= opens) & (default_plan.coupled.t <= closes)
    assert height[inside].min() > goal_range.ABOVE
    touches = default_plan.coupled.t[np.flatnonzero(height > goal_range.ABOVE)[-1]]
    rate = 0.5 * skill.alpha_z / skill.tau  # Critically damped: what is left of a lag of 1.
    assert (1.0 + rate * (touches - closes)) * np.exp(-rate * (touches - closes)) < 0.05


def test_a_carry_that_hardly_rises_leaves_no_time(default_plan, monkeypatch):
    monkeypatch.setattr(goal_range, "ABOVE", 0.5)
    assert GoalWindow(default_plan) is None


def test_without_a_box_all_three_axes_move_from_when_the_arms_join_in():
    scenario = Scenario(task=TaskConfig(kind="motion"), retarget=RetargetConfig(world=[0.0, 0.3, 1.0], scale=0.8))
    plan = MakeFreePlan(scenario, MakeSource(scenario, [recorded(*wave())]))
    np.testing.assert_array_equal(GoalRange(plan), FARTHEST * np.array([[-1.0, 1.0]] * 3))
    assert GoalWindow(plan) == (plan.settle_s, plan.task.skill.tau)
