from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drake_blfdmp.errors import ScenarioError
from drake_blfdmp.skeleton import HANDS
from drake_blfdmp.skill.bands import LOWER, UPPER, Bands, make_bands
from drake_blfdmp.skill.geometry import link_lengths
from drake_blfdmp.skill.profiles import ConstantDistance, HandDistance

BANDS = make_bands(0.22, 0.28, HandDistance(0.37, 0.27, 1.0, 4.0, 0.8))


def test_the_papers_bands():
    """(13) and (20): sigma = 0.02 exp(-k / 10) + 0.01 m at sample k of 30 a second for the hands, 0.01 m for bones."""
    bands = make_bands(0.22, 0.28, ConstantDistance(0.30))
    for k in (0, 3, 30):
        at = bands.evaluate(k / 30.0)
        hands = 0.02 * np.exp(-k / 10) + 0.01
        np.testing.assert_allclose(at[UPPER], [0.23, 0.29, 0.30 + hands, 0.29, 0.23], atol=1e-15)
        np.testing.assert_allclose(at[LOWER], [0.21, 0.27, 0.30 - hands, 0.27, 0.21], atol=1e-15)


def test_the_derivatives_are_those_of_the_bands():
    bands = BANDS.opened_to(np.arange(18.0).reshape(6, 3) * 0.05)
    t, h = np.linspace(0.1, 6.0, 101), 1e-5
    at, before, after = bands.evaluate(t), bands.evaluate(t - h), bands.evaluate(t + h)
    assert at.shape == (101, 6, 5)
    np.testing.assert_allclose(at[:, 2:4], (after - before)[:, 0:2] / (2 * h), atol=1e-7)
    np.testing.assert_allclose(at[:, 4:6], (after - before)[:, 2:4] / (2 * h), atol=1e-5)


points = st.lists(st.floats(-1.0, 1.0), min_size=18, max_size=18).map(lambda values: np.array(values).reshape(6, 3))


@given(x=points, filling=st.floats(0.05, 0.99))
def test_an_opened_funnel_holds_the_start_and_opens_no_further_than_needed(x, filling):
    bands = BANDS.opened_to(x, filling)
    at = bands.evaluate(0.0)
    middle, half = (at[UPPER] + at[LOWER]) / 2, (at[UPPER] - at[LOWER]) / 2
    filled = np.abs(link_lengths(x) - middle) / half
    assert np.all(filled <= filling + 1e-9)
    plain = BANDS.half_widths(0.0)[0]
    assert np.all(half >= plain - 1e-15)
    opened = half > plain + 1e-12
    np.testing.assert_allclose(filled[opened], filling, rtol=1e-6)
    np.testing.assert_array_equal(bands.paper().evaluate(0.7), BANDS.evaluate(0.7))


@given(x=points)
def test_an_opened_funnel_closes_to_the_final_width(x):
    at = BANDS.opened_to(x).evaluate(20.0)
    np.testing.assert_allclose(at[UPPER] - at[LOWER], 0.02, atol=1e-12)


def test_a_batch_of_starts_opens_a_batch_of_funnels():
    x = np.random.default_rng(0).normal(size=(7, 6, 3)) * 0.3
    together = BANDS.opened_to(x).evaluate(0.3)
    assert together.shape == (7, 6, 5)
    for one, start in zip(together, x, strict=True):
        np.testing.assert_array_equal(one, BANDS.opened_to(start).evaluate(0.3))


def test_every_member_of_a_batch_may_have_its_own_rate_and_its_own_hands():
    x = np.random.default_rng(0).normal(size=(3, 6, 3)) * 0.3
    rates, opens = np.array([0.5, 3.0, 9.0]), np.array([4.0, 5.0, 6.0])
    hands = HandDistance(0.37, 0.27, 1.0, opens, 0.8)
    together = replace(BANDS, rate=rates, hands=hands).opened_to(x).evaluate(4.3)
    assert together.shape == (3, 6, 5)
    for i, one in enumerate(together):
        alone = replace(BANDS, rate=rates[i], hands=replace(hands, open_s=opens[i])).opened_to(x[i])
        np.testing.assert_array_equal(one, alone.evaluate(4.3))


def test_the_hands_follow_their_profile_and_the_bones_do_not_move():
    d, rate, _ = BANDS.desired(np.array([1.4, 2.5]))
    np.testing.assert_allclose(d[:, HANDS], [0.32, 0.27], atol=1e-15)
    np.testing.assert_array_equal(np.delete(d, HANDS, axis=1), [[0.22, 0.28, 0.28, 0.22]] * 2)
    assert rate[0, HANDS] < 0 and not np.any(np.delete(rate, HANDS, axis=1))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"final": np.zeros(5)}, "must be positive"),
        ({"initial": np.full(5, 0.005)}, "must not grow"),
        ({"rate": 0.0}, "rate must be positive"),
        ({"rate": np.array([3.0, -1.0])}, "rate must be positive, not -1 1/s"),
    ],
)
def test_impossible_bands_are_refused(change, message):
    values = {
        "hands": ConstantDistance(0.3),
        "initial": np.full(5, 0.02),
        "final": np.full(5, 0.01),
    }
    with pytest.raises(ScenarioError, match=message):
        Bands(np.ones(5), **(values | change))
