"""What the world does otherwise than the plan believes is in the simulated plant, and nowhere else."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.systems.framework import DiagramBuilder

from drake_blfdmp.diagrams.hold_and_place import AddPlannedPlant, MakeHoldAndPlace, SetInitialState
from drake_blfdmp.errors import TaskError
from drake_blfdmp.planning.scenario_sections import RealityConfig
from drake_blfdmp.robot.plant import DEFAULT_DAMPING, DEFAULT_STIFFNESS, ArmActuators


def really(plan, **changes):
    return replace(plan, scenario=replace(plan.scenario, reality=RealityConfig(**changes)))


def test_by_default_it_is_as_believed(default_plan):
    assert default_plan.real_box == default_plan.box
    diagram, _ = MakeHoldAndPlace(default_plan)
    assert not diagram.HasSubsystemNamed("push")


def test_the_box_is_what_it_really_is_and_the_plan_stays(default_plan):
    plan = really(default_plan, mass_scale=1.2, friction_scale=0.8, width_error=0.01)
    assert plan.box == default_plan.box
    plant, scene_graph, _, box = AddPlannedPlant(DiagramBuilder(), plan)
    assert box.default_mass() == pytest.approx(1.2 * plan.box.mass)
    inspector = scene_graph.model_inspector()
    (shape,) = {inspector.GetShape(id).size().tobytes() for id in plant.GetCollisionGeometriesForBody(box)}
    np.testing.assert_allclose(np.frombuffer(shape), plan.box.size + np.array([0.01, 0.0, 0.0]))
    for id in plant.GetCollisionGeometriesForBody(box):
        friction = inspector.GetProximityProperties(id).GetProperty("material", "coulomb_friction")
        assert friction.dynamic_friction() == pytest.approx(0.8 * plan.box.friction)


def test_softer_arms(default_plan):
    plant, _, arms, _ = AddPlannedPlant(DiagramBuilder(), really(default_plan, stiffness_scale=0.25))
    for arm in arms:
        gains = [actuator.get_controller_gains() for actuator in ArmActuators(plant, arm)]
        np.testing.assert_allclose([gain.p for gain in gains], 0.25 * np.array(DEFAULT_STIFFNESS))
        np.testing.assert_allclose([gain.d for gain in gains], 0.5 * np.array(DEFAULT_DAMPING))


@pytest.mark.parametrize(("arm", "index"), [("left", 0), ("right", 1)])
def test_a_push_reaches_the_palm_that_is_named_when_it_is_held(default_plan, arm, index):
    plan = really(default_plan, push_arm=arm, push_force=[0.0, 0.0, -40.0], push_duration=0.3)
    assert plan.push_at_s == pytest.approx(np.mean(plan.task.held))
    diagram, parts = MakeHoldAndPlace(plan)
    context = diagram.CreateDefaultContext()
    SetInitialState(parts, diagram, context)
    mine = parts.plant.GetMyContextFromRoot(context)
    for t, acts in ((plan.push_at_s - 0.01, 0), (plan.push_at_s + 0.29, 1), (plan.push_at_s + 0.31, 0)):
        context.SetTime(t)
        forces = parts.plant.get_applied_spatial_force_input_port().Eval(mine)
        assert len(forces) == acts
        for force in forces:
            np.testing.assert_array_equal(force.F_Bq_W.translational(), [0.0, 0.0, -40.0])
            assert force.body_index == parts.plant.GetBodyByName("palm", parts.arms[index]).index()


def test_a_box_of_no_width_is_refused(default_plan):
    with pytest.raises(TaskError, match="box width"):
        AddPlannedPlant(DiagramBuilder(), really(default_plan, width_error=-1.0))
