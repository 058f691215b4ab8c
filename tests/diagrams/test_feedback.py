"""The feedback's wiring, what each switch takes away, and that the law holds at any tempo."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import LogVectorOutput, TrajectorySource
from pydrake.trajectories import PiecewisePolynomial

from drake_blfdmp.demonstration.modelled_person import hold_and_place
from drake_blfdmp.diagrams.hold_and_place import MakeHoldAndPlace, SkillClock
from drake_blfdmp.diagrams.skill import AddSkill, ConnectTempo
from drake_blfdmp.planning.scenario_sections import FeedbackConfig
from drake_blfdmp.skill.bands import make_bands
from drake_blfdmp.skill.canonical import phase_at, time_at
from drake_blfdmp.skill.learning import learn_skill
from drake_blfdmp.skill.profiles import HandDistance
from drake_blfdmp.skill.rollout import roll_out

DT = 0.004
SKILL = learn_skill(*hold_and_place(), basis_functions=25)
SKILL = SKILL.with_start(SKILL.start + 0.03 * np.random.default_rng(0).normal(size=(6, 3)))
BANDS = make_bands(0.22, 0.28, HandDistance(0.37, 0.28, 0.3, 3.0, 0.6)).opened_to(SKILL.start)
# What hangs on the tempo, and what closes the loop on the hands.
CLOCKED = {"canonical", "forcing", "transformation", "retargeting", "hands_observer"}
LOOP = ("hands_observer", "measured_distance", "coupler", "measured_distance")


def wires(plan, law="default", **feedback):
    scenario = replace(plan.scenario, feedback=FeedbackConfig(**feedback), law=law)
    diagram, parts = MakeHoldAndPlace(replace(plan, scenario=scenario))
    found = {
        (
            source.get_name(),
            source.get_output_port(o).get_name(),
            target.get_name(),
            target.get_input_port(i).get_name(),
        )
        for (target, i), (source, o) in diagram.connection_map().items()
    }
    return found, parts


def test_by_default_everything_is_fed_back(default_plan):
    found, parts = wires(default_plan)
    assert {target for source, _, target, port in found if port == "tempo" and source == "phase_stopping"} == CLOCKED
    assert LOOP in found
    for wire in (
        ("plant", "body_poses", "phase_stopping", "body_poses"),
        ("plant", "body_poses", "hands_observer", "body_poses"),
        ("ik", "commanded_palms", "phase_stopping", "commanded_palms"),
        ("ik", "tempo", "phase_stopping", "arms_tempo"),
        ("palm_forces", "palm_force", "hands_observer", "palm_force"),
    ):
        assert wire in found
    assert parts.tempo.get_system().get_name() == "phase_stopping"


@pytest.mark.parametrize(
    ("feedback", "source"),
    [({"phase_stopping": False}, "ik"), ({"tempo": False}, "phase_stopping"),
     ({"tempo": False, "phase_stopping": False}, None)],
)  # fmt: skip
def test_each_switch_takes_away_its_own(default_plan, feedback, source):
    found, parts = wires(default_plan, **feedback)
    assert {wire[0] for wire in found if wire[3] == "tempo"} == ({source} if source else set())
    assert (parts.tempo is None) == (source is None)
    assert (("ik", "tempo", "phase_stopping", "arms_tempo") in found) == feedback.get("tempo", source != "ik")


@pytest.mark.parametrize(("law", "hands"), [("default", False), ("none", True), ("gams", True)])
def test_where_the_loop_on_the_hands_stays_open_they_are_watched_all_the_same(default_plan, law, hands):
    found, parts = wires(default_plan, law, hands=hands)
    assert LOOP not in found
    assert parts.observer.GetOutputPort("effective_distance").size() == 1


def test_the_skills_clock_is_read_from_its_phase(default_plan):
    diagram, parts = MakeHoldAndPlace(default_plan)
    context = diagram.CreateDefaultContext()
    skill = parts.plan.task.skill
    phase = parts.skill.canonical.GetMyMutableContextFromRoot(context).get_mutable_discrete_state_vector()
    phase.SetFromVector([phase_at(2.5, skill.tau, skill.gamma)])
    assert SkillClock(parts, context) == pytest.approx(2.5)


@given(st.lists(st.floats(0.02, 1.0), min_size=6, max_size=6))
@settings(max_examples=10, deadline=None)
def test_the_law_holds_and_the_path_is_the_same_at_any_tempo(tempos):
    """Tempos that change every 0.4 s: no band is left, no barrier rises, and the points pass where they would."""
    builder = DiagramBuilder()
    skill = AddSkill(builder, SKILL, BANDS, time_step=DT)
    steps = PiecewisePolynomial.ZeroOrderHold(0.4 * np.arange(7), np.array([[*tempos, tempos[-1]]]))
    ConnectTempo(builder, skill, builder.AddSystem(TrajectorySource(steps)).get_output_port())
    ports = {
        "phase": skill.canonical.GetOutputPort("phase"),
        "position": skill.transformation.GetOutputPort("position"),
        "margin": skill.coupler.GetOutputPort("margin"),
        "barrier": skill.coupler.GetOutputPort("barrier"),
    }
    sinks = {name: LogVectorOutput(port, builder, DT) for name, port in ports.items()}
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(2.4)
    log = {name: sink.FindLog(simulator.get_context()).data().T for name, sink in sinks.items()}
    assert log["margin"].min() > 0.0
    # It falls at every step down to the floor of the sampled law, which takes bands' accelerations at a step's start.
    assert np.all(log["barrier"][1:] <= np.maximum(log["barrier"][:-1], 0.01))
    assert log["barrier"][0].max() > 0.3
    clock = time_at(log["phase"][:, 0], SKILL.tau, SKILL.gamma)
    assert clock[-1] == pytest.approx(0.4 * sum(tempos), abs=2 * DT)
    reference = roll_out(SKILL, time_step=0.001, duration=clock[-1] + 0.01, bands=BANDS)
    expected = np.array([np.interp(clock, reference.t, column) for column in reference.x.reshape(-1, 18).T]).T
    np.testing.assert_allclose(log["position"], expected, atol=2e-3)
