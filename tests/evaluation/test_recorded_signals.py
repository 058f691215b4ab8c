"""What is made of ports' values when a run is recorded, each against numbers that are known without it."""

import numpy as np
import pytest
from pydrake.multibody.tree import BodyIndex

from drake_blfdmp.diagrams.hold_and_place import MakeHoldAndPlace
from drake_blfdmp.evaluation.planned_signals import MakePlannedSignals
from drake_blfdmp.evaluation.recorded_signals import (
    LINK_LENGTHS,
    ClockMaker,
    PlannedBoxMaker,
    RunSignals,
    SwivelMaker,
    lengths_and_limits,
)
from drake_blfdmp.robot.kinematics import DualArmKinematics
from drake_blfdmp.skeleton import LINKS
from drake_blfdmp.skill.canonical import phase_at


@pytest.fixture(scope="module")
def run(default_plan):
    """The diagram of the default run, its parts, its planned signals."""
    diagram, parts = MakeHoldAndPlace(default_plan)
    return diagram, parts, MakePlannedSignals(default_plan, parts.limits)


def test_every_signal_makes_as_many_numbers_as_it_names(run):
    _, parts, planned = run
    signals = RunSignals(parts, planned)
    assert len({signal.name for signal in signals}) == len(signals) >= 14
    for signal in signals:
        size = sum(port.size() for port in signal.ports) + 12 * len(signal.bodies)
        made = np.ones((3, size)) if signal.make is None else signal.make(np.full((3, size), 0.5))
        assert made.shape == (3, len(signal.elements)), signal.name


def test_link_lengths_stand_beside_their_bands_by_name():
    x, bands = np.random.default_rng(1).normal(size=(2, 6, 3)), np.arange(60.0).reshape(2, 30)
    rows = lengths_and_limits(np.hstack([x.reshape(2, 18), bands]))
    for n in range(2):
        found = dict(zip(LINK_LENGTHS, rows[n], strict=True))
        for k, link in enumerate(LINKS):
            assert found[link.name] == pytest.approx(np.linalg.norm(x[n, link.b] - x[n, link.a]))
            assert (found[f"{link.name}_lower"], found[f"{link.name}_upper"]) == (30 * n + k, 30 * n + 5 + k)


def test_the_clock_is_the_time_of_the_phase(default_plan):
    skill = default_plan.task.skill
    t = np.array([0.0, 1.7, 3.0])
    found = ClockMaker(default_plan)(phase_at(t, skill.tau, skill.gamma)[:, None])
    np.testing.assert_allclose(found[:, 0], t, atol=1e-12)


def test_swivels_are_those_of_the_kinematics(run):
    _, parts, _ = run
    plant, context = parts.plant, parts.plant.CreateDefaultContext()
    q = np.random.default_rng(2).uniform(-0.5, 0.5, (3, 14)) + [0.2, -0.5, 0.3, -1.9, 0.4, 1.8, 0.1] * 2
    make = SwivelMaker(plant, parts.arms)
    rows = []
    for one in q:
        for arm, part in zip(parts.arms, np.split(one, 2), strict=True):
            plant.SetPositions(context, arm, part)
        poses = [plant.EvalBodyPoseInWorld(context, plant.get_body(BodyIndex(body))) for body in make.bodies]
        rows.append(np.concatenate([[0.1, 0.2], *(X_WB.GetAsMatrix34().ravel() for X_WB in poses)]))
    found = make(np.array(rows))
    kinematics = DualArmKinematics()
    np.testing.assert_allclose(found[:, :2], [[arm.swivel for arm in kinematics.evaluate(one)] for one in q], atol=1e-9)
    np.testing.assert_array_equal(found[:, 2:], [[0.1, 0.2]] * 3)


def test_a_planned_pose_is_the_nearest(run, default_plan):
    _, _, planned = run
    skill, clock = default_plan.task.skill, planned.clock
    step = clock[1] - clock[0]
    t = np.array([clock[0], clock[0] + 0.4 * step, clock[0] + 0.6 * step, clock[-1] + 5.0])
    found = PlannedBoxMaker(default_plan, planned)(phase_at(t, skill.tau, skill.gamma)[:, None])
    np.testing.assert_array_equal(found, planned.box[[0, 0, 1, -1]])
