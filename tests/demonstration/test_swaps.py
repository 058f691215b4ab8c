"""Points under each other's names are swapped back, whichever two, wherever it begins and ends."""

from itertools import combinations

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from synthetic_carry import carry

from drake_blfdmp.demonstration.swaps import describe_swaps, find_exchanges, swap_back
from drake_blfdmp.skeleton import POINTS

T, X = carry()
ARMS = [3, 4, 5, 0, 1, 2]
FAR = [
    (a, b)
    for a, b in combinations(range(6), 2)
    if np.linalg.norm(X[:, a] - X[:, b], axis=-1).min() > 0.2  # Nearer ones need not go faster than a hand.
]


def exchanged(x, first, last, a, b):
    out = x.copy()
    out[first:last, [a, b]] = x[first:last, [b, a]]
    return out


@pytest.mark.parametrize(("a", "b"), FAR)
def test_any_two_points(a, b):
    back = swap_back(T, exchanged(X, 60, 75, a, b), 5.0)
    np.testing.assert_array_equal(back.x, X)
    assert set(zip(*np.nonzero(back.moved), strict=True)) == {(i, k) for i in range(60, 75) for k in (a, b)}


@settings(max_examples=40, deadline=None)
@given(
    spans=st.lists(st.tuples(st.integers(0, 175), st.integers(1, 40)), min_size=1, max_size=3), seed=st.integers(0, 99)
)
@example(spans=[(0, 1), (0, 2)], seed=0)
@example(spans=[(0, 2), (0, 1)], seed=0)
def test_wrists_and_elbows_several_times_in_noise(spans, seed):
    rng = np.random.default_rng(seed)
    truth = X + 0.005 * rng.normal(size=X.shape)
    x, swapped = truth.copy(), np.zeros(X.shape[:2], dtype=bool)
    for (start, length), pair in zip(spans, [(2, 5), (1, 4), (2, 5)], strict=False):
        stretch = slice(start, min(start + length, len(T)))
        if swapped[stretch][:, pair].any() or swapped[max(start - 1, 0)][list(pair)].any():
            continue
        x[stretch] = exchanged(x, stretch.start, stretch.stop, *pair)[stretch]
        swapped[stretch, pair[0]] = swapped[stretch, pair[1]] = True
    back = swap_back(T, x, 5.0)
    np.testing.assert_array_equal(back.x, truth)
    np.testing.assert_array_equal(back.moved, swapped)


def test_both_arms_exchanged_are_named_as_most_of_the_time():
    x = X.copy()
    x[:50] = X[:50, ARMS]
    np.testing.assert_array_equal(swap_back(T, x, 5.0).x, X)


def test_the_bones_outweigh_the_time():
    x = exchanged(X, 20, len(T), 2, 5)
    np.testing.assert_array_equal(swap_back(T, x, 5.0).x, X)


def test_an_end_that_a_gap_hides_leaves_the_rest_alone():
    x = exchanged(X, 60, 75, 2, 5)
    x[74:78, 2] = np.nan
    back = swap_back(T, x, 5.0)
    assert not back.moved[78:].any()
    np.testing.assert_array_equal(back.x[78:], X[78:])


def test_an_exchange_over_a_gap_in_which_no_hand_can_go_so_far():
    t, truth = carry(rate=120.0)
    x = exchanged(truth, 240, len(t), 2, 5)
    x[236:240] = np.nan
    assert find_exchanges(t, x, 5.0) == [(240, 2, 5)]
    np.testing.assert_array_equal(swap_back(t, x, 5.0).x[240:], truth[240:])


def test_a_jump_is_no_swap_and_nothing_is_nothing():
    x = X.copy()
    x[60:70, [2, 5]] = x[60:70, [5, 2]] + [0.0, 0.3, 0.0]
    for recorded in (x, X):
        back = swap_back(T, recorded, 5.0)
        assert not back.moved.any()
        np.testing.assert_array_equal(back.x, recorded)


def test_the_sentence_names_points_and_frames():
    moved = swap_back(T, exchanged(X, 60, 75, 2, 5), 5.0).moved
    said = describe_swaps(moved, 1000 + np.arange(len(T)))
    assert all(text in said for text in (POINTS[2], POINTS[5], "15 frames", "1060", "1074"))
