"""The observer of the palms' distance, alone and in the loop around the law."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydrake.common.value import AbstractValue
from pydrake.math import RigidTransform
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder, LeafSystem
from pydrake.systems.primitives import ConstantVectorSource, LogVectorOutput

from drake_blfdmp.demonstration.modelled_person import hold_and_place
from drake_blfdmp.diagrams.skill import AddSkill, ConnectTempo
from drake_blfdmp.errors import ScenarioError
from drake_blfdmp.robot.palm_feedback import effective_distance, filter_matrices, filtered
from drake_blfdmp.skeleton import HANDS
from drake_blfdmp.skill.bands import make_bands
from drake_blfdmp.skill.barrier import middles_and_half_widths
from drake_blfdmp.skill.geometry import link_states
from drake_blfdmp.skill.learning import learn_skill
from drake_blfdmp.skill.profiles import HandDistance
from drake_blfdmp.systems.hands_observer import HandsObserver, Squeeze

DT, RATE = 0.004, 12.0
SQUEEZE = Squeeze(0.3, 4e-4, 10.0)
X = np.random.default_rng(3).normal(size=(6, 3))
VELOCITY = np.random.default_rng(4).normal(size=(6, 3))
RHO, RHO_DOT = (value[HANDS] for value in link_states(X, VELOCITY)[:2])


def make(**changes):
    return HandsObserver(**({"palms": (2, 1), "time_step": DT, "rate": RATE, "largest": 0.03} | changes))


def prepared(distance, force=None, tempo=None, **changes):
    """With the left palm at body 2 and the right one at body 1, `distance` apart."""
    system = make(**changes)
    context = system.CreateDefaultContext()
    poses = [RigidTransform(), RigidTransform([0.1 + distance, 0.5, 0.9]), RigidTransform([0.1, 0.5, 0.9])]
    system.GetInputPort("body_poses").FixValue(context, AbstractValue.Make(poses))
    system.GetInputPort("position").FixValue(context, X.ravel())
    system.GetInputPort("velocity").FixValue(context, VELOCITY.ravel())
    for name, value in (("palm_force", force), ("tempo", tempo)):
        if value is not None:
            system.GetInputPort(name).FixValue(context, value)
    return system, context


def test_ports():
    system = make()
    inputs = [system.get_input_port(i) for i in range(system.num_input_ports())]
    assert [port.get_name() for port in inputs] == ["position", "velocity", "body_poses", "palm_force", "tempo"]
    outputs = [system.get_output_port(i) for i in range(system.num_output_ports())]
    assert [(port.get_name(), port.size()) for port in outputs] == [("measured_distance", 3), ("effective_distance", 1)]


@pytest.mark.parametrize(
    ("force", "squeeze"), [(None, None), ([0.0, 0.0], SQUEEZE), ([40.0, 60.0], SQUEEZE), ([40.0, 60.0], None)]
)
def test_the_effective_distance_is_what_palms_and_forces_make_it(force, squeeze):
    system, context = prepared(0.305, force, squeeze=squeeze, hands_scale=0.5)
    want = 0.305 if squeeze is None or force is None else effective_distance(0.305, np.mean(force), *squeeze)
    assert system.GetOutputPort("effective_distance").Eval(context) == pytest.approx(want / 0.5, rel=1e-14)


@pytest.mark.parametrize("tempo", [None, 1.0, 0.25])
def test_the_error_is_filtered_on_the_skills_clock(tempo):
    system, context = prepared(RHO + 0.02, tempo=tempo)
    context.SetDiscreteState(0, [0.004, -0.01])
    length = DT * (tempo or 1.0)
    after = np.array(filtered(0.004, -0.01, 0.02, filter_matrices(RATE, length)))
    np.testing.assert_allclose(
        system.GetOutputPort("measured_distance").Eval(context),
        [RHO + 0.004, RHO_DOT - 0.01, (after[1] + 0.01) / length],
        rtol=1e-9,
    )
    np.testing.assert_allclose(system.EvalUniquePeriodicDiscreteUpdate(context).value(0), after, rtol=1e-12)


def test_a_clock_that_stands_still_stops_the_filter():
    system, context = prepared(RHO + 0.02, tempo=0.0)
    context.SetDiscreteState(0, [0.004, -0.01])
    np.testing.assert_allclose(system.GetOutputPort("measured_distance").Eval(context)[2], 0.0)
    np.testing.assert_allclose(system.EvalUniquePeriodicDiscreteUpdate(context).value(0), [0.004, -0.01])


@pytest.mark.parametrize(("error", "counts_as"), [(0.5, 0.03), (-0.5, -0.03)])
def test_an_error_beyond_the_largest_counts_as_it(error, counts_as):
    system, context = prepared(RHO + error)
    after = filtered(0.0, 0.0, counts_as, filter_matrices(RATE, DT))
    np.testing.assert_allclose(system.EvalUniquePeriodicDiscreteUpdate(context).value(0), after, rtol=1e-12)


def test_until_the_arms_join_in_there_is_no_error():
    system, context = prepared(RHO + 0.02, active_from=1.0)
    for t, active in ((0.0, False), (0.99, False), (1.0, True)):
        context.SetTime(t)
        assert bool(system.EvalUniquePeriodicDiscreteUpdate(context).value(0).any()) == active


@pytest.mark.parametrize("name", ["time_step", "rate", "largest"])
@pytest.mark.parametrize("value", [0.0, -1.0, np.inf, np.nan])
def test_what_must_be_positive_is_refused_otherwise(name, value):
    with pytest.raises(ScenarioError, match=f"hands observer: {name} must be positive"):
        make(**{name: value})


SKILL = learn_skill(*hold_and_place(), basis_functions=25)
BANDS = make_bands(0.22, 0.28, HandDistance(0.37, 0.28, 0.3, 3.0, 0.6)).opened_to(SKILL.start)


class Palms(LeafSystem):
    """A robot whose palms are the skill's hands with an error of their distance: a + b sin(c t), m."""

    def __init__(self, a, b, c):
        super().__init__()
        self._error = lambda t: a + b * np.sin(c * t)
        self._position = self.DeclareVectorInputPort("position", 18)
        self.DeclareAbstractOutputPort(
            "body_poses", lambda: AbstractValue.Make([RigidTransform()]), self._calc, {self.all_sources_ticket()}
        )

    def _calc(self, context, output):
        x = self._position.Eval(context).reshape(6, 3)
        distance = np.linalg.norm(x[5] - x[2]) + self._error(context.get_time())
        output.set_value([RigidTransform(), RigidTransform([distance, 0.0, 0.0])])


@given(
    st.floats(-0.03, 0.03),
    st.floats(0.0, 0.03),
    st.floats(0.5, 60.0),
    st.floats(0.2, 1.0),
    st.sampled_from([4.0, 20.0]),
)
@settings(max_examples=12, deadline=None)
def test_whatever_the_palms_do_the_law_keeps_the_filtered_distance_and_so_the_real_one(a, b, c, tempo, rate):
    """At every step what the law is given is inside; the palms are as far as the filter is no farther behind."""
    builder = DiagramBuilder()
    skill = AddSkill(builder, SKILL, BANDS, time_step=DT)
    palms = builder.AddSystem(Palms(a, b, c))
    observer = builder.AddSystem(make(palms=(0, 1), rate=rate, largest=0.1))
    clock = builder.AddSystem(ConstantVectorSource([tempo])).get_output_port()
    ConnectTempo(builder, skill, clock)
    builder.Connect(skill.transformation.GetOutputPort("position"), palms.get_input_port())
    for name in ("position", "velocity"):
        builder.Connect(skill.transformation.GetOutputPort(name), observer.GetInputPort(name))
    builder.Connect(palms.get_output_port(), observer.GetInputPort("body_poses"))
    builder.Connect(clock, observer.GetInputPort("tempo"))
    builder.Connect(observer.GetOutputPort("measured_distance"), skill.coupler.GetInputPort("measured_distance"))
    ports = {
        "margin": skill.coupler.GetOutputPort("margin"),
        "kept": observer.GetOutputPort("measured_distance"),
        "real": observer.GetOutputPort("effective_distance"),
        "bands": skill.bands.GetOutputPort("bands"),
    }
    sinks = {name: LogVectorOutput(port, builder, DT) for name, port in ports.items()}
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(1.5)
    log = {name: sink.FindLog(simulator.get_context()).data().T for name, sink in sinks.items()}
    assert log["margin"].min() > 0.0
    (m, _, _), (w, _, _) = middles_and_half_widths(log["bands"].reshape(-1, 6, 5))
    behind = np.abs(log["real"][:, 0] - log["kept"][:, 0])
    real = 1.0 - np.abs(log["real"][:, 0] - m[:, HANDS]) / w[:, HANDS]
    assert np.all(real >= log["margin"][:, HANDS] - behind / w[:, HANDS] - 1e-9)
    assert np.all(real[behind < log["margin"][:, HANDS] * w[:, HANDS]] > 0.0)
