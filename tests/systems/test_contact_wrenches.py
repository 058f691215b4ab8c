"""Contact as wrenches: what a body at rest must feel is known without any simulation."""

import numpy as np
import pytest
from pydrake.geometry import (
    AddCompliantHydroelasticProperties,
    AddContactMaterial,
    AddRigidHydroelasticProperties,
    Box,
    ProximityProperties,
    Sphere,
)
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.math import SpatialForce
from pydrake.multibody.plant import AddMultibodyPlant, CoulombFriction
from pydrake.multibody.tree import SpatialInertia, UnitInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from drake_blfdmp.robot.contact import ContactPlantConfig
from drake_blfdmp.robot.contact_wrenches import ContactForce, ContactPair, wrench_in_body, wrench_on
from drake_blfdmp.systems.contact_wrenches import ContactWrenches

MASS, GRAVITY, SIZE = 1.7, 9.81, (0.3, 0.2, 0.1)
COM = np.array([0.04, -0.03, 0.02])  # In the body's frame, whose origin lies at a place of its own.
CENTER = np.array([0.06, -0.01, 0.05])  # Of its faces.
YAW, FOOT = 0.7, 0.01


def _properties(hydroelastic, compliant):
    properties = ProximityProperties()
    AddContactMaterial(1.0, None if hydroelastic else 1e6, CoulombFriction(0.6, 0.6), properties)
    if hydroelastic and compliant:
        AddCompliantHydroelasticProperties(0.02, 5e6, properties)
    elif hydroelastic:
        AddRigidHydroelasticProperties(properties)
    return properties


class Resting:
    """A block at rest on two slabs side by side, turned about the vertical."""

    def __init__(self, hydroelastic, above=0.0, duration=1.0):
        builder = DiagramBuilder()
        plant, _ = AddMultibodyPlant(ContactPlantConfig(), builder)
        self.slabs = []
        for k, name in enumerate(("left", "right")):
            slab = plant.AddRigidBody(
                name, plant.AddModelInstance(name), SpatialInertia.SolidBoxWithMass(1.0, 1.0, 1.0, 0.1)
            )
            plant.WeldFrames(plant.world_frame(), slab.body_frame(), RigidTransform([k - 0.5, 0.0, -0.05]))
            shape = Box(1.0, 1.0, 0.1)
            plant.RegisterCollisionGeometry(slab, RigidTransform(), shape, name, _properties(hydroelastic, True))
            self.slabs.append(slab)
        inertia = SpatialInertia(MASS, COM, UnitInertia.SolidBox(*SIZE).ShiftFromCenterOfMass(COM))
        self.block = plant.AddRigidBody("block", plant.AddModelInstance("block"), inertia)
        shapes = {"block": (CENTER, Box(*SIZE))}
        if not hydroelastic:  # A box has one point of contact, on which it rocks; four feet stand.
            shapes = {
                f"foot {x} {y}": (
                    CENTER + np.array([x * SIZE[0] / 2, y * SIZE[1] / 2, FOOT - SIZE[2] / 2]),
                    Sphere(FOOT),
                )
                for x in (-1, 1)
                for y in (-1, 1)
            }
        for name, (at, shape) in shapes.items():
            X_BG, properties = RigidTransform(at), _properties(hydroelastic, False)
            plant.RegisterCollisionGeometry(self.block, X_BG, shape, name, properties)
        plant.Finalize()
        left, right = self.slabs
        pairs = {
            "block": ContactPair(self.block, (left, right)),
            "block_left": ContactPair(self.block, (left,)),
            "block_right": ContactPair(self.block, (right,)),
            "left": ContactPair(left, (self.block,)),
            "right": ContactPair(right, (self.block,)),
        }
        self.names = list(pairs)
        self.system = builder.AddSystem(ContactWrenches(pairs=list(pairs.values())))
        builder.Connect(plant.get_contact_results_output_port(), self.system.GetInputPort("contact_results"))
        simulator = Simulator(builder.Build())
        self.context = simulator.get_mutable_context()
        X_WB = RigidTransform(RollPitchYaw(0.0, 0.0, YAW), [0.0, 0.0, above + SIZE[2] / 2 - CENTER[2]])
        plant.SetFreeBodyPose(plant.GetMyMutableContextFromRoot(self.context), self.block, X_WB)
        simulator.AdvanceTo(duration)
        plant_context = plant.GetMyContextFromRoot(self.context)
        self.X_WB = plant.EvalBodyPoseInWorld(plant_context, self.block)
        self.X_WS = [plant.EvalBodyPoseInWorld(plant_context, slab) for slab in self.slabs]

    def __getitem__(self, name):
        """The wrench of a pair, in the frame of its body."""
        wrenches = self.system.get_output_port().Eval(self.system.GetMyContextFromRoot(self.context))
        X_WB = {"left": self.X_WS[0], "right": self.X_WS[1]}.get(name, self.X_WB)
        return wrench_in_body(wrenches.reshape(-1, 6)[self.names.index(name)], X_WB.GetAsMatrix34())


@pytest.fixture(scope="module", params=[True, False], ids=["hydroelastic", "point"])
def resting(request):
    return Resting(request.param)


def test_a_block_at_rest_is_held_by_its_weight(resting):
    """Force -m g, and the torque that keeps the weight at the centre of mass from turning it about its own origin."""
    up = resting.X_WB.rotation().inverse().matrix() @ [0.0, 0.0, 1.0]
    force = MASS * GRAVITY * up
    np.testing.assert_allclose(resting["block"][3:], force, atol=0.02)
    np.testing.assert_allclose(resting["block"][:3], np.cross(COM, force), atol=0.002)


def test_what_two_bodies_do_adds_up(resting):
    assert min(resting["block_left"][5], resting["block_right"][5]) > 1.0
    np.testing.assert_allclose(resting["block_left"] + resting["block_right"], resting["block"], atol=1e-12)


def test_what_acts_on_the_block_acts_back_on_the_slab(resting):
    """Both brought to the world's origin and axes, which lies elsewhere than either body's."""
    for name, X_WS in zip(("left", "right"), resting.X_WS, strict=True):
        total = np.zeros(6)
        for wrench, X in ((resting[f"block_{name}"], resting.X_WB), (resting[name], X_WS)):
            torque, force = X.rotation().matrix() @ wrench[:3], X.rotation().matrix() @ wrench[3:]
            total += np.concatenate([torque + np.cross(X.translation(), force), force])
        np.testing.assert_allclose(total, 0.0, atol=1e-9)


def test_the_other_bodies_contacts_do_not_count():
    contact = ContactForce(1, 2, np.array([0.1, 0.2, 0.3, 0.0, 0.0, 5.0]))
    np.testing.assert_array_equal(wrench_on([contact], 1, {3}), 0.0)
    np.testing.assert_array_equal(wrench_on([contact], 3, {1, 2}), 0.0)
    np.testing.assert_array_equal(wrench_on([contact], 1, {2}), [0.1, 0.2, 0.3, 0, 0, 5])
    np.testing.assert_array_equal(wrench_on([contact], 2, {1}), [-0.1, -0.2, -0.3, 0, 0, -5])
    np.testing.assert_array_equal(wrench_on([contact, contact], 1, {2}), [0.2, 0.4, 0.6, 0, 0, 10])


def test_a_wrench_in_a_bodys_frame_is_that_of_drake():
    rng = np.random.default_rng(5)
    wrenches = rng.normal(size=(2, 3, 6))
    poses = [RigidTransform(RollPitchYaw(*rng.normal(size=3)), rng.normal(size=3)) for _ in range(3)]
    found = wrench_in_body(wrenches, np.array([X_WB.GetAsMatrix34() for X_WB in poses]))
    for n in range(2):
        for k, X_WB in enumerate(poses):
            force = SpatialForce(tau=wrenches[n, k, :3], f=wrenches[n, k, 3:]).Shift(X_WB.translation())
            turned = force.get_coeffs().reshape(2, 3) @ X_WB.rotation().matrix()  # R_BW times columns, as rows.
            np.testing.assert_allclose(found[n, k], turned.ravel(), atol=1e-14)


def test_ports_without_state_and_zero_in_the_air():
    falling = Resting(True, above=1.0, duration=0.02)
    assert falling.system.num_input_ports() == 1 and falling.system.num_output_ports() == 1
    assert falling.system.CreateDefaultContext().num_total_states() == 0
    for name in ("block", "left"):
        np.testing.assert_array_equal(falling[name], 0.0)
