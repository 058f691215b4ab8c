"""Random problems are what they say, and what comes of them depends on nothing but them."""

from dataclasses import fields, replace

import numpy as np
import pytest

from drake_blfdmp.demonstration.modelled_person import hold_and_place
from drake_blfdmp.errors import BlfDmpError
from drake_blfdmp.evaluation.studies.intervals import proportion
from drake_blfdmp.evaluation.studies.random_problems import (
    NEVER,
    Job,
    Spread,
    draw_gains,
    draw_problems,
    run_job,
    run_jobs,
    with_hands_apart,
)
from drake_blfdmp.skeleton import HANDS
from drake_blfdmp.skill.bands import make_bands
from drake_blfdmp.skill.geometry import link_lengths
from drake_blfdmp.skill.laws import law
from drake_blfdmp.skill.learning import learn_skill
from drake_blfdmp.skill.profiles import HandDistance
from drake_blfdmp.skill.rollout import roll_out
from drake_blfdmp.skill.sampled import Gains

SKILL = learn_skill(*hold_and_place())
BONES = np.array([0.22, 0.28, 0.0, 0.28, 0.22])
STEP = 0.004
CALM = {
    "start_m": 0.005,
    "goal_m": 0.01,
    "hands_error_m": 0.02,
    "tau": (0.8, 1.0),
    "box_m": (0.28, 0.32),
    "half_width_m": (0.01, 0.02),
}


def problems(count, seed=0, **changes):
    return draw_problems(SKILL, count, seed, STEP, Spread(**changes))


def job(count, name="default", seed=0, **changes):
    return Job(SKILL, BONES, 3.0, problems(count, seed, **{"tau": (0.3, 0.6), **changes}), name, STEP)


def test_problems_spread_as_they_say():
    many = problems(4000)
    spread = Spread()
    assert many.start.shape == many.goal.shape == (4000, 6, 3)
    assert np.std(many.goal - SKILL.goal) == pytest.approx(spread.goal_m, rel=0.02)
    ratio = many.tau / SKILL.tau
    assert (ratio.min(), ratio.max()) == pytest.approx(spread.tau, rel=0.01)
    assert np.median(ratio) == pytest.approx(1.0, rel=0.05)
    error = link_lengths(many.start)[:, HANDS] - many.open_m
    assert np.abs(error).max() <= spread.hands_error_m + 1e-12
    assert np.abs(error).max() > 0.99 * spread.hands_error_m
    assert link_lengths(many.start)[:, HANDS].min() >= spread.nearest_m - 1e-12
    bones = np.delete(link_lengths(many.start) - link_lengths(SKILL.start), HANDS, axis=1)
    assert 0.03 < np.std(bones) < 0.06
    assert np.all(many.close_s + many.closing_s <= many.open_s)
    assert np.all(many.open_s + many.closing_s < many.tau)
    for k_1, k_2 in zip(many.k_1, many.k_2, strict=True):
        Gains(k_1, k_2).check(STEP)


def test_every_problem_differs_and_the_seed_decides():
    first, again, other = problems(50), problems(50), problems(50, seed=1)
    for item in fields(first):
        values = getattr(first, item.name)
        assert len(np.unique(values.reshape(50, -1), axis=0)) == 50, item.name
        np.testing.assert_array_equal(values, getattr(again, item.name))
        assert np.all(values != getattr(other, item.name))


def test_hands_are_set_apart_and_nothing_else():
    x = SKILL.start + 0.03 * np.random.default_rng(0).normal(size=(20, 6, 3))
    wanted = np.linspace(0.05, 0.8, 20)
    moved = with_hands_apart(x, wanted)
    np.testing.assert_allclose(link_lengths(moved)[:, HANDS], wanted, atol=1e-12)
    np.testing.assert_allclose(
        np.delete(link_lengths(moved), HANDS, axis=1), np.delete(link_lengths(x), HANDS, axis=1), atol=1e-12
    )
    np.testing.assert_allclose(moved.mean(axis=1), x.mean(axis=1), atol=1e-12)


def test_bands_are_opened_to_the_starts():
    many = problems(100)
    bands = many.bands(BONES, 3.0, filling=0.6)
    error = np.abs(link_lengths(many.start) - bands.desired(0.0)[0])
    filled = error / bands.half_widths(0.0)[0]
    assert filled.max() == pytest.approx(0.6)
    assert np.sum(np.isclose(filled, 0.6)) > 200
    np.testing.assert_allclose(bands.half_widths(100.0)[0], np.repeat(many.half_width_m[:, None], 5, axis=1))


def test_gains_that_no_step_allows_are_refused():
    with pytest.raises(BlfDmpError, match=r"hardly any gains from 1 to 2 1/s allow a step of 0\.01 s; take a shorter"):
        draw_gains(np.random.default_rng(0), 10, 0.01, (1.0, 2.0))


@pytest.mark.parametrize("name", ["default", "published", "none"])
def test_a_batch_is_its_problems_rolled_out_one_by_one(name):
    # Where the published law leaves its bands it is chaotic, and rounding shows: its problems are calm ones.
    many = job(3, name, **(CALM if name == "published" else {}))
    outcome = run_job(many)
    for i in range(3):
        one = many.problems[i : i + 1]
        p = many.problems
        hands = HandDistance(*(float(v[i]) for v in (p.open_m, p.closed_m, p.close_s, p.open_s, p.closing_s)))
        half = float(p.half_width_m[i])
        bands = make_bands(0.22, 0.28, hands, bone_half_width=half, hands_half_width=half,
                           hands_funnel=float(p.funnel_m[i])).opened_to(one.start[0])  # fmt: skip
        gains = Gains(float(p.k_1[i]), float(p.k_2[i])) if name == "default" else None
        rollout = roll_out(
            replace(SKILL, tau=float(p.tau[i])),
            time_step=STEP,
            duration=STEP * np.floor(p.tau[i] / STEP),
            bands=bands,
            law=law(name),
            gains=gains,
            start=one.start[0],
            goal=one.goal[0],
        )
        np.testing.assert_allclose(outcome.least[i], rollout.margins.min(axis=0), atol=1e-7)
        left = rollout.margins <= 0.0
        first = np.where(left.any(axis=0), STEP * left.argmax(axis=0), NEVER)
        np.testing.assert_allclose(outcome.left_s[i], first, atol=1e-9)


def test_chunks_and_the_order_of_jobs_change_nothing():
    jobs = [job(7), job(5, "none", seed=2)]
    whole = run_jobs(jobs)
    parts = run_jobs(jobs[::-1], chunk=3)[::-1]
    for a, b in zip(whole, parts, strict=True):
        np.testing.assert_allclose(a.least, b.least, atol=1e-9)
        np.testing.assert_array_equal(a.left_s, b.left_s)


def test_the_number_of_processes_changes_nothing():
    shares = []
    jobs = [job(6)]
    alone, shared = run_jobs(jobs, 1, chunk=3), run_jobs(jobs, 2, shares.append, chunk=3)
    np.testing.assert_array_equal(alone[0].least, shared[0].least)
    np.testing.assert_array_equal(alone[0].left_s, shared[0].left_s)
    assert shares == sorted(shares) and shares[-1] == pytest.approx(1.0)


def test_without_coupling_bands_are_left_and_with_it_they_are_not():
    free, coupled = run_jobs([job(20, "none"), job(20)])
    assert free.left.any(axis=1).all()
    assert not coupled.left.any()
    assert coupled.least.min() > 0.0
    np.testing.assert_array_equal(free.left, free.least <= 0.0)


def test_a_law_that_diverges_is_told_as_left():
    outcome = run_job(job(3, "published_lagged"))
    assert np.all(outcome.left.any(axis=1))
    assert np.all(outcome.least.min(axis=1) == -np.inf)


def test_gains_far_outside_the_limit_leave_bands():
    """The runner judges, it does not pass everything: the same problems with a law too stiff for the step."""
    stiff = job(5)
    stiff = replace(stiff, problems=stiff.problems.with_gains(600.0, 600.0))
    assert run_job(stiff).left.any(axis=1).all()


def test_the_interval_is_exact():
    none = proportion(0, 10_000)
    assert none.lower == 0.0
    assert none.upper == pytest.approx(1.0 - 0.025 ** (1.0 / 10_000), rel=1e-9)
    every = proportion(20, 20)
    assert (every.share, every.upper) == (1.0, 1.0)
    assert every.lower == pytest.approx(0.025 ** (1.0 / 20.0), rel=1e-9)
    assert proportion(3, 200).percent() == "3 of 200 (1.5 %, 0.31 to 4.32 %)"
    with pytest.raises(ValueError):
        proportion(3, 2)
