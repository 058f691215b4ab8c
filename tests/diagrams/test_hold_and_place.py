"""The whole diagram: who is connected to whom, the state it starts from, and that it stays at rest before it moves."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from drake_blfdmp.diagrams.hold_and_place import MakeHoldAndPlace, SetInitialState
from drake_blfdmp.diagrams.non_finite import state_of
from drake_blfdmp.robot.rigid import rigid

# Output -> input, by names of systems and ports; the skill's own wiring is tested in test_skill.py.
CONNECTIONS = [
    ("transformation", "position", "retargeting", "position"),
    ("transformation", "velocity", "retargeting", "velocity"),
    ("retargeting", "palm_poses", "ik", "palm_poses"),
    ("retargeting", "palm_twists", "ik", "palm_twists"),
    ("retargeting", "swivel", "ik", "swivel"),
    ("retargeting", "swivel_rate", "ik", "swivel_rate"),
    ("ik", "desired_state_left", "plant", "left_arm_desired_state"),
    ("ik", "desired_state_right", "plant", "right_arm_desired_state"),
    ("plant", "contact_results", "palm_forces", "contact_results"),
    ("transformation", "position", "coupler", "position"),
    ("coupler", "link_acceleration", "reshaper", "link_acceleration"),
    ("reshaper", "coupling_acceleration", "transformation", "coupling_acceleration"),
]


@pytest.fixture(scope="module")
def made(default_plan):
    return MakeHoldAndPlace(default_plan)


@pytest.fixture
def started(made):
    diagram, parts = made
    context = diagram.CreateDefaultContext()
    SetInitialState(parts, diagram, context)
    return diagram, parts, context


def wires(diagram):
    found = set()
    for (target, target_port), (source, source_port) in diagram.connection_map().items():
        found.add(
            (
                source.get_name(),
                source.get_output_port(source_port).get_name(),
                target.get_name(),
                target.get_input_port(target_port).get_name(),
            )
        )
    return found


@pytest.mark.parametrize("wire", CONNECTIONS, ids=lambda wire: f"{wire[0]}.{wire[1]} to {wire[2]}.{wire[3]}")
def test_ports_are_connected_by_name(made, wire):
    assert wire in wires(made[0])


def test_nothing_that_a_part_needs_is_left_open(made):
    """Every input of our systems has a source."""
    diagram, parts = made
    connected = {(target, port) for _, _, target, port in wires(diagram)}
    skill = parts.skill
    systems = [parts.retargeting, parts.palm_forces, parts.observer, parts.tempo.get_system(), skill.canonical]
    systems += [skill.forcing, skill.transformation, skill.coupler, skill.reshaper]
    left = {
        (system.get_name(), system.get_input_port(i).get_name())
        for system in systems
        for i in range(system.num_input_ports())
    } - connected
    # Of recordings that have no orientations.
    assert left == {("retargeting", "orientation"), ("retargeting", "angular_velocity")}


def test_there_is_no_algebraic_loop(made):
    """Building refuses one; the diagram has been built, and no input of its own is left."""
    assert made[0].num_input_ports() == 0


def test_the_box_stands_where_the_plan_has_it(started):
    _, parts, context = started
    plant_context = parts.plant.GetMyContextFromRoot(context)
    pose = parts.plant.GetFreeBodyPose(plant_context, parts.box)
    np.testing.assert_allclose(pose.GetAsMatrix4(), rigid(parts.plan.start).GetAsMatrix4(), atol=1e-12)
    np.testing.assert_array_equal(parts.plant.GetVelocities(plant_context), 0.0)


def test_the_arms_start_where_they_are_told_to_be(started):
    _, parts, context = started
    plant_context = parts.plant.GetMyContextFromRoot(context)
    for arm, name, first in zip(parts.arms, ("left", "right"), (0, 7), strict=True):
        q = parts.plant.GetPositions(plant_context, arm)
        np.testing.assert_allclose(q, parts.plan.reach.start[first : first + 7], atol=1e-12)
        desired = parts.plant.get_desired_state_input_port(arm).Eval(plant_context)
        np.testing.assert_allclose(desired[:7], q, atol=1e-9)
        wired = parts.ik.GetOutputPort(f"desired_state_{name}").Eval(parts.ik.GetMyContextFromRoot(context))
        np.testing.assert_array_equal(wired, desired)


def palm_force(parts, context):
    return parts.palm_forces.get_output_port().Eval(parts.palm_forces.GetMyContextFromRoot(context))


def test_no_palm_touches_the_box_at_first(started):
    _, parts, context = started
    np.testing.assert_array_equal(palm_force(parts, context), 0.0)


def test_a_fifth_of_a_second_later_everything_is_still_at_rest(started):
    diagram, parts, context = started
    simulator = Simulator(diagram, context)
    simulator.AdvanceTo(0.2)
    plant_context = parts.plant.GetMyContextFromRoot(context)
    pose = parts.plant.GetFreeBodyPose(plant_context, parts.box)
    start = rigid(parts.plan.start)
    assert np.linalg.norm(pose.translation() - start.translation()) < 5e-4
    np.testing.assert_allclose(pose.rotation().matrix(), start.rotation().matrix(), atol=2e-3)
    np.testing.assert_array_equal(palm_force(parts, context), 0.0)
    for arm, first in zip(parts.arms, (0, 7), strict=True):
        moved = parts.plant.GetPositions(plant_context, arm) - parts.plan.reach.start[first : first + 7]
        assert np.abs(moved).max() < 1e-3  # The arms wait until the points have been drawn into their bands.


def test_the_simulated_skill_is_the_planned_rollout(started):
    diagram, parts, context = started
    Simulator(diagram, context).AdvanceTo(0.2)
    x = parts.skill.transformation.GetOutputPort("position").Eval(
        parts.skill.transformation.GetMyContextFromRoot(context)
    )
    step = parts.plan.scenario.simulation.skill_time_step
    np.testing.assert_allclose(x.reshape(6, 3), parts.plan.coupled.x[round(0.2 / step)], atol=1e-9)


def test_a_copied_context_goes_on_as_the_original_does(started):
    diagram, parts, context = started
    Simulator(diagram, context).AdvanceTo(0.05)
    twin = diagram.CreateDefaultContext()
    twin.SetTimeStateAndParametersFrom(context)
    for each in (context, twin):
        Simulator(diagram, each).AdvanceTo(0.1)
    states = [parts.plant.GetPositionsAndVelocities(parts.plant.GetMyContextFromRoot(each)) for each in (context, twin)]
    np.testing.assert_array_equal(*states)


def test_a_run_saved_in_motion_and_restored_has_the_same_future(started):
    """All state is in the context: none of it hides in a system, so its clone goes on bit by bit."""
    diagram, parts, context = started
    saved_at = parts.plan.settle_s + 0.3  # The arms move.
    simulator = Simulator(diagram, context)
    simulator.AdvanceTo(saved_at)
    saved = context.Clone()
    simulator.AdvanceTo(saved_at + 0.1)
    again = Simulator(diagram, saved)
    again.AdvanceTo(saved_at + 0.1)
    first, second = (state_of(each.get_context()) for each in (simulator, again))
    np.testing.assert_array_equal(first, second)
    fresh = diagram.CreateDefaultContext()
    SetInitialState(parts, diagram, fresh)
    assert np.abs(state_of(fresh)[np.isfinite(first)] - first[np.isfinite(first)]).max() > 0.01


def test_a_tempo_of_zero_in_one_context_stops_the_phase_there_and_nowhere_else(started):
    diagram, parts, context = started
    canonical = parts.skill.canonical
    twin = context.Clone()
    canonical.GetInputPort("tempo").FixValue(canonical.GetMyMutableContextFromRoot(context), 0.0)
    phases = []
    for each in (context, twin):
        Simulator(diagram, each).AdvanceTo(0.02)
        phases.append(canonical.GetOutputPort("phase").Eval(canonical.GetMyContextFromRoot(each))[0])
    assert phases[0] == 1.0 > phases[1]
