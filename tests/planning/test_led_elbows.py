"""A task that brings the arms into each other's way is carried out with elbows that are led around each other."""

from dataclasses import replace

import numpy as np
import pytest

from drake_blfdmp.demonstration.timing import Timing
from drake_blfdmp.errors import TaskError
from drake_blfdmp.planning.carried_box import CarriedBox
from drake_blfdmp.planning.carry import Carry
from drake_blfdmp.planning.led_elbows import ROOM, SceneOf, TeachElbows
from drake_blfdmp.planning.plan import MakePlan
from drake_blfdmp.planning.planned import IndexAt
from drake_blfdmp.planning.scenario import Scenario, TaskConfig
from drake_blfdmp.planning.scenario_sections import SyntheticConfig
from drake_blfdmp.planning.searches import LED, NEAR, SEARCHES, WIDE, MayBe
from drake_blfdmp.robot.clearance import ClearanceChecker
from drake_blfdmp.robot.kinematics import DualArmKinematics
from drake_blfdmp.robot.plant import ARMS, MakeKinematicPlant, ReadJointLimits
from drake_blfdmp.robot.rigid import rigid
from drake_blfdmp.robot.swings import Swings
from drake_blfdmp.robot.swivel import swivel_angle, wrap
from drake_blfdmp.skeleton import ELBOWS, SHOULDERS, WRISTS
from drake_blfdmp.skill.geometry import link_lengths

PLANT = MakeKinematicPlant()
LIMITS = ReadJointLimits(PLANT, [PLANT.GetModelInstanceByName(arm) for arm in ARMS])
KINEMATICS = DualArmKinematics(PLANT)


@pytest.fixture(scope="module")
def plan():
    """A narrow box that is taken half a metre to the right and in front, and put down beside the pedestals."""
    task = TaskConfig(take_offset=[0.5416, 0.5685, 0.2743], place_offset=[0.4477, 0.0377, -0.2971])
    scenario = Scenario(
        seed=991439281,
        synthetic=SyntheticConfig(box_width=0.2029, sensor="steady"),
        timing=Timing(speed=0.871),
        task=task,
    )
    return MakePlan(replace(scenario, retarget=replace(scenario.retarget, scale=0.6)))


def test_the_plan_says_so_and_is_sound(plan):
    assert plan.reach.swings is not None and plan.reach.sound
    [note] = [note for note in plan.notes if note.startswith("elbows led")]
    assert "with the person's the arms do not get along" in note
    assert not any("thrown about" in note or "swing limited" in note for note in plan.notes)


def test_the_skill_has_learned_the_elbows_ways_with_bones_of_their_lengths(plan):
    t, x, swings = plan.coupled.t / plan.stretch, plan.coupled.x, plan.reach.swings
    moving = plan.coupled.t >= plan.settle_s
    angle = swivel_angle(*(x[:, arms] for arms in (SHOULDERS, ELBOWS, WRISTS)))
    wanted = np.stack([np.interp(t, swings.t, one) for one in swings.angle.T], axis=-1)
    assert np.abs(wrap(angle - wanted))[moving].max() < 0.15
    bands = plan.task.bands.evaluate(plan.coupled.t)
    lengths = link_lengths(x)
    assert np.all(lengths > bands[:, 0]) and np.all(lengths < bands[:, 1])


def test_the_arms_keep_clear_of_each_other_of_the_tables_and_of_the_box(plan):
    checker = ClearanceChecker(plan.tables, plan.box, max_distance=0.05)
    box = plan.planned_box()
    samples = np.minimum((plan.reach.samples * plan.stretch).astype(int), len(box) - 1)
    pairs = zip(plan.reach.following.q, samples, strict=True)
    assert min(checker.min_clearance(q, rigid(box[k]))[0] for q, k in pairs) > 0.0


class Planner:
    """Knows of the box alone."""

    def __init__(self, plan):
        self.plan = plan

    def in_palms(self, retarget):
        return CarriedBox(self.plan.box, retarget, self.plan.scenario.task.grasp_above, True)

    def taught(self, carry, motion):
        """A learner that does not see how the elbows are led."""
        return carry


def test_the_scene_is_the_plans(plan):
    carry = Carry(plan.task.motion, plan.task, plan.coupled, plan.reach)
    made = SceneOf(Planner(plan), carry, plan.settle_s)(plan.retarget, np.array([0, 2000, 10**6]))
    first = IndexAt(plan.coupled, plan.settle_s)
    for k, at in enumerate((first, first + 2000, -1)):
        np.testing.assert_allclose(made._poses[k], plan.planned_box()[at], atol=1e-9)
    expected = ClearanceChecker(plan.tables, plan.box, max_distance=2.0 * ROOM, among_arms=False)
    for q in plan.reach.following.q[::40]:
        for pose in made._poses:
            told = made._checker.link_clearances(q, rigid(pose))
            np.testing.assert_allclose(told, expected.link_clearances(q, rigid(pose)), atol=1e-6)


def test_elbows_that_are_not_learned_are_refused_in_one_line(plan):
    other_way = Swings(plan.reach.swings.t, -plan.reach.swings.angle)
    x = other_way.of(plan.coupled.t / plan.stretch, plan.coupled.x)
    carry = Carry(plan.task.motion, plan.task, replace(plan.coupled, x=x), plan.reach)
    with pytest.raises(TaskError, match="elbows led around each other") as error:
        TeachElbows(Planner(plan), carry, plan.settle_s, KINEMATICS, LIMITS)
    assert error.value.reason == "reach" and "\n" not in str(error.value)


def test_a_carry_without_led_elbows_is_left_alone():
    carry = Carry(None, None, None, type("Reach", (), {"swings": None}))
    assert TeachElbows(None, carry, 0.5, None, None) is carry


def test_searches_are_left_the_freedom_they_need():
    scenario = Scenario()
    assert list(SEARCHES) == [NEAR, WIDE, LED]
    assert all(MayBe(search, scenario) for search in SEARCHES)
    there = replace(scenario, retarget=replace(scenario.retarget, world=[0.0, 0.4, 1.0]))
    assert [MayBe(search, there) for search in SEARCHES] == [True, False, True]
    hanging = replace(scenario, retarget=replace(scenario.retarget, elbow_up=False))
    turned = replace(scenario, task=replace(scenario.task, place_rotation=[0.0, 0.0, 0.3]))
    for one in (hanging, turned):
        assert [MayBe(search, one) for search in SEARCHES] == [True, True, False]
