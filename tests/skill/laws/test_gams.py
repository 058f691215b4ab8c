"""The coupling of Gams et al.: against its own two equations, its poles and its resting distance."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from drake_blfdmp.skeleton import HANDS
from drake_blfdmp.skill.bands import make_bands
from drake_blfdmp.skill.laws.gams import GamsGains, characteristic, gams, resting_distance
from drake_blfdmp.skill.laws.primitive import Primitive
from drake_blfdmp.skill.profiles import ConstantDistance, HandDistance

TAU, ALPHA, BETA = 1.5, 48.0, 12.0


def on_a_line(left, right):
    """Points whose wrists are at these x coordinates; the others out of the way."""
    x = np.arange(18.0).reshape(6, 3)
    x[2], x[5] = [left, 0.0, 0.0], [right, 0.0, 0.0]
    return x


def coupling(y, y_dot, bands, gains):
    """The right and the left hand's coupling acceleration on one axis."""
    velocity = np.zeros((6, 3))
    velocity[5, 0], velocity[2, 0] = y_dot
    out = gams(on_a_line(y[1], y[0]), velocity, None, None, bands, Primitive(TAU, ALPHA), gains)
    return out[5, 0], out[2, 0]


@pytest.mark.parametrize("gains", [GamsGains(100.0, 0.0), GamsGains(20.0, 3.0), GamsGains(5.0, 1.0, 0.7, 0.2)])
def test_it_is_the_articles_two_equations(gains):
    """Tau z' = alpha (beta (g - y) - z) + f + c_2 C', tau y' = z + C, integrated as printed, beside y'' as here."""
    profile = HandDistance(0.4, 0.3, 0.2, 1.0, 0.5)
    bands = make_bands(0.22, 0.28, profile)
    goals, y_0 = np.array([0.25, -0.2]), np.array([0.21, -0.24])
    sign_lf = np.array([gains.lf_1, -gains.lf_2])

    def article(t, state):
        y, z = state[:2], state[2:]
        d, d_rate, _ = profile.evaluate(t)
        c = gains.c_k * (d - (y[0] - y[1])) * sign_lf
        y_dot = (z + c) / TAU
        c_dot = gains.c_k * (d_rate - (y_dot[0] - y_dot[1])) * sign_lf
        f = 30.0 * np.sin(3.0 * t) * np.array([1.0, -0.5])
        return np.concatenate([y_dot, (ALPHA * (BETA * (goals - y) - z) + f + gains.c_2 * c_dot) / TAU])

    def ours(t, state):
        y, y_dot = state[:2], state[2:]
        f = 30.0 * np.sin(3.0 * t) * np.array([1.0, -0.5])
        nominal = (ALPHA * (BETA * (goals - y) - TAU * y_dot) + f) / TAU**2
        return np.concatenate([y_dot, nominal + coupling(y, y_dot, bands.evaluate(t), gains)])

    times = np.linspace(0.0, 2.0, 41)
    options = {"t_eval": times, "rtol": 1e-9, "atol": 1e-11}
    c_0 = gains.c_k * (0.4 - 0.45) * sign_lf
    a = solve_ivp(article, (0.0, 2.0), np.concatenate([y_0, -c_0]), **options)
    b = solve_ivp(ours, (0.0, 2.0), np.concatenate([y_0, [0.0, 0.0]]), **options)
    np.testing.assert_allclose(a.y[:2], b.y[:2], atol=1e-7)


def test_the_resting_distance_of_the_paper():
    assert resting_distance(0.3, 0.4, 12.0, 100.0) == pytest.approx(0.30566, abs=5e-6)


def test_at_the_resting_distance_everything_is_at_rest():
    gains = GamsGains(100.0, 2.0)
    rest = resting_distance(0.3, 0.4, BETA, gains.c_k)
    y = 0.5 * np.array([rest, -rest])
    pull = ALPHA * BETA * (np.array([0.2, -0.2]) - y) / TAU**2
    bands = make_bands(0.22, 0.28, ConstantDistance(0.3)).evaluate(0.0)
    np.testing.assert_allclose(coupling(y, (0.0, 0.0), bands, gains), -pull, rtol=1e-12)


@pytest.mark.parametrize("gains", [GamsGains(100.0, 0.0), GamsGains(20.0, 3.0)])
def test_the_distances_poles(gains):
    """The coefficients of the polynomial are what distance and rate do to the distance's acceleration."""
    bands = make_bands(0.22, 0.28, ConstantDistance(0.3)).evaluate(0.0)
    one, a_1, a_0 = characteristic(TAU, ALPHA, BETA, gains)

    def distance_acceleration(distance, rate):
        y, y_dot = 0.5 * np.array([distance, -distance]), 0.5 * np.array([rate, -rate])
        nominal = (ALPHA * (-BETA * y - TAU * y_dot)) / TAU**2
        total = nominal + coupling(y, y_dot, bands, gains)
        return total[0] - total[1]

    assert one == 1.0
    at = distance_acceleration(0.3, 0.0)
    assert (distance_acceleration(0.31, 0.0) - at) / 0.01 == pytest.approx(-a_0)
    assert (distance_acceleration(0.3, 0.2) - at) / 0.2 == pytest.approx(-a_1)


def test_only_the_hands_are_coupled_and_turning_hands_too():
    """In space: along the line the law of one axis; C' also turns with the line, by finite differences."""
    rng = np.random.default_rng(0)
    x, velocity = on_a_line(-0.2, 0.2) + 0.05 * rng.normal(size=(6, 3)), rng.normal(size=(6, 3))
    gains, bands = GamsGains(40.0, 2.0), make_bands(0.22, 0.28, HandDistance(0.4, 0.3, 0.0, 2.0, 0.5)).evaluate(0.2)
    out = gams(x, velocity, None, None, bands, Primitive(TAU, ALPHA), gains)
    assert np.all(out[[0, 1, 3, 4]] == 0.0)
    np.testing.assert_allclose(out[5], -out[2])

    def force(t):
        r = (x[5] + t * velocity[5]) - (x[2] + t * velocity[2])
        desired = 0.5 * (bands[0, HANDS] + bands[1, HANDS]) + t * 0.5 * (bands[2, HANDS] + bands[3, HANDS])
        return gains.c_k * (desired - np.linalg.norm(r)) * r / np.linalg.norm(r)

    rate = (force(1e-6) - force(-1e-6)) / 2e-6
    np.testing.assert_allclose(out[5], (ALPHA * force(0.0) + (gains.c_2 + TAU) * rate) / TAU**2, rtol=1e-6)


def test_it_broadcasts_over_batches_of_states_gains_and_durations():
    rng = np.random.default_rng(1)
    x, velocity = on_a_line(-0.2, 0.2) + 0.05 * rng.normal(size=(5, 6, 3)), rng.normal(size=(5, 6, 3))
    c_k, tau = rng.uniform(10, 99, (5, 1, 1)), rng.uniform(1, 3, (5, 1, 1))
    bands = np.stack([make_bands(0.22, 0.28, ConstantDistance(d)).evaluate(0.1) for d in (0.2, 0.3, 0.4, 0.5, 0.6)])
    together = gams(x, velocity, None, None, bands, Primitive(tau, ALPHA), GamsGains(c_k, 1.0))
    for i in range(5):
        primitive = Primitive(float(tau[i, 0, 0]), ALPHA)
        alone = gams(x[i], velocity[i], None, None, bands[i], primitive, GamsGains(float(c_k[i, 0, 0]), 1.0))
        np.testing.assert_allclose(together[i], alone, rtol=1e-12)
