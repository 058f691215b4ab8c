import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drake_blfdmp.demonstration.modelled_person import hold_and_place
from drake_blfdmp.errors import ScenarioError
from drake_blfdmp.skeleton import HANDS
from drake_blfdmp.skill.bands import make_bands
from drake_blfdmp.skill.geometry import link_lengths
from drake_blfdmp.skill.laws import LAWS, law, none
from drake_blfdmp.skill.learning import learn_skill
from drake_blfdmp.skill.profiles import ConstantDistance, HandDistance
from drake_blfdmp.skill.rollout import roll_out
from drake_blfdmp.skill.sampled import Gains

SKILL = learn_skill(*hold_and_place())
BATCH = 8


def hands_that_close(tau):
    return HandDistance(0.37, 0.276, 0.2 * tau, 0.7 * tau, 0.12 * tau)


def moved(rng, points, size):
    """A batch of `points`, every coordinate moved by `size` m rms."""
    return points + size * rng.normal(size=(BATCH, 6, 3))


def wrong_starts(rng):
    """Starts with bones wrong by centimetres, and hands from 0.15 m too near each other to 0.35 m too far apart."""
    start = moved(rng, SKILL.start, 0.03)
    start[:, :3, 0] -= rng.uniform(-0.15, 0.33, size=(BATCH, 1))
    return start


@settings(max_examples=12, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    tau=st.floats(3.0, 12.0),
    k_1=st.floats(6.0, 30.0),
    k_2=st.floats(18.0, 40.0),
    share=st.floats(0.2, 1.0),
    moving=st.booleans(),
    filling=st.floats(0.3, 0.85),
)
def test_no_link_ever_leaves_its_band(seed, tau, k_1, k_2, share, moving, filling):
    """Random starts (hands wrong by up to 0.35 m), goals, durations, gains; any time step the gains allow."""
    rng = np.random.default_rng(seed)
    gains = Gains(k_1, k_2)
    step = max(share * gains.largest_step(), 0.002)
    gains.check(step)
    start = wrong_starts(rng)
    bands = make_bands(0.22, 0.28, hands_that_close(tau) if moving else ConstantDistance(0.3)).opened_to(start, filling)
    r = roll_out(
        SKILL.with_duration(tau),
        time_step=step,
        duration=0.6 * tau,
        bands=bands,
        gains=gains,
        start=start,
        goal=moved(rng, SKILL.goal, 0.08),
    )
    assert r.margins.shape == (len(r.t), BATCH, 5)
    assert r.margins.min() > 0.0


def test_the_starts_above_are_as_wrong_as_they_say():
    rng = np.random.default_rng(0)
    lengths = np.concatenate([link_lengths(wrong_starts(rng)) for _ in range(200)])
    errors = np.abs(lengths - [0.22, 0.28, 0.37, 0.28, 0.22])
    assert np.quantile(errors[:, HANDS], 0.95) > 0.3
    assert np.quantile(np.delete(errors, HANDS, axis=1), 0.95) > 0.06


def test_without_coupling_bands_are_crossed():
    """What the property above claims is not true of any rollout."""
    start = moved(np.random.default_rng(1), SKILL.start, 0.06)
    bands = make_bands(0.22, 0.28, hands_that_close(SKILL.tau)).opened_to(start)
    goal = moved(np.random.default_rng(2), SKILL.goal, 0.08)
    r = roll_out(SKILL, time_step=0.004, bands=bands, law=none, start=start, goal=goal)
    assert np.all(r.margins.min(axis=(0, 2)) < 0.0)


def test_a_step_far_too_long_crosses_bands():
    """The limit on the time step is not for nothing."""
    rng = np.random.default_rng(3)
    start = moved(rng, SKILL.start, 0.06)
    gains = Gains(4.0, 10.0)
    bands = make_bands(0.22, 0.28, hands_that_close(3.0)).opened_to(start)
    with np.errstate(all="ignore"):
        r = roll_out(
            SKILL.with_duration(3.0),
            time_step=20 * gains.largest_step(),
            bands=bands,
            gains=gains,
            start=start,
            goal=moved(rng, SKILL.goal, 0.15),
        )
        assert not r.margins.min() > 0.0


def test_the_coupled_hands_keep_close_to_their_middle():
    bands = make_bands(0.22, 0.28, hands_that_close(SKILL.tau)).opened_to(SKILL.start)
    r = roll_out(SKILL, time_step=0.002, bands=bands)
    late = r.t > 1.5
    middle = r.bands[late, :2].mean(axis=1)
    assert np.abs(r.lengths[late] - middle).max() < 2e-4


def fine_and_coarse(steps, finest, **options):
    """Largest difference in the positions to a rollout at `finest`, on the clock of the coarsest step."""
    reference = roll_out(SKILL, time_step=finest, duration=1.6, **options)
    errors = []
    for step in steps:
        r = roll_out(SKILL, time_step=step, duration=1.6, **options)
        stride = round(steps[0] / step)
        errors.append(np.abs(r.x[::stride] - reference.x[:: round(steps[0] / finest)]).max())
    return np.array(errors)


def test_the_discrete_primitive_converges_with_second_order():
    errors = fine_and_coarse([0.04, 0.02, 0.01], 0.0005)
    np.testing.assert_allclose(np.log2(errors[:-1] / errors[1:]), 2.0, atol=0.15)


def test_the_coupled_rollout_converges_with_first_order():
    bands = make_bands(0.22, 0.28, ConstantDistance(0.3)).opened_to(SKILL.start)
    errors = fine_and_coarse([0.008, 0.004, 0.002], 0.000125, bands=bands)
    orders = np.log2(errors[:-1] / errors[1:])
    assert np.all(orders > 0.85)
    assert errors[-1] < 1e-3


def test_a_batch_is_its_members():
    rng = np.random.default_rng(4)
    start, goal = moved(rng, SKILL.start, 0.05), moved(rng, SKILL.goal, 0.05)
    bands = make_bands(0.22, 0.28, ConstantDistance(0.3), hands_half_width=0.3, bone_half_width=0.3)
    together = roll_out(SKILL, time_step=0.005, duration=1.0, bands=bands, start=start, goal=goal)
    for i in (0, BATCH - 1):
        one = roll_out(SKILL.with_start(start[i]).with_goal(goal[i]), time_step=0.005, duration=1.0, bands=bands)
        np.testing.assert_allclose(together.x[:, i], one.x, atol=1e-12)
        np.testing.assert_allclose(together.margins[:, i], one.margins, atol=1e-10)


def test_progress_is_told_and_ends_at_one():
    shares = []
    roll_out(SKILL, time_step=0.005, progress=shares.append)
    assert shares == sorted(shares) and shares[-1] == 1.0 and len(shares) > 5


def test_margins_need_bands():
    with pytest.raises(ValueError, match="no bands"):
        _ = roll_out(SKILL, time_step=0.02).margins


def test_an_unknown_law_is_refused_with_the_names_there_are():
    with pytest.raises(ScenarioError, match="unknown law 'defualt'; there are " + ", ".join(LAWS)):
        law("defualt")
