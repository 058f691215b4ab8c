import numpy as np
import pytest
from pydrake.autodiffutils import AutoDiffXd
from pydrake.symbolic import Expression, Variable

from drake_blfdmp.demonstration.modelled_person import hold_and_place
from drake_blfdmp.skill.basis import activations
from drake_blfdmp.skill.canonical import phase_at
from drake_blfdmp.skill.learning import learn_skill
from drake_blfdmp.systems.forcing_term import ForcingTerm, ForcingTerm_


@pytest.fixture(scope="module")
def skill():
    return learn_skill(*hold_and_place(), basis_functions=12)


def test_ports(skill):
    system = ForcingTerm(skill=skill)
    assert (system.num_input_ports(), system.num_output_ports()) == (2, 1)
    assert [system.GetInputPort(name).size() for name in ("phase", "tempo")] == [1, 1]
    assert system.GetOutputPort("forcing").size() == 18
    assert system.HasAnyDirectFeedthrough()


@pytest.mark.parametrize("time_step", [0.0, 0.05])
@pytest.mark.parametrize("t", [0.0, 1.3, 8.0])
def test_the_forcing_is_the_skills_half_a_step_ahead(skill, time_step, t):
    system = ForcingTerm(skill=skill, time_step=time_step)
    context = system.CreateDefaultContext()
    system.GetInputPort("phase").FixValue(context, phase_at(t, skill.tau, skill.gamma))
    want = skill.forcing(phase_at(t + 0.5 * time_step, skill.tau, skill.gamma))
    np.testing.assert_allclose(system.GetOutputPort("forcing").Eval(context), want, rtol=1e-12)


def test_at_a_slower_tempo_half_a_step_is_shorter(skill):
    system = ForcingTerm(skill=skill, time_step=0.05)
    context = system.CreateDefaultContext()
    system.GetInputPort("phase").FixValue(context, phase_at(1.3, skill.tau, skill.gamma))
    system.GetInputPort("tempo").FixValue(context, 0.4)
    want = skill.forcing(phase_at(1.3 + 0.01, skill.tau, skill.gamma))
    np.testing.assert_allclose(system.GetOutputPort("forcing").Eval(context), want, rtol=1e-12)


def test_the_elements_are_ordered_point_by_point(skill):
    one = np.zeros((12, 6, 3))
    one[:, 4, 2] = 1.0
    system = ForcingTerm(skill=type(skill)(**(vars(skill) | {"weights": one})))
    context = system.CreateDefaultContext()
    system.GetInputPort("phase").FixValue(context, 0.5)
    np.testing.assert_allclose(system.GetOutputPort("forcing").Eval(context), 0.5 * (np.arange(18) == 14), atol=1e-14)


def test_the_autodiff_gradient_is_the_derivative(skill):
    system = ForcingTerm(skill=skill).ToAutoDiffXd()
    assert isinstance(system, ForcingTerm_[AutoDiffXd])
    context = system.CreateDefaultContext()
    system.GetInputPort("phase").FixValue(context, np.array([AutoDiffXd(0.4, [1.0])]))
    gradient = [f.derivatives()[0] for f in system.GetOutputPort("forcing").Eval(context)]
    h = 1e-6
    np.testing.assert_allclose(
        gradient, (skill.forcing(0.4 + h) - skill.forcing(0.4 - h)) / (2 * h), rtol=1e-5, atol=1e-5
    )


def test_the_symbolic_forcing_evaluates_to_the_same(skill):
    system = ForcingTerm(skill=skill).ToSymbolic()
    s = Variable("s")
    context = system.CreateDefaultContext()
    system.GetInputPort("phase").FixValue(context, np.array([Expression(s)]))
    values = [f.Evaluate({s: 0.3}) for f in system.GetOutputPort("forcing").Eval(context)]
    np.testing.assert_allclose(values, skill.forcing(0.3), rtol=1e-12)


def weights_of(system, context):
    return context.get_numeric_parameter(0).CopyToVector().reshape(12, 18)


def test_a_context_carries_weights_of_its_own(skill):
    system = ForcingTerm(skill=skill)
    mine, other = system.CreateDefaultContext(), system.CreateDefaultContext()
    np.testing.assert_array_equal(weights_of(system, mine), skill.weights.reshape(12, 18))
    changed = np.random.default_rng(0).normal(size=(12, 6, 3))
    for context in (mine, other):
        system.GetInputPort("phase").FixValue(context, 0.4)
        system.GetOutputPort("forcing").Eval(context)  # Now in the cache.
    mine.get_mutable_numeric_parameter(0).SetFromVector(changed.ravel())
    want = type(skill)(**(vars(skill) | {"weights": changed})).forcing(0.4)
    np.testing.assert_allclose(system.GetOutputPort("forcing").Eval(mine), want, rtol=1e-12)
    np.testing.assert_allclose(system.GetOutputPort("forcing").Eval(other), skill.forcing(0.4), rtol=1e-12)
    other.SetTimeStateAndParametersFrom(mine)
    np.testing.assert_allclose(system.GetOutputPort("forcing").Eval(other), want, rtol=1e-12)


def test_the_forcing_is_linear_in_the_weights_by_its_own_derivatives(skill):
    """Twelve weights, each of another basis function and column: df/dtheta is the activation, in its column alone."""
    system = ForcingTerm(skill=skill).ToAutoDiffXd()
    context = system.CreateDefaultContext()
    chosen = np.arange(12) * 18 + np.arange(12)
    values = [AutoDiffXd(v, np.zeros(12)) for v in skill.weights.ravel()]
    for k, index in enumerate(chosen):
        values[index] = AutoDiffXd(skill.weights.ravel()[index], np.eye(12)[k])
    context.get_mutable_numeric_parameter(0).SetFromVector(np.array(values))
    system.GetInputPort("phase").FixValue(context, np.array([AutoDiffXd(0.4, np.zeros(12))]))
    gradient = np.array([f.derivatives() for f in system.GetOutputPort("forcing").Eval(context)])
    want = np.zeros((18, 12))
    want[np.arange(12), np.arange(12)] = activations(0.4, skill.centers, skill.widths)
    np.testing.assert_allclose(gradient, want, atol=1e-14)
