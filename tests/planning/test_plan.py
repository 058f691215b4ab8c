"""The plan: everything in it fits together, and each setting moves just what it names."""

from dataclasses import replace

import numpy as np
import pytest

from drake_blfdmp.errors import TaskError
from drake_blfdmp.planning import plan as plan_module
from drake_blfdmp.planning.moved_carry import ShiftWindow
from drake_blfdmp.planning.plan import MakePlan
from drake_blfdmp.planning.planned import BelowPalms
from drake_blfdmp.planning.scenario import BoxConfig, Scenario, TaskConfig
from drake_blfdmp.planning.squeeze import USUAL_FORCE
from drake_blfdmp.robot.clearance import ClearanceChecker
from drake_blfdmp.robot.kinematics import DualArmKinematics
from drake_blfdmp.robot.retargeting import box_pose, retarget_motion, up_axis
from drake_blfdmp.robot.rigid import rigid


@pytest.fixture(scope="module")
def moved_plan():
    """The default with the box put down elsewhere and a given duration."""
    return MakePlan(Scenario(task=TaskConfig(place_offset=[0.05, 0.04, 0.0], duration_scale=1.6)))


def outline(plan, pose):
    """The lower corners of the box at a pose, in W: (4, 3)."""
    half = 0.5 * plan.box.size
    corners = np.array([[a, b, -1.0] for a in (-1.0, 1.0) for b in (-1.0, 1.0)]) * half
    return np.array([rigid(pose).multiply(corner) for corner in corners])


def test_the_box_stands_on_a_table_at_both_ends(default_plan):
    plan = default_plan
    for pose, table in ((plan.start, plan.tables[0]), (plan.goal, plan.tables[-1])):
        corners = outline(plan, pose)
        np.testing.assert_allclose(corners[:, 2], table.top_center[2], atol=1e-9)
        half = 0.5 * np.array(table.size)
        assert np.all(np.abs(corners[:, :2] - table.top_center[:2]) <= half + 1e-9)
        np.testing.assert_allclose(up_axis(pose), [0.0, 0.0, 1.0], atol=1e-12)


def test_the_first_posture_reaches_the_first_palm_poses(default_plan):
    plan = default_plan
    # The arms join in after the rest in which the skill's initial errors vanish.
    first = np.searchsorted(plan.coupled.t, plan.settle_s)
    palms = retarget_motion(plan.coupled.x[first], plan.coupled.velocity[first], plan.retarget)[0]
    for state, palm in zip(DualArmKinematics().evaluate(plan.reach.start), palms, strict=True):
        wanted = rigid(palm)
        np.testing.assert_allclose(state.position, wanted.translation(), atol=2e-3)
        np.testing.assert_allclose(state.rotation, wanted.rotation().matrix(), atol=5e-3)
    assert plan.reach.sound


def test_nothing_touches_before_the_grasp(default_plan):
    plan = default_plan
    clearance, _ = ClearanceChecker(plan.tables, plan.box).min_clearance(plan.reach.start, rigid(plan.start))
    assert clearance > 0.01


def test_the_planned_box_waits_is_carried_between_the_palms_and_stays(default_plan):
    plan = default_plan
    planned, t = plan.planned_box(), plan.coupled.t
    grasped, released = plan.task.held
    assert planned.shape == (len(t), 7)
    np.testing.assert_allclose(np.linalg.norm(planned[:, :4], axis=1), 1.0, atol=1e-9)
    np.testing.assert_allclose(planned[t <= grasped], planned[:1].repeat(np.sum(t <= grasped), 0), atol=2e-4)
    np.testing.assert_allclose(planned[t >= released], planned[-1:].repeat(np.sum(t >= released), 0), atol=2e-4)
    np.testing.assert_allclose(planned[0, 4:], plan.start[4:], atol=1e-3)
    np.testing.assert_allclose(planned[-1, 4:], plan.goal[4:], atol=1e-3)
    k = len(t) // 2
    between = box_pose(plan.coupled.x[k], plan.retarget)
    np.testing.assert_allclose(planned[k, 4:], between[4:] - [0.0, 0.0, plan.scenario.task.grasp_above], atol=1e-9)
    assert planned[:, 6].max() - planned[0, 6] > 0.15


def test_the_box_hangs_along_its_own_axis():
    half = np.sqrt(0.5)
    tipped = np.array([[half, half, 0.0, 0.0, 1.0, 2.0, 3.0]])  # Its z axis points along -y.
    np.testing.assert_allclose(BelowPalms(tipped, 0.1)[0, 4:], [1.0, 2.1, 3.0], atol=1e-12)


def test_the_default_is_not_changed_by_planning_and_says_what_it_adapted(default_plan, default_scenario):
    assert default_scenario == Scenario()
    assert default_plan.scenario == Scenario()
    assert default_plan.stretch >= 1.0
    slowed = [note for note in default_plan.notes if note.startswith("slowed down")]
    assert bool(slowed) == (default_plan.stretch > 1.005)
    assert all(note and "\n" not in note for note in default_plan.notes)


def test_the_duration_is_the_skills_and_the_tail(default_plan):
    assert default_plan.duration_s == pytest.approx(default_plan.task.skill.tau + Scenario().task.tail, abs=0.01)
    assert default_plan.task.skill.tau == pytest.approx(default_plan.stretch * default_plan.task.motion.t[-1])


def test_place_offset_moves_the_goal_by_exactly_that(default_plan, moved_plan):
    np.testing.assert_allclose(moved_plan.goal[4:] - default_plan.goal[4:], [0.05, 0.04, 0.0], atol=2e-3)
    np.testing.assert_allclose(moved_plan.start[4:], default_plan.start[4:], atol=2e-3)
    for pose, table in ((moved_plan.start, moved_plan.tables[0]), (moved_plan.goal, moved_plan.tables[-1])):
        np.testing.assert_allclose(outline(moved_plan, pose)[:, 2], table.top_center[2], atol=1e-9)


def test_the_scenario_of_a_plan_is_the_one_given(moved_plan):
    assert moved_plan.scenario.task.place_offset == [0.05, 0.04, 0.0]


def test_a_given_duration_is_kept(moved_plan):
    assert moved_plan.stretch == 1.6
    assert moved_plan.task.skill.tau == pytest.approx(1.6 * moved_plan.task.motion.t[-1])


def test_a_box_wider_than_the_arms_reach_is_refused_in_one_line():
    with pytest.raises(TaskError, match=r"cannot take a box 1\.50 m wide|1\.476|wide") as caught:
        MakePlan(replace(Scenario(), box=BoxConfig(width=1.5)))
    assert "\n" not in str(caught.value) and caught.value.reason == "reach"


def test_a_box_thinner_than_the_squeeze_is_refused_in_one_line():
    with pytest.raises(TaskError, match=r"box: 0\.040 m is too narrow to be squeezed by 0\.012 m"):
        MakePlan(replace(Scenario(), box=BoxConfig(width=0.04)))


def test_progress_names_each_stage_and_ends_at_one():
    seen = []
    with pytest.raises(TaskError):
        MakePlan(replace(Scenario(), box=BoxConfig(width=0.04)), lambda what, share: seen.append((what, share)))
    assert [what for what, _ in seen] == ["filming the modelled person (synthetic)", "cleaning"]


def test_the_plan_says_what_it_presses_with(default_plan):
    assert default_plan.squeeze_force == pytest.approx(USUAL_FORCE)
    closed = default_plan.task.bands.hands.closed_m
    depth = 0.5 * (default_plan.box.width - closed)
    assert 2.0 * depth / default_plan.squeeze_compliance == pytest.approx(USUAL_FORCE, rel=1e-6)


def test_a_box_that_no_allowed_force_holds_is_refused_before_anything_is_searched():
    seen = []
    with pytest.raises(TaskError, match=r"^force: a box of 12 kg .* needs 16\d N of each palm at rest") as caught:
        MakePlan(replace(Scenario(), box=BoxConfig(mass=12.0, friction=0.3)), lambda what, share: seen.append(what))
    assert caught.value.reason == "force" and "finding a reachable place" not in seen


def test_a_box_that_nothing_holds_is_planned_with_what_is_asked_where_force_is_not_heeded():
    base = Scenario()
    scenario = replace(base, box=BoxConfig(mass=12.0, friction=0.3), task=replace(base.task, squeeze_force=150.0))
    plan = MakePlan(scenario, heed_force=False)
    assert plan.squeeze_force == pytest.approx(150.0) and plan.box is not None and plan.box.mass == 12.0
    assert not any("squeezed" in note for note in plan.notes)


@pytest.mark.parametrize(
    ("reasons", "told", "farther"),
    [
        (("reach", "clearance", "reach"), "clearance", True),
        (("clearance", "reach", "reach"), "clearance", True),
        (("force", "reach", "clearance"), "force", False),  # Other places do not make the arms stronger.
    ],
)
def test_of_all_that_failed_what_got_farthest_is_told_once_all_searches_were_tried(monkeypatch, reasons, told, farther):
    tried = []

    def fail(scenario, source, kinematics, limits, progress, *, wide=False, led=False, **options):
        reason = "reach" if wide or led else reasons[len(tried)]
        tried.append("led" if led else "wide" if wide else "near")
        raise TaskError(f"{reason}: not with {scenario.timing.approach_s:g} s", reason=reason)

    monkeypatch.setattr(plan_module, "MakeUnmoved", fail)
    with pytest.raises(TaskError) as caught:
        MakePlan(Scenario())
    assert caught.value.reason == told and tried == ["near"] * 3 + ["wide", "led"] * farther


def test_a_release_is_shifted_while_the_box_is_above_both_ends_or_if_it_never_is_during_the_whole_carry(default_plan):
    task, rollout = default_plan.task, default_plan.coupled
    events, (grasped, released) = task.skill.events, task.held
    share = np.clip((rollout.t - grasped) / (released - grasped), 0.0, 1.0)

    def window(height):
        x = rollout.x.copy()
        x[:, [2, 5], 2] = height[:, None]
        return ShiftWindow(replace(rollout, x=x), task, False)

    start, end = window(0.2 * share + 0.3 * np.sin(np.pi * share))
    assert events["grasp_end"] < start < end < events["release"]
    for straight in (share, -share):  # Straight up on to a shelf, or straight down from one.
        assert window(straight) == (events["grasp_end"], events["release"])
    # A highest point next to the end, as a rollout's last millimetres make one, leaves no time to move the box in.
    late = window(share + 0.1 * np.exp(-(((share - 0.97) / 0.02) ** 2)))
    assert late == (events["grasp_end"], events["release"])


def test_take_offset_moves_the_start_by_exactly_that_and_the_goal_only_in_height(default_plan):
    """Both ends of the default share one table, whose height follows the grasp."""
    plan = MakePlan(Scenario(task=TaskConfig(take_offset=[-0.06, 0.05, 0.04])))
    np.testing.assert_allclose(plan.start[4:] - default_plan.start[4:], [-0.06, 0.05, 0.04], atol=2e-3)
    np.testing.assert_allclose(plan.goal[4:] - default_plan.goal[4:], [0.0, 0.0, 0.04], atol=2e-3)
    for pose, table in ((plan.start, plan.tables[0]), (plan.goal, plan.tables[-1])):
        corners = outline(plan, pose)
        np.testing.assert_allclose(corners[:, 2], table.top_center[2], atol=1e-9)
        assert np.all(np.abs(corners[:, :2] - table.top_center[:2]) <= 0.5 * np.array(table.size) + 1e-9)
    assert plan.reach.sound
    assert plan.scenario.task.take_offset == [-0.06, 0.05, 0.04]
    np.testing.assert_allclose(
        plan.task.skill.start - default_plan.task.skill.start, np.tile([-0.06, 0.05, 0.04], (6, 1)), atol=2e-3
    )


def test_both_offsets_together_move_both_ends(default_plan):
    plan = MakePlan(Scenario(task=TaskConfig(take_offset=[0.05, -0.03, 0.0], place_offset=[0.05, 0.04, 0.0])))
    np.testing.assert_allclose(plan.start[4:] - default_plan.start[4:], [0.05, -0.03, 0.0], atol=2e-3)
    np.testing.assert_allclose(plan.goal[4:] - default_plan.goal[4:], [0.05, 0.04, 0.0], atol=2e-3)
