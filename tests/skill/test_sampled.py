import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drake_blfdmp.errors import ScenarioError
from drake_blfdmp.skill.barrier import error_acceleration
from drake_blfdmp.skill.sampled import LONGEST_STEP, Gains

gains = st.floats(0.05, 200.0)


def spectral_radius(gains, dt):
    """Of the linearised sampled loop: a double integrator with the acceleration held."""
    a = np.array([[1.0, dt], [0.0, 1.0]])
    b = np.array([[0.5 * dt**2], [dt]])
    feedback = np.array([[1.0 + gains.k_1 * gains.k_2, gains.k_1 + gains.k_2]])
    return np.abs(np.linalg.eigvals(a - b @ feedback)).max()


@given(k_1=gains, k_2=gains)
def test_every_step_that_is_allowed_is_stable(k_1, k_2):
    allowed = Gains(k_1, k_2).largest_step()
    assert spectral_radius(Gains(k_1, k_2), allowed) < 1.0


@given(k_1=st.floats(1.0, 100.0), k_2=st.floats(1.0, 100.0))
def test_jurys_limit_is_where_the_linear_loop_becomes_unstable(k_1, k_2):
    limit = 2.0 * min(1.0 / (k_1 + k_2), (k_1 + k_2) / (1.0 + k_1 * k_2))
    assert spectral_radius(Gains(k_1, k_2), 0.999 * limit) < 1.0 < spectral_radius(Gains(k_1, k_2), 1.001 * limit)


@given(k_1=gains, k_2=gains, share=st.floats(0.5, 2.0))
def test_a_step_is_refused_exactly_above_the_largest(k_1, k_2, share):
    law = Gains(k_1, k_2)
    step = share * law.largest_step()
    if share <= 1.0:
        law.check(step)
    else:
        with pytest.raises(ScenarioError, match="time step"):
            law.check(step)


@given(k_1=gains, k_2=gains, start=st.floats(-0.8, 0.8))
def test_one_undisturbed_link_stays_inside_at_the_largest_step(k_1, k_2, start):
    dt = Gains(k_1, k_2).largest_step()
    xi, rate = start, 0.0
    for _ in range(200):
        acceleration = error_acceleration(xi, rate, k_1, k_2)
        xi, rate = xi + dt * rate + 0.5 * dt**2 * acceleration, rate + dt * acceleration
        assert abs(xi) <= max(abs(start), 1e-12) * (1 + 1e-9)


def test_30_hz_with_stiff_gains_is_refused_and_the_message_says_what_to_use():
    with pytest.raises(ScenarioError) as caught:
        Gains(20.0, 40.0).check(1 / 30)
    message = str(caught.value)
    assert message.startswith("law: the time step 0.0333333 s is too long for k_1 = 20, k_2 = 40 1/s; use at most ")
    Gains(20.0, 40.0).check(float(message.split("use at most ")[1].split(" s")[0]) * 0.999)


def test_the_message_says_which_way_the_gains_must_go():
    with pytest.raises(ScenarioError, match="or smaller gains"):
        Gains(50.0, 100.0).check(0.002)
    with pytest.raises(ScenarioError, match="or larger gains"):
        Gains(2.0, 5.0).check(0.002)


def test_no_gains_allow_a_step_above_the_longest():
    k = np.geomspace(1.0, 500.0, 200)
    assert max(Gains(a, b).largest_step() for a in k for b in k) <= 1.02 * LONGEST_STEP


def test_the_default_gains_carry_the_default_step_and_continuous_time():
    Gains().check(0.005)
    Gains().check(0.0)


@pytest.mark.parametrize("bad", [(0.0, 20.0), (8.0, -1.0), (float("nan"), 20.0)])
def test_gains_that_are_not_positive_are_refused(bad):
    with pytest.raises(ScenarioError, match="must be positive"):
        Gains(*bad).check(0.0)
