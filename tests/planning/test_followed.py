"""A plan is followed once more, closely; what the arms may not get along then is put behind others, and told."""

from dataclasses import replace

import numpy as np

from drake_blfdmp.planning import plan as plan_module
from drake_blfdmp.planning.followed import FINER, SWINGS_OVER, DoubtOf
from drake_blfdmp.planning.plan import MakePlan
from drake_blfdmp.planning.scenario import RetargetConfig, Scenario
from drake_blfdmp.robot.kinematics import DualArmKinematics
from drake_blfdmp.robot.plant import ARMS, MakeKinematicPlant, ReadJointLimits
from drake_blfdmp.robot.reach_evaluation import SAMPLES, Reach

PLANT = MakeKinematicPlant()
ARMS_KNOWN = DualArmKinematics(PLANT), ReadJointLimits(PLANT, [PLANT.GetModelInstanceByName(arm) for arm in ARMS])


def faster(plan, times):
    return replace(plan, coupled=replace(plan.coupled, t=plan.coupled.t / times), stretch=plan.stretch / times)


def test_a_plan_that_the_arms_follow_is_not_doubted(default_plan):
    assert DoubtOf(default_plan, *ARMS_KNOWN) == ""


def test_a_way_out_of_reach_is_doubted(default_plan):
    retarget = replace(default_plan.retarget, world=default_plan.retarget.world + np.array([0.0, 0.5, 0.0]))
    elsewhere = replace(default_plan, reach=replace(default_plan.reach, retarget=retarget))
    assert "may not get along the whole way" in DoubtOf(elsewhere, *ARMS_KNOWN)


def test_what_only_the_finer_samples_show_is_doubted(default_plan):
    """A bulge out of reach between two of the coarse samples."""
    coupled, x = default_plan.coupled, default_plan.coupled.x.copy()
    first = np.searchsorted(coupled.t, default_plan.settle_s)
    coarse, fine = (
        np.linspace(first, len(x) - 1, samples).round().astype(int) for samples in (SAMPLES, FINER * SAMPLES)
    )
    between = np.setdiff1d(fine, coarse)
    x[between[np.abs(between - len(x) // 2).argmin()]] += [0.0, 0.6, 0.0]
    assert "may not get along" in DoubtOf(replace(default_plan, coupled=replace(coupled, x=x)), *ARMS_KNOWN)


def test_a_throw_is_doubted_unless_it_is_asked_for(default_plan):
    times = 1.2 * SWINGS_OVER
    thrown = replace(faster(default_plan, times), stretch=default_plan.stretch)
    assert "swings over at" in DoubtOf(thrown, *ARMS_KNOWN)
    assert DoubtOf(faster(default_plan, times), *ARMS_KNOWN) == ""  # As `task.duration_scale` would have it.


def plan_with_doubts(monkeypatch, doubts):
    """The default planned as if no reach were comfortable, and these the doubts of one plan after the other."""
    asked = []

    def doubt(plan, kinematics, limits):
        asked.append(plan.notes)
        return doubts[min(len(asked), len(doubts)) - 1]

    monkeypatch.setattr(plan_module, "DoubtOf", doubt)
    monkeypatch.setattr(Reach, "comfortable", property(lambda reach: False))
    scenario = Scenario(retarget=RetargetConfig(scale=1.0))  # One scale alone, as each takes seconds.
    return MakePlan(scenario), asked


def test_a_plan_without_a_doubt_is_preferred(monkeypatch):
    plan, asked = plan_with_doubts(monkeypatch, ["it swings over", "", "it swings over"])
    assert len(asked) == 3 and plan.notes == asked[1]
    assert any("before the grasp" in note for note in plan.notes)  # The second has less approach and retreat.


def test_where_all_are_doubted_the_first_is_taken_and_the_doubt_told(monkeypatch):
    plan, asked = plan_with_doubts(monkeypatch, ["it swings over"])
    assert plan.notes == (*asked[0], "it swings over") and len(asked) >= 3
