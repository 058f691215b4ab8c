"""Section 2 of the paper's law, its misprints repaired: (7)-(9) by symbolic differentiation, and its theorem."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydrake.symbolic import Expression, Variable
from scipy.integrate import solve_ivp

from drake_blfdmp.skill.laws.follower import (
    PublishedGains,
    barrier_derivative,
    barrier_function,
    barrier_gain,
    follower_acceleration,
    limited_barrier_gain,
    virtual_control,
)

NAMES = ("x_own", "v_own", "x_p", "xd_p", "lo", "hi", "k_z", "d_z", "k_2", "tau", "z_1", "z_2", "room")
V = {name: Variable(name) for name in NAMES}
E = {name: Expression(variable) for name, variable in V.items()}
GAINS = PublishedGains(k_z=E["k_z"], d_z=E["d_z"], k_2=E["k_2"])


def same(a, b):
    """Whether two expressions are one polynomial."""
    return (a - b).Expand().EqualTo(Expression(0.0))


def numbers(seed):
    """Random values inside the band."""
    rng = np.random.default_rng(seed)
    lo = rng.uniform(-1.0, 0.5)
    hi = lo + rng.uniform(0.1, 2.0)
    env = {V[name]: rng.uniform(-2.0, 2.0) for name in NAMES}
    env |= {V[name]: rng.uniform(0.2, 5.0) for name in ("k_z", "d_z", "k_2", "tau")}
    env |= {V["lo"]: lo, V["hi"]: hi, V["z_1"]: lo + rng.uniform(0.05, 0.95) * (hi - lo)}
    return env


def test_alpha_2_is_the_one_of_9():
    """d_z alpha_2 = tau d_z x_p' + z_1 - (hi + lo) / 2, as (9) prints it."""
    alpha_2 = virtual_control(E["z_1"], E["lo"], E["hi"], E["xd_p"], E["tau"], GAINS)
    printed = E["tau"] * E["d_z"] * E["xd_p"] + E["z_1"] - 0.5 * (E["hi"] + E["lo"])
    for seed in range(50):
        env = numbers(seed)
        assert E["d_z"].Evaluate(env) * alpha_2.Evaluate(env) == pytest.approx(printed.Evaluate(env), rel=1e-12)


def test_k_n_is_the_one_of_9():
    k_n = barrier_gain(E["z_1"], E["lo"], E["hi"], E["tau"], GAINS)
    for seed in range(50):
        env = numbers(seed)
        v = {name: env[V[name]] for name in NAMES}
        room = (v["hi"] - v["z_1"]) * (v["z_1"] - v["lo"])
        assert k_n.Evaluate(env) * 4 * v["tau"] * v["d_z"] ** 2 * room == pytest.approx(v["k_z"], rel=1e-12)


def test_the_derivative_of_the_barrier_is_minus_a_square_with_the_half():
    """tau V' = -(k_z / (d_z D)) (z_1 - mid - z_2 / 2)^2 - tau d_z k_2 z_2^2, identically, with 1 / D as a variable."""
    mid = 0.5 * (E["hi"] + E["lo"])
    over_room = E["room"]  # Stands for 1 / ((hi - z_1)(z_1 - lo)), so that both sides are polynomials in it ...
    # ... and in 1 / d_z, for which a variable q with q d_z = 1 is put in: v_own = alpha_2 - q z_2.
    q = Expression(Variable("q"))
    z_1_dot_tau = E["k_z"] * (-q * (E["z_1"] - mid) + q * E["z_2"])  # tau k_z (x_p' - v_own / tau)
    z_2_dot_tau = -(E["k_z"] * q * over_room * 0.25 + E["tau"] * E["d_z"] * E["k_2"]) * E["z_2"]
    v_dot_tau = (E["z_1"] - mid) * over_room * z_1_dot_tau + E["z_2"] * z_2_dot_tau
    square = E["z_1"] - mid - 0.5 * E["z_2"]
    claimed = -E["k_z"] * q * over_room * square * square - E["tau"] * E["d_z"] * E["k_2"] * E["z_2"] * E["z_2"]
    assert same(v_dot_tau, claimed)
    # The paper's last line of the proof, without the half, is another function.
    printed_square = E["z_1"] - 2.0 * mid - E["z_2"]
    assert not same(v_dot_tau, -E["k_z"] * q * over_room * printed_square * printed_square)


def test_the_packages_functions_are_that_derivative():
    """V of (7) differentiated along z_1', z_2' of the closed loop, against `barrier_derivative`."""
    value = barrier_function(E["z_1"], E["z_2"], E["lo"], E["hi"])
    k_n = barrier_gain(E["z_1"], E["lo"], E["hi"], E["tau"], GAINS)
    error = E["z_1"] - 0.5 * (E["lo"] + E["hi"])
    z_1_dot = -E["k_z"] / (E["tau"] * E["d_z"]) * (error - E["z_2"])
    z_2_dot = -E["d_z"] * (k_n + E["k_2"]) * E["z_2"]
    v_dot = value.Differentiate(V["z_1"]) * z_1_dot + value.Differentiate(V["z_2"]) * z_2_dot
    claimed = barrier_derivative(E["z_1"], E["z_2"], E["lo"], E["hi"], E["tau"], GAINS)
    for seed in range(200):
        env = numbers(seed)
        assert v_dot.Evaluate(env) == pytest.approx(claimed.Evaluate(env), rel=1e-9, abs=1e-9)


def closed_loop(gains, tau=0.7, wrong_sign=False):
    """(t, state) -> (x', x'') of an own point that follows a partner at sin(2 t), distance 0.3, half width 0.05."""

    def rates(t, state):
        x, velocity = state
        partner = np.array([np.sin(2 * t), 2 * np.cos(2 * t), -4 * np.sin(2 * t)])
        middle = partner[0] - 0.3
        shown = 2 * middle - x if wrong_sign else x  # Mirrored in the middle: the error with the other sign.
        acceleration = follower_acceleration(
            shown, velocity, middle - 0.05, middle + 0.05, partner[1], partner[2], tau, gains
        )
        return [velocity, acceleration]

    return rates


def z_of(t, x, velocity, gains, tau=0.7):
    z_1 = gains.k_z * (np.sin(2 * t) - x)
    lo, hi = gains.k_z * 0.25, gains.k_z * 0.35
    return z_1, gains.d_z * (virtual_control(z_1, lo, hi, 2 * np.cos(2 * t), tau, gains) - tau * velocity), lo, hi


@given(
    k_z=st.floats(1.0, 20.0),
    d_z=st.floats(0.3, 3.0),
    k_2=st.sampled_from([0.0, 3.0]),
    where=st.floats(-0.8, 0.8),
    speed=st.floats(-0.3, 0.3),
)
def test_the_acceleration_is_the_laws(k_z, d_z, k_2, where, speed):
    """With the acceleration, z_2' = -d_z (k_n + k_2) z_2: by finite differences of z_2 along the motion."""
    gains = PublishedGains(k_z, d_z, k_2, largest_rate=np.inf)
    t, x, velocity = 0.4, np.sin(0.8) - 0.3 + 0.05 * where, 2 * np.cos(0.8) + speed
    a = closed_loop(gains)(t, (x, velocity))[1]
    h = 1e-5
    ahead, behind = (z_of(t + s, x + s * velocity + 0.5 * s * s * a, velocity + s * a, gains)[1] for s in (h, -h))
    z_1, z_2, lo, hi = z_of(t, x, velocity, gains)
    k_n = barrier_gain(z_1, lo, hi, 0.7, gains)
    expected = -d_z * (k_n + k_2) * z_2
    assert (ahead - behind) / (2 * h) == pytest.approx(expected, rel=1e-4, abs=1e-4 * (1 + abs(a)))


def test_a_constant_band_is_kept_and_v_never_grows():
    """Theorem 1, in continuous time: the distance's bounds are constant although the partner moves."""
    gains = PublishedGains(5.0, 1.0, 0.0, np.inf)
    times = np.linspace(0.0, 4.0, 401)
    start = [-0.3 + 0.045, 2.0]
    motion = solve_ivp(closed_loop(gains), (0.0, 4.0), start, t_eval=times, rtol=1e-9, atol=1e-11)
    z_1, z_2, lo, hi = z_of(motion.t, *motion.y, gains)
    assert np.all((z_1 > lo) & (z_1 < hi))
    assert np.all(np.diff(barrier_function(z_1, z_2, lo, hi)) < 1e-9)
    assert abs(z_1[-1] - 0.5 * (lo + hi)) < 0.02 * abs(z_1[0] - 0.5 * (lo + hi))


def test_with_the_other_sign_of_z_1_the_band_is_left():
    gains = PublishedGains(5.0, 1.0, 0.0, 1e3)
    motion = solve_ivp(closed_loop(gains, wrong_sign=True), (0.0, 1.0), [-0.29, 2.0], rtol=1e-8, atol=1e-10)
    assert np.abs(np.sin(2 * motion.t) - motion.y[0] - 0.3).max() > 0.05


def test_semi_definite_without_and_definite_with_further_damping():
    """V' vanishes on z_1 - mid = z_2 / 2 off the origin; k_2 takes that away."""
    still = barrier_derivative(0.2, 0.4, -1.0, 1.0, 2.0, PublishedGains(1.0, 1.0, 0.0))
    damped = barrier_derivative(0.2, 0.4, -1.0, 1.0, 2.0, PublishedGains(1.0, 1.0, 3.0))
    assert still == 0.0
    assert damped == pytest.approx(-3.0 * 0.16)


def test_the_gain_is_limited_at_the_edge_and_outside():
    gains = PublishedGains(1.0, 2.0, 0.0, largest_rate=10.0)
    z_1 = np.array([0.0, 0.999999, 1.0, 1.5, -7.0])
    k_n = limited_barrier_gain(z_1, -1.0, 1.0, 0.5, gains)
    assert k_n[0] == pytest.approx(1.0 / (4 * 0.5 * 4.0))
    np.testing.assert_array_equal(k_n[1:], 5.0)
