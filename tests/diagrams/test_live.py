"""What the live view adds to a run's diagram: nothing until it is used, and then what docs/live.md says."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from drake_blfdmp.diagrams.hold_and_place import AddHoldAndPlace
from drake_blfdmp.diagrams.live import AddLive
from drake_blfdmp.diagrams.skill import AddSkill
from drake_blfdmp.planning import goal_range
from drake_blfdmp.planning.scenario_sections import RealityConfig
from drake_blfdmp.planning.task import LawGains
from drake_blfdmp.skill.geometry import link_lengths
from drake_blfdmp.systems.live_goal import LiveGoal

STEP = 0.004


def made(plan):
    builder = DiagramBuilder()
    parts = AddHoldAndPlace(builder, plan)
    live = AddLive(builder, parts)
    diagram = builder.Build()
    return diagram, parts, live, diagram.CreateDefaultContext()


def forces(parts, context):
    port = parts.plant.get_applied_spatial_force_input_port()
    return [
        (force.body_index, tuple(force.F_Bq_W.translational()))
        for force in port.Eval(parts.plant.GetMyContextFromRoot(context))
    ]


def test_until_it_is_used_the_goal_is_the_plans_and_nothing_pushes(default_plan):
    _, parts, live, context = made(default_plan)
    wanting = parts.skill.transformation
    goal = wanting.GetInputPort("goal").Eval(wanting.GetMyContextFromRoot(context))
    assert goal.tobytes() == default_plan.task.skill.goal.tobytes()
    assert forces(parts, context) == [] and not live.GoalOffset(context).any()


def test_a_push_acts_beside_the_scenarios_own(default_plan):
    reality = RealityConfig(push_arm="right", push_force=[0.0, 0.0, -40.0], push_at=3.0)
    plan = replace(default_plan, scenario=replace(default_plan.scenario, reality=reality))
    _, parts, live, context = made(plan)
    palm = parts.plant.GetBodyByName("palm", parts.arms[1]).index(), (0.0, 0.0, -40.0)
    box = parts.box.index(), (20.0, 0.0, 0.0)
    context.SetTime(3.1)
    assert forces(parts, context) == [palm]
    live.Push(context, [20.0, 0.0, 0.0], 3.3)
    assert forces(parts, context) == [palm, box]
    context.SetTime(3.25)
    assert forces(parts, context) == [box]
    context.SetTime(3.3)
    assert forces(parts, context) == []


def test_a_carry_without_time_for_it_has_a_goal_that_stays(default_plan, monkeypatch):
    monkeypatch.setattr(goal_range, "ABOVE", 0.5)
    diagram, _, live, context = made(default_plan)
    assert live.goal is None and live.window is None and not diagram.HasSubsystemNamed("live_goal")
    live.MoveGoal(context, [0.1, 0.0, 0.0])
    assert not live.GoalOffset(context).any()


def test_a_moved_goal_moves_all_points_as_critical_damping_has_it_and_no_lengths(default_plan):
    """In closed form, with the law between the points at work."""
    plan, skill = default_plan, default_plan.task.skill
    assert skill.beta_z == pytest.approx(0.25 * skill.alpha_z)
    builder = DiagramBuilder()
    parts = AddSkill(builder, skill, plan.task.bands, gains=LawGains(plan.scenario), time_step=STEP)
    opens, after = 0.2, 0.6
    goal = builder.AddSystem(
        LiveGoal(
            scale=0.5, window=(opens - 0.5 * STEP, 99.0), rate=1e6, tau=skill.tau, gamma=skill.gamma, time_step=STEP
        )
    )
    planned, wanting = parts.goal.get_output_port(), parts.transformation.GetInputPort("goal")
    builder.Disconnect(planned, wanting)
    builder.Connect(planned, goal.GetInputPort("planned_goal"))
    builder.Connect(parts.canonical.get_output_port(), goal.GetInputPort("phase"))
    builder.Connect(goal.GetOutputPort("goal"), wanting)
    simulator = Simulator(builder.Build())
    context = simulator.get_mutable_context()
    goal.GetInputPort("wanted_offset").FixValue(goal.GetMyMutableContextFromRoot(context), [0.05, -0.02, 0.01])
    simulator.AdvanceTo(opens + after)
    mine = parts.transformation.GetMyContextFromRoot(context)
    x = parts.transformation.GetOutputPort("position").Eval(mine).reshape(6, 3)
    k = round((opens + after) / STEP)
    u = 0.5 * skill.alpha_z / skill.tau * (after - STEP)  # The goal jumps one step after the window opens.
    share = 1.0 - (1.0 + u) * np.exp(-u)
    assert 0.2 < share < 0.8
    moved = np.tile(share * np.array([0.05, -0.02, 0.01]) / 0.5, (6, 1))
    np.testing.assert_allclose(x - plan.coupled.x[k], moved, atol=1e-9)
    np.testing.assert_allclose(link_lengths(x), link_lengths(plan.coupled.x[k]), atol=1e-9)
