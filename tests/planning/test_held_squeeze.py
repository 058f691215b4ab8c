"""What is predicted of a squeezed box along the default run's way, and the squeeze that is chosen by it."""

import re
from dataclasses import replace

import numpy as np
import pytest

from drake_blfdmp.errors import TaskError
from drake_blfdmp.planning import held_squeeze
from drake_blfdmp.planning.held_squeeze import HeldSqueeze, Way
from drake_blfdmp.planning.scenario_sections import TaskConfig
from drake_blfdmp.planning.squeeze import ARMS_NEED, UNSURE, ChooseSqueeze, Compliances, NeededForce, WantedForce
from drake_blfdmp.planning.task import DEFAULT_SQUEEZE
from drake_blfdmp.robot.box import BoxParameters
from drake_blfdmp.robot.plant import MakeKinematicPlant

HEAVY = BoxParameters(width=0.3, mass=4.0, friction=0.5)


@pytest.fixture(scope="module")
def way(default_plan):
    first, last = default_plan.task.held
    # The samples were taken before the motion was slowed down.
    t = default_plan.stretch * default_plan.scenario.simulation.skill_time_step * default_plan.reach.samples
    postures = default_plan.reach.following.q[(t >= first) & (t <= last)]
    plant, below = MakeKinematicPlant(), default_plan.scenario.task.grasp_above
    return Way(plant, postures, DEFAULT_SQUEEZE, below, 0.4, Compliances(plant, postures))


@pytest.fixture(scope="module")
def compliances(way):
    return Compliances(way.plant, way.postures)


@pytest.fixture(scope="module")
def per_depth(compliances):
    """Mean force over the depth, N/m."""
    return float(2.0 * np.mean(1.0 / compliances))


@pytest.mark.parametrize(
    ("force", "limit", "what", "more_helps"),
    [
        (50.0, 120.0, "it slips", True),  # Simulated, it tilts by 14 degrees; with 60 N by 7.
        (60.0, 120.0, "it slips", True),
        (75.0, 120.0, None, None),  # Simulated, it is carried, tilted by half a degree.
        (75.0, 80.0, "a palm may press with", False),
        (200.0, 1000.0, "a motor needs", False),
    ],
)
def test_problems_of_a_heavy_box(way, per_depth, force, limit, what, more_helps):
    found = HeldSqueeze(way, HEAVY, limit).problem(force / per_depth)
    if what is None:
        assert found is None
    else:
        assert found.what.startswith(what) and found.more_helps == more_helps


@pytest.mark.parametrize(
    ("mass", "friction", "too_little", "enough"),
    [(1.0, 0.8, 12.0, 14.0), (1.0, 0.313, 22.0, 25.0), (3.0, 0.8, 38.0, 42.0), (4.0, 0.5, 60.0, 75.0)],
)
def test_the_least_squeeze_is_that_of_the_simulated_arms(way, per_depth, mass, friction, too_little, enough):
    """Of boxes of docs/contact.md, carried out with these squeezes."""
    held = HeldSqueeze(way, BoxParameters(width=0.3, mass=mass, friction=friction), 120.0)
    assert held.problem(too_little / per_depth).more_helps
    assert held.problem(enough / per_depth) is None


def test_a_closed_loop_keeps_the_force_even_along_the_way(way, per_depth, monkeypatch):
    """Without it one depth presses the harder the stiffer the arms are."""
    seen, real = [], held_squeeze.CarryQuasiStatically

    def carry(*given, slides):
        seen.append(real(*given, slides=slides))
        return seen[-1]

    monkeypatch.setattr(held_squeeze, "CarryQuasiStatically", carry)
    for one in (way, replace(way, compliances=None)):
        assert HeldSqueeze(one, BoxParameters(width=0.3), 120.0).problem(55.0 / per_depth) is None
    even, uneven = (hold.force for hold in seen[::2])
    assert np.ptp(even) < 0.1 * even.mean() < 0.5 * np.ptp(uneven)
    assert even.mean() == pytest.approx(uneven.mean(), rel=0.05)


def test_a_light_box_has_none_and_bears_to_be_worse(way, per_depth):
    held = HeldSqueeze(way, BoxParameters(width=0.3), 120.0)
    assert held.problem(55.0 / per_depth) is None and held.problem(55.0 / per_depth, worse=UNSURE) is None


def test_the_depth_found_is_the_least_that_holds_what_is_worse_too(way, per_depth):
    held = HeldSqueeze(way, BoxParameters(width=0.3, mass=2.0, friction=0.6), 120.0)
    depth, told = held.find(per_depth, UNSURE)
    assert told == "" and held.problem(depth, worse=UNSURE) is None
    assert held.problem(0.8 * depth, worse=UNSURE) is not None


def test_where_nothing_holds_what_is_worse_the_depth_is_well_among_those_that_hold(way, per_depth):
    held = HeldSqueeze(way, HEAVY, 120.0)
    depth, told = held.find(per_depth, UNSURE)
    assert held.problem(depth) is None and "20% heavier and smoother is not" in told
    for factor, more_helps in ((1.08, None), (1.3, False), (1 / 1.2, None), (1 / 1.4, True)):
        problem = held.problem(factor * depth)
        assert (problem and problem.more_helps) is more_helps


@pytest.mark.parametrize(
    ("box", "limit", "told"),
    [
        (BoxParameters(width=0.3, mass=10.0, friction=0.8), 120.0, "with 120 N it slips"),
        (HEAVY, 76.0, r"with 6\d(\.\d)? N it slips, with 6\d(\.\d)? N a palm may press with (7|8)\d N"),
    ],
)
def test_what_cannot_be_held_is_told_with_its_forces(way, per_depth, box, limit, told):
    depth, why = HeldSqueeze(way, box, limit).find(per_depth, UNSURE)
    assert depth is None and re.search(told, why)


def test_a_squeeze_that_holds_a_worse_box_is_kept(way, per_depth):
    held = HeldSqueeze(way, BoxParameters(width=0.3), 120.0)
    assert held.harder(55.0 / per_depth, 80.0 / per_depth, UNSURE) == 55.0 / per_depth


def test_a_squeeze_in_which_a_worse_box_slips_is_made_harder_until_it_holds(way, per_depth):
    held = HeldSqueeze(way, BoxParameters(width=0.3, mass=2.5, friction=0.6), 120.0)
    assert held.problem(45.0 / per_depth, worse=UNSURE).more_helps
    depth, step = held.harder(45.0 / per_depth, 75.0 / per_depth, UNSURE), 30.0 / (held_squeeze.HARDER_TRIED - 1)
    assert held.problem(depth, worse=UNSURE) is None and held.problem(depth) is None
    assert held.problem(depth - step / per_depth, worse=UNSURE) is not None


def test_where_nothing_holds_a_worse_box_it_is_squeezed_as_hard_as_palms_and_motors_bear(way, per_depth):
    held = HeldSqueeze(way, HEAVY, 120.0)
    depth, step = held.harder(75.0 / per_depth, 110.0 / per_depth, UNSURE), 35.0 / (held_squeeze.HARDER_TRIED - 1)
    assert held.problem(depth, worse=UNSURE) is not None
    assert held.problem(depth) is None and held.problem(depth + step / per_depth).more_helps is False


def test_what_leaves_no_room_for_uneven_palms_is_squeezed_harder_where_it_is_predicted_to_be_borne(
    way, compliances, per_depth
):
    box, room = BoxParameters(width=0.3, mass=2.9, friction=0.5), np.full(len(compliances), 30.0)
    strong, held = np.full(len(compliances), 200.0), HeldSqueeze(way, box, 120.0)

    def choose(held, **task):
        return ChooseSqueeze(TaskConfig(**task), box, compliances, strong, room, 0.4, held)

    careful, predicted = choose(None), choose(held)
    assert held.problem(careful.depth, worse=UNSURE) is not None
    assert held.problem(predicted.depth, worse=UNSURE) is None and predicted.force <= WantedForce(box, 0.4) + 1e-9
    assert "may need it" in predicted.notes[0]
    for task in ({"squeeze_force": 48.0}, {"squeeze": 48.0 / per_depth}):  # What is asked for is asked for.
        assert choose(held, **task).force == pytest.approx(48.0)


def test_where_the_prediction_may_be_wrong_the_depth_is_found_and_the_doubt_is_told(way, per_depth):
    held = HeldSqueeze(way, BoxParameters(width=0.3, mass=5.5, friction=0.5), 120.0)
    depth, told = held.find(per_depth, UNSURE)
    assert re.fullmatch(r"though barely, and it may fail: with 9\S+ N it slips, with 9\S+ N a motor needs .*", told)
    assert held.problem(depth) is not None
    doubtful = {"worse": -held_squeeze.DOUBT, "effort": held_squeeze.DOUBTFUL_EFFORT}
    assert held.problem(depth, **doubtful, at_best=True) is None


def test_a_box_that_its_table_holds_and_one_that_slides_are_both_looked_at(way, per_depth, monkeypatch):
    held, real, fails = HeldSqueeze(way, BoxParameters(width=0.3), 120.0), held_squeeze.CarryQuasiStatically, set()

    def carry(*given, slides):
        hold = real(*given, slides=slides)
        return replace(hold, lost=True) if slides in fails else hold

    monkeypatch.setattr(held_squeeze, "CarryQuasiStatically", carry)
    for failing, at_worst, at_best in ((set(), False, False), ({True}, True, False), ({False}, True, False),
                                       ({True, False}, True, True)):  # fmt: skip
        fails.clear()
        fails.update(failing)
        assert (held.problem(55.0 / per_depth) is not None) is at_worst
        assert (held.problem(55.0 / per_depth, at_best=True) is not None) is at_best


def test_a_box_that_rules_of_thumb_refuse_is_carried_where_it_is_predicted_to_hold(way, compliances, per_depth):
    def choose(box=HEAVY, **task):
        strong, held = np.full(len(compliances), 70.0), HeldSqueeze(way, box, TaskConfig(**task).force_limit)
        return ChooseSqueeze(TaskConfig(**task), box, compliances, strong, strong, 0.4, held)

    assert NeededForce(HEAVY, 0.4, ARMS_NEED) > 70.0
    found = choose()
    assert 65.0 < found.force < 100.0 and found.force == pytest.approx(found.depth * per_depth)
    assert "predicted to hold a box of 4 kg with friction 0.5" in found.notes[0]
    assert choose(squeeze_force=75.0).force == pytest.approx(75.0)
    for box, task in ((HEAVY, {"squeeze_force": 50.0}), (HEAVY, {"squeeze": 50.0 / per_depth})):
        with pytest.raises(
            TaskError, match=r"^force: .*4 kg .* cannot be held: with 50 N it slips; use a lighter"
        ) as told:
            choose(box, **task)
        assert told.value.reason == "force"
    assert choose(squeeze=75.0 / per_depth, squeeze_force=50.0).force == pytest.approx(75.0)  # As without a prediction.
    with pytest.raises(TaskError, match="12 kg with friction 0.5 cannot be held: "):
        choose(BoxParameters(width=0.3, mass=12.0, friction=0.5))
