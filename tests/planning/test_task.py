"""The motion on the task's clock, and the skill and bands laid around it."""

from dataclasses import replace

import numpy as np
import pytest

from drake_blfdmp.demonstration.timing import TaskMotion
from drake_blfdmp.errors import ScenarioError, SkillError
from drake_blfdmp.planning.scenario import Scenario
from drake_blfdmp.planning.sources import LoadSource
from drake_blfdmp.planning.task import (
    DEFAULT_SQUEEZE,
    Centred,
    LawGains,
    MakeMotion,
    MakeTask,
    Raised,
    RollOutTask,
    Shifted,
)
from drake_blfdmp.skill.laws.follower import PublishedGains
from drake_blfdmp.skill.laws.gams import GamsGains
from drake_blfdmp.skill.sampled import Gains


@pytest.fixture(scope="module")
def source():
    return LoadSource(Scenario())


@pytest.fixture(scope="module")
def motion(source):
    return MakeMotion(Scenario(), source)


@pytest.fixture(scope="module")
def task(source, motion):
    return MakeTask(Scenario(), source, motion)


def scenario(**changes):
    """The default with changed sections, given as section={key: value}."""
    default = Scenario()
    return replace(default, **{name: replace(getattr(default, name), **values) for name, values in changes.items()})


def middle(x):
    return 0.5 * (x[:, 2] + x[:, 5])


def test_the_source_of_the_default_is_the_modelled_person(source):
    assert source.recording.synthetic
    assert (source.dimensions.upper_arm, source.dimensions.forearm, source.dimensions.box_width) == (0.22, 0.28, 0.30)
    assert source.estimated == ()


def test_given_dimensions_go_before_known_ones():
    dimensions = LoadSource(scenario(bands={"upper_arm": 0.25}, box={"width": 0.27})).dimensions
    assert (dimensions.upper_arm, dimensions.forearm, dimensions.box_width) == (0.25, 0.28, 0.27)


def test_a_given_held_interval_is_taken_as_it_is():
    holding = LoadSource(scenario(task={"held": [2.5, 5.0]})).holding
    assert (holding.start_s, holding.end_s) == (2.5, 5.0)
    assert holding.hand_distance == pytest.approx(0.30, abs=0.06)


@pytest.mark.parametrize("held", [[5.0, 2.0], [-1.0, 3.0], [1.0, 99.0], [3.0, 3.0]])
def test_a_held_interval_outside_the_recording_is_refused(held):
    with pytest.raises(ScenarioError, match=r"task\.held: .* is not an interval of the recording, which lasts 8\.00 s"):
        LoadSource(scenario(task={"held": held}))


def test_the_seed_decides_the_noise():
    first, again, other = (LoadSource(replace(Scenario(), seed=seed)).demonstration.x for seed in (3, 3, 4))
    np.testing.assert_array_equal(first, again)
    assert np.abs(first - other).max() > 1e-3


def still_hands(wander):
    """Hands 0.4 m apart along a line 0.3 rad from x, whose middle wanders along it by `wander` (N,)."""
    t = np.arange(len(wander)) / 100.0
    line = np.array([np.cos(0.3), np.sin(0.3), 0.0])
    x = np.zeros((len(t), 6, 3)) + wander[:, None, None] * line
    x[:, 2] -= 0.2 * line
    x[:, 5] += 0.2 * line
    events = {"grasp": 1.0, "grasp_end": 2.0, "release": 3.0, "release_end": 4.0}
    return TaskMotion(t=t, x=x, recorded=t, events=events), line


def test_the_middle_stays_in_the_boxs_plane_while_the_hands_are_open():
    t = np.arange(501) / 100.0
    wander = np.where(
        t < 1.0, 0.05 * (1 - t), np.where(t > 4.0, 0.03 * (t - 4.0), 0.02 * np.sin(3 * (t - 1) * (4 - t)))
    )
    motion, line = still_hands(wander)
    centred = Centred(motion)
    np.testing.assert_allclose(middle(centred.x)[t < 1.0] @ line, 0.0, atol=1e-12)
    np.testing.assert_allclose(middle(centred.x)[t > 4.0] @ line, 0.0, atol=1e-12)
    inside = (t >= 1.0) & (t <= 4.0)
    np.testing.assert_array_equal(centred.x[inside], motion.x[inside])


def test_centring_moves_all_points_alike(motion):
    t = np.arange(501) / 100.0
    before, _ = still_hands(np.where(t < 1.0, 0.05 * (1 - t), 0.0))
    moved = Centred(before).x - before.x
    np.testing.assert_allclose(moved, np.broadcast_to(moved[:, :1], moved.shape), atol=1e-15)


def test_centring_twice_changes_nothing_more(motion):
    np.testing.assert_allclose(Centred(motion).x, motion.x, atol=2e-4)


def test_a_shift_is_nothing_before_and_everything_after_its_window(motion):
    shift, window = np.array([0.1, -0.2, 0.05]), (3.0, 4.0)
    moved = Shifted(motion, shift, window).x - motion.x
    np.testing.assert_allclose(moved[motion.t <= 3.0], 0.0, atol=1e-15)
    np.testing.assert_allclose(
        moved[motion.t >= 4.0],
        np.broadcast_to(shift, (6, 3))[None].repeat(1, 0) + 0 * moved[motion.t >= 4.0],
        atol=1e-12,
    )
    share = moved[:, 0, 0] / shift[0]
    assert np.diff(share).min() >= -1e-12
    assert share[np.searchsorted(motion.t, 3.5)] == pytest.approx(0.5, abs=1e-6)


def test_raising_reaches_its_height_in_the_middle_and_leaves_the_ends(motion):
    moved = Raised(motion, 0.08, (3.0, 4.5)).x - motion.x
    np.testing.assert_allclose(moved[..., :2], 0.0, atol=1e-15)
    np.testing.assert_allclose(moved[(motion.t <= 3.0) | (motion.t >= 4.5)], 0.0, atol=1e-12)
    inside = (motion.t >= 3.5) & (motion.t <= 4.0)
    np.testing.assert_allclose(moved[inside, :, 2], 0.08, atol=1e-12)
    assert moved.max() <= 0.08 + 1e-12


@pytest.mark.parametrize(
    "change", [lambda m: Shifted(m, [0.1, 0.0, 0.0], (3.0, 4.0)), lambda m: Raised(m, 0.1, (3.0, 4.5))]
)
def test_changes_of_the_motion_are_smooth(motion, change):
    """A quintic step of 0.1 m over a third of 1.5 s accelerates by 10/sqrt(3) 0.1/0.5^2 m/s^2 at most."""
    moved = change(motion).x - motion.x
    assert np.abs(np.diff(moved, 2, axis=0)).max() * 100.0**2 <= 1.02 * (10 / np.sqrt(3)) * 0.1 / 0.5**2


def test_the_hands_close_within_the_dwell_at_the_grasp_and_open_within_that_at_the_release(task):
    hands, events = task.bands.hands, task.skill.events
    assert events["grasp"] < hands.close_s < hands.close_s + hands.duration_s < events["grasp_end"]
    assert events["release"] < hands.open_s < hands.open_s + hands.duration_s < events["release_end"]
    assert task.held == (hands.close_s + hands.duration_s, hands.open_s)


def test_the_hands_distance_is_the_box_and_what_is_given_or_taken(task):
    hands, given = task.bands.hands, Scenario().task
    times = np.array([0.0, hands.close_s, task.held[0], np.mean(task.held), task.held[1], task.skill.tau])
    opened, closed = 0.30 + 2 * given.clearance, 0.30 - 2 * DEFAULT_SQUEEZE
    np.testing.assert_allclose(hands.evaluate(times)[0], [opened, opened, closed, closed, closed, opened])


def test_every_link_starts_inside_its_funnel(task):
    rollout = RollOutTask(Scenario(), task)
    assert rollout.margins[0].min() >= 0.2 - 1e-9
    assert rollout.margins.min() > 0.0


def test_only_the_coupled_rollout_keeps_the_bones(task):
    bones = [0, 1, 3, 4]
    wanted = np.array([0.22, 0.28, 0.28, 0.22])
    coupled, uncoupled = (RollOutTask(Scenario(), task, coupled=c).lengths[:, bones] - wanted for c in (True, False))
    late = slice(round(1.0 / Scenario().simulation.skill_time_step), None)
    assert np.abs(coupled[late]).max() < 0.01
    assert np.abs(uncoupled[late]).max() > 0.02


def test_stretching_slows_skill_events_and_hands_alike(source, motion, task):
    slow = MakeTask(Scenario(), source, motion, 1.5)
    assert slow.skill.tau == pytest.approx(1.5 * task.skill.tau)
    for name, t in task.skill.events.items():
        assert slow.skill.events[name] == pytest.approx(1.5 * t)
    np.testing.assert_allclose(slow.held, 1.5 * np.array(task.held))
    a, b = (RollOutTask(Scenario(), each, coupled=False) for each in (task, slow))
    for share in (0.2, 0.5, 0.8):
        at = [np.searchsorted(r.t, share * each.skill.tau) for r, each in ((a, task), (b, slow))]
        np.testing.assert_allclose(b.x[at[1]], a.x[at[0]], atol=4e-3)


def test_the_rollout_reproduces_the_motion_and_ends_after_the_tail(task):
    rollout = RollOutTask(Scenario(), task, coupled=False)
    assert rollout.t[-1] == pytest.approx(task.skill.tau + Scenario().task.tail, abs=0.005)
    expected = np.stack([np.interp(rollout.t, task.motion.t, c) for c in task.motion.x.reshape(-1, 18).T], -1)
    assert np.sqrt(np.mean((rollout.x.reshape(-1, 18) - expected) ** 2)) < 1e-3


def test_what_learning_and_the_law_refuse_is_refused(source, motion, task):
    with pytest.raises(ScenarioError, match=r"time step 0\.03 s is too long for k_1"):
        RollOutTask(scenario(simulation={"skill_time_step": 0.03}), task)
    with pytest.raises(SkillError, match="alpha_z"):
        MakeTask(scenario(learning={"alpha_z": -1.0}), source, motion)
    with pytest.raises(ScenarioError, match="half widths"):
        MakeTask(scenario(bands={"bone_half_width": 0.0}), source, motion)


@pytest.mark.parametrize(
    ("law", "changes", "gains"),
    [
        ("default", {"gains": {"k_1": 6.0}}, Gains(6.0, 20.0)),
        ("published", {"published": {"k_z": 50.0, "k_2": 1.0}}, PublishedGains(50.0, 0.2, 1.0, 150.0)),
        ("published_loop", {}, PublishedGains()),
        ("published_lagged", {"published": {"largest_rate": 9.0}}, PublishedGains(largest_rate=9.0)),
        ("gams", {"gams": {"c_k": 20.0, "c_2": 2.0}}, GamsGains(20.0, 2.0)),
        ("none", {}, None),
    ],
)
def test_every_law_gets_its_own_gains(law, changes, gains):
    assert LawGains(replace(scenario(**changes), law=law)) == gains


@pytest.mark.parametrize("law", ["published", "published_loop", "gams", "none"])
def test_every_law_rolls_out_and_changes_something(task, law):
    rollout = RollOutTask(replace(Scenario(), law=law), task)
    uncoupled = RollOutTask(Scenario(), task, coupled=False)
    assert np.all(np.isfinite(rollout.x))
    assert (np.abs(rollout.x - uncoupled.x).max() > 0.02) == (law != "none")


def test_a_law_that_grows_without_bound_is_refused(task):
    with pytest.raises(
        SkillError, match=r"law published_lagged: .* grows without bound, past 100 m at 0\.\d\d s; use another"
    ):
        RollOutTask(replace(Scenario(), law="published_lagged"), task)
