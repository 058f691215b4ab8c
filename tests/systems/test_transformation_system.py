import numpy as np
import pytest
from pydrake.autodiffutils import AutoDiffXd
from pydrake.symbolic import Expression
from pydrake.systems.analysis import Simulator

from drake_blfdmp.demonstration.modelled_person import hold_and_place
from drake_blfdmp.skill.learning import learn_skill
from drake_blfdmp.skill.transformation import (
    derivatives,
    mean_acceleration,
    nominal_acceleration,
    step,
    step_matrices,
)
from drake_blfdmp.systems.transformation_system import TransformationSystem, TransformationSystem_

DT = 0.02
PORTS = ("forcing", "goal", "coupling_acceleration")


@pytest.fixture(scope="module")
def skill():
    return learn_skill(*hold_and_place(), basis_functions=12)


def numbers(seed=0):
    return np.random.default_rng(seed).normal(size=(5, 18))


def prepared(skill, time_step, coupled=True):
    """A system and a context with known state and inputs, and these: x, velocity, forcing, goal, coupling."""
    system = TransformationSystem(skill=skill, time_step=time_step)
    context = system.CreateDefaultContext()
    x, velocity, *inputs = numbers()
    if time_step:
        context.SetDiscreteState(0, x)
        context.SetDiscreteState(1, velocity)
    else:
        context.SetContinuousState(np.concatenate([x, velocity]))
    for name, value in zip(PORTS[: 2 + coupled], inputs, strict=False):
        system.GetInputPort(name).FixValue(context, value)
    return system, context, (x, velocity, *inputs)


@pytest.mark.parametrize("time_step", [0.0, DT])
def test_ports(skill, time_step):
    system = TransformationSystem(skill=skill, time_step=time_step)
    assert tuple(system.get_input_port(i).get_name() for i in range(4)) == (*PORTS, "tempo")
    assert system.GetInputPort("tempo").size() == 1
    assert [system.get_output_port(i).get_name() for i in range(3)] == ["position", "velocity", "nominal_acceleration"]
    assert {system.get_input_port(i).size() for i in range(3)} | {
        system.get_output_port(i).size() for i in range(3)
    } == {18}
    assert (system.num_input_ports(), system.num_output_ports()) == (4, 3)


@pytest.mark.parametrize("time_step", [0.0, DT])
def test_only_the_nominal_acceleration_feeds_through_and_not_from_the_coupling(skill, time_step):
    system = TransformationSystem(skill=skill, time_step=time_step)
    through = [(i, o) for i in range(4) for o in range(3) if system.HasDirectFeedthrough(i, o)]
    assert through == [(0, 2), (1, 2), (3, 2)]


@pytest.mark.parametrize("time_step", [0.0, DT])
def test_it_starts_at_rest_at_the_skills_start(skill, time_step):
    system = TransformationSystem(skill=skill, time_step=time_step)
    context = system.CreateDefaultContext()
    np.testing.assert_array_equal(system.GetOutputPort("position").Eval(context), skill.start.reshape(18))
    np.testing.assert_array_equal(system.GetOutputPort("velocity").Eval(context), np.zeros(18))


@pytest.mark.parametrize("time_step", [0.0, DT])
def test_the_outputs_are_the_state_and_the_uncoupled_acceleration(skill, time_step):
    system, context, (x, velocity, f, goal, _) = prepared(skill, time_step)
    np.testing.assert_array_equal(system.GetOutputPort("position").Eval(context), x)
    np.testing.assert_array_equal(system.GetOutputPort("velocity").Eval(context), velocity)
    arguments = (x, skill.tau * velocity, f, goal, skill.tau)
    if time_step:
        want = mean_acceleration(*arguments, step_matrices(DT, skill.tau, skill.alpha_z, skill.beta_z), DT)
    else:
        want = nominal_acceleration(*arguments, skill.alpha_z, skill.beta_z)
    np.testing.assert_allclose(system.GetOutputPort("nominal_acceleration").Eval(context), want, rtol=1e-12)


@pytest.mark.parametrize("coupled", [True, False])
def test_the_discrete_update(skill, coupled):
    system, context, (x, velocity, f, goal, coupling) = prepared(skill, DT, coupled)
    matrices = step_matrices(DT, skill.tau, skill.alpha_z, skill.beta_z)
    want_x, want_v = step(x, skill.tau * velocity, f, goal, coupling * coupled, skill.tau, matrices, DT)
    after = system.EvalUniquePeriodicDiscreteUpdate(context)
    np.testing.assert_allclose(after.value(0), want_x, rtol=1e-12)
    np.testing.assert_allclose(after.value(1), want_v / skill.tau, rtol=1e-12)


@pytest.mark.parametrize("coupled", [True, False])
def test_the_continuous_derivatives(skill, coupled):
    system, context, (x, velocity, f, goal, coupling) = prepared(skill, 0.0, coupled)
    x_dot, v_dot = derivatives(
        x, skill.tau * velocity, f, goal, coupling * coupled, skill.tau, skill.alpha_z, skill.beta_z
    )
    got = system.EvalTimeDerivatives(context).CopyToVector()
    np.testing.assert_allclose(got, np.concatenate([x_dot, v_dot / skill.tau]), rtol=1e-12)


def test_a_tempo_shortens_the_step(skill):
    system, context, (x, velocity, f, goal, coupling) = prepared(skill, DT)
    system.GetInputPort("tempo").FixValue(context, 0.3)
    matrices = step_matrices(0.3 * DT, skill.tau, skill.alpha_z, skill.beta_z)
    want_x, want_v = step(x, skill.tau * velocity, f, goal, coupling, skill.tau, matrices, 0.3 * DT)
    after = system.EvalUniquePeriodicDiscreteUpdate(context)
    np.testing.assert_allclose(after.value(0), want_x, rtol=1e-12)
    np.testing.assert_allclose(after.value(1), want_v / skill.tau, rtol=1e-12)
    mean = mean_acceleration(x, skill.tau * velocity, f, goal, skill.tau, matrices, 0.3 * DT)
    np.testing.assert_allclose(system.GetOutputPort("nominal_acceleration").Eval(context), mean, rtol=1e-9)


@pytest.mark.parametrize("time_step", [0.0, DT])
def test_a_tempo_of_zero_stops_it(skill, time_step):
    system, context, (x, velocity, f, goal, _) = prepared(skill, time_step)
    system.GetInputPort("tempo").FixValue(context, 0.0)
    if time_step:
        after = system.EvalUniquePeriodicDiscreteUpdate(context)
        np.testing.assert_allclose(after.value(0), x, rtol=1e-14)
        np.testing.assert_allclose(after.value(1), velocity, rtol=1e-14)
    else:
        np.testing.assert_array_equal(system.EvalTimeDerivatives(context).CopyToVector(), 0.0)
    want = nominal_acceleration(x, skill.tau * velocity, f, goal, skill.tau, skill.alpha_z, skill.beta_z)
    np.testing.assert_allclose(system.GetOutputPort("nominal_acceleration").Eval(context), want, rtol=1e-12)


def test_continuous_rates_go_by_the_tempo(skill):
    system, context, _ = prepared(skill, 0.0)
    full = system.EvalTimeDerivatives(context).CopyToVector()
    system.GetInputPort("tempo").FixValue(context, 0.6)
    np.testing.assert_allclose(system.EvalTimeDerivatives(context).CopyToVector(), 0.6 * full, rtol=1e-14)


def test_the_gradient_by_the_tempo_is_that_of_finite_differences(skill):
    system, context, _ = prepared(skill, DT)
    other = system.ToAutoDiffXd()
    copy = other.CreateDefaultContext()
    copy.SetTimeStateAndParametersFrom(context)
    other.FixInputPortsFrom(system, context, copy)
    other.GetInputPort("tempo").FixValue(copy, np.array([AutoDiffXd(0.5, [1.0])]))
    gradient = [x.derivatives()[0] for x in other.EvalUniquePeriodicDiscreteUpdate(copy).value(0)]
    ends = []
    for tempo in (0.5 - 1e-5, 0.5 + 1e-5):
        system.GetInputPort("tempo").FixValue(context, tempo)
        ends.append(system.EvalUniquePeriodicDiscreteUpdate(context).value(0).copy())
    np.testing.assert_allclose(gradient, (ends[1] - ends[0]) / 2e-5, rtol=1e-6, atol=1e-9)


def test_a_goal_may_move_while_the_skill_runs(skill):
    system = TransformationSystem(skill=skill, time_step=DT)
    simulator = Simulator(system)
    context = simulator.get_mutable_context()
    system.GetInputPort("forcing").FixValue(context, np.zeros(18))
    for goal in (np.full(18, 0.2), np.full(18, -0.4)):
        system.GetInputPort("goal").FixValue(context, goal)
        simulator.AdvanceTo(context.get_time() + 6.0)
        np.testing.assert_allclose(system.GetOutputPort("position").Eval(context), goal, atol=1e-6)


@pytest.mark.parametrize("time_step", [0.0, DT])
def test_other_scalar_types_give_the_same_numbers(skill, time_step):
    system, context, _ = prepared(skill, time_step)
    want = system.GetOutputPort("nominal_acceleration").Eval(context)
    for scalar, other in ((AutoDiffXd, system.ToAutoDiffXd()), (Expression, system.ToSymbolic())):
        assert isinstance(other, TransformationSystem_[scalar])
        copy = other.CreateDefaultContext()
        copy.SetTimeStateAndParametersFrom(context)
        other.FixInputPortsFrom(system, context, copy)
        got = other.GetOutputPort("nominal_acceleration").Eval(copy)
        values = [a.value() if scalar is AutoDiffXd else a.Evaluate() for a in got]
        np.testing.assert_allclose(values, want, rtol=1e-12)
        if time_step:
            other.EvalUniquePeriodicDiscreteUpdate(copy)
        else:
            other.EvalTimeDerivatives(copy)
