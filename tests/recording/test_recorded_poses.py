"""What is made of bodies' poses when samples are encoded, however a recorder learns of them."""

import numpy as np
import pytest
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.math import SpatialForce
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.multibody.tree import BallRpyJoint, FixedOffsetFrame, RevoluteJoint, SpatialInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource, LogVectorOutput

from drake_blfdmp.recording.mcap_recorder import McapRecorder
from drake_blfdmp.recording.read import read_mcap
from drake_blfdmp.recording.topics import VectorTopic

WRENCHES = np.array([[0.1, -0.2, 0.3, 4.0, 5.0, -6.0], [0.0, 0.5, 0.0, 1.0, 0.0, 0.0]])  # In W, about its origin.


@pytest.mark.parametrize("joint", [RevoluteJoint, BallRpyJoint])
def test_wrenches_and_vectors_in_the_frames_of_moving_bodies(joint, tmp_path):
    """Every sample of /tf, every second of the others: each against the plant's own pose at that instant."""
    builder = DiagramBuilder()
    plant, _ = AddMultibodyPlantSceneGraph(builder, 0.001)
    inertia = SpatialInertia.SolidBoxWithMass(1.0, 0.1, 0.2, 0.3)
    hanging, free = (plant.AddRigidBody(name, inertia) for name in ("hanging", "free"))
    frames = [
        plant.AddFrame(FixedOffsetFrame(name, frame, RigidTransform(RollPitchYaw(0.1, 0.2, 0.3), [0.4, 0.5, at])))
        for name, frame, at in (("hook", plant.world_frame(), 0.6), ("eye", hanging.body_frame(), -0.2))
    ]
    plant.AddJoint(joint("joint", *frames, *([[0.0, 1.0, 0.0]] if joint is RevoluteJoint else [])))
    plant.Finalize()
    bodies = [int(body.index()) for body in (free, hanging)]
    recorder = McapRecorder.AddToBuilder(filename=tmp_path / "a.mcap", builder=builder, plant=plant, arms=[])
    wrenches = recorder.AddWrenchInputs("contact", {"on_free": "free", "on_hanging": "hanging"}, bodies=bodies, every=2)
    heights = VectorTopic(
        "heights", ["free", "hanging", "twice"], "m", size=1, make=lambda rows: rows[:, [12, 24, 0]], bodies=bodies
    )
    vectors = recorder.AddVectorInputs("vectors", [heights], every=2)
    builder.Connect(builder.AddSystem(ConstantVectorSource(WRENCHES.ravel())).get_output_port(), wrenches)
    builder.Connect(builder.AddSystem(ConstantVectorSource([7.0])).get_output_port(), vectors)
    logger = LogVectorOutput(plant.get_state_output_port(), builder, publish_period=0.01)
    simulator = Simulator(builder.Build())
    context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    plant.SetFreeBodyPose(context, free, RigidTransform(RollPitchYaw(0.3, -0.4, 0.5), [1.0, 2.0, 3.0]))
    plant.SetVelocities(context, np.linspace(-2.0, 2.0, plant.num_velocities()))
    with recorder:
        simulator.AdvanceTo(0.1)
        states = logger.FindLog(simulator.get_context()).data().T
    series = read_mcap(tmp_path / "a.mcap").series
    assert len(series["/tf"].t) == 11
    for k, state in enumerate(states[:11:2]):
        plant.SetPositionsAndVelocities(context, state)
        poses = [plant.EvalBodyPoseInWorld(context, body) for body in (free, hanging)]
        for name, wrench, X_WB in zip(("/on_free", "/on_hanging"), WRENCHES, poses, strict=True):
            moved = SpatialForce(wrench[:3], wrench[3:]).Shift(X_WB.translation())
            torque, force = moved.get_coeffs().reshape(2, 3) @ X_WB.rotation().matrix()
            np.testing.assert_allclose(series[name].values[k], [force, torque], atol=1e-12)
        heights = [X_WB.translation()[2] for X_WB in poses]
        np.testing.assert_allclose(series["/heights"].values[k], [*heights, 7.0], atol=1e-12)
    assert np.ptp(series["/on_hanging"].values, axis=0).max() > 0.1
