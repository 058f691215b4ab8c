from dataclasses import replace

import numpy as np
import pytest
from pydrake.autodiffutils import AutoDiffXd
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from drake_blfdmp.demonstration.modelled_person import hold_and_place
from drake_blfdmp.diagrams.skill import AddSkill
from drake_blfdmp.errors import ScenarioError
from drake_blfdmp.skill.bands import make_bands
from drake_blfdmp.skill.laws import LAWS
from drake_blfdmp.skill.learning import learn_skill
from drake_blfdmp.skill.profiles import HandDistance
from drake_blfdmp.skill.rollout import roll_out
from drake_blfdmp.skill.sampled import Gains

DT = 0.004
SKILL = learn_skill(*hold_and_place(), basis_functions=25)
# A start and a goal that are not the demonstration's, so that there is something to couple.
_rng = np.random.default_rng(0)
SKILL = SKILL.with_start(SKILL.start + 0.03 * _rng.normal(size=(6, 3))).with_goal(
    SKILL.goal + 0.03 * _rng.normal(size=(6, 3))
)
BANDS = make_bands(0.22, 0.28, HandDistance(0.37, 0.28, 0.3, 3.0, 0.6)).opened_to(SKILL.start)

UNCOUPLED = {
    "canonical.phase -> forcing.phase",
    "canonical.phase -> bands.phase",
    "forcing.forcing -> transformation.forcing",
    "goal.y0 -> transformation.goal",
    "transformation.position -> coupler.position",
    "transformation.velocity -> coupler.velocity",
    "bands.bands -> coupler.bands",
}
COUPLED = UNCOUPLED | {
    "transformation.position -> reshaper.position",
    "transformation.velocity -> reshaper.velocity",
    "transformation.nominal_acceleration -> reshaper.nominal_acceleration",
    "coupler.link_acceleration -> reshaper.link_acceleration",
    "reshaper.coupling_acceleration -> transformation.coupling_acceleration",
}
ON_POINTS = UNCOUPLED | {
    "transformation.position -> point_coupler.position",
    "transformation.velocity -> point_coupler.velocity",
    "transformation.nominal_acceleration -> point_coupler.nominal_acceleration",
    "bands.bands -> point_coupler.bands",
    "point_coupler.coupling_acceleration -> transformation.coupling_acceleration",
}


def built(skill=SKILL, **options):
    builder = DiagramBuilder()
    systems = AddSkill(builder, skill, BANDS, **options)
    return builder.Build(), systems


def wiring(diagram):
    return {
        f"{output[0].get_name()}.{output[0].get_output_port(output[1]).get_name()} -> "
        f"{target[0].get_name()}.{target[0].get_input_port(target[1]).get_name()}"
        for target, output in diagram.connection_map().items()
    }


def positions(diagram, systems, times):
    """Positions (N, 6, 3) and velocities just before the updates at `times`."""
    simulator = Simulator(diagram)
    simulator.get_mutable_integrator().set_target_accuracy(1e-7)
    simulator.Initialize()
    context = systems.transformation.GetMyContextFromRoot(simulator.get_context())
    out = []
    for t in times:
        if t > 0.0:  # Advancing to 0 would perform the update at 0.
            simulator.AdvanceTo(t)
        out.append([systems.transformation.GetOutputPort(name).Eval(context) for name in ("position", "velocity")])
    values = np.array(out).reshape(len(times), 2, 6, 3)
    return values[:, 0], values[:, 1]


@pytest.mark.parametrize("time_step", [0.0, DT])
@pytest.mark.parametrize(("law", "connections"), [("default", COUPLED), ("none", UNCOUPLED)])
def test_every_connection(law, connections, time_step):
    diagram, systems = built(law=law, time_step=time_step)  # Building fails on an algebraic loop.
    assert wiring(diagram) == connections
    assert (systems.reshaper is None) == (law == "none")


@pytest.mark.parametrize("time_step", [0.0, DT])
@pytest.mark.parametrize("law", ["published", "published_loop", "gams"])
def test_every_connection_of_the_laws_on_points(law, time_step):
    diagram, systems = built(law=law, time_step=time_step)
    assert wiring(diagram) == ON_POINTS
    assert systems.reshaper is None and systems.point_coupler is not None


@pytest.mark.parametrize("law", LAWS)
def test_the_discrete_diagram_is_the_batch_rollout(law):
    # The lagged law is unstable: it turns the last bit into everything within a few dozen samples.
    times = DT * np.arange(0, 301 if law != "published_lagged" else 12)
    x, velocity = positions(*built(law=law, time_step=DT), times)
    r = roll_out(SKILL, time_step=DT, duration=times[-1], bands=BANDS, law=LAWS[law])
    tolerance = 1e-12 if law in ("default", "none") else 1e-9
    np.testing.assert_allclose(x, r.x, atol=tolerance)
    np.testing.assert_allclose(velocity, r.velocity, atol=10 * tolerance)


@pytest.mark.parametrize("mobility", [[1.0, 1.0, 1.0, 1.0, 1.0, 1.0], [3.0, 0.1, 0.5, 0.02, 2.0, 8.0]])
def test_the_weights_of_the_points_are_the_same_in_the_diagram_and_in_the_rollout(mobility):
    weighed = replace(SKILL, mobility=np.array(mobility))
    times = DT * np.arange(0, 301)
    x, velocity = positions(*built(skill=weighed, time_step=DT), times)
    rollouts = [roll_out(skill, time_step=DT, duration=times[-1], bands=BANDS) for skill in (weighed, SKILL)]
    np.testing.assert_allclose(x, rollouts[0].x, atol=1e-12)
    np.testing.assert_allclose(velocity, rollouts[0].velocity, atol=1e-11)
    assert np.abs(rollouts[0].x - rollouts[1].x).max() > 1e-3


@pytest.mark.parametrize(("law", "time_step"), [("none", 0.004), ("default", 0.0005)])
def test_the_continuous_and_the_discrete_diagram_agree(law, time_step):
    times = np.array([0.2, 0.5, 0.8])
    continuous, _ = positions(*built(law=law), times)
    r = roll_out(SKILL, time_step=time_step, duration=0.8, bands=BANDS, law=LAWS[law])
    np.testing.assert_allclose(continuous, r.x[np.round(times / time_step).astype(int)], atol=1e-4)


def test_the_coupler_watches_what_an_uncoupled_skill_does():
    diagram, systems = built(law="none", time_step=DT)
    simulator = Simulator(diagram)
    worst = np.inf
    for t in np.linspace(0.0, 3.0, 31):
        simulator.AdvanceTo(t)
        margin = systems.coupler.GetOutputPort("margin").Eval(
            systems.coupler.GetMyContextFromRoot(simulator.get_context())
        )
        worst = min(worst, margin.min())
    assert worst < 0.0


@pytest.mark.parametrize("time_step", [0.0, DT])
def test_a_context_can_be_saved_and_restored(time_step):
    diagram, systems = built(time_step=time_step)
    simulator = Simulator(diagram)
    simulator.AdvanceTo(0.2)
    saved = simulator.get_context().Clone()
    ends = []
    for _ in range(2):
        again = Simulator(diagram, saved.Clone())
        again.AdvanceTo(0.4)
        context = systems.transformation.GetMyContextFromRoot(again.get_context())
        ends.append(systems.transformation.GetOutputPort("position").Eval(context).copy())
    np.testing.assert_array_equal(*ends)
    simulator.AdvanceTo(0.4)
    context = systems.transformation.GetMyContextFromRoot(simulator.get_context())
    np.testing.assert_allclose(systems.transformation.GetOutputPort("position").Eval(context), ends[0], atol=1e-5)


@pytest.mark.parametrize("time_step", [0.0, DT])
def test_the_diagram_converts_to_other_scalar_types(time_step):
    diagram, _ = built(time_step=time_step)
    for other in (diagram.ToAutoDiffXd(), diagram.ToSymbolic()):
        assert wiring(other) == COUPLED
        context = other.CreateDefaultContext()
        coupler = other.GetSubsystemByName("coupler")
        margin = coupler.GetOutputPort("margin").Eval(coupler.GetMyContextFromRoot(context))
        margin = np.array([float(str(m)) if not hasattr(m, "derivatives") else m.value() for m in margin])
        np.testing.assert_allclose(
            margin, roll_out(SKILL, time_step=DT, duration=DT, bands=BANDS).margins[0], atol=1e-5
        )


@pytest.mark.parametrize("what", ["start", "goal", "weights"])
def test_the_gradient_of_the_endpoint_is_that_of_finite_differences(what):
    """Ten coarse coupled steps, differentiated by three coordinates, or by weights of early functions."""
    dt, steps, h = 0.005, 10, 1e-5 if what != "weights" else 1.0
    # Three coordinates of the first function's 18, the second's and the fourth's.
    chosen = [1, 6, 17] if what != "weights" else [2, 18 + 7, 3 * 18 + 15]
    diagram = built(time_step=dt)[0].ToAutoDiffXd()
    context = diagram.CreateDefaultContext()
    plain = getattr(SKILL, what).ravel()
    values = np.array([AutoDiffXd(v, np.zeros(3)) for v in plain])
    for k, i in enumerate(chosen):
        values[i] = AutoDiffXd(plain[i], np.eye(3)[k])
    system = {"start": "transformation", "goal": "goal", "weights": "forcing"}[what]
    part = diagram.GetSubsystemByName(system)
    mine = part.GetMyMutableContextFromRoot(context)
    if what == "start":
        mine.SetDiscreteState(0, values)
    elif what == "goal":
        part.get_mutable_source_value(mine).SetFromVector(values)
    else:
        mine.get_mutable_numeric_parameter(0).SetFromVector(values)
    for _ in range(steps):
        after = diagram.EvalUniquePeriodicDiscreteUpdate(context)
        for group in range(after.num_groups()):
            context.SetDiscreteState(group, after.value(group))
    transformation = diagram.GetSubsystemByName("transformation")
    end = transformation.GetOutputPort("position").Eval(transformation.GetMyContextFromRoot(context))
    gradient = np.array([x.derivatives() for x in end])

    def finish(change):
        changed = (plain + change).reshape(getattr(SKILL, what).shape)
        skill, options = (replace(SKILL, weights=changed), {}) if what == "weights" else (SKILL, {what: changed})
        return roll_out(skill, time_step=dt, duration=dt * steps, bands=BANDS, **options).x[-1].reshape(18)

    unit = h * np.eye(len(plain))
    numeric = np.stack([(finish(unit[i]) - finish(-unit[i])) / (2 * h) for i in chosen], axis=1)
    largest = np.abs(numeric).max()
    assert largest > {"start": 0.5, "goal": 0.005, "weights": 1e-6}[what]
    np.testing.assert_allclose(gradient, numeric, atol=1e-6 * (largest if what == "weights" else max(1.0, largest)))


def test_an_unknown_law_and_unsafe_gains_are_refused():
    with pytest.raises(ScenarioError, match="unknown law"):
        built(law="magnets")
    with pytest.raises(ScenarioError, match="use at most"):
        built(gains=Gains(20.0, 40.0), time_step=1 / 30)


def test_a_tempo_of_zero_stops_the_phase():
    diagram, systems = built(time_step=DT)
    simulator = Simulator(diagram)
    simulator.AdvanceTo(0.3)
    context = systems.canonical.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    phase = systems.canonical.GetOutputPort("phase")
    before = phase.Eval(context)[0]
    systems.canonical.GetInputPort("tempo").FixValue(context, 0.0)
    simulator.AdvanceTo(0.6)
    assert phase.Eval(context)[0] == before < 1.0
