import numpy as np
import pytest

from drake_blfdmp.skill.canonical import phase_at, phase_rate, time_at

REFERENCE = [
    1,
    0.63095734,
    0.39810717,
    0.25118864,
    0.15848932,
    0.1,
    0.06309573,
    0.03981072,
    0.02511886,
    0.01584893,
    0.01,
]


def test_the_phase_has_the_reference_values():
    np.testing.assert_allclose(phase_at(np.linspace(0.0, 1.0, 11), 1.0), REFERENCE, atol=5e-9)


@pytest.mark.parametrize("tau", [0.5, 1.0, 7.0])
def test_the_phase_solves_its_equation(tau):
    t, h = np.linspace(0.0, tau, 20), 1e-5 * tau
    numeric = (phase_at(t + h, tau) - phase_at(t - h, tau)) / (2 * h)
    np.testing.assert_allclose(phase_rate(phase_at(t, tau), tau), numeric, rtol=1e-8)


def test_time_is_the_inverse_of_the_phase():
    t = np.linspace(0.0, 9.0, 50)
    np.testing.assert_allclose(time_at(phase_at(t, 6.0, 3.0), 6.0, 3.0), t, atol=1e-12)
