"""The diagram of a motion without a box: the same wires to the arms, and nothing of a box."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from waving import recorded, wave

from drake_blfdmp.diagrams.hold_and_place import MakeHoldAndPlace, SetInitialState
from drake_blfdmp.diagrams.non_finite import state_of
from drake_blfdmp.planning.free_plan import MakeFreePlan
from drake_blfdmp.planning.scenario import RetargetConfig, Scenario, TaskConfig
from drake_blfdmp.planning.scenario_sections import FeedbackConfig
from drake_blfdmp.planning.sources import MakeSource


@pytest.fixture(scope="module")
def made():
    scenario = Scenario(task=TaskConfig(kind="motion"), retarget=RetargetConfig(world=[0.0, 0.3, 1.0], scale=0.8))
    plan = MakeFreePlan(scenario, MakeSource(scenario, [recorded(*wave())]))
    return MakeHoldAndPlace(plan)


def test_there_is_no_box_and_nobody_listens_to_its_forces(made):
    diagram, parts = made
    assert parts.box is None and parts.palm_forces is None
    assert not diagram.HasSubsystemNamed("palm_forces")
    assert not parts.plant.HasBodyNamed("box")
    assert parts.plant.num_positions() == 14


def test_the_arms_are_driven_as_ever(made):
    diagram, _ = made
    wires = {(source[0].get_name(), target[0].get_name()) for target, source in diagram.connection_map().items()}
    assert {("transformation", "retargeting"), ("retargeting", "ik"), ("ik", "plant"), ("bands", "coupler")} <= wires
    assert diagram.num_input_ports() == 0


def test_without_feedback_the_simulated_skill_is_the_planned_rollout_and_the_palms_follow_it(made):
    plan = made[1].plan
    scenario = replace(plan.scenario, feedback=FeedbackConfig(hands=False))
    diagram, parts = MakeHoldAndPlace(replace(plan, scenario=scenario))
    context = diagram.CreateDefaultContext()
    SetInitialState(parts, diagram, context)
    end = parts.plan.settle_s + 1.2
    Simulator(diagram, context).AdvanceTo(end)
    x = parts.skill.transformation.GetOutputPort("position").Eval(
        parts.skill.transformation.GetMyContextFromRoot(context)
    )
    k = round(end / parts.plan.scenario.simulation.skill_time_step)
    np.testing.assert_allclose(x.reshape(6, 3), parts.plan.coupled.x[k], atol=1e-6)
    poses = parts.retargeting.GetOutputPort("palm_poses").Eval(parts.retargeting.GetMyContextFromRoot(context))
    plant_context = parts.plant.GetMyContextFromRoot(context)
    for arm, wanted in zip(parts.arms, poses.reshape(2, 7)[:, 4:], strict=True):
        palm = parts.plant.GetFrameByName("palm", arm).CalcPoseInWorld(plant_context).translation()
        assert np.linalg.norm(palm - wanted) < 2e-3


def test_the_bands_move_with_the_hands_in_the_diagram(made):
    diagram, parts = made
    context = diagram.CreateDefaultContext()
    SetInitialState(parts, diagram, context)
    Simulator(diagram, context).AdvanceTo(2.0)
    bands = parts.skill.bands.GetOutputPort("bands").Eval(parts.skill.bands.GetMyContextFromRoot(context))
    np.testing.assert_allclose(bands.reshape(6, 5), parts.plan.task.bands.evaluate(np.array(2.0)), atol=1e-6)


def test_a_run_saved_in_motion_and_restored_has_the_same_future(made):
    diagram, parts = made
    simulator = Simulator(diagram)
    SetInitialState(parts, diagram, simulator.get_mutable_context())
    saved_at = parts.plan.settle_s + 0.3
    simulator.AdvanceTo(saved_at)
    again = Simulator(diagram, simulator.get_context().Clone())
    for each in (simulator, again):
        each.AdvanceTo(saved_at + 0.1)
    np.testing.assert_array_equal(state_of(simulator.get_context()), state_of(again.get_context()))
