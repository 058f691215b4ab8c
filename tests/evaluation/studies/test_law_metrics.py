from dataclasses import replace

import numpy as np
import pytest

from drake_blfdmp.evaluation.studies import law_metrics
from drake_blfdmp.evaluation.studies.law_metrics import (
    common_results,
    cost_ratio,
    first_round,
    measure,
    offline_order,
    roll_out_law,
    second_round_distance,
    turned,
)
from drake_blfdmp.planning.sources import LoadSource
from drake_blfdmp.planning.task import MakeMotion, MakeTask
from drake_blfdmp.skeleton import HANDS
from drake_blfdmp.skill.laws.follower import PublishedGains
from drake_blfdmp.skill.laws.primitive import Primitive
from drake_blfdmp.skill.laws.published import published
from drake_blfdmp.skill.profiles import ConstantDistance
from drake_blfdmp.skill.rollout import Rollout, roll_out


@pytest.fixture(scope="module")
def task(default_scenario):
    source = LoadSource(default_scenario)
    return MakeTask(default_scenario, source, MakeMotion(default_scenario, source))


def chain(hands=0.3, turn=0.0):
    """Six points in the plane x, z whose bones are 0.22 and 0.28 m; the left forearm turned by `turn` rad."""
    forearm = 0.28 * np.array([np.sin(turn), 0.0, -np.cos(turn)])
    left = np.array([[0.0, 0.0, 0.5], [0.0, 0.0, 0.28], np.array([0.0, 0.0, 0.28]) + forearm])
    right = np.array([[0.0, 0.0, 0.5], [0.0, 0.0, 0.28], [0.0, 0.0, 0.0]]) + np.array([hands, 0.0, 0.0])
    return np.concatenate([left, right])


def resting(task, points, hands=0.3):
    bands = replace(task.bands, hands=ConstantDistance(hands), opening=0.0)
    t = 0.1 * np.arange(len(points))
    return Rollout(t, np.array(points), np.zeros((len(points), 6, 3)), bands.evaluate(t)), bands


def test_measure_counts_the_links_that_a_law_couples(task):
    bent = chain()
    bent[1, 2] += 0.05  # Both bones of the left arm leave their bands, the hands do not.
    run, bands = resting(task, [chain(), bent, bent, chain(), chain()])
    every, hands = measure(run, task, "published", bands), measure(run, task, "gams", bands)
    assert (every.outside, every.outside_paper, every.samples, every.first_s) == (2, 2, 5, 0.1)
    assert every.until_inside == 9 and every.least_margin == pytest.approx(-4.0)
    assert (hands.outside, hands.first_s, hands.until_inside) == (0, np.inf, 0)
    far = np.linalg.norm(chain() - task.skill.goal, axis=-1).max()
    assert every.from_goal_m == pytest.approx(far)


def test_measure_survives_an_overflow(task):
    run, bands = resting(task, [chain(), np.full((6, 3), np.nan)])
    result = measure(run, task, "published", bands)
    assert (result.outside, result.least_margin, result.until_inside) == (1, -np.inf, None)
    assert result.distance_m == result.from_goal_m == np.inf


def test_turned_is_the_angle():
    angles = turned(np.array([chain(), chain(turn=0.4), chain(turn=3.0)]))
    np.testing.assert_allclose(angles[:, 1], [0.0, 0.4, 3.0], atol=1e-12)
    np.testing.assert_allclose(angles[:, 0], 0.0, atol=1e-12)


def test_common_results(task):
    run, _ = resting(task, [chain(), chain(hands=0.4)])
    found = common_results(run)
    assert not found.empty[0].any() and not found.widening[0].any()
    # Along x the forearm keeps the wrist where it is, the hands ask for 0.1 m: none in common on both wrists' x.
    np.testing.assert_array_equal(found.empty[1], [[True, False, False]] * 2)
    sigma = 0.01 + 0.02 * np.exp(-0.3)
    np.testing.assert_allclose(found.widening[1, :, 0], 0.1 - sigma / np.sqrt(3.0), atol=1e-9)
    assert not found.elbows_empty.any()


def test_first_round_couples_the_wrists_alone_and_reflects_the_hands(task):
    run = roll_out(task.skill, time_step=0.007, duration=1.0, bands=task.bands, law=first_round)
    free = roll_out(task.skill, time_step=0.007, duration=1.0)
    np.testing.assert_array_equal(run.x[:, [0, 1, 3, 4]], free.x[:, [0, 1, 3, 4]])
    assert np.abs(run.x[:, [2, 5]] - free.x[:, [2, 5]]).max() > 0.01
    assert np.all(run.margins[:, [1, 3]] > 0)
    desired = task.bands.desired(run.t)[0][:, HANDS]
    np.testing.assert_allclose(second_round_distance(run, task.bands) - desired, desired - run.lengths[:, HANDS])


def test_the_offline_order_only_reflects_the_hands(task):
    order = offline_order(task, PublishedGains(), time_step=0.007)
    assert order.samples == len(order.first_m) == len(order.outside) == round(task.skill.tau / 0.007) + 1
    desired = task.bands.desired(0.007 * np.arange(order.samples))[0][:, HANDS]
    reflected = order.first_m < desired  # The error changes its sign, where the hands do not pass each other.
    assert reflected.mean() > 0.9
    np.testing.assert_allclose(order.second_m[reflected], order.first_m[reflected], atol=1e-12)
    assert order.forearms_outside == 0 and order.outside.mean() > 0.5


def test_a_rollout_takes_given_gains_or_the_scenarios(task, default_scenario):
    own, same, other = (
        roll_out_law(default_scenario, task, "published", gains=gains, time_step=0.02).x[:40]
        for gains in (None, PublishedGains(), PublishedGains(k_z=20.0))
    )
    np.testing.assert_array_equal(own, same)
    assert np.abs(own - other).max() > 1e-3


def test_cost_ratio_is_of_both_laws_and_needs_bands(task, monkeypatch):
    """A clock that a slow law moves by 3 and a fast one by 1 a call: nothing is timed here."""
    clock = [0.0]

    def costing(seconds):
        def law(*arguments, gains):
            clock[0] += seconds

        return law

    monkeypatch.setattr(law_metrics.time, "process_time", lambda: clock[0])
    monkeypatch.setattr(law_metrics, "law_named", {"slow": costing(3.0), "fast": costing(1.0)}.get)
    run = roll_out(task.skill, time_step=0.02, duration=0.2, bands=task.bands, law=published)
    primitive = Primitive(task.skill.tau, task.skill.alpha_z)
    assert cost_ratio(run, ("slow", "fast"), primitive, 4, (None, None), 3) == pytest.approx(3.0)
    with pytest.raises(ValueError, match="bands"):
        cost_ratio(replace(run, bands=None), ("slow", "fast"), primitive, 4, (None, None), 1)
