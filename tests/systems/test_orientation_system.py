"""The orientation's primitive as a system: ports, the pure functions' values, both kinds of state, goal and tempo."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource

from drake_blfdmp.demonstration.modelled_person import hold_and_place
from drake_blfdmp.errors import SkillError
from drake_blfdmp.quaternions import angle_between, from_rotation_vector
from drake_blfdmp.skill.canonical import phase_at
from drake_blfdmp.skill.learning import learn_skill
from drake_blfdmp.skill.orientation import angular_acceleration, orientation_step, roll_out_orientation
from drake_blfdmp.skill.transformation import step_matrices
from drake_blfdmp.systems.canonical_system import CanonicalSystem
from drake_blfdmp.systems.orientation_system import OrientationSystem

DT = 0.02
UNIT = np.array([1.0, 0.0, 0.0, 0.0])


@pytest.fixture(scope="module")
def skill():
    t, x = hold_and_place()
    u = t / t[-1]
    turn = from_rotation_vector((np.sin(np.pi * u**2 * (3 - 2 * u)) ** 2)[:, None] * [0.6, 0.1, -0.2])
    return learn_skill(t, x, basis_functions=40, turn=turn)


def with_clock(skill, time_step, tempo=None, goal=None):
    """Canonical system, goal and orientation; the tempo, where given, drives both."""
    builder = DiagramBuilder()
    canonical = builder.AddSystem(CanonicalSystem(tau=skill.tau, gamma=skill.gamma, time_step=time_step))
    orientation = builder.AddSystem(OrientationSystem(skill=skill, time_step=time_step))
    goal = builder.AddSystem(ConstantVectorSource(skill.orientation.goal if goal is None else goal))
    builder.Connect(canonical.get_output_port(), orientation.GetInputPort("phase"))
    builder.Connect(goal.get_output_port(), orientation.GetInputPort("goal_orientation"))
    if tempo is not None:
        source = builder.AddSystem(ConstantVectorSource([tempo]))
        for system in (canonical, orientation):
            builder.Connect(source.get_output_port(), system.GetInputPort("tempo"))
    simulator = Simulator(builder.Build())
    simulator.get_mutable_integrator().set_target_accuracy(1e-6)
    simulator.Initialize()
    return simulator, orientation


def values(simulator, orientation):
    context = orientation.GetMyContextFromRoot(simulator.get_context())
    return [orientation.GetOutputPort(name).Eval(context).copy() for name in ("orientation", "angular_velocity")]


@pytest.mark.parametrize("time_step", [0.0, DT])
def test_ports(skill, time_step):
    system = OrientationSystem(skill=skill, time_step=time_step)
    inputs = [system.get_input_port(i) for i in range(system.num_input_ports())]
    assert [(p.get_name(), p.size()) for p in inputs] == [("phase", 1), ("goal_orientation", 4), ("tempo", 1)]
    outputs = [system.get_output_port(i) for i in range(system.num_output_ports())]
    assert [(p.get_name(), p.size()) for p in outputs] == [("orientation", 4), ("angular_velocity", 3)]
    assert not any(system.HasDirectFeedthrough(i, o) for i in range(3) for o in range(2))


def test_it_starts_at_rest_at_the_skills_start(skill):
    for time_step in (0.0, DT):
        simulator, orientation = with_clock(skill, time_step)
        q, omega = values(simulator, orientation)
        np.testing.assert_array_equal(q, skill.orientation.start)
        np.testing.assert_array_equal(omega, 0.0)


def test_the_discrete_update_is_the_step(skill):
    system = OrientationSystem(skill=skill, time_step=DT)
    context = system.CreateDefaultContext()
    q, omega, goal = from_rotation_vector(np.array([0.4, 0.2, -0.1])), np.array([0.3, -0.2, 0.1]), -UNIT
    context.SetDiscreteState(0, q)
    context.SetDiscreteState(1, omega)
    system.GetInputPort("phase").FixValue(context, [0.3])
    system.GetInputPort("goal_orientation").FixValue(context, goal)
    for tempo in (1.0, 0.25):
        if tempo != 1.0:
            system.GetInputPort("tempo").FixValue(context, [tempo])
        after = system.EvalUniquePeriodicDiscreteUpdate(context)
        middle = 0.3 * phase_at(0.5 * tempo * DT, skill.tau, skill.gamma)
        f = skill.orientation.forcing(middle, skill.centers, skill.widths)
        matrices = step_matrices(tempo * DT, skill.tau, skill.alpha_z, skill.beta_z)
        wanted = orientation_step(q, omega, f, goal, skill.tau, matrices)
        for index, value in enumerate(wanted):
            np.testing.assert_allclose(after.value(index), value, atol=1e-13)


def test_the_derivatives_are_those_of_the_primitive(skill):
    system = OrientationSystem(skill=skill)
    context = system.CreateDefaultContext()
    q, omega = from_rotation_vector(np.array([0.4, 0.2, -0.1])), np.array([0.3, -0.2, 0.1])
    context.SetContinuousState(np.concatenate([q, omega]))
    system.GetInputPort("phase").FixValue(context, [0.3])
    system.GetInputPort("goal_orientation").FixValue(context, UNIT)
    f = skill.orientation.forcing(0.3, skill.centers, skill.widths)
    wanted = angular_acceleration(q, omega, f, UNIT, skill.tau, skill.alpha_z, skill.beta_z)
    rates = system.EvalTimeDerivatives(context).CopyToVector()
    np.testing.assert_allclose(rates[4:], wanted, atol=1e-12)
    h = 1e-6
    after = from_rotation_vector(h * omega)
    turned = from_rotation_vector(np.array([0.4, 0.2, -0.1]))
    assert angle_between(q + h * rates[:4], turned) == pytest.approx(angle_between(after, UNIT), rel=1e-3)
    system.GetInputPort("tempo").FixValue(context, [0.5])
    np.testing.assert_allclose(system.EvalTimeDerivatives(context).CopyToVector(), 0.5 * rates, atol=1e-14)


def test_the_discrete_system_is_the_rollout(skill):
    simulator, orientation = with_clock(skill, DT)
    turn, rate = roll_out_orientation(skill, time_step=DT, samples=201)
    for k in (1, 50, 200):
        simulator.AdvanceTo(k * DT)
        q, omega = values(simulator, orientation)
        np.testing.assert_allclose(q, turn[k], atol=1e-9)
        np.testing.assert_allclose(omega, rate[k], atol=1e-8)
        assert np.linalg.norm(q) == pytest.approx(1.0, abs=1e-14)


def test_both_kinds_of_state_show_one_motion(skill):
    runs = [with_clock(skill, time_step) for time_step in (0.0, 0.005)]
    for end in (1.0, 2.0):
        shown = []
        for simulator, orientation in runs:
            simulator.AdvanceTo(end)
            shown.append(values(simulator, orientation))
        assert angle_between(shown[0][0], shown[1][0]) < 2e-4
        np.testing.assert_allclose(shown[0][1], shown[1][1], atol=1e-3)
        assert np.linalg.norm(shown[0][0]) == pytest.approx(1.0, abs=1e-14)


def test_half_the_tempo_takes_twice_the_time(skill):
    (one, first), (half, second) = with_clock(skill, 0.005), with_clock(skill, 0.01, tempo=0.5)
    one.AdvanceTo(3.0)
    half.AdvanceTo(6.0)
    for a, b in zip(values(one, first), values(half, second), strict=True):
        np.testing.assert_allclose(a, b, atol=1e-9)  # Both per second of the skill's clock.
    still, third = with_clock(skill, DT, tempo=0.0)
    still.AdvanceTo(1.0)
    np.testing.assert_allclose(values(still, third)[0], skill.orientation.start, atol=1e-12)


def test_another_goal_is_reached(skill):
    goal = from_rotation_vector(np.array([0.3, 0.0, 0.0]))
    simulator, orientation = with_clock(skill, DT, goal=-2.0 * goal)  # Of any sign and length.
    simulator.AdvanceTo(skill.tau + 2.0)
    assert angle_between(values(simulator, orientation)[0], goal) < 1e-3


def test_a_skill_without_orientation_is_refused(skill):
    with pytest.raises(SkillError, match="no orientation"):
        OrientationSystem(skill=replace(skill, orientation=None))
