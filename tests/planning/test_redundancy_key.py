"""`retarget.redundancy`: read, checked, and passed on to the running arms but not to the plan."""

from dataclasses import replace

import numpy as np
import pytest

from drake_blfdmp.diagrams.hold_and_place import MakeHoldAndPlace, SetInitialState
from drake_blfdmp.errors import ScenarioError
from drake_blfdmp.planning.scenario import ApplySetting, CheckScenario, DumpScenario, LoadScenario, Scenario
from drake_blfdmp.robot.kinematics import DualArmKinematics
from drake_blfdmp.robot.redundancy import REDUNDANCIES
from drake_blfdmp.robot.tracking import DualArmTracker


def with_redundancy(plan, redundancy):
    retarget = replace(plan.scenario.retarget, redundancy=redundancy)
    return replace(plan, scenario=replace(plan.scenario, retarget=retarget))


def test_the_swivel_is_the_default():
    assert Scenario().retarget.redundancy == "swivel"


@pytest.mark.parametrize("redundancy", REDUNDANCIES)
def test_every_choice_is_accepted_and_survives_being_written(redundancy, tmp_path):
    scenario = ApplySetting(Scenario(), f"retarget.redundancy={redundancy}")
    CheckScenario(scenario)
    path = tmp_path / "scenario.yaml"
    path.write_text(DumpScenario(scenario), encoding="utf-8")
    assert LoadScenario(path).retarget.redundancy == redundancy


def test_anything_else_is_refused_in_one_line():
    with pytest.raises(ScenarioError) as error:
        CheckScenario(ApplySetting(Scenario(), "retarget.redundancy=elbow"))
    assert str(error.value) == ("scenario: retarget.redundancy is 'elbow'; choose one of swivel, none, published")


@pytest.mark.parametrize("redundancy", REDUNDANCIES)
def test_the_diagrams_arms_obey_the_key(default_plan, redundancy):
    plan = with_redundancy(default_plan, redundancy)
    diagram, parts = MakeHoldAndPlace(plan)
    context = diagram.CreateDefaultContext()
    SetInitialState(parts, diagram, context)
    context.SetTime(plan.settle_s)
    ik_context = parts.ik.GetMyContextFromRoot(context)
    names = (("palm_poses", (2, 7)), ("palm_twists", (2, 6)), ("swivel", (2,)), ("swivel_rate", (2,)))
    asked = [parts.ik.GetInputPort(name).Eval(ik_context).reshape(shape) for name, shape in names]
    state = parts.ik.EvalUniquePeriodicDiscreteUpdate(ik_context)
    tracker = DualArmTracker(DualArmKinematics(), parts.limits, redundancy=redundancy, mirrored=plan.retarget.elbow_up)
    step = plan.scenario.simulation.skill_time_step
    expected = tracker.velocity(np.asarray(plan.reach.start), *asked, np.zeros(14), step)[0]
    np.testing.assert_allclose(state.get_vector(1).value(), expected, atol=1e-12)
    others = [
        DualArmTracker(DualArmKinematics(), parts.limits, redundancy=other).velocity(
            np.asarray(plan.reach.start), *asked, np.zeros(14), step
        )[0]
        for other in REDUNDANCIES
        if other != redundancy
    ]
    assert min(np.abs(expected - other).max() for other in others) > 1e-6
