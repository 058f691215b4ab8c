"""Retargeting as a system: ports, values, and that the one kept computation never serves another context."""

import numpy as np
import pytest
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource

from drake_blfdmp.quaternions import from_rotation_vector
from drake_blfdmp.robot.retargeting import Retarget, retarget_motion
from drake_blfdmp.systems.retargeting import Retargeting

MAP = Retarget(0.7, np.array([0.0, 0.0, 1.4]), np.array([0.0, 0.25, 0.9]), np.array([0.4, -0.2]), level=False)
NAMES = ("palm_poses", "palm_twists", "swivel", "swivel_rate")
POINTS = np.array(
    [[-0.2, 0.0, 1.4], [-0.35, 0.1, 1.2], [-0.16, 0.35, 1.13], [0.2, 0.0, 1.4], [0.28, 0.12, 1.16], [0.17, 0.38, 1.17]]
)


def motion(seed):
    rng = np.random.default_rng(seed)
    return POINTS + rng.uniform(-0.04, 0.04, (6, 3)), rng.uniform(-0.5, 0.5, (6, 3))


def fix(system, context, x, velocity):
    system.GetInputPort("position").FixValue(context, x.ravel())
    system.GetInputPort("velocity").FixValue(context, velocity.ravel())


def outputs(system, context):
    return [system.GetOutputPort(name).Eval(context).copy() for name in NAMES]


def expected(x, velocity):
    return [np.ravel(value) for value in retarget_motion(x, velocity, MAP)]


@pytest.fixture
def system():
    return Retargeting(retarget=MAP)


def test_ports_have_their_names_and_sizes(system):
    inputs = [system.get_input_port(i) for i in range(system.num_input_ports())]
    assert [(port.get_name(), port.size()) for port in inputs] == [
        ("position", 18),
        ("velocity", 18),
        ("tempo", 1),
        ("orientation", 4),
        ("angular_velocity", 3),
    ]
    ports = [system.get_output_port(i) for i in range(system.num_output_ports())]
    assert [(port.get_name(), port.size()) for port in ports] == list(zip(NAMES, (14, 12, 2, 2), strict=True))
    assert system.CreateDefaultContext().num_total_states() == 0


def test_outputs_are_the_retargeted_motion(system):
    context = system.CreateDefaultContext()
    for seed in range(3):
        x, velocity = motion(seed)
        fix(system, context, x, velocity)
        for value, wanted in zip(outputs(system, context), expected(x, velocity), strict=True):
            np.testing.assert_allclose(value, wanted, atol=1e-14)


def test_a_tempo_turns_rates_of_the_skills_clock_into_rates_in_the_world(system):
    context = system.CreateDefaultContext()
    x, velocity = motion(1)
    fix(system, context, x, velocity)
    system.GetInputPort("tempo").FixValue(context, 0.3)
    for value, wanted in zip(outputs(system, context), expected(x, 0.3 * velocity), strict=True):
        np.testing.assert_allclose(value, wanted, atol=1e-14)


def test_the_palms_roll_with_what_is_held(system):
    context = system.CreateDefaultContext()
    x, velocity = motion(4)
    fix(system, context, x, velocity)
    turn, rate = from_rotation_vector(np.array([0.6, 0.1, -0.2])), np.array([0.3, -0.1, 0.2])
    system.GetInputPort("orientation").FixValue(context, turn)
    system.GetInputPort("angular_velocity").FixValue(context, rate)
    wanted = [np.ravel(value) for value in retarget_motion(x, velocity, MAP, turn=turn, turn_rate=rate)]
    for value, one in zip(outputs(system, context), wanted, strict=True):
        np.testing.assert_allclose(value, one, atol=1e-14)
    assert not np.allclose(wanted[0], expected(x, velocity)[0], atol=0.1)
    system.GetInputPort("angular_velocity").FixValue(context, 0 * rate)  # One changed input is noticed.
    assert not np.allclose(system.GetOutputPort("palm_twists").Eval(context), wanted[1])
    system.GetInputPort("angular_velocity").FixValue(context, rate)
    system.GetInputPort("tempo").FixValue(context, 0.3)
    slowed = retarget_motion(x, 0.3 * velocity, MAP, turn=turn, turn_rate=0.3 * rate)
    np.testing.assert_allclose(system.GetOutputPort("palm_twists").Eval(context), slowed[1].ravel(), atol=1e-14)


@pytest.mark.parametrize("first", NAMES)
def test_two_contexts_that_take_turns_each_get_their_own(system, first):
    """All outputs share one kept computation; whichever is asked first, and in whatever order contexts alternate."""
    contexts = [system.CreateDefaultContext() for _ in range(2)]
    cases = [motion(10), motion(11)]
    for context, case in zip(contexts, cases, strict=True):
        fix(system, context, *case)
    order = [first, *(name for name in NAMES if name != first)]
    for name in order:
        for context, case in zip(contexts, cases, strict=True):
            wanted = dict(zip(NAMES, expected(*case), strict=True))
            np.testing.assert_allclose(system.GetOutputPort(name).Eval(context), wanted[name], atol=1e-14)


def test_a_change_of_one_input_alone_is_noticed(system):
    context = system.CreateDefaultContext()
    (x, velocity), (other, faster) = motion(1), motion(2)
    for case in ((x, velocity), (x, faster), (other, faster), (other, velocity), (x, velocity)):
        fix(system, context, *case)
        for value, wanted in zip(outputs(system, context), expected(*case), strict=True):
            np.testing.assert_allclose(value, wanted, atol=1e-14)


def test_it_serves_two_diagram_contexts_through_connected_ports(system):
    builder = DiagramBuilder()
    builder.AddSystem(system)
    x, velocity = motion(5)
    sources = [builder.AddSystem(ConstantVectorSource(value.ravel())) for value in (x, velocity)]
    for source, name in zip(sources, ("position", "velocity"), strict=True):
        builder.Connect(source.get_output_port(), system.GetInputPort(name))
    diagram = builder.Build()
    roots = [diagram.CreateDefaultContext() for _ in range(2)]
    other, _ = motion(6)
    sources[0].get_mutable_source_value(sources[0].GetMyMutableContextFromRoot(roots[1])).SetFromVector(other.ravel())
    for _ in range(2):
        for root, points in zip(roots, (x, other), strict=True):
            values = outputs(system, system.GetMyContextFromRoot(root))
            for value, wanted in zip(values, expected(points, velocity), strict=True):
                np.testing.assert_allclose(value, wanted, atol=1e-14)
