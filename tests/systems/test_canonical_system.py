import numpy as np
import pytest
from pydrake.autodiffutils import AutoDiffXd
from pydrake.symbolic import Expression, Variable
from pydrake.systems.analysis import Simulator

from drake_blfdmp.skill.canonical import phase_at, phase_rate
from drake_blfdmp.systems.canonical_system import CanonicalSystem, CanonicalSystem_

TAU, DT = 4.0, 0.1


def test_ports():
    system = CanonicalSystem(tau=TAU)
    assert [system.get_input_port(i).get_name() for i in range(system.num_input_ports())] == ["tempo"]
    assert system.GetInputPort("tempo").size() == system.GetOutputPort("phase").size() == 1
    assert not system.HasAnyDirectFeedthrough()


@pytest.mark.parametrize("time_step", [0.0, DT])
def test_the_phase_starts_at_one_and_follows_the_solution(time_step):
    system = CanonicalSystem(tau=TAU, time_step=time_step)
    simulator = Simulator(system)
    phase = system.GetOutputPort("phase")
    assert phase.Eval(simulator.get_context())[0] == 1.0
    for t in (1.0, 2.0, 4.0):
        simulator.AdvanceTo(t + 1e-9)  # Past the update at t.
        k = t + DT if time_step else t  # The state holds s(t + dt) once the update at t is done.
        assert phase.Eval(simulator.get_context())[0] == pytest.approx(phase_at(k, TAU), abs=1e-4)


def test_the_discrete_update_is_exact():
    system = CanonicalSystem(tau=TAU, gamma=3.0, time_step=DT)
    context = system.CreateDefaultContext()
    context.SetDiscreteState([0.37])
    after = system.EvalUniquePeriodicDiscreteUpdate(context).value()
    assert after[0] == pytest.approx(0.37 * phase_at(DT, TAU, 3.0), abs=1e-15)


def test_the_derivative_is_that_of_equation_2():
    system = CanonicalSystem(tau=TAU, gamma=3.0)
    context = system.CreateDefaultContext()
    context.SetContinuousState([0.37])
    assert system.EvalTimeDerivatives(context)[0] == phase_rate(0.37, TAU, 3.0)


@pytest.mark.parametrize("tempo", [0.0, 0.5, 1.0, 2.0])
def test_the_tempo_scales_and_stops_the_phase(tempo):
    continuous, discrete = CanonicalSystem(tau=TAU), CanonicalSystem(tau=TAU, time_step=DT)
    a, b = continuous.CreateDefaultContext(), discrete.CreateDefaultContext()
    continuous.GetInputPort("tempo").FixValue(a, tempo)
    discrete.GetInputPort("tempo").FixValue(b, tempo)
    assert continuous.EvalTimeDerivatives(a)[0] == pytest.approx(tempo * phase_rate(1.0, TAU))
    assert discrete.EvalUniquePeriodicDiscreteUpdate(b).value()[0] == pytest.approx(phase_at(tempo * DT, TAU))


@pytest.mark.parametrize("time_step", [0.0, DT])
def test_other_scalar_types(time_step):
    system = CanonicalSystem(tau=TAU, time_step=time_step)
    autodiff, symbolic = system.ToAutoDiffXd(), system.ToSymbolic()
    assert isinstance(autodiff, CanonicalSystem_[AutoDiffXd]) and isinstance(symbolic, CanonicalSystem_[Expression])
    context = symbolic.CreateDefaultContext()
    s = Variable("s")
    if time_step:
        context.SetDiscreteState([Expression(s)])
        after = symbolic.EvalUniquePeriodicDiscreteUpdate(context).value()[0]
        assert after.Evaluate({s: 0.5}) == pytest.approx(0.5 * phase_at(DT, TAU))
    else:
        context.SetContinuousState([Expression(s)])
        rate = symbolic.EvalTimeDerivatives(context)[0]
        assert rate.Differentiate(s).Evaluate({s: 0.5}) == pytest.approx(-np.log(100.0) / TAU)
