"""Excursions: the quick search for them finds what the plain one does, in any order of their sizes."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from synthetic_carry import carry

from drake_blfdmp.demonstration.bones import robust_sigma
from drake_blfdmp.demonstration.jumps import describe_jumps, find_jumps, speed_jumps

T, X = carry()


def plain_speed_jumps(t, p, limit):
    """The definition: the shortest short piece goes, its neighbours are joined where reachable, and again."""
    valid = np.flatnonzero(np.isfinite(p).all(axis=1))
    t, p = t[valid], p[valid]
    speed = np.linalg.norm(np.diff(p, axis=0), axis=1) / np.diff(t)
    limit = max(limit, float(np.median(speed) + 10.0 * robust_sigma(speed)))
    cuts = np.flatnonzero(speed > limit) + 1
    pieces = [[a, b - 1] for a, b in zip([0, *cuts], [*cuts, len(t)], strict=True)]
    padded = np.pad(p, [(5, 5), (0, 0)], mode="edge")
    around = np.median(np.lib.stride_tricks.sliding_window_view(padded, 11, axis=0), axis=-1)
    deviation = np.linalg.norm(p - around, axis=1)
    out = []
    while len(pieces) > 1:
        short = [piece for piece in pieces if t[piece[1]] - t[piece[0]] < 0.5]
        if not short:
            break
        removed = min(short, key=lambda piece: (piece[1] - piece[0], -deviation[piece[0]]))
        index = pieces.index(removed)
        pieces.pop(index)
        out += range(removed[0], removed[1] + 1)
        if 0 < index < len(pieces):
            before, after = pieces[index - 1], pieces[index]
            if np.linalg.norm(p[after[0]] - p[before[1]]) <= limit * (t[after[0]] - t[before[1]]):
                pieces[index - 1 : index + 1] = [[before[0], after[1]]]
    return sorted(set(valid[out]))  # What was joined may hold samples that are out already.


@settings(max_examples=60, deadline=None)
@given(
    seed=st.integers(0, 10**6), size=st.integers(5, 150), spells=st.integers(0, 15), step=st.sampled_from([1 / 30, 0.2])
)
def test_the_same_samples_as_by_the_definition(seed, size, spells, step):
    rng = np.random.default_rng(seed)
    t = np.cumsum(rng.choice([step, 2 * step], size))
    p = np.cumsum(0.01 * rng.normal(size=(size, 3)), axis=0)
    for start in rng.integers(0, size, spells):
        p[start : start + rng.integers(1, 12)] += rng.normal(size=3)
    p[rng.random(size) < 0.1] = np.nan
    if np.isfinite(p).all(axis=1).sum() >= 3:
        np.testing.assert_array_equal(np.flatnonzero(speed_jumps(t, p, 5.0)), plain_speed_jumps(t, p, 5.0))


def test_a_long_stay_is_no_jump():
    p = X[:, 2].copy()
    p[40:50] += [0.0, 0.6, 0.0]
    p[90:120] += [0.0, 0.6, 0.0]
    np.testing.assert_array_equal(np.flatnonzero(speed_jumps(T, p, 5.0)), np.arange(40, 50))


def test_a_wrong_elbow_breaks_both_its_bones():
    x = X.copy()
    x[33:36, 4] += [0.3, 0.0, 0.4]
    jumps = find_jumps(T, x, 5.0)
    np.testing.assert_array_equal(np.argwhere(jumps), [[33, 4], [34, 4], [35, 4]])
    assert describe_jumps(jumps, 100 + np.arange(len(T))) == (
        "jumps taken out between frames 133 and 135 (frames: right_elbow 3)"
    )


@pytest.mark.parametrize("count", [0, 1, 2])
def test_too_few_samples_to_tell(count):
    p = np.full((20, 3), np.nan)
    p[:count] = np.arange(count)[:, None] * 100.0
    assert not speed_jumps(np.arange(20) / 30.0, p, 5.0).any()
