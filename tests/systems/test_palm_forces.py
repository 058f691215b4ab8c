"""The force monitor: its ports, zero without contact, and the push that was put in."""

import numpy as np
import pytest
from pydrake.geometry import ProximityProperties, Sphere
from pydrake.math import RigidTransform
from pydrake.multibody.plant import AddMultibodyPlant, ContactResults, CoulombFriction
from pydrake.multibody.tree import PrismaticJoint, SpatialInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from drake_blfdmp.robot.contact import ContactPlantConfig
from drake_blfdmp.systems.palm_forces import PalmForces

PUSH = 25.0


class Press:
    """Two balls on sliders on either side of a third, without gravity; each slider is pushed by its actuator."""

    def __init__(self, gap=0.0):
        builder = DiagramBuilder()
        self.plant, _ = AddMultibodyPlant(ContactPlantConfig(), builder)
        self.plant.mutable_gravity_field().set_gravity_vector(np.zeros(3))
        self.palms = [self._body("left", -0.1 - gap, 1.0), self._body("right", 0.1 + gap, -1.0)]
        self.box = self._body("box", 0.0, None)
        self.plant.Finalize()
        self.monitor = builder.AddSystem(PalmForces(palms=self.palms, box=self.box))
        builder.Connect(self.plant.get_contact_results_output_port(), self.monitor.GetInputPort("contact_results"))
        self.simulator = Simulator(builder.Build())
        self.context = self.simulator.get_mutable_context()

    def _body(self, name, x, direction):
        instance = self.plant.AddModelInstance(name)
        body = self.plant.AddRigidBody(name, instance, SpatialInertia.SolidBoxWithMass(0.5, 0.1, 0.1, 0.1))
        properties = ProximityProperties()
        properties.AddProperty("material", "coulomb_friction", CoulombFriction(0.5, 0.5))
        self.plant.RegisterCollisionGeometry(body, RigidTransform(), Sphere(0.05), name, properties)
        if direction is not None:
            frame = RigidTransform([x, 0.0, 0.0])
            joint = self.plant.AddJoint(
                PrismaticJoint(
                    f"{name}_slide",
                    self.plant.AddFrame(_fixed(self.plant, f"{name}_at", frame)),
                    body.body_frame(),
                    [direction, 0.0, 0.0],
                )
            )
            self.plant.AddJointActuator(f"{name}_push", joint)
        return body

    def forces(self, pushes, duration):
        for palm, push in zip(self.palms, pushes, strict=True):
            port = self.plant.get_actuation_input_port(palm.model_instance())
            port.FixValue(self.plant.GetMyMutableContextFromRoot(self.context), [push])
        self.simulator.AdvanceTo(duration)
        return self.monitor.GetOutputPort("palm_force").Eval(self.monitor.GetMyContextFromRoot(self.context))


def _fixed(plant, name, X_WF):
    from pydrake.multibody.tree import FixedOffsetFrame

    return FixedOffsetFrame(name, plant.world_frame(), X_WF)


def test_ports_and_no_state():
    press = Press()
    monitor = press.monitor
    assert (monitor.num_input_ports(), monitor.num_output_ports()) == (1, 1)
    assert monitor.GetOutputPort("palm_force").size() == 2
    assert monitor.CreateDefaultContext().num_total_states() == 0


def test_palms_that_do_not_touch_press_with_nothing():
    np.testing.assert_array_equal(Press(gap=0.05).forces([0.0, 0.0], 0.02), 0.0)


def test_both_palms_press_with_what_pushes_them():
    np.testing.assert_allclose(Press().forces([PUSH, PUSH], 0.5), PUSH, rtol=0.02)


def test_the_order_is_left_then_right():
    """The right palm is held off: only the left one pushes, and moves the box away with it."""
    left, right = Press(gap=0.0).forces([PUSH, -PUSH], 0.02)
    assert left > 1.0
    assert right == 0.0


def test_an_empty_contact_result_gives_zeros():
    press = Press()
    context = press.monitor.CreateDefaultContext()
    from pydrake.common.value import AbstractValue

    press.monitor.GetInputPort("contact_results").FixValue(context, AbstractValue.Make(ContactResults()))
    assert press.monitor.GetOutputPort("palm_force").Eval(context) == pytest.approx([0.0, 0.0])
