import numpy as np
import pytest
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.multibody.tree import SpatialInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from drake_blfdmp.systems.timed_push import TimedPush

FORCE, MASS = np.array([3.0, -1.0, 0.5]), 2.0


def pushed(start_s, duration_s):
    """A free body without gravity, and what pushes it."""
    builder = DiagramBuilder()
    plant, _ = AddMultibodyPlantSceneGraph(builder, time_step=0.001)
    body = plant.AddRigidBody("body", SpatialInertia.SolidSphereWithMass(MASS, 0.1))
    plant.mutable_gravity_field().set_gravity_vector(np.zeros(3))
    plant.Finalize()
    push = builder.AddNamedSystem("push", TimedPush(body=body, force=FORCE, start_s=start_s, duration_s=duration_s))
    builder.Connect(push.get_output_port(), plant.get_applied_spatial_force_input_port())
    return builder.Build(), push, plant, body


@pytest.mark.parametrize(("t", "acts"), [(0.0, False), (0.0999, False), (0.1, True), (0.29, True), (0.31, False)])
def test_it_acts_from_its_start_until_its_end(t, acts):
    diagram, push, _, body = pushed(0.1, 0.2)
    context = diagram.CreateDefaultContext()
    context.SetTime(t)
    forces = push.get_output_port().Eval(push.GetMyContextFromRoot(context))
    assert len(forces) == acts
    if acts:
        np.testing.assert_array_equal(forces[0].F_Bq_W.translational(), FORCE)
        assert forces[0].body_index == body.index()


def test_a_free_body_gets_force_times_duration_of_momentum():
    diagram, _, plant, body = pushed(0.05, 0.1)
    simulator = Simulator(diagram)
    simulator.AdvanceTo(0.3)
    velocity = plant.EvalBodySpatialVelocityInWorld(plant.GetMyContextFromRoot(simulator.get_context()), body)
    np.testing.assert_allclose(MASS * velocity.translational(), 0.1 * FORCE, atol=1.01e-3 * np.abs(FORCE).max())
    np.testing.assert_allclose(velocity.rotational(), 0.0, atol=1e-12)
