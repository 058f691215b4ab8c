"""The phase slows so that the palms stay on a path that is too fast for the joints: phase, path, arms in one loop."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder, LeafSystem
from pydrake.systems.primitives import LogVectorOutput
from scipy.spatial.transform import Rotation

from drake_blfdmp.robot.differential_ik import DEFAULT_GAINS
from drake_blfdmp.robot.kinematics import DualArmKinematics
from drake_blfdmp.robot.plant import ARMS, MakeKinematicPlant, ReadJointLimits
from drake_blfdmp.systems.canonical_system import CanonicalSystem
from drake_blfdmp.systems.swivel_differential_ik import SwivelDifferentialIk

PLANT = MakeKinematicPlant()
LIMITS = ReadJointLimits(PLANT, [PLANT.GetModelInstanceByName(arm) for arm in ARMS])
KINEMATICS = DualArmKinematics(PLANT)
START = np.array([0.5, 0.8, -0.5, -1.9, -1.0, 1.75, 0.0, -0.5, 0.8, 0.5, -1.9, 1.0, 1.75, 0.0])
"""Elbows bent, joint 2 well away from 0, where joints 1 and 3 share an axis."""
HOME_POSES = np.array(
    [[*np.roll(Rotation.from_matrix(s.rotation).as_quat(), 1), *s.position] for s in KINEMATICS.evaluate(START)]
)
SWIVEL = np.array([s.swivel for s in KINEMATICS.evaluate(START)])
DT, GAMMA = 0.004, 4.0


def shift(phase):
    """Where on its curve the palm is, (3,), m: a wave to the side and up; starts and ends at rest."""
    u = np.clip((1.0 - phase) / (1.0 - np.exp(-GAMMA)), 0.0, 1.0)
    ease = u * u * (3.0 - 2.0 * u)
    return np.array([0.06 * np.sin(2.0 * np.pi * ease), -0.05 * ease, 0.2 * ease])


class Path(LeafSystem):
    """Palm poses and twists along the curve, at the phase and at the tempo it runs at."""

    def __init__(self, tau):
        super().__init__()
        self._tau = tau
        self._phase, self._tempo = (self.DeclareVectorInputPort(name, 1) for name in ("phase", "tempo"))
        self.DeclareVectorOutputPort("palm_poses", 14, self._poses)
        self.DeclareVectorOutputPort("palm_twists", 12, self._twists)

    def _poses(self, context, output):
        pose = HOME_POSES.copy()
        pose[:, 4:] += shift(np.asarray(self._phase.Eval(context))[0])
        output.SetFromVector(pose.ravel())

    def _twists(self, context, output):
        s, h, twist = np.asarray(self._phase.Eval(context))[0], 1e-5, np.zeros((2, 6))
        rate = -GAMMA * s / self._tau * np.asarray(self._tempo.Eval(context))[0]
        twist[:, 3:] = rate * (shift(s + h) - shift(s - h)) / (2.0 * h)
        output.SetFromVector(twist.ravel())


def run(tau, seconds, connected):
    """Times (N,), tempo (N,), phase (N,), distance (N, 2) of the palms from the curve's present point, m, and v."""
    builder = DiagramBuilder()
    canonical = builder.AddSystem(CanonicalSystem(tau=tau, gamma=GAMMA, time_step=DT))
    path = builder.AddSystem(Path(tau))
    ik = builder.AddSystem(
        SwivelDifferentialIk(kinematics=KINEMATICS, limits=LIMITS, initial_position=START, time_step=DT)
    )
    builder.Connect(canonical.GetOutputPort("phase"), path.GetInputPort("phase"))
    for name in ("palm_poses", "palm_twists"):
        builder.Connect(path.GetOutputPort(name), ik.GetInputPort(name))
    if connected:
        builder.Connect(ik.GetOutputPort("tempo"), canonical.GetInputPort("tempo"))
        builder.Connect(ik.GetOutputPort("tempo"), path.GetInputPort("tempo"))
    logs = {
        name: LogVectorOutput(port, builder, DT)
        for name, port in (
            ("q", ik.GetOutputPort("position")),
            ("v", ik.GetOutputPort("velocity")),
            ("tempo", ik.GetOutputPort("tempo")),
            ("phase", canonical.GetOutputPort("phase")),
        )
    }
    diagram = builder.Build()  # Refuses an algebraic loop.
    simulator = Simulator(diagram)
    context = simulator.get_mutable_context()
    for name, value in (("swivel", SWIVEL), ("swivel_rate", np.zeros(2))):
        ik.GetInputPort(name).FixValue(ik.GetMyMutableContextFromRoot(context), value)
    if not connected:
        path.GetInputPort("tempo").FixValue(path.GetMyMutableContextFromRoot(context), [1.0])
    simulator.AdvanceTo(seconds)
    data = {name: log.FindLog(context).data().T for name, log in logs.items()}
    off = [
        [
            np.linalg.norm(s.position - HOME_POSES[arm, 4:] - shift(phase[0]))
            for arm, s in enumerate(KINEMATICS.evaluate(q))
        ]
        for q, phase in zip(data["q"], data["phase"], strict=True)
    ]
    return data["tempo"][:, 0], data["phase"][:, 0], np.array(off), data["v"]


@pytest.fixture(scope="module")
def too_fast():
    """The curve in 0.8 s, with and without the loop."""
    return {connected: run(0.8, 3.0, connected) for connected in (True, False)}


def test_a_phase_that_slows_keeps_the_palms_on_their_path(too_fast):
    with_it, without = too_fast[True][2], too_fast[False][2]
    assert without.max() > 0.05
    assert with_it.max() < 0.25 * without.max()
    assert with_it[-1].max() < 1e-3


def test_it_slows_no_more_than_needed_does_not_chatter_and_comes_back(too_fast):
    tempo, phase, _, v = too_fast[True]
    assert DEFAULT_GAINS.tempo_floor < tempo.min() < 0.8
    # One way down and one way back for each bend of the path, not a zigzag.
    turns = np.count_nonzero(np.diff(np.sign(np.diff(tempo)[np.abs(np.diff(tempo)) > 1e-5])))
    assert turns <= 12
    assert tempo[-1] > 0.95
    assert phase[-1] < 1e-2  # The movement is finished.
    change = np.abs(np.diff(v, axis=0)) / DT
    assert np.all(change <= DEFAULT_GAINS.acceleration_share * LIMITS.acceleration + 1e-6)


def test_a_motion_within_the_limits_runs_at_tempo_one_to_the_bit():
    tempo, phase, off, _ = run(4.0, 4.0, True)
    np.testing.assert_array_equal(tempo, 1.0)
    assert off.max() < 5e-3
    assert phase[-1] == pytest.approx(np.exp(-GAMMA), rel=1e-6)
