"""How high a box is carried: lifted as far as asked, and never led below the table it is over."""

import numpy as np
import pytest

from drake_blfdmp.demonstration.timing import TaskMotion
from drake_blfdmp.evaluation.robustness.tasks import draw_task, task_scenario
from drake_blfdmp.evaluation.summary import planned_lift
from drake_blfdmp.planning.box_path import ROOM
from drake_blfdmp.planning.carry_height import BLEND, NOTED, KeptUp, RaisedToLift, height_lacking
from drake_blfdmp.planning.plan import MakePlan
from drake_blfdmp.planning.scenario import RetargetConfig, Scenario, TaskConfig
from drake_blfdmp.skill.profiles import smooth_step

T = np.arange(801) / 100.0
EVENTS = {"grasp": 1.0, "grasp_end": 2.0, "release": 6.0, "release_end": 7.0}


def way(lift, drop=0.0, dip=0.0):
    """Of the hands' middle (N, 3): up by `lift`, 0.3 m to the side, down to `drop` below the start.

    In the last 1.6 s, the last 6 mm of the way, it dips by `dip` and comes back.
    """
    u = (T - 2.0) / 4.0
    z = lift * smooth_step(3.0 * u)[0] - (lift + drop) * smooth_step(3.0 * (u - 0.35))[0]
    z = z - dip * smooth_step((T - 4.4) / 0.4)[0] * smooth_step((6.0 - T) / 0.8)[0]
    x = 0.294 * smooth_step((T - 2.0) / 2.4)[0] + 0.006 * smooth_step((T - 4.4) / 1.6)[0]
    return np.stack([x, np.zeros(len(T)), 0.4 + z], axis=-1)


def motion(middle):
    """All six points at the middle but the hands, 0.3 m apart."""
    x = np.repeat(middle[:, None], 6, axis=1)
    x[:, [2, 5], 0] += [-0.15, 0.15]
    return TaskMotion(t=T, x=x, recorded=T, events=EVENTS)


def held_middle(moved):
    inside = (T >= 2.0) & (T <= 6.0)
    return 0.5 * (moved.x[:, 2] + moved.x[:, 5])[inside]


@pytest.mark.parametrize("drop", [0.0, 0.25, -0.05])
def test_a_carry_that_rises_too_little_is_raised_to_just_the_least_lift(drop):
    before = motion(way(0.06, drop))
    raised, height = RaisedToLift(before, 0.12)
    z = held_middle(raised)[:, 2]
    assert z.max() - z[0] == pytest.approx(0.12, abs=1e-3)
    assert 0.0 < height < 0.15
    np.testing.assert_allclose(z[[0, -1]], held_middle(before)[[0, -1], 2], atol=1e-12)
    moved = raised.x - before.x
    np.testing.assert_allclose(moved, np.broadcast_to(moved[:, :1], moved.shape), atol=1e-12)


@pytest.mark.parametrize("least", [0.0, 0.12, 0.19])
def test_a_carry_that_rises_enough_is_left_as_it_is(least):
    before = motion(way(0.2))
    assert RaisedToLift(before, least) == (before, 0.0)


@pytest.mark.parametrize("drop", [0.0, 0.2, -0.05])
def test_a_dip_before_the_release_is_taken_out_and_the_ends_stay(drop):
    held = (T >= 2.0) & (T <= 6.0)
    middle = way(0.25, drop, dip=0.0115)[held]
    assert (middle[:, 2] - middle[-1, 2]).min() < -0.01
    lacking = height_lacking(middle)
    np.testing.assert_allclose(lacking[[0, -1]], 0.0, atol=1e-9)
    kept = middle[:, 2] + lacking
    late = np.arange(len(kept)) > np.argmax(middle[:, 2])
    assert (kept[late] - kept[-1]).min() > -0.16 * BLEND
    assert lacking.max() < 0.0115 + ROOM
    # Well above both tables nothing changes but what the blend rounds.
    high = middle[:, 2] > max(middle[0, 2], middle[-1, 2]) + ROOM + BLEND
    assert high.sum() > 50
    np.testing.assert_allclose(lacking[high], 0.0, atol=0.16 * BLEND + 1e-9)


def test_a_way_without_a_highest_point_clear_of_both_ends_is_left_alone():
    held = (T >= 2.0) & (T <= 6.0)
    np.testing.assert_array_equal(height_lacking(way(0.02, dip=0.01)[held]), 0.0)


def test_a_motion_is_kept_up_at_its_scale_and_only_where_that_is_worth_a_note():
    held = (T >= 2.0) & (T <= 6.0)
    before = motion(way(0.25, dip=0.0115))
    kept, raised = KeptUp(before, T[held], 0.5 * held_middle(before), 0.5)
    np.testing.assert_allclose(raised, height_lacking(0.5 * held_middle(before)).max())
    assert (kept.x - before.x)[..., 2].max() == pytest.approx(2.0 * raised)
    assert raised > NOTED
    clean = motion(way(0.25))
    steady, none = KeptUp(clean, T[held], held_middle(clean), 1.0)
    assert steady is clean and none == 0.0


def test_the_plan_lifts_as_far_as_asked_and_says_so(default_plan):
    scenario = Scenario(task=TaskConfig(least_lift=0.34))
    plan = MakePlan(scenario)
    assert planned_lift(default_plan) < 0.3
    assert planned_lift(plan) == pytest.approx(0.34, abs=0.005)
    assert sum("task.least_lift" in note for note in plan.notes) == 1
    assert not any("task.least_lift" in note for note in default_plan.notes)
    assert plan.reach.sound


def test_offsets_hold_with_a_given_place_of_the_person(default_plan):
    """The person's mean moves with the motion; it must not be mapped back to the given place."""
    where = RetargetConfig(
        world=[float(v) for v in default_plan.retarget.world], scale=float(default_plan.retarget.scale)
    )
    still = MakePlan(Scenario(retarget=where))
    moved = MakePlan(
        Scenario(retarget=where, task=TaskConfig(take_offset=[0.06, 0.02, 0.03], place_offset=[-0.05, 0.03, 0.0]))
    )
    assert still.start is not None and still.goal is not None
    assert moved.start is not None and moved.goal is not None
    np.testing.assert_allclose(moved.start[4:] - still.start[4:], [0.06, 0.02, 0.03], atol=2e-3)
    np.testing.assert_allclose(moved.goal[4:] - still.goal[4:], [-0.05, 0.03, 0.03], atol=2e-3)


def test_a_way_out_of_reach_is_tried_with_calmer_hands_and_smaller_before_it_is_refused():
    """A wide box, noisy and moved far: two tables, and no place at the scale that suits the person's own motion."""
    scenario = task_scenario(Scenario(), draw_task(0, 10), "default")
    plan = MakePlan(scenario)
    assert plan.reach.sound
    assert plan.retarget.scale < 1.0 and plan.retarget.yaw[1] < np.deg2rad(10.0)
    assert plan.start is not None and plan.goal is not None and len(plan.tables) == 2
    # As far apart as the tables need, no farther: the asked offsets count in that.
    near, far = sorted((plan.tables[0], plan.tables[1]), key=lambda table: table.top_center[1])
    gap = far.top_center[1] - 0.5 * far.size[1] - near.top_center[1] - 0.5 * near.size[1]
    assert 0.0 < gap < 0.06
