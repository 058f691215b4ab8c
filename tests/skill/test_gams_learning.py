import numpy as np
import pytest

from drake_blfdmp.demonstration.modelled_person import hold_and_place
from drake_blfdmp.errors import SkillError
from drake_blfdmp.skeleton import HANDS
from drake_blfdmp.skill.bands import make_bands
from drake_blfdmp.skill.gams_learning import SampledDistance, iterate, updated
from drake_blfdmp.skill.learning import learn_skill
from drake_blfdmp.skill.profiles import ConstantDistance, HandDistance


def test_sampled_distance_adds_the_reference_and_its_derivatives():
    t = np.linspace(0.0, 2.0, 201)
    profile = SampledDistance(HandDistance(0.4, 0.3, 0.5, 1.5, 0.3), t, 0.02 * np.sin(3.0 * t))
    base = HandDistance(0.4, 0.3, 0.5, 1.5, 0.3)
    u = np.linspace(0.2, 1.8, 77)
    expected = (0.02 * np.sin(3 * u), 0.06 * np.cos(3 * u), -0.18 * np.sin(3 * u))
    for got, own, extra, tolerance in zip(
        profile.evaluate(u), base.evaluate(u), expected, (1e-8, 1e-5, 2e-3), strict=True
    ):
        np.testing.assert_allclose(got, own + extra, atol=tolerance)
    d, rate, acceleration = profile.evaluate(5.0)
    assert d == pytest.approx(0.4 + 0.02 * np.sin(6.0)) and rate == 0.0 and acceleration == 0.0


@pytest.mark.parametrize(
    "t, r", [([0.0], [0.0]), ([0.0, 0.0], [0.0, 1.0]), ([0.0, 1.0], [0.0, np.nan]), ([0.0, 1.0], [0.0, 1.0, 2.0])]
)
def test_sampled_distance_refuses(t, r):
    with pytest.raises(SkillError, match="sampled distance"):
        SampledDistance(ConstantDistance(0.3), t, r)


def test_update_shifts_by_one_sample():
    np.testing.assert_allclose(updated(np.array([1.0, 2.0, 3.0]), np.array([0.1, 0.2, 0.4]), 0.5, 2.0), [0.7, 1.4, 1.9])


def test_learning_takes_the_settled_error_away_and_not_the_start():
    skill = learn_skill(*hold_and_place())
    bands = make_bands(0.22, 0.28, ConstantDistance(0.3)).opened_to(skill.start)
    epochs = iterate(skill, bands, epochs=4, time_step=0.008, duration=4.0)
    assert not epochs[0].reference.any()
    assert epochs[0].settled_rms > 5e-4
    assert epochs[3].settled_rms < 0.05 * epochs[0].settled_rms
    assert all(epoch.error[0] == epochs[0].error[0] for epoch in epochs)
    np.testing.assert_allclose(epochs[1].reference, updated(epochs[0].reference, epochs[0].error))
    np.testing.assert_allclose(epochs[1].error, 0.3 - epochs[1].rollout.lengths[:, HANDS])


def test_a_diverging_learning_says_so():
    skill = learn_skill(*hold_and_place())
    bands = make_bands(0.22, 0.28, ConstantDistance(0.3)).opened_to(skill.start)
    with np.errstate(all="ignore"), pytest.raises(SkillError, match="smaller Q or L"):
        iterate(skill, bands, epochs=5, time_step=0.02, duration=1.2, learning_gain=1e200)
