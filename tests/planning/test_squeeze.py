"""How hard the palms press: what is asked, what the box needs, never more than is allowed."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drake_blfdmp.errors import TaskError
from drake_blfdmp.planning.scenario_sections import TaskConfig
from drake_blfdmp.planning.squeeze import (
    ARMS_NEED,
    OVERSHOOT,
    UNEVEN,
    USUAL_FORCE,
    AskedSqueeze,
    ChooseSqueeze,
    Compliances,
    NeededForce,
    RefuseForce,
    SqueezeCompliance,
    Strengths,
    WantedForce,
)
from drake_blfdmp.robot.box import BoxParameters
from drake_blfdmp.robot.contact import palm_stiffness
from drake_blfdmp.robot.grasp_force import largest_squeeze
from drake_blfdmp.robot.plant import ARMS, DEFAULT_STIFFNESS, HOME, MakeKinematicPlant

COMPLIANCES = 2.0 / np.array([4500.0, 5000.0, 6000.0])  # Two palms of 4.5, 5 and 6 N/mm each.
STRONG = np.full(3, 500.0)
HEAVY = BoxParameters(mass=3.0, friction=0.5)


LIGHT = BoxParameters()


def choose(box=LIGHT, acceleration=0.4, strengths=STRONG, uneven=STRONG, **task):
    return ChooseSqueeze(TaskConfig(**task), box, COMPLIANCES, strengths, uneven, acceleration)


def forces(squeeze):
    return 2.0 * squeeze.depth / COMPLIANCES


@pytest.mark.parametrize("asked", [20.0, 40.0, 70.0])
def test_the_mean_force_is_the_one_that_is_asked_for(asked):
    squeeze = choose(squeeze_force=asked)
    assert squeeze.force == pytest.approx(asked) == np.mean(forces(squeeze))
    assert squeeze.notes == ()


def test_a_light_box_gets_the_usual_force_and_a_heavy_one_what_it_needs_with_a_note():
    assert choose().force == pytest.approx(USUAL_FORCE) and choose().notes == ()
    heavy = choose(HEAVY)
    # 2.2 m (g + a) / (2 mu), mu = 2 n 0.8 / (n + 0.8), of a box a fifth heavier and smoother: m = 3.6, n = 0.4
    assert heavy.force == pytest.approx(2.2 * 3.6 * (9.81 + 0.4) * 1.2 / (2 * 2 * 0.4 * 0.8), rel=1e-6)
    assert "3 kg with friction 0.5 may need it" in heavy.notes[0]
    assert choose(HEAVY, acceleration=2.0).force > heavy.force


@given(mass=st.floats(0.1, 5.0), friction=st.floats(0.2, 1.5), acceleration=st.floats(0.0, 3.0))
def test_a_box_unlike_what_is_believed_still_gets_what_it_needs(mass, friction, acceleration):
    wanted = WantedForce(BoxParameters(mass=mass, friction=friction), acceleration)
    for heavier, smoother in ((1.0, 1.0), (1.2, 1.0), (1.0, 0.8), (1.2, 0.8)):
        other = BoxParameters(mass=heavier * mass, friction=smoother * friction)
        assert wanted >= NeededForce(other, acceleration, ARMS_NEED) * (1 - 1e-12)
    assert wanted >= max(USUAL_FORCE, NeededForce(BoxParameters(mass=mass, friction=friction), acceleration, 2.5))


def test_no_posture_presses_harder_than_the_limit_or_the_arms_can():
    limited = choose(HEAVY, force_limit=80.0)
    assert forces(limited).max() == pytest.approx(80.0 / OVERSHOOT)
    weak = choose(HEAVY, strengths=np.array([200.0, 200.0, 84.0]))
    assert np.max(forces(weak) - np.array([200.0, 200.0, 84.0]) / OVERSHOOT) == pytest.approx(0.0, abs=1e-9)


def test_what_comes_on_top_leaves_room_for_palms_that_bear_the_box_unevenly():
    needed, wanted = NeededForce(HEAVY, 1.0, ARMS_NEED), WantedForce(HEAVY, 1.0)
    assert USUAL_FORCE < needed < wanted
    for room, force in ((2.0 * wanted, wanted), (0.5 * (needed + wanted), None), (0.5 * needed, needed)):
        chosen = choose(HEAVY, acceleration=1.0, uneven=np.full(3, room * OVERSHOOT))
        if force is None:
            assert np.max(forces(chosen)) == pytest.approx(room)  # In the stiffest posture, less in the others.
        else:
            assert chosen.force == pytest.approx(force)
    assert choose(uneven=np.full(3, 10.0)).force == pytest.approx(USUAL_FORCE)


def test_what_is_asked_for_is_squeezed_where_nothing_is_heeded():
    for task, force in ((TaskConfig(squeeze_force=150.0), 150.0), (TaskConfig(), USUAL_FORCE)):
        squeeze = AskedSqueeze(task, COMPLIANCES)
        assert squeeze.force == pytest.approx(force) == np.mean(forces(squeeze)) and squeeze.notes == ()
    deep = AskedSqueeze(TaskConfig(squeeze=0.05, squeeze_force=10.0), COMPLIANCES)
    assert deep.depth == 0.05 and deep.force == pytest.approx(np.mean(0.1 / COMPLIANCES))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"squeeze_force": 115.0}, r"task\.squeeze_force is 115 N, but beyond"),
        ({"squeeze": 0.05}, r"task\.squeeze is 0\.05 m, but beyond 0\.0\d+ m"),
        ({"box": HEAVY, "force_limit": 60.0}, r"a box of 3 kg with friction 0\.5 needs \d+ N of each palm, and task"),
        ({"box": HEAVY, "strengths": np.full(3, 50.0)}, r"the arms' strength allows 3\d N"),
    ],
)
def test_too_much_is_refused_in_one_line_with_its_reason(changes, message):
    with pytest.raises(TaskError, match=f"^force: .*{message}") as caught:
        choose(**changes)
    assert caught.value.reason == "force" and "\n" not in str(caught.value)


def test_a_force_above_the_limit_is_refused_before_the_search():
    with pytest.raises(TaskError, match=r"squeeze_force is 130 N, more than task\.force_limit, 120 N") as caught:
        RefuseForce(TaskConfig(squeeze_force=130.0), BoxParameters())
    assert caught.value.reason == "force"
    RefuseForce(TaskConfig(), BoxParameters())


def test_too_little_is_done_as_asked_and_said():
    assert "where the box needs about" in choose(squeeze_force=10.0).notes[0]


def test_compliance_and_strength_are_those_of_the_postures():
    plant = MakeKinematicPlant()
    postures = np.array([np.tile(HOME, 2), np.tile(HOME, 2) + 0.1])
    context, found = plant.CreateDefaultContext(), []
    for q in postures:
        plant.SetPositions(context, q)
        arms = (plant.GetModelInstanceByName(arm) for arm in ARMS)
        found.append(sum(1.0 / palm_stiffness(plant, context, arm, DEFAULT_STIFFNESS) for arm in arms))
    np.testing.assert_allclose(Compliances(plant, postures), found)
    assert SqueezeCompliance(np.array(found)) == pytest.approx(1.0 / np.mean(1.0 / np.array(found)))
    plant.SetPositions(context, postures[1])
    left, right = (
        largest_squeeze(plant, context, plant.GetModelInstanceByName(arm), (0.0, 0.0, -2.0 * 9.81)) for arm in ARMS
    )
    assert Strengths(plant, postures, 4.0)[1] == pytest.approx(min(left, right))
    np.testing.assert_allclose(Strengths(plant, postures, 4.0, UNEVEN), Strengths(plant, postures, 8.0))
