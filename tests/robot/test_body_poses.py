"""Poses of bodies at many positions, against Drake's own."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import (
    BallRpyJoint,
    BodyIndex,
    FixedOffsetFrame,
    PrismaticJoint,
    QuaternionFloatingJoint,
    RevoluteJoint,
    SpatialInertia,
    WeldJoint,
)

from drake_blfdmp.robot.body_poses import BodyPoses
from drake_blfdmp.robot.plant import MakeKinematicPlant

INERTIA = SpatialInertia.SolidBoxWithMass(1.0, 0.1, 0.2, 0.3)


def pose(k):
    return RigidTransform(RollPitchYaw(0.3 * k, -0.2 * k, 0.1 + k), [0.1 * k, -0.2, 0.3])


def mixed_plant():
    """Two branches with every known joint, each with offsets on both sides, and two floating bodies, one not from W."""
    plant = MultibodyPlant(0.001)
    bodies = [plant.AddRigidBody(f"b{k}", INERTIA) for k in range(9)]
    joint = plant.AddJoint
    joint(RevoluteJoint("j0", _frame(plant, plant.world_body(), 1), _frame(plant, bodies[0], 2), [1.0, 2.0, -0.5]))
    joint(PrismaticJoint("j1", _frame(plant, bodies[0], 3), _frame(plant, bodies[1], 4), [0.2, -1.0, 0.7]))
    joint(WeldJoint("j2", _frame(plant, bodies[1], 5), _frame(plant, bodies[2], 6), pose(7)))
    joint(RevoluteJoint("j3", _frame(plant, bodies[2], 8), _frame(plant, bodies[3], 9), [0.0, 0.0, 1.0]))
    joint(WeldJoint("j4", plant.world_frame(), bodies[4].body_frame(), pose(3)))
    joint(RevoluteJoint("j5", _frame(plant, bodies[4], 1), bodies[5].body_frame(), [0.0, 1.0, 0.0]))
    joint(RevoluteJoint("j6", bodies[6].body_frame(), bodies[7].body_frame(), [0.0, 1.0, 0.0]))  # On a floating one.
    joint(QuaternionFloatingJoint("j7", _frame(plant, bodies[3], 2), _frame(plant, bodies[8], 5)))
    plant.Finalize()
    return plant


def _frame(plant, body, k):
    return plant.AddFrame(FixedOffsetFrame(f"f{k}_{body.name()}", body, pose(k)))


def drakes(plant, bodies, q):
    context = plant.CreateDefaultContext()
    found = []
    for one in q:
        plant.SetPositions(context, one)
        found.append([plant.EvalBodyPoseInWorld(context, plant.get_body(BodyIndex(b))).GetAsMatrix34() for b in bodies])
    return np.array(found)


def positions(plant, seed, n):
    rng = np.random.default_rng(seed)
    q = rng.uniform(-2.5, 2.5, (n, plant.num_positions()))
    for index in plant.GetJointIndices():
        joint = plant.get_joint(index)
        if joint.type_name() == "quaternion_floating":
            first = joint.position_start()
            q[:, first : first + 4] /= np.linalg.norm(q[:, first : first + 4], axis=1, keepdims=True)
    return q


@given(seed=st.integers(0, 2**31), n=st.integers(1, 5))
def test_every_joint_as_drake_has_it(seed, n):
    plant = mixed_plant()
    bodies = list(range(1, plant.num_bodies()))
    q = positions(plant, seed, n)
    np.testing.assert_allclose(BodyPoses(plant, bodies).evaluate(q), drakes(plant, bodies, q), atol=1e-12)


def test_some_bodies_in_the_order_asked_for():
    plant = mixed_plant()
    q = positions(plant, 1, 3)
    for bodies in ([4], [8, 1, 4], [0, 5]):
        np.testing.assert_allclose(BodyPoses(plant, bodies).evaluate(q), drakes(plant, bodies, q), atol=1e-12)


def test_a_quaternion_of_another_length_is_the_same_turn():
    plant = MultibodyPlant(0.001)
    plant.AddRigidBody("b", INERTIA)
    plant.Finalize()
    q = positions(plant, 2, 2)
    longer = q * [3.0, 3.0, 3.0, 3.0, 1.0, 1.0, 1.0]
    poses = BodyPoses(plant, [1])
    np.testing.assert_allclose(poses.evaluate(longer), poses.evaluate(q), atol=1e-12)


def test_the_arms():
    plant = MakeKinematicPlant()
    bodies = list(range(1, plant.num_bodies()))
    assert BodyPoses.known(plant)
    q = positions(plant, 3, 4)
    np.testing.assert_allclose(BodyPoses(plant, bodies).evaluate(q), drakes(plant, bodies, q), atol=1e-12)


def test_a_joint_that_is_not_known_is_named():
    plant = MultibodyPlant(0.001)
    body = plant.AddRigidBody("b", INERTIA)
    plant.AddJoint(BallRpyJoint("ball", plant.world_frame(), body.body_frame()))
    plant.Finalize()
    assert not BodyPoses.known(plant)
    with pytest.raises(ValueError, match="joint ball: ball_rpy is not known here"):
        BodyPoses(plant, [1])


def test_a_joint_that_is_hung_the_other_way_round_is_not_known():
    """Drake turns such a joint round; what places its body here does not."""
    plant = MultibodyPlant(0.001)
    body = plant.AddRigidBody("b", INERTIA)
    plant.AddJoint(RevoluteJoint("back", body.body_frame(), plant.world_frame(), [0.0, 0.0, 1.0]))
    plant.Finalize()
    assert not BodyPoses.known(plant)
    with pytest.raises(ValueError, match="body 1 is the child of no joint"):
        BodyPoses(plant, [1])


def test_positions_of_another_plant_are_refused():
    with pytest.raises(ValueError, match="13 positions of a plant that has 14"):
        BodyPoses(MakeKinematicPlant(), [1]).evaluate(np.zeros((1, 13)))
