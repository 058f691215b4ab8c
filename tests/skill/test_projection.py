"""The nearest legal skeleton against closed forms, its optimality conditions and a general solver."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import minimize

from drake_blfdmp.errors import BlfDmpError, SkillError
from drake_blfdmp.skeleton import LINKS
from drake_blfdmp.skill.geometry import link_lengths, link_vectors
from drake_blfdmp.skill.projection import nearest_skeleton
from drake_blfdmp.skill.reshaper import DEFAULT_MOBILITY

DESIRED = np.array([0.22, 0.28, 0.30, 0.28, 0.22])
seeds = st.integers(0, 2**32 - 1)


def legal(seed, leading=()):
    """Skeletons (..., 6, 3) with links of exactly the desired lengths in random directions."""
    rng = np.random.default_rng(seed)
    n = rng.normal(size=(*leading, 5, 3))
    n /= np.linalg.norm(n, axis=-1, keepdims=True)
    x = np.zeros((*leading, 6, 3))
    for i, link in enumerate(LINKS):
        x[..., link.b, :] = x[..., link.a, :] + DESIRED[i] * n[..., i, :]
    return x


def disturbed(seed, size=0.03, leading=()):
    return legal(seed, leading) + size * np.random.default_rng([seed, 1]).uniform(-1, 1, (*leading, 6, 3))


def straight(lengths):
    """A chain along x with the given lengths (5,)."""
    x = np.zeros((6, 3))
    for i, link in enumerate(LINKS):
        x[link.b] = x[link.a] + [lengths[i], 0.0, 0.0]
    return x


def incidence(y):
    """G(y) (5, 18): the lengths' derivatives by the points."""
    r = link_vectors(y)
    n = r / np.linalg.norm(r, axis=-1, keepdims=True)
    g = np.zeros((5, 6, 3))
    for i, link in enumerate(LINKS):
        g[i, link.a], g[i, link.b] = -n[i], n[i]
    return g.reshape(5, 18)


@pytest.mark.parametrize("seed", range(5))
def test_a_legal_skeleton_stays_where_it_is(seed):
    np.testing.assert_allclose(nearest_skeleton(legal(seed), DESIRED), legal(seed), atol=1e-14)


@pytest.mark.parametrize("excess", [0.05, -0.04])
def test_a_link_at_right_angles_moves_only_its_own_ends_by_their_shares(excess):
    """The first link is crosswise to the second: nothing else has to move if only the shoulder's side is free."""
    x = straight(DESIRED)
    x[0] = x[1] + [0.0, DESIRED[0] + excess, 0.0]
    y = nearest_skeleton(x, DESIRED, np.array([1e6, 1.0, 1.0, 1.0, 1.0, 1.0]))
    np.testing.assert_allclose(y[1:], x[1:], atol=1e-6)
    np.testing.assert_allclose(y[0], x[1] + [0.0, DESIRED[0], 0.0], atol=1e-6)


def test_hands_too_far_apart_on_stretched_arms_close_by_mobility_shares():
    """On a straight chain the problem is linear: the change that opens or closes one link is spread over both sides."""
    lengths = DESIRED + 0.06 * (np.arange(5) == 2)
    x = straight(lengths)
    y = nearest_skeleton(x, DESIRED)
    shift = (y - x)[:, 0]
    np.testing.assert_allclose((y - x)[:, 1:], 0.0, atol=1e-14)
    left, right = shift[:3], shift[3:]
    np.testing.assert_allclose(left, 0.03, atol=1e-13)  # Either arm as a whole, by half: their mobilities are equal.
    np.testing.assert_allclose(right, -0.03, atol=1e-13)


def test_one_stretched_link_moves_both_sides_by_their_summed_mobility():
    lengths = DESIRED + 0.05 * (np.arange(5) == 1)
    y = nearest_skeleton(straight(lengths), DESIRED)
    shift = (y - straight(lengths))[:, 0]
    # Rigid sides weigh the sum of 1/w of their points: left upper arm 5 + 2, the other four points 1 + 1 + 2 + 5.
    near, far = 5.0 + 2.0, 1.0 + 1.0 + 2.0 + 5.0
    np.testing.assert_allclose(shift[[0, 1]], 0.05 * far / (near + far), atol=1e-13)
    np.testing.assert_allclose(shift[[2, 5, 4, 3]], -0.05 * near / (near + far), atol=1e-13)


@given(seed=seeds)
def test_lengths_are_met_and_doing_it_twice_changes_nothing(seed):
    y = nearest_skeleton(disturbed(seed), DESIRED)
    np.testing.assert_allclose(link_lengths(y), DESIRED, atol=1e-12)
    np.testing.assert_allclose(nearest_skeleton(y, DESIRED), y, atol=1e-12)


@given(seed=seeds)
def test_the_change_is_one_that_tensions_along_the_links_make(seed):
    """Karush-Kuhn-Tucker: W^-1 (y - x) lies in the range of G(y)^T."""
    x = disturbed(seed)
    y = nearest_skeleton(x, DESIRED)
    g, force = incidence(y), ((y - x) / DEFAULT_MOBILITY[:, None]).ravel()
    tension, *_ = np.linalg.lstsq(g.T, force, rcond=None)
    np.testing.assert_allclose(g.T @ tension, force, atol=1e-10)


@pytest.mark.parametrize("seed", range(4))
def test_a_general_solver_finds_nothing_nearer(seed):
    x = disturbed(seed, 0.05)

    def cost(flat):
        return 1e3 * np.sum((flat.reshape(6, 3) - x) ** 2 / DEFAULT_MOBILITY[:, None])

    meets = {"type": "eq", "fun": lambda flat: link_lengths(flat.reshape(6, 3)) - DESIRED}
    found = minimize(cost, x.ravel(), method="SLSQP", constraints=[meets], options={"maxiter": 300, "ftol": 1e-14})
    assert found.success
    y = nearest_skeleton(x, DESIRED)
    np.testing.assert_allclose(y, found.x.reshape(6, 3), atol=1e-5)
    assert cost(y.ravel()) <= found.fun + 1e-9


def test_less_mobile_points_move_less():
    x = disturbed(7, 0.04, (300,))
    size = np.linalg.norm(nearest_skeleton(x, DESIRED) - x, axis=-1).mean(axis=0)
    assert size[0] < size[1] < size[2] and size[3] < size[4] < size[5]


@pytest.mark.parametrize("leading", [(4,), (2, 3)])
def test_leading_axes_are_independent_problems(leading):
    x = disturbed(5, 0.03, leading)
    lengths = np.broadcast_to(DESIRED, (*leading, 5)) + 0.001 * np.arange(np.prod(leading)).reshape(*leading, 1)
    together = nearest_skeleton(x, lengths)
    assert together.shape == x.shape
    for i in np.ndindex(leading):
        np.testing.assert_allclose(together[i], nearest_skeleton(x[i], lengths[i]), atol=1e-12)


def test_one_skeleton_against_many_lengths_broadcasts_and_is_left_untouched():
    x = disturbed(6)
    before = x.copy()
    many = DESIRED + np.linspace(-0.01, 0.01, 5)[:, None]
    assert nearest_skeleton(x, many).shape == (5, 6, 3)
    assert nearest_skeleton(np.empty((0, 6, 3)), DESIRED).shape == (0, 6, 3)
    np.testing.assert_array_equal(x, before)


def test_coinciding_ends_are_named():
    x = np.stack([legal(1), legal(2)])
    x[1, 5] = x[1, 4]
    with pytest.raises(SkillError, match="at sample 1 the link right_forearm has its ends at one point"):
        nearest_skeleton(x, DESIRED)
    with pytest.raises(SkillError, match="skeleton: the link right_forearm"):
        nearest_skeleton(x[1], DESIRED)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_numbers_that_are_not_finite_are_refused(bad):
    x = legal(1)
    x[2, 0] = bad
    with pytest.raises(SkillError, match="not finite"):
        nearest_skeleton(x, DESIRED)


@pytest.mark.parametrize("lengths", [DESIRED * 0.0, -DESIRED])
def test_lengths_must_be_positive(lengths):
    with pytest.raises(SkillError, match="must be positive"):
        nearest_skeleton(legal(1), lengths)


def test_what_does_not_settle_is_an_error_that_names_sample_and_link():
    """A bent chain whose middle link is ten times too long: the iteration swings from side to side."""
    x = np.stack([legal(3), legal(3)])
    x[1, 2] += [3.0, 0.0, 0.0]
    x[1, 1] += [0.0, 3.0, 0.0]
    x[1, 0] += [-3.0, -3.0, 2.0]
    with pytest.raises(BlfDmpError, match=r"at sample 1 not found in \d+ iterations; the link left_"):
        nearest_skeleton(x, DESIRED)
