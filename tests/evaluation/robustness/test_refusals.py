"""Refusals are looked at once more: what no arms can reach is told from what they can, and both are counted."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.multibody.inverse_kinematics import InverseKinematics
from pydrake.solvers import SnoptSolver

from drake_blfdmp.evaluation.robustness import refusals
from drake_blfdmp.evaluation.robustness.joined_postures import JoinedPostures
from drake_blfdmp.evaluation.robustness.reach_search import REGION, ReachSearch, Way
from drake_blfdmp.evaluation.robustness.refusals import (
    RefusalCheck,
    check_reach,
    refusal_table,
    refusals_right,
    sample,
)
from drake_blfdmp.evaluation.robustness.trial import make_trials
from drake_blfdmp.evaluation.studies.intervals import proportion
from drake_blfdmp.planning.scenario import Scenario
from drake_blfdmp.robot.plant import ARMS, MakeKinematicPlant, ReadJointLimits
from drake_blfdmp.robot.reach_evaluation import JOINT_MARGIN

EASY = Way(
    apart=((0.27, 0.40), (0.27,), (0.27, 0.40)),
    yaw=np.zeros(3),
    way=np.array([[0.0, 0.0, 0.0], [0.05, 0.0, 0.2], [0.1, 0.05, 0.03]]),
    share=np.array([0.0, 0.5, 1.0]),
    shift=np.zeros(3),
    level=True,
)


@pytest.fixture(scope="module")
def search():
    return ReachSearch()


@pytest.mark.parametrize("yaw", [0.0, 0.5, -0.7])
def test_where_palms_can_face_each_other_is_where_drake_finds_postures(search, yaw):
    """Against InverseKinematics from many starts, which knows no closed form."""
    plant = MakeKinematicPlant()
    arms = [plant.GetModelInstanceByName(arm) for arm in ARMS]
    rng = np.random.default_rng(7)
    middles = rng.uniform([-0.4, 0.1, 0.2], [0.4, 1.0, 1.5], (12, 3))
    found = search.facing(middles, 0.3, yaw)
    assert 2 <= found.sum() <= 10
    normal = np.array([np.cos(yaw), np.sin(yaw), 0.0])
    for middle, facing in zip(middles, found, strict=True):
        assert facing == all(
            drake_reaches(plant, arm, middle + sign * 0.15 * normal, -sign * normal, rng)
            for arm, sign in zip(arms, (-1.0, 1.0), strict=True)
        )


def drake_reaches(plant, arm, palm, normal, rng):
    """Whether Drake finds a posture with the palm there, to 0.1 mm and 0.01 degrees, from one of 30 starts."""
    ik = InverseKinematics(plant, True)
    frame = plant.GetFrameByName("palm", arm)
    ik.AddPositionConstraint(
        frameB=frame, p_BQ=np.zeros(3), frameA=plant.world_frame(), p_AQ_lower=palm - 1e-4, p_AQ_upper=palm + 1e-4
    )
    ik.AddAngleBetweenVectorsConstraint(plant.world_frame(), normal, frame, np.array([0.0, 0.0, 1.0]), 0.0, 2e-4)
    limits = ReadJointLimits(plant, [plant.GetModelInstanceByName(name) for name in ARMS])
    starts = rng.uniform(limits.lower, limits.upper, (30, 14))
    return any(SnoptSolver().Solve(ik.prog(), start, None).is_success() for start in starts)


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("side", [0, 1])
def test_the_region_goes_as_far_as_arms_reach(search, axis, side):
    """On its faces nothing is reached, so beyond them neither: a way that begins there cannot be."""
    axes = [np.arange(low, high + 1e-9, 0.12) for low, high in zip(*REGION, strict=True)]
    axes[axis] = np.array([REGION[side][axis]])
    face = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    assert not any(search.facing(face, 0.2, yaw).any() for yaw in (-0.7, 0.0, 0.7))


def test_what_is_out_of_reach_has_none(search):
    assert not search.facing([[0.0, 1.3, 0.7], [0.0, 0.45, 1.9], [0.9, 0.4, 0.7]], 0.3, 0.0).any()
    assert not search.facing([[0.0, 0.45, 0.8]], 2.0, 0.0).any()
    assert search.facing(np.empty((0, 3)), 0.3, 0.0).shape == (0,)


def test_the_whole_way_counts_and_one_table_has_one_height(search):
    found, tried, had = search.search(EASY, spacing=0.2)
    assert len(found) == 1 and tried >= 1 and had == 1
    place, scale = found[0]
    middles = EASY.middles(place, scale)
    np.testing.assert_allclose(middles[0], place)
    np.testing.assert_allclose(middles[-1], place + scale * np.array([0.1, 0.05, 0.0]))
    assert middles[1, 2] == pytest.approx(place[2] + scale * (0.2 - 0.5 * 0.03))
    assert search.facing(middles, 0.27, 0.0).all()
    stairs = replace(EASY, level=False, shift=np.array([0.0, 0.0, 0.1]))
    assert stairs.middles(place, scale)[-1, 2] == pytest.approx(place[2] + scale * 0.03 + 0.1)
    for k in (1, 2):  # Not only the ends.
        way = EASY.way.copy()
        way[k, 0] = 9.0
        assert search.search(replace(EASY, way=way), spacing=0.3)[0] == []


@pytest.mark.parametrize("level", [True, False])
@pytest.mark.parametrize("scale", [0.5, 1.0])
def test_a_box_may_be_led_straight_up_over_and_straight_down(level, scale):
    """The ends stay where they are; between them it goes over the higher one, and over the ground only up there."""
    count = 25
    way = Way(
        apart=((0.27, 0.40), *[(0.27,)] * (count - 2), (0.27, 0.40)),
        yaw=np.zeros(count),
        way=np.linspace([0.0, 0.0, 0.0], [0.1, 0.4, 0.03], count),
        share=np.linspace(0.0, 1.0, count) ** 2,
        shift=np.array([0.2, 0.1, -0.3]),
        level=level,
    )
    grasp = np.array([0.1, 0.4, 0.7])
    own, led = (replace(way, over=over).middles(grasp, scale) for over in (None, 0.15))
    np.testing.assert_allclose(led[[0, -1]], own[[0, -1]], atol=1e-12)
    top = max(own[0, 2], own[-1, 2]) + 0.15
    assert np.all(led[:, 2] <= top + 1e-12) and np.all(np.diff(led[:, 1]) >= -1e-12)
    across = slice(count // 3, -(count // 3))
    np.testing.assert_allclose(led[across, 2], top)
    np.testing.assert_allclose(led[: across.start, :2], np.tile(own[0, :2], (across.start, 1)), atol=1e-12)
    np.testing.assert_allclose(led[across.stop :, :2], np.tile(own[-1, :2], (-across.stop, 1)), atol=1e-12)
    assert all(np.ptp(part[:, 2]) > 0.1 for part in (led[: across.start], led[across.stop :]))


def scenario_with(**offsets):
    scenario = Scenario()
    return replace(scenario, task=replace(scenario.task, **offsets))


def test_a_release_metres_away_is_rightly_refused(monkeypatch):
    monkeypatch.setattr(ReachSearch.search, "__defaults__", (0.3, *ReachSearch.search.__defaults__[1:]))
    right, evidence = check_reach(scenario_with(place_offset=[3.0, 0.0, 0.0]))
    assert right is True and "no postures" in evidence


def test_a_task_that_can_be_done_is_wrongly_refused(monkeypatch):
    tried = []

    def succeed(scenario):
        tried.append(scenario)
        return True, "carried with up to 70 N", ""

    monkeypatch.setattr(refusals, "run_anyway", succeed)
    monkeypatch.setattr(refusals, "PLACES_TRIED", 1)
    right, evidence = check_reach(scenario_with(place_offset=[0.05, 0.0, 0.0]))
    assert right is False and "succeeds with retarget.scale=" in evidence
    assert tried[0].retarget.world is not None and tried[0].task.place_offset == [0.05, 0.0, 0.0]
    monkeypatch.setattr(refusals, "run_anyway", lambda scenario: (False, "dropped", ""))
    right, evidence = check_reach(scenario_with(place_offset=[0.05, 0.0, 0.0]))
    assert right is False and "dropped" in evidence


def test_what_is_refused_for_force_is_run_without_heed_of_it_squeeze_by_squeeze(monkeypatch):
    tried = []

    def drop(scenario, limit, *, heed_force):
        tried.append((scenario, heed_force))
        return False, "The box was dropped.", ""

    monkeypatch.setattr(refusals, "run_anyway", drop)
    base = Scenario()
    heavy = replace(
        base,
        box=replace(base.box, mass=9.0),
        task=replace(base.task, squeeze=0.02),
        reality=replace(base.reality, mass_scale=0.5, friction_scale=1.2),
    )
    right, evidence = refusals.check_force(heavy)
    assert right is True and evidence.count("dropped") == len(refusals.SQUEEZES) and "84 N" in evidence
    forces = [scenario.task.squeeze_force for scenario, _ in tried]
    assert sorted(forces) == pytest.approx([48.0, 60.0, 72.0, 84.0, 96.0, 108.0])
    for scenario, heeded in tried:
        assert heeded is False and scenario.task.squeeze is None
        # The box that the planner was told of.
        assert scenario.box == heavy.box and (scenario.reality.mass_scale, scenario.reality.friction_scale) == (1, 1)


def test_only_what_keeps_the_margins_that_arms_keep_is_a_way(monkeypatch):
    """The same limits and clearance as in a plan's reach, whatever else it does."""
    asked = []

    class Never(JoinedPostures):
        def __init__(self, limits, clearance):
            super().__init__(limits, clearance)
            asked.append((limits, clearance))

        def reached(self, *args):
            return 0

    monkeypatch.setattr(refusals, "JoinedPostures", Never)
    monkeypatch.setattr(ReachSearch.search, "__defaults__", (0.4, *ReachSearch.search.__defaults__[1:]))
    assert check_reach(Scenario())[0] is True
    [(limits, clearance)] = asked
    plant = MakeKinematicPlant()
    own = ReadJointLimits(plant, [plant.GetModelInstanceByName(name) for name in ARMS])
    assert np.all(limits.lower == own.lower + JOINT_MARGIN) and np.all(limits.upper <= own.upper - JOINT_MARGIN)
    assert clearance == Scenario().retarget.clearance > 0.0


def test_one_squeeze_that_carries_shows_that_a_refusal_for_force_is_wrong(monkeypatch):
    def carry(scenario, limit, *, heed_force):
        force = scenario.task.squeeze_force
        return (True, "carried with up to 90 N", "") if force < 65.0 else (False, "carried, but with up to 130 N", "")

    monkeypatch.setattr(refusals, "run_anyway", carry)
    right, evidence = refusals.check_force(Scenario())
    assert right is False and evidence == "squeezed with 60 N: carried with up to 90 N"
    monkeypatch.setattr(refusals, "run_anyway", lambda scenario, limit, heed_force: (False, "out of reach", "reach"))
    right, evidence = refusals.check_force(Scenario())
    assert right is False and evidence == "not shown: out of reach"


def test_what_is_refused_for_clearance_is_run_without_heed_of_it(monkeypatch):
    heeded = []

    def carry(scenario, *, heed_clearance):
        heeded.append(heed_clearance)
        return True, "carried with up to 70 N", ""

    monkeypatch.setattr(refusals, "run_anyway", carry)
    monkeypatch.setattr(refusals, "check_reach", None)  # Is not asked.
    assert refusals.check_clearance(Scenario()) == (False, "carried with up to 70 N") and heeded == [False]


@pytest.mark.parametrize("right", [True, False])
@pytest.mark.parametrize(
    ("answer", "told"),
    [
        ((False, "It fell.", ""), "without heed of the tables: It fell. And with it: at no place"),
        ((False, "they overlap", "clearance"), "at no place"),
    ],
)
def test_that_it_fails_without_heed_of_the_tables_does_not_show_that_there_is_no_other_way(
    monkeypatch, answer, told, right
):
    monkeypatch.setattr(refusals, "run_anyway", lambda scenario, heed_clearance: answer)
    monkeypatch.setattr(refusals, "check_reach", lambda scenario: (right, "at no place"))
    found, evidence = refusals.check_clearance(Scenario())
    assert found is right and evidence == told


def test_places_where_the_arms_do_not_get_along_are_none(search):
    asked = []

    def never(place, scale):
        asked.append((tuple(place), scale))
        return False

    found, tried, had = search.search(EASY, spacing=0.4, joined=never)
    assert found == [] and had == len(asked) == len(set(asked)) and tried >= had > 0
    assert len({scale for _, scale in asked}) > 1  # Every scale is asked for.


def test_a_reach_in_which_the_arms_overlap_is_rightly_refused(monkeypatch):
    monkeypatch.setattr(ReachSearch.search, "__defaults__", (0.4, *ReachSearch.search.__defaults__[1:]))
    monkeypatch.setattr(refusals.JoinedPostures, "reached", lambda *args: 0)
    right, evidence = check_reach(scenario_with(place_offset=[0.05, 0.0, 0.0]))
    assert right is True and "but the arms jump, or get into each other" in evidence


def test_checks_are_sampled_counted_and_told():
    trials = make_trials(Scenario(), "default", 5)
    kinds = ["reach", None, "input", "reach", "force"]
    rows = [
        {"verdict": "refused", "classes": [kind]} if kind else {"verdict": "success", "classes": []} for kind in kinds
    ]
    checks = sample(trials, rows, 2)
    assert [check.trial.task.index for check in checks] == [0, 3]
    assert [check.reason for check in sample(trials, rows, 9)] == ["reach", "reach", "force"]
    assert isinstance(checks[0], RefusalCheck) and checks[0].key != trials[0].key
    results = [checks[0].crashed("no end after 9 s, killed"), checks[1].crashed("") | {"right": True}]
    assert refusals_right(results) == proportion(1, 2) and refusals_right([]) is None
    told = ("robustness-0-0000-default", "reach", False, "not shown: no end after 9 s, killed")
    assert refusal_table(results).rows()[0] == told
