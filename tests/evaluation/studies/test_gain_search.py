import numpy as np
import pytest

from drake_blfdmp.errors import ScenarioError
from drake_blfdmp.evaluation.studies.gain_search import (
    DURATIONS,
    GainSearch,
    best_for_all,
    coupled_links,
    demonstrated_motion,
    search_gains,
    search_steps,
    search_tasks,
)
from drake_blfdmp.planning.sources import LoadSource
from drake_blfdmp.planning.task import MakeMotion, MakeTask
from drake_blfdmp.skeleton import HANDS
from drake_blfdmp.skill.laws.follower import PublishedGains
from drake_blfdmp.skill.laws.gams import GamsGains
from drake_blfdmp.skill.laws.published import published
from drake_blfdmp.skill.rollout import roll_out


@pytest.fixture(scope="module")
def task(default_scenario):
    source = LoadSource(default_scenario)
    return MakeTask(default_scenario, source, MakeMotion(default_scenario, source))


def finished(outside, distance, k=(1.0, 2.0, 3.0)):
    outside = np.array(outside)
    return GainSearch("gams", 0.01, 10, {"c_k": np.array(k)}, outside, np.full(3, np.inf), np.array(distance))


def test_samples_outside_come_before_distance():
    chosen = finished([5, 0, 0], [0.1, 0.3, 0.2])
    assert chosen.gains_of(chosen.best).c_k == 3.0 and chosen.kept == 2
    assert finished([5, 6, 7], [9.0, 0.3, 0.2]).best == 0
    assert finished([0, 0, 0], [np.inf, 0.3, 0.2]).table().rows()[0][0] == 3.0
    assert finished([0, 0, 0], [1.0, 1.0, 1.0]).member(GamsGains(2.0)) == 1
    assert finished([0, 0, 0], [1.0, 1.0, 1.0]).member(GamsGains(2.5)) is None


def test_best_for_all_sums():
    assert best_for_all([finished([0, 0, 0], [0.1, 0.2, 0.9]), finished([0, 0, 0], [0.9, 0.2, 0.1])]) == 1
    assert best_for_all([finished([0, 0, 0], [0.1, 0.2, 0.9]), finished([0, 1, 0], [0.1, 0.2, 0.1])]) == 0
    with pytest.raises(ScenarioError, match="same grid"):
        best_for_all([finished([0, 0, 0], [1, 1, 1]), finished([0, 0, 0], [1, 1, 1], (1.0, 2.0, 4.0))])


def test_a_member_is_the_rollout_with_its_gains(task):
    found = search_gains(task, "published", {"k_z": (10.0, 300.0), "d_z": (0.3,)}, time_step=0.008, duration=1.0)
    for i, k_z in enumerate((10.0, 300.0)):
        run = roll_out(
            task.skill, time_step=0.008, duration=1.0, bands=task.bands, law=published, gains=PublishedGains(k_z, 0.3)
        )
        lost = ~np.all(run.margins > 0, axis=-1)
        assert found.outside[i] == lost.sum()
        assert found.first[i] == (run.t[np.argmax(lost)] if lost.any() else np.inf)
        far = np.sqrt(np.mean(np.sum((run.x - demonstrated_motion(task, run.t)) ** 2, axis=-1)))
        assert found.distance[i] == pytest.approx(far)
    assert found.best == 1 and found.outside[0] > 0


@pytest.mark.parametrize(
    "law, grid", [("default", {"k_1": (8.0, 9.0), "k_2": (20.0,)}), ("gams", {"c_k": (1.0, 300.0)})]
)
def test_every_kind_of_gains_searches(task, law, grid):
    found = search_gains(task, law, grid, time_step=0.007, duration=0.7)
    assert found.outside.shape == (2,) and np.all(np.isfinite(found.distance))
    assert found.outside[found.best] == 0


def test_lagged_overflows_and_is_counted(task):
    found = search_gains(task, "published_lagged", {"k_z": (300.0,)}, time_step=0.004, duration=1.5)
    assert 0 < found.first[0] < 0.2 and found.outside[0] > 300


def test_what_cannot_be_searched(task):
    with pytest.raises(ScenarioError, match="choose from default"):
        search_gains(task, "none", time_step=0.01)
    with pytest.raises(ScenarioError, match="no gain 'k_9'; there are c_k"):
        search_gains(task, "gams", {"k_9": (1.0,)}, time_step=0.01)


def test_tasks_add_up(task):
    grid = {"c_k": (1.0, 300.0)}
    one = search_gains(task, "gams", grid, time_step=0.008, duration=0.8)
    both = search_tasks([task, task], "gams", grid, time_step=0.008, duration=0.8)
    np.testing.assert_array_equal(both.outside, 2 * one.outside)
    np.testing.assert_allclose(both.distance, one.distance)
    np.testing.assert_array_equal(both.first, one.first)
    assert both.samples == 2 * one.samples and both.best == one.best == 1 and one.outside[0] > 0


def test_the_defaults_are_what_the_search_finds(task, default_scenario):
    """With the default grids and durations; the published readings share one set of gains."""
    source = LoadSource(default_scenario)
    motion = MakeMotion(default_scenario, source)
    tasks = [MakeTask(default_scenario, source, motion, share) for share in DURATIONS]
    found = {name: search_tasks(tasks, name, time_step=0.004) for name in ("published", "published_loop", "gams")}
    published_ones = [found["published"], found["published_loop"]]
    shared = best_for_all(published_ones)
    assert found["published"].gains_of(shared) == PublishedGains()
    assert found["gams"].gains_of(found["gams"].best) == GamsGains()
    assert found["gams"].kept > 0
    for name in ("published", "published_loop"):  # And they keep the bands of the task itself.
        grid = {gain: (float(values[shared]),) for gain, values in found[name].gains.items()}
        assert search_gains(task, name, grid, time_step=0.004).kept == 1


def test_steps_are_searched_one_by_one(task):
    table = search_steps(task, "gams", {"c_k": (1.0, 300.0), "c_2": (0.0,)}, time_steps=(0.02, 0.01), duration=0.5)
    columns = table.columns
    assert list(columns["step_s"]) == [0.02, 0.01] and list(columns["gains_tried"]) == [2, 2]
    assert list(columns["that_keep_all_bands"]) == [1, 1] and list(columns["longest_inside_s"]) == [np.inf] * 2
    assert columns["with"][0] == "c_k 300, c_2 0"


def test_gams_is_judged_by_the_hands():
    assert list(coupled_links("gams")) == [HANDS] and len(coupled_links("published")) == 5


def test_demonstrated_motion_stays_after_its_end(task):
    x = demonstrated_motion(task, np.array([0.0, task.skill.tau, task.skill.tau + 3.0]))
    np.testing.assert_allclose(x[0], task.motion.x[0])
    np.testing.assert_allclose(x[1:], np.broadcast_to(task.motion.x[-1], (2, 6, 3)))
