import numpy as np
import pytest
from pydrake.autodiffutils import AutoDiffXd
from pydrake.symbolic import Expression

from drake_blfdmp.errors import ScenarioError
from drake_blfdmp.skeleton import HANDS
from drake_blfdmp.skill.bands import make_bands
from drake_blfdmp.skill.barrier import barrier_function, normalised_error
from drake_blfdmp.skill.geometry import link_states
from drake_blfdmp.skill.laws.default import link_acceleration
from drake_blfdmp.skill.profiles import HandDistance
from drake_blfdmp.skill.sampled import Gains
from drake_blfdmp.systems.blf_coupler import BlfCoupler, BlfCoupler_

GAINS = Gains(7.0, 25.0)
X = np.array(
    [[-0.18, 0, 1.4], [-0.25, 0.05, 1.19], [-0.17, 0.3, 1.1], [0.18, 0, 1.4], [0.26, 0.03, 1.2], [0.16, 0.28, 1.1]]
)
VELOCITY = np.random.default_rng(0).normal(size=(6, 3)) * 0.1
BANDS = make_bands(0.22, 0.28, HandDistance(0.37, 0.3, 1.0, 4.0, 0.8)).opened_to(X).evaluate(0.02)
INPUTS = {"position": X.reshape(18), "velocity": VELOCITY.reshape(18), "bands": BANDS.reshape(30)}


def prepared(**more):
    system = BlfCoupler(gains=GAINS)
    context = system.CreateDefaultContext()
    for name, value in (INPUTS | more).items():
        system.GetInputPort(name).FixValue(context, value)
    return system, context


def outputs(system, context):
    return [system.GetOutputPort(name).Eval(context) for name in ("link_acceleration", "barrier", "margin")]


def test_ports():
    system = BlfCoupler()
    inputs = {
        system.get_input_port(i).get_name(): system.get_input_port(i).size() for i in range(system.num_input_ports())
    }
    assert inputs == {"position": 18, "velocity": 18, "bands": 30, "measured_distance": 3}
    sizes = {system.get_output_port(i).get_name(): system.get_output_port(i).size() for i in range(3)}
    assert sizes == {"link_acceleration": 5, "barrier": 5, "margin": 5}


def test_the_outputs_are_those_of_the_law():
    rho, rho_dot, *_ = states = link_states(X, VELOCITY)
    demanded, (xi, xi_dot) = link_acceleration(states, BANDS, GAINS), normalised_error(rho, rho_dot, BANDS)
    assert np.all(np.abs(xi) < 1)
    want = [demanded, barrier_function(xi, xi_dot, GAINS.k_1), 1 - np.abs(xi)]
    for got, value in zip(outputs(*prepared()), want, strict=True):
        np.testing.assert_allclose(got, value, rtol=1e-12)


def test_a_measured_distance_takes_the_place_of_the_planned_one():
    rho, rho_dot, _, _ = link_states(X, VELOCITY)
    measured = np.array([rho[HANDS] + 0.004, -0.03, 0.0])
    plain, replaced = outputs(*prepared()), outputs(*prepared(measured_distance=measured))
    for a, b in zip(plain, replaced, strict=True):
        assert a[HANDS] != b[HANDS]
        np.testing.assert_array_equal(np.delete(a, HANDS), np.delete(b, HANDS))
    rho[HANDS], rho_dot[HANDS] = measured[:2]
    xi, xi_dot = normalised_error(rho, rho_dot, BANDS)
    np.testing.assert_allclose(replaced[1], barrier_function(xi, xi_dot, GAINS.k_1), rtol=1e-12)
    same = outputs(*prepared(measured_distance=[*(link_states(X, VELOCITY)[i][HANDS] for i in (0, 1)), 0.0]))
    for a, b in zip(plain, same, strict=True):
        np.testing.assert_array_equal(a, b)


def test_what_the_measured_distance_does_by_itself_is_not_demanded_of_the_plan():
    still, moving = (outputs(*prepared(measured_distance=[0.34, 0.02, a])) for a in (0.0, 0.7))
    np.testing.assert_allclose(still[0] - moving[0], 0.7 * np.eye(5)[HANDS], atol=1e-12)
    for a, b in zip(still[1:], moving[1:], strict=True):
        np.testing.assert_array_equal(a, b)


def test_the_margin_is_negative_outside_the_band():
    system, context = prepared(measured_distance=[0.8, 0.0, 0.0])
    margin = system.GetOutputPort("margin").Eval(context)
    assert margin[HANDS] < 0 < np.delete(margin, HANDS).min()


def test_gains_that_the_time_step_cannot_carry_are_refused():
    with pytest.raises(ScenarioError, match="use at most"):
        BlfCoupler(gains=Gains(20.0, 40.0), time_step=1 / 30)


def test_other_scalar_types_give_the_same_numbers():
    for more in ({}, {"measured_distance": np.array([0.33, 0.01, 0.2])}):
        system, context = prepared(**more)
        want = outputs(system, context)
        for scalar, other in ((AutoDiffXd, system.ToAutoDiffXd()), (Expression, system.ToSymbolic())):
            assert isinstance(other, BlfCoupler_[scalar])
            copy = other.CreateDefaultContext()
            other.FixInputPortsFrom(system, context, copy)
            for got, value in zip(outputs(other, copy), want, strict=True):
                numbers = [a.value() if scalar is AutoDiffXd else a.Evaluate() for a in got]
                np.testing.assert_allclose(numbers, value, rtol=1e-9)
