"""The systems that make what is recorded, each against numbers that are known without it."""

import numpy as np
import pytest
from pydrake.common.value import AbstractValue

from drake_blfdmp.robot.kinematics import DualArmKinematics
from drake_blfdmp.robot.plant import ARMS, MakeKinematicPlant
from drake_blfdmp.skeleton import LINKS
from drake_blfdmp.skill.canonical import phase_at
from drake_blfdmp.systems.arm_swivels import ArmSwivels
from drake_blfdmp.systems.link_lengths import ELEMENTS, LinkLengths
from drake_blfdmp.systems.passed_times import PassedTimes
from drake_blfdmp.systems.planned_pose import PlannedPose
from drake_blfdmp.systems.skill_clock import SkillClock


def output(system, **inputs):
    context = system.CreateDefaultContext()
    for name, value in inputs.items():
        system.GetInputPort(name).FixValue(context, value)
    return system.get_output_port().Eval(context)


def test_link_lengths_stand_beside_their_bands_by_name():
    x = np.random.default_rng(1).normal(size=(6, 3))
    found = dict(zip(ELEMENTS, output(LinkLengths(), position=x.ravel(), bands=np.arange(30.0)), strict=True))
    for k, link in enumerate(LINKS):
        assert found[link.name] == pytest.approx(np.linalg.norm(x[link.b] - x[link.a]))
        assert (found[f"{link.name}_lower"], found[f"{link.name}_upper"]) == (k, 5 + k)


def test_the_clock_is_the_time_of_the_phase():
    phase = phase_at(1.7, tau=3.0)
    np.testing.assert_allclose(output(SkillClock(tau=3.0), phase=[phase]), [1.7])


def test_swivels_are_those_of_the_kinematics():
    plant = MakeKinematicPlant()
    context = plant.CreateDefaultContext()
    q = np.array([0.2, -0.5, 0.3, -2.1, 0.4, 1.8, 0.1, -0.3, -0.4, 0.6, -1.9, -0.2, 2.0, 0.5])
    plant.SetPositions(context, q)
    poses = plant.get_body_poses_output_port().Eval(context)
    arms = [plant.GetModelInstanceByName(arm) for arm in ARMS]
    found = output(ArmSwivels(plant=plant, arms=arms), body_poses=AbstractValue.Make(poses))
    np.testing.assert_allclose(found, [arm.swivel for arm in DualArmKinematics().evaluate(q)], atol=1e-12)


def test_a_planned_pose_is_the_nearest():
    poses = np.arange(21.0).reshape(3, 7)
    system = PlannedPose(t=np.array([0.0, 1.0, 2.0]), poses=poses)
    for clock, row in ((-1.0, 0), (0.4, 0), (0.6, 1), (1.9, 2), (9.0, 2)):
        np.testing.assert_array_equal(output(system, clock=[clock]), poses[row])


def test_times_are_counted_once_they_are_reached():
    system = PassedTimes(times=[2.0, 0.5])
    for clock, number in ((0.0, 0), (0.499, 0), (0.5, 1), (1.9, 1), (2.0 - 1e-12, 2), (7.0, 2)):
        assert output(system, clock=[clock]) == [number]
