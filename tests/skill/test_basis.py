import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drake_blfdmp.skill.basis import activations, centers_and_widths, forcing
from drake_blfdmp.skill.canonical import DEFAULT_GAMMA, phase_at


@given(n=st.integers(2, 100), t=st.floats(-0.05, 1.1), gamma=st.floats(1.0, 6.0))
def test_the_activations_sum_to_the_phase(n, t, gamma):
    s = phase_at(t, 1.0, gamma)
    psi = activations(s, *centers_and_widths(n, gamma))
    assert np.all(psi >= 0.0)
    np.testing.assert_allclose(psi.sum(), s, rtol=1e-12)


def test_the_centres_are_equally_spaced_in_time_from_start_to_end():
    c, h = centers_and_widths(11, DEFAULT_GAMMA)
    np.testing.assert_allclose(-np.log(c) / DEFAULT_GAMMA, np.linspace(0.0, 1.0, 11), atol=1e-12)
    assert np.all(h > 0)


def test_the_design_is_well_conditioned():
    for n in (20, 50, 80):
        design = activations(phase_at(np.linspace(0.0, 1.0, 20 * n), 1.0), *centers_and_widths(n, DEFAULT_GAMMA))
        assert np.linalg.cond(design / np.linalg.norm(design, axis=0)) < 100


def test_equal_weights_force_in_proportion_to_the_phase():
    c, h = centers_and_widths(20, DEFAULT_GAMMA)
    s = phase_at(np.linspace(0.0, 1.0, 7).reshape(7, 1), 1.0)
    f = forcing(s, np.full((20, 4), 3.0), c, h)
    assert f.shape == (7, 1, 4)
    np.testing.assert_allclose(f, 3.0 * np.broadcast_to(s[..., None], f.shape), rtol=1e-12)


def test_one_function_is_no_basis():
    with pytest.raises(ValueError, match="at least 2"):
        centers_and_widths(1, DEFAULT_GAMMA)
