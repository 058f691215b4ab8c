"""Who moves when the links are made right: any positive weights keep the bands, and uncertainty gives the best ones."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drake_blfdmp.demonstration.modelled_person import hold_and_place
from drake_blfdmp.errors import SkillError
from drake_blfdmp.skill.bands import make_bands
from drake_blfdmp.skill.barrier import barrier_derivative, barrier_function, normalised_error
from drake_blfdmp.skill.geometry import link_states
from drake_blfdmp.skill.laws import LAWS, default
from drake_blfdmp.skill.laws.primitive import Primitive
from drake_blfdmp.skill.learning import learn_skill
from drake_blfdmp.skill.profiles import HandDistance
from drake_blfdmp.skill.reshaper import DEFAULT_MOBILITY, MOST_UNEQUAL, mobility_from_uncertainty, reshape
from drake_blfdmp.skill.rollout import roll_out
from drake_blfdmp.skill.sampled import Gains

T, X = hold_and_place()
SKILL = learn_skill(T, X)
HANDS_CLOSE = HandDistance(0.37, 0.276, 1.6, 5.6, 0.9)
GAINS = Gains()

seeds = st.integers(0, 2**32 - 1)
mobilities = st.lists(st.floats(-3.0, 3.0), min_size=6, max_size=6).map(lambda exponents: 10.0 ** np.array(exponents))
"""Six positive weights, up to a million times apart."""


def weighed(mobility):
    return learn_skill(T, X, mobility=np.asarray(mobility))


@given(seed=seeds, mobility=mobilities)
def test_the_barrier_falls_as_the_law_promises_whatever_the_weights(seed, mobility):
    """V' along the coupled motion, by a step of the true second-order motion, is the law's: negative off the origin."""
    rng = np.random.default_rng(seed)
    x = SKILL.start + 0.02 * rng.normal(size=(6, 3))
    velocity, nominal = (scale * rng.normal(size=(6, 3)) for scale in (0.1, 2.0))
    bands = make_bands(0.22, 0.28, HANDS_CLOSE).opened_to(x)
    t = float(rng.uniform(0.0, 0.02))
    coupling = default(x, velocity, nominal, 0.0, bands.evaluate(t), Primitive(8.0, 80.0), GAINS, mobility)

    def errors(s):
        moved, speed = x + s * velocity + 0.5 * s**2 * (nominal + coupling), velocity + s * (nominal + coupling)
        rho, rho_dot, _, _ = link_states(moved, speed)
        return normalised_error(rho, rho_dot, bands.evaluate(t + s))

    xi, xi_dot = errors(0.0)
    if np.abs(xi).max() > 0.95:
        return
    promised = barrier_derivative(xi, xi_dot, GAINS.k_1, GAINS.k_2)
    h = 1e-6
    numeric = (barrier_function(*errors(h), GAINS.k_1) - barrier_function(*errors(-h), GAINS.k_1)) / (2 * h)
    np.testing.assert_allclose(numeric, promised, rtol=1e-3, atol=1e-3 * (1.0 + np.abs(promised).max()))
    assert (promised <= 0.0).all()


@settings(max_examples=6, deadline=None)
@given(seed=seeds, exponents=st.lists(st.floats(-1.0, 1.0), min_size=6, max_size=6))
def test_no_link_leaves_its_band_with_any_weights_a_hundred_times_apart(seed, exponents):
    rng = np.random.default_rng(seed)
    start = SKILL.start + 0.03 * rng.normal(size=(6, 6, 3))
    goal = SKILL.goal + 0.05 * rng.normal(size=(6, 6, 3))
    bands = make_bands(0.22, 0.28, HANDS_CLOSE).opened_to(start)
    skill = weighed(10.0 ** np.array(exponents))
    rollout = roll_out(skill, time_step=0.004, duration=4.0, bands=bands, start=start, goal=goal)
    assert rollout.margins.min() > 0.0


@given(scale=st.floats(1e-3, 1e3), seed=seeds)
def test_only_the_ratios_count(scale, seed):
    rng = np.random.default_rng(seed)
    x, velocity, nominal = (rng.normal(size=(6, 3)) * size for size in (0.3, 1.0, 3.0))
    demanded, mobility = 10.0 * rng.normal(size=5), rng.uniform(0.1, 2.0, 6)
    one, other = (reshape(x, velocity, nominal, demanded, m) for m in (mobility, scale * mobility))
    np.testing.assert_allclose(one, other, rtol=1e-9, atol=1e-9 * np.abs(one).max())


@given(seed=seeds)
def test_squared_uncertainties_leave_the_least_variance(seed):
    """Points measured with independent errors, links known: what is left of the errors, for several weights."""
    rng = np.random.default_rng(seed)
    x, still = rng.normal(size=(6, 3)), np.zeros((6, 3))
    sigma = rng.uniform(0.01, 0.025, 6)
    covariance = np.diag(np.repeat(sigma**2, 3))

    def variance(mobility):
        """Trace of what is left of the errors' covariance when the links are made right, to first order."""
        kept = np.stack(
            [(e + reshape(x, still, e, np.zeros(5), mobility)).ravel() for e in np.eye(18).reshape(18, 6, 3)]
        )
        return np.trace(kept.T @ covariance @ kept)

    best = variance(mobility_from_uncertainty(sigma))
    for other in (DEFAULT_MOBILITY, np.ones(6), rng.uniform(0.1, 2.0, 6), 1.0 / sigma**2):
        assert best <= variance(other) * (1.0 + 1e-9)


def test_mobility_is_the_squared_uncertainty_over_its_geometric_mean():
    sigma = np.array([0.01, 0.02, 0.03, 0.012, 0.02, 0.025])
    mobility = mobility_from_uncertainty(sigma)
    np.testing.assert_allclose(mobility, sigma**2 / np.exp(np.mean(np.log(sigma**2))))
    np.testing.assert_allclose(mobility_from_uncertainty(7.0 * sigma), mobility)
    np.testing.assert_allclose(mobility_from_uncertainty(np.stack([sigma, sigma[::-1]]))[1], mobility[::-1])


@given(sigma=st.lists(st.floats(0.0, 1.0), min_size=6, max_size=6))
def test_mobility_stays_in_its_range_even_without_error(sigma):
    mobility = mobility_from_uncertainty(sigma)
    assert (mobility >= 1.0 / MOST_UNEQUAL).all() and (mobility <= MOST_UNEQUAL).all()
    if not any(sigma):
        np.testing.assert_allclose(mobility, 1.0)


def test_errors_too_small_to_mean_anything_are_all_alike():
    np.testing.assert_allclose(mobility_from_uncertainty([1e-9, 1e-4, 1e-6, 1e-5, 0.0, 9e-4]), 1.0)


@pytest.mark.parametrize("sigma", [[0.01] * 5, [0.01] * 5 + [-0.01], [0.01] * 5 + [np.nan], 0.01])
def test_an_uncertainty_that_is_none_is_refused(sigma):
    with pytest.raises(SkillError, match="6 standard deviations"):
        mobility_from_uncertainty(sigma)


@pytest.mark.parametrize("law", LAWS)
def test_only_the_default_law_has_weights(law):
    rng = np.random.default_rng(0)
    start = SKILL.start + 0.02 * rng.normal(size=(6, 3))
    bands = make_bands(0.22, 0.28, HANDS_CLOSE).opened_to(start)
    plain, other = (
        roll_out(skill, time_step=0.004, duration=0.05, bands=bands, law=LAWS[law], start=start).x
        for skill in (SKILL, weighed([1.0, 1.0, 1.0, 2.0, 0.5, 0.1]))
    )
    assert np.array_equal(plain, other) == (law != "default")


def test_the_laws_own_weights_given_are_the_laws_own():
    bands = make_bands(0.22, 0.28, HANDS_CLOSE).opened_to(SKILL.start)
    one, other = (
        roll_out(skill, time_step=0.004, duration=1.0, bands=bands).x for skill in (SKILL, weighed(DEFAULT_MOBILITY))
    )
    np.testing.assert_array_equal(one, other)


def test_a_point_that_hardly_gives_way_stays_where_the_demonstration_has_it():
    rng = np.random.default_rng(1)
    start = SKILL.start + 0.02 * rng.normal(size=(6, 3))
    bands = make_bands(0.22, 0.28, HANDS_CLOSE).opened_to(start)
    free = roll_out(SKILL, time_step=0.004, start=start).x

    def moved(mobility):
        coupled = roll_out(weighed(mobility), time_step=0.004, bands=bands, start=start).x
        return np.sqrt(np.mean(np.sum((coupled - free) ** 2, axis=-1), axis=0))

    equal, stiff = moved(np.ones(6)), moved([1.0, 1.0, 0.01, 1.0, 1.0, 1.0])
    assert stiff[2] < 0.1 * equal[2] and stiff[5] > equal[5]  # The other hand does it.


@pytest.mark.parametrize("mobility", [[1.0] * 5, [1.0] * 5 + [0.0], [1.0] * 5 + [-1.0], [1.0] * 5 + [np.inf]])
def test_weights_that_are_none_are_refused(mobility):
    with pytest.raises(SkillError, match="mobility must be 6 positive numbers"):
        weighed(mobility)
