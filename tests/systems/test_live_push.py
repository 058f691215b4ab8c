import numpy as np
import pytest
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.multibody.tree import SpatialInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from drake_blfdmp.systems.live_push import LivePush

FORCE, MASS = np.array([3.0, -1.0, 0.5]), 2.0


@pytest.fixture
def pushed():
    """A simulator of a free body without gravity, what pushes it, its plant and itself."""
    builder = DiagramBuilder()
    plant, _ = AddMultibodyPlantSceneGraph(builder, time_step=0.001)
    body = plant.AddRigidBody("body", SpatialInertia.SolidSphereWithMass(MASS, 0.1))
    plant.mutable_gravity_field().set_gravity_vector(np.zeros(3))
    plant.Finalize()
    push = builder.AddNamedSystem("push", LivePush(body=body))
    builder.Connect(push.get_output_port(), plant.get_applied_spatial_force_input_port())
    return Simulator(builder.Build()), push, plant, body


def give(simulator, push, force, until):
    context = push.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    push.GetInputPort("push").FixValue(context, np.append(force, until))


def momentum(simulator, plant, body):
    velocity = plant.EvalBodySpatialVelocityInWorld(plant.GetMyContextFromRoot(simulator.get_context()), body)
    np.testing.assert_allclose(velocity.rotational(), 0.0, atol=1e-12)
    return MASS * velocity.translational()


def test_nothing_acts_until_it_is_asked_for(pushed):
    simulator, _, plant, body = pushed
    simulator.AdvanceTo(0.1)
    np.testing.assert_array_equal(momentum(simulator, plant, body), 0.0)


def test_every_push_gives_force_times_duration_of_momentum(pushed):
    simulator, push, plant, body = pushed
    simulator.AdvanceTo(0.1)
    give(simulator, push, FORCE, 0.3 - 1e-9)
    simulator.AdvanceTo(0.5)
    np.testing.assert_allclose(momentum(simulator, plant, body), 0.2 * FORCE, atol=1e-9)
    give(simulator, push, -2.0 * FORCE, 0.6 - 1e-9)
    simulator.AdvanceTo(1.0)
    np.testing.assert_allclose(momentum(simulator, plant, body), 0.0, atol=1e-9)


def test_it_acts_on_the_body_it_is_of(pushed):
    simulator, push, _, body = pushed
    give(simulator, push, FORCE, 0.2)
    (force,) = push.get_output_port().Eval(push.GetMyContextFromRoot(simulator.get_context()))
    assert force.body_index == body.index()
    np.testing.assert_array_equal(force.F_Bq_W.translational(), FORCE)
    np.testing.assert_array_equal(force.F_Bq_W.rotational(), 0.0)
