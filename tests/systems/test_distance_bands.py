import numpy as np
import pytest
from pydrake.autodiffutils import AutoDiffXd
from pydrake.symbolic import Expression, Variable

from drake_blfdmp.errors import SkillError
from drake_blfdmp.skill.bands import make_bands
from drake_blfdmp.skill.canonical import phase_at
from drake_blfdmp.skill.profiles import HandDistance, RecordedDistance
from drake_blfdmp.systems.distance_bands import DistanceBands, DistanceBands_

TAU = 6.0
BANDS = make_bands(0.22, 0.28, HandDistance(0.37, 0.27, 1.0, 4.0, 0.8))


def evaluated(system, t):
    context = system.CreateDefaultContext()
    system.GetInputPort("phase").FixValue(context, phase_at(t, TAU))
    return system.GetOutputPort("bands").Eval(context).reshape(6, 5)


def test_ports():
    system = DistanceBands(bands=BANDS, tau=TAU)
    assert system.num_input_ports() == 1 and system.GetInputPort("phase").size() == 1
    assert system.num_output_ports() == 1 and system.GetOutputPort("bands").size() == 30


@pytest.mark.parametrize("t", [0.0, 1.3, 4.5, 6.0])
def test_the_bands_are_those_of_the_time_that_belongs_to_the_phase(t):
    np.testing.assert_allclose(evaluated(DistanceBands(bands=BANDS, tau=TAU), t), BANDS.evaluate(t), atol=1e-9)


def test_the_autodiff_gradient_is_the_band_rate_per_phase_rate():
    system = DistanceBands(bands=BANDS, tau=TAU).ToAutoDiffXd()
    assert isinstance(system, DistanceBands_[AutoDiffXd])
    context = system.CreateDefaultContext()
    s = phase_at(1.3, TAU)
    system.GetInputPort("phase").FixValue(context, np.array([AutoDiffXd(s, [1.0])]))
    bands = system.GetOutputPort("bands").Eval(context).reshape(6, 5)
    per_phase = np.array([[b.derivatives()[0] if b.derivatives().size else 0.0 for b in row] for row in bands[:2]])
    s_dot = -np.log(100.0) / TAU * s
    np.testing.assert_allclose(per_phase * s_dot, BANDS.evaluate(1.3)[2:4], atol=1e-9)


def test_the_symbolic_bands_evaluate_to_the_same():
    system = DistanceBands(bands=BANDS, tau=TAU).ToSymbolic()
    s = Variable("s")
    context = system.CreateDefaultContext()
    system.GetInputPort("phase").FixValue(context, np.array([Expression(s)]))
    symbolic = system.GetOutputPort("bands").Eval(context)
    for t in (0.5, 1.4, 3.0, 4.3):
        values = np.array([b.Evaluate({s: phase_at(t, TAU)}) for b in symbolic]).reshape(6, 5)
        np.testing.assert_allclose(values, BANDS.evaluate(t), atol=1e-9)


TIMES = np.linspace(0.0, TAU, 300)
RECORDED = make_bands(0.22, 0.28, RecordedDistance(TIMES, 0.4 + 0.1 * np.sin(np.pi * TIMES / TAU) ** 4))


@pytest.mark.parametrize("t", [0.0, 1.3, 5.9, 6.0])
def test_the_bands_may_follow_a_recorded_distance(t):
    np.testing.assert_allclose(evaluated(DistanceBands(bands=RECORDED, tau=TAU), t), RECORDED.evaluate(t), atol=1e-9)


def test_the_gradient_of_recorded_bands_is_their_rate():
    context = (system := DistanceBands(bands=RECORDED, tau=TAU).ToAutoDiffXd()).CreateDefaultContext()
    s = phase_at(1.3, TAU)
    system.GetInputPort("phase").FixValue(context, np.array([AutoDiffXd(s, [1.0])]))
    bands = system.GetOutputPort("bands").Eval(context).reshape(6, 5)
    per_phase = np.array([b.derivatives()[0] for b in bands[:2, 2]])
    s_dot = -np.log(100.0) / TAU * s
    np.testing.assert_allclose(per_phase * s_dot, RECORDED.evaluate(1.3)[2:4, 2], atol=1e-9)


def test_recorded_bands_refuse_symbols_in_one_line_and_drake_needs_none_to_know_what_depends_on_what():
    system = DistanceBands(bands=RECORDED, tau=TAU)
    assert system.HasDirectFeedthrough(0, 0)
    symbolic = system.ToSymbolic()
    context = symbolic.CreateDefaultContext()
    symbolic.GetInputPort("phase").FixValue(context, np.array([Expression(Variable("s"))]))
    with pytest.raises(SkillError, match=r"^recorded distance: [^\n]* has no symbolic form; [^\n]*$"):
        symbolic.GetOutputPort("bands").Eval(context)
