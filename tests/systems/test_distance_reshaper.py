import numpy as np
import pytest
from pydrake.autodiffutils import AutoDiffXd
from pydrake.symbolic import Expression

from drake_blfdmp.skill.reshaper import DEFAULT_MOBILITY, reshape, reshape_limited
from drake_blfdmp.systems.distance_reshaper import DistanceReshaper, DistanceReshaper_

_rng = np.random.default_rng(0)
X, VELOCITY, NOMINAL = (_rng.normal(size=(6, 3)) * scale for scale in (0.3, 0.5, 2.0))
DEMANDED = _rng.normal(size=5) * 5.0
INPUTS = {
    "position": X.reshape(18),
    "velocity": VELOCITY.reshape(18),
    "nominal_acceleration": NOMINAL.reshape(18),
    "link_acceleration": DEMANDED,
}


def prepared(**options):
    system = DistanceReshaper(**options)
    context = system.CreateDefaultContext()
    for name, value in INPUTS.items():
        system.GetInputPort(name).FixValue(context, value)
    return system, context


def outputs(system, context):
    return system.GetOutputPort("coupling_acceleration").Eval(context), system.GetOutputPort("widening").Eval(context)


def test_ports():
    system = DistanceReshaper()
    inputs = {
        system.get_input_port(i).get_name(): system.get_input_port(i).size() for i in range(system.num_input_ports())
    }
    assert inputs == {"position": 18, "velocity": 18, "nominal_acceleration": 18, "link_acceleration": 5}
    sizes = {system.get_output_port(i).get_name(): system.get_output_port(i).size() for i in range(2)}
    assert sizes == {"coupling_acceleration": 18, "widening": 1}


@pytest.mark.parametrize("mobility", [DEFAULT_MOBILITY, np.array([1.0, 2.0, 3.0, 0.1, 0.2, 0.3])])
def test_the_coupling_is_the_weighted_least_change(mobility):
    coupling, widening = outputs(*prepared(mobility=mobility))
    np.testing.assert_allclose(coupling, reshape(X, VELOCITY, NOMINAL, DEMANDED, mobility).reshape(18), rtol=1e-12)
    assert widening[0] == 0.0


def test_a_limit_that_binds_widens_the_hands_band():
    limit = 0.8 * np.linalg.norm(NOMINAL + reshape(X, VELOCITY, NOMINAL, DEMANDED), axis=-1).max()
    want, given_up = reshape_limited(X, VELOCITY, NOMINAL, DEMANDED, limit)
    coupling, widening = outputs(*prepared(acceleration_limit=limit, law_stiffness=200.0))
    np.testing.assert_allclose(coupling, want.reshape(18), rtol=1e-12)
    assert widening[0] == pytest.approx(given_up / 200.0) and widening[0] > 0.0


def test_a_limit_that_does_not_bind_changes_nothing():
    coupling, widening = outputs(*prepared(acceleration_limit=1e4))
    np.testing.assert_allclose(coupling, outputs(*prepared())[0], rtol=1e-10)
    assert widening[0] == 0.0


def test_other_scalar_types_give_the_same_numbers():
    system, context = prepared()
    want = outputs(system, context)[0]
    for scalar, other in ((AutoDiffXd, system.ToAutoDiffXd()), (Expression, system.ToSymbolic())):
        assert isinstance(other, DistanceReshaper_[scalar])
        copy = other.CreateDefaultContext()
        other.FixInputPortsFrom(system, context, copy)
        coupling, widening = outputs(other, copy)
        values = [a.value() if scalar is AutoDiffXd else a.Evaluate() for a in coupling]
        np.testing.assert_allclose(values, want, rtol=1e-9)
        assert len(widening) == 1
