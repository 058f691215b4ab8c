"""A motion without a box: what is played, the hands' own moving distance, what the arms make of it, and the limits."""

from dataclasses import replace

import numpy as np
import pytest
from waving import FOREARM, UPPER_ARM, recorded, wave

from drake_blfdmp.demonstration.smoothing import smooth
from drake_blfdmp.demonstration.timing import TaskMotion
from drake_blfdmp.errors import RecordingError, ScenarioError, TaskError
from drake_blfdmp.planning import plan as planning
from drake_blfdmp.planning.free_plan import REMEDY, CentralSample, HandNotes, LeastApart, MakeFreePlan
from drake_blfdmp.planning.plan import MakePlan
from drake_blfdmp.planning.scenario import RetargetConfig, Scenario, TaskConfig
from drake_blfdmp.planning.sources import MOTION_HINT, MakeSource
from drake_blfdmp.planning.task import DesiredApart, MakeMotion, MakeTask, RollOutTask
from drake_blfdmp.robot.clearance import ClearanceChecker
from drake_blfdmp.robot.retargeting import retarget_motion
from drake_blfdmp.skeleton import HANDS
from drake_blfdmp.skill.profiles import RecordedDistance
from drake_blfdmp.skill.rollout import Rollout

MOTION = Scenario(task=TaskConfig(kind="motion"), retarget=RetargetConfig(world=[0.0, 0.3, 1.0], scale=0.8))


def source_of(scenario=MOTION, **options):
    return MakeSource(scenario, [recorded(*wave(**options))])


def planned(**options):
    """The plan of a waving person, at one place, so that the search is short."""
    return MakeFreePlan(MOTION, source_of(**options))


@pytest.fixture(scope="module")
def plan():
    return planned()


@pytest.fixture(scope="module")
def close_plan():
    """Hands that come together to 4 mm."""
    return planned(apart=0.2, sweep=0.1)


def test_a_hold_refuses_it_and_says_how_to_play_it():
    with pytest.raises(RecordingError, match=f"one hand carries, or none.*, {MOTION_HINT}$") as caught:
        source_of(Scenario())
    assert "\n" not in str(caught.value)


def test_the_source_is_the_whole_recording_and_has_no_box():
    source = source_of()
    assert (source.holding.start_s, source.holding.end_s) == (0.0, source.demonstration.duration_s)
    assert source.dimensions.box_width is None
    assert source.estimated == ("upper_arm", "forearm")
    assert source.dimensions.upper_arm == pytest.approx(UPPER_ARM, abs=1e-3)
    assert source.dimensions.forearm == pytest.approx(FOREARM, abs=1e-3)


def test_an_interval_is_played_alone():
    scenario = replace(MOTION, task=replace(MOTION.task, held=[1.0, 3.5]))
    source = source_of(scenario)
    motion = MakeMotion(scenario, source)
    assert (source.holding.start_s, source.holding.end_s) == (1.0, 3.5)
    assert motion.recorded[0] == 1.0 and motion.recorded[-1] == pytest.approx(3.5)
    assert set(motion.events) == {"start", "end"}
    with pytest.raises(ScenarioError, match=r"task\.held: 1 to 9 s is not an interval of the recording"):
        source_of(replace(MOTION, task=replace(MOTION.task, held=[1.0, 9.0])))


def test_more_than_two_minutes_are_refused_at_once():
    source = source_of(duration_s=125.0)
    with pytest.raises(ScenarioError, match=r"motion: 125\.0 s would be played, .* 120 s; choose an interval"):
        MakeFreePlan(MOTION, source)


def test_the_plan_has_no_box_no_table_and_nothing_held(plan):
    assert plan.box is None and plan.start is None and plan.goal is None and plan.tables == []
    assert plan.task.box_width is None
    with pytest.raises(TypeError, match="nothing is held"):
        _ = plan.task.held


def test_every_link_keeps_its_moving_band_at_every_step(plan, close_plan):
    for each in (plan, close_plan):
        assert each.coupled.margins.min() > 0.0
        bones = [0, 1, 3, 4]
        wanted = np.array([each.source.dimensions.upper_arm, each.source.dimensions.forearm])[[0, 1, 1, 0]]
        late = each.coupled.t > 1.0
        assert np.abs(each.coupled.lengths[late][:, bones] - wanted).max() < 0.01


def test_the_hands_desired_distance_is_the_persons_own(plan):
    _, x = wave()
    t = plan.source.demonstration.t
    apart = np.linalg.norm(smooth(t, x, 1.2)[:, 5] - smooth(t, x, 1.2)[:, 2], axis=-1)
    motion = plan.task.motion
    wanted = np.interp(motion.recorded, t, apart)
    desired, rate, _ = plan.task.bands.desired(motion.t * plan.stretch)
    np.testing.assert_allclose(desired[:, HANDS], wanted, atol=1e-3)
    assert np.abs(rate[:, HANDS]).max() > 0.1  # It moves.
    assert isinstance(plan.task.bands.hands, RecordedDistance)


def test_the_hands_band_is_the_papers_around_it(plan):
    bands = plan.task.bands.evaluate(np.array([0.0, 5.0]))
    np.testing.assert_allclose(bands[:, 1, HANDS] - bands[:, 0, HANDS], [0.06, 0.02], atol=1e-5)


def test_the_arms_follow_it_and_are_slowed_down_as_far_as_they_need(plan):
    assert plan.reach.sound and plan.stretch >= 1.0
    assert plan.duration_s == pytest.approx(plan.stretch * plan.task.motion.t[-1] + MOTION.task.tail, abs=0.01)
    first = np.searchsorted(plan.coupled.t, plan.settle_s)
    palms = retarget_motion(plan.coupled.x[first], plan.coupled.velocity[first], plan.retarget)[0]
    assert np.linalg.norm(palms[1, 4:] - palms[0, 4:]) > 0.1


def test_hands_that_meet_are_kept_apart_as_far_as_palms_must_be_and_it_is_said(close_plan):
    note = next(note for note in close_plan.notes if note.startswith("hands kept at least"))
    assert "where the person's come to 0.00" in note
    least = LeastApart(MOTION, close_plan.retarget.hands_scale)
    times = np.linspace(0.0, close_plan.duration_s, 2000)
    desired = close_plan.task.bands.desired(times)[0][:, HANDS]
    assert least - 1e-6 <= desired.min() < least + 0.005
    assert close_plan.reach.clearance >= 0.02


def test_the_least_distance_is_that_at_which_the_palms_clear_each_other(close_plan):
    """Palms clear each other by their distance: at the closest posture nothing else is nearer."""
    checker, plan = ClearanceChecker(max_distance=0.2), close_plan
    palms = retarget_motion(plan.coupled.x, plan.coupled.velocity, plan.retarget)[0][..., 4:]
    apart = np.linalg.norm(palms[:, 1] - palms[:, 0], axis=-1)
    followed = np.minimum((plan.reach.samples * plan.stretch).astype(int), len(apart) - 1)
    k = int(np.argmin(apart[followed]))
    distance, names = checker.min_clearance(plan.reach.following.q[k])
    assert {name.split("::")[1] for name in names} == {"palm"}
    assert distance == pytest.approx(apart[followed[k]], abs=2e-3)


def test_palms_that_go_a_shorter_way_need_hands_farther_apart():
    assert LeastApart(MOTION, 1.0) == pytest.approx(0.04)
    assert LeastApart(MOTION, 0.5) == pytest.approx(0.07)
    wide = replace(MOTION, bands=replace(MOTION.bands, hands_half_width=0.02))
    assert LeastApart(wide, 1.0) == pytest.approx(0.05)


def made_up(apart):
    x = np.zeros((len(apart), 6, 3))
    x[:, 5, 0] = apart
    return TaskMotion(t=np.arange(len(apart)) / 100.0, x=x, recorded=np.zeros(len(apart)), events={})


def test_hands_that_stay_apart_are_left_as_they_are_and_nothing_is_said():
    motion = made_up(np.array([0.3, 0.2, 0.1]))
    np.testing.assert_array_equal(DesiredApart(motion, 0.04), [0.3, 0.2, 0.1])
    assert HandNotes(motion, 0.04, 1.0) == []
    (note,) = HandNotes(motion, 0.04, 0.5)
    assert "0.5 of the person's" in note


def test_the_anchor_is_the_most_central_sample_after_the_rest():
    x = np.zeros((5, 6, 3))
    x[:, 2, 0] = x[:, 5, 0] = [0.0, 4.0, 2.0, 1.0, 9.0]
    rollout = Rollout(t=np.arange(5.0), x=x, velocity=0 * x, bands=None)
    assert CentralSample(rollout, 0.0) == 2
    assert CentralSample(rollout, 3.0) == 3  # Medians of two lie between: the first of the equally near.


def test_what_the_arms_cannot_reach_is_refused_in_one_line_with_what_to_do():
    far = replace(MOTION, retarget=replace(MOTION.retarget, world=[0.0, 3.0, 1.0]))
    with pytest.raises(TaskError, match=f"^reach: [^\n]*{REMEDY.split(',')[0].replace('[', '.').replace(']', '.')}"):
        MakeFreePlan(far, source_of())


def test_make_plan_takes_the_way_of_the_kind(monkeypatch):
    taken = []
    monkeypatch.setattr(planning, "LoadSource", lambda scenario, progress: source_of(scenario))
    monkeypatch.setattr(planning, "MakeFreePlan", lambda *arguments: taken.append(arguments) or "free")
    assert MakePlan(MOTION) == "free"
    assert taken[0][0] is MOTION
    with pytest.raises(RecordingError, match="task.kind=motion"):
        MakePlan(Scenario())


def test_several_recordings_of_a_motion_become_their_mean():
    t, x = wave()
    noisy = [x + 0.01 * np.sin(3.0 * t + k)[:, None, None] for k in (0.0, np.pi)]
    source = MakeSource(MOTION, [recorded(t, each) for each in noisy])
    assert source.together is not None and source.dimensions.box_width is None
    motion = MakeMotion(MOTION, source)
    assert motion.t[-1] == pytest.approx(5.0 + 0.7 + 1.0, abs=0.2)
    task = MakeTask(MOTION, source, motion)
    assert task.skill.spread is not None
    assert RollOutTask(MOTION, task).margins.min() > 0.0
