"""A box that is tipped on the way and put down turned: the plan, its parts, and what is refused."""

from dataclasses import replace

import numpy as np
import pytest

from drake_blfdmp.demonstration.modelled_person import hold_and_place
from drake_blfdmp.demonstration.timing import TaskMotion
from drake_blfdmp.diagrams.hold_and_place import MakeHoldAndPlace
from drake_blfdmp.errors import RecordingError, ScenarioError, TaskError
from drake_blfdmp.planning.plan import CheckYaw, MakePlan
from drake_blfdmp.planning.planned import TurnNotes
from drake_blfdmp.planning.scenario import ApplySetting, CheckScenario, Scenario
from drake_blfdmp.planning.scenario_sections import RetargetConfig, SyntheticConfig, TaskConfig
from drake_blfdmp.planning.sources import LoadSource, ReadRecordings
from drake_blfdmp.planning.task import MakeMotion, Turned
from drake_blfdmp.quaternions import from_rotation_vector
from drake_blfdmp.robot.retargeting import hand_line, retarget_motion, up_axis
from drake_blfdmp.robot.rigid import rigid
from drake_blfdmp.robot.swivel import swivel_angle
from drake_blfdmp.skeleton import ELBOWS, SHOULDERS, WRISTS
from drake_blfdmp.skill.geometry import link_lengths
from drake_blfdmp.skill.rollout import Rollout
from drake_blfdmp.skill.skill import Skill

YAW, PITCH = -0.3, 0.5


@pytest.fixture(scope="module")
def plan():
    """Tipped by 0.5 rad in the middle of the carry, put down turned by -0.3 rad."""
    return MakePlan(
        Scenario(
            synthetic=SyntheticConfig(box_pitch=PITCH),
            task=TaskConfig(place_rotation=[0.0, 0.0, YAW]),
            retarget=RetargetConfig(scale=1.0, world=[-0.05, 0.40, 0.784]),  # What a longer search finds.
        )
    )


def yaw_of(pose):
    return 2.0 * np.arctan2(pose[3], pose[0])


def tipped(poses):
    """How far boxes' up axes lean, rad."""
    return np.arccos(np.clip(up_axis(poses)[..., 2], -1.0, 1.0))


def test_the_box_is_put_down_turned_by_what_was_asked(plan, default_plan):
    # The same film but for the hands' orientations: the default plan tells how the person puts the box down.
    assert yaw_of(plan.start) == pytest.approx(yaw_of(default_plan.start), abs=0.01)
    assert yaw_of(plan.goal) - yaw_of(default_plan.goal) == pytest.approx(YAW, abs=0.01)
    box = plan.planned_box()
    np.testing.assert_allclose(box[-1], plan.goal, atol=2e-3)
    np.testing.assert_allclose(box[0], plan.start, atol=2e-3)


def test_it_stands_level_on_a_table_that_reaches_under_it(plan):
    for pose, table in ((plan.start, plan.tables[0]), (plan.goal, plan.tables[-1])):
        np.testing.assert_allclose(up_axis(pose), [0.0, 0.0, 1.0], atol=1e-12)
        corners = np.array([[a, b, -1.0] for a in (-1.0, 1.0) for b in (-1.0, 1.0)]) * 0.5 * plan.box.size
        corners = np.array([rigid(pose).multiply(corner) for corner in corners])
        assert np.all(np.abs(corners[:, :2] - table.top_center[:2]) <= 0.5 * np.array(table.size) + 1e-9)


def test_it_is_tipped_on_the_way_and_level_while_it_touches_a_table(plan):
    box, t, events = plan.planned_box(), plan.coupled.t, plan.task.skill.events
    lean = tipped(box)
    assert lean.max() == pytest.approx(PITCH, abs=0.12)  # The film's error, and what the smoothing takes.
    touches = (t <= events["grasp_end"]) | (t >= events["release"])
    assert lean[touches].max() < np.deg2rad(0.2)
    raised = box[:, 6] - plan.start[6]
    assert np.all(raised[lean > 0.1] > 0.03)
    assert plan.reach.sound


def test_the_palms_hold_it_as_one_rigid_thing(plan):
    t, held = plan.coupled.t, plan.task.held
    inside = np.flatnonzero((t >= held[0]) & (t <= held[1]))[::25]
    coupled = plan.coupled
    palms = retarget_motion(
        coupled.x[inside],
        coupled.velocity[inside],
        plan.retarget,
        turn=coupled.turn[inside],
        turn_rate=coupled.turn_rate[inside],
    )[0]
    for arm in range(2):
        seen = [
            (rigid(palm).inverse() @ rigid(box)).GetAsMatrix4()
            for palm, box in zip(palms[:, arm], plan.planned_box()[inside], strict=True)
        ]
        np.testing.assert_allclose([m[:3, :3] for m in seen], [seen[0][:3, :3]] * len(seen), atol=1e-9)
        # But for the hands' distance in its band the box stays where it is, too.
        np.testing.assert_allclose([m[:3, 3] for m in seen], [seen[0][:3, 3]] * len(seen), atol=5e-3)


def test_the_diagram_has_the_orientation_and_its_goal(plan):
    diagram, parts = MakeHoldAndPlace(plan)
    root = diagram.CreateDefaultContext()
    context = parts.orientation.GetMyContextFromRoot(root)
    np.testing.assert_allclose(parts.orientation.GetInputPort("goal_orientation").Eval(context)[0], 1.0, atol=1e-9)
    assert parts.orientation.GetInputPort("tempo").Eval(context)[0] == 1.0  # The skill's own clock.
    retargeting = parts.retargeting.GetMyContextFromRoot(root)
    for name in ("orientation", "angular_velocity"):
        np.testing.assert_array_equal(
            parts.retargeting.GetInputPort(name).Eval(retargeting), parts.orientation.GetOutputPort(name).Eval(context)
        )


def test_the_skill_keeps_its_orientation_in_its_file(plan, tmp_path, default_plan):
    skill = plan.task.skill
    skill.save(tmp_path / "a.json")
    back = Skill.load(tmp_path / "a.json")
    for name, value in vars(skill.orientation).items():
        np.testing.assert_array_equal(getattr(back.orientation, name), value)
    turned = back.with_goal_orientation(from_rotation_vector(np.array([0.2, 0.0, 0.0])))
    assert turned.orientation.goal[1] == pytest.approx(np.sin(0.1))
    assert default_plan.task.skill.orientation is None and default_plan.coupled.turn is None


def test_orientations_can_be_left_aside():
    scenario = Scenario(synthetic=SyntheticConfig(box_pitch=PITCH))
    source = LoadSource(scenario)
    assert MakeMotion(scenario, source).turn is not None
    assert MakeMotion(ApplySetting(scenario, "retarget.pitch=false"), source).turn is None


def test_the_person_walks_around_the_box():
    t, x = hold_and_place()
    motion = TaskMotion(t, x, t, {})
    turned = Turned(motion, 0.4, (3.0, 5.0))
    np.testing.assert_allclose(link_lengths(turned.x), link_lengths(x), atol=1e-12)
    np.testing.assert_allclose(turned.x[:, WRISTS].mean(axis=1), x[:, WRISTS].mean(axis=1), atol=1e-12)
    np.testing.assert_allclose(turned.x[t <= 3.0], x[t <= 3.0], atol=1e-12)
    line, before = (points[:, 5, :2] - points[:, 2, :2] for points in (turned.x, x))
    angle = np.arctan2(*line.T[::-1]) - np.arctan2(*before.T[::-1])
    np.testing.assert_allclose(angle[t >= 5.0], 0.4, atol=1e-12)
    swivels = [swivel_angle(*(points[:, arms] for arms in (SHOULDERS, ELBOWS, WRISTS))) for points in (turned.x, x)]
    np.testing.assert_allclose(swivels[0], swivels[1], atol=1e-9)


@pytest.mark.parametrize(
    ("rotation", "said"),
    [
        ([0.1, 0.0, 0.0], "neither rolls nor pitches"),
        ([0.0, -0.1, 0.2], "neither rolls nor pitches"),
        ([0.0, 0.0, 2.0], "yaw of 2 rad"),
        ([0.0, 0.0, float("nan")], "yaw of nan"),
        ([0.2], "must have 3 numbers"),
    ],
)
def test_what_no_level_table_bears_is_refused(rotation, said):
    with pytest.raises(ScenarioError, match=said):
        CheckScenario(replace(Scenario(), task=TaskConfig(place_rotation=rotation)))


def test_a_pitch_beyond_the_persons_is_refused_in_a_line():
    with pytest.raises(RecordingError, match="within 90 degrees"):
        ReadRecordings(ApplySetting(Scenario(), "synthetic.box_pitch=3"))


def test_a_turn_that_the_palms_do_not_take_is_refused():
    CheckYaw(0.3, 0.1, 0.39)
    with pytest.raises(TaskError, match=r"0\.60 rad was asked for.*0\.42 rad"):
        CheckYaw(0.6, 0.1, 0.52)


def test_what_was_taken_from_the_turn_is_said(plan):
    n = 4
    turn = from_rotation_vector(np.linspace(0.0, 1.5, n)[:, None] * [1.0, 0.0, 0.0])
    rollout = Rollout(np.arange(n), np.zeros((n, 6, 3)), np.zeros((n, 6, 3)), None, turn, np.zeros((n, 3)))
    motion = TaskMotion(np.arange(n), np.zeros((n, 6, 3)), np.arange(n), {}, levelled=np.deg2rad(7.0))
    level, limited = TurnNotes(motion, rollout, plan.retarget)
    assert "+7 degrees" in level
    assert "of 86 degrees" in limited
    still = replace(rollout, turn=None)
    assert TurnNotes(motion, still, plan.retarget) == []
    (aside,) = TurnNotes(replace(motion, disagreeing=0.5), still, plan.retarget)
    assert "by 29 degrees" in aside


def test_the_line_itself_turns_no_box_about_it(plan, default_plan):
    """The hands' line has the same yaw whether or not the box is tipped."""
    first = np.searchsorted(plan.coupled.t, plan.task.held[0])
    x = plan.coupled.x[[first]]
    assert hand_line(x, 0 * x, plan.retarget)[4][0] == pytest.approx(yaw_of(default_plan.start), abs=0.01)
