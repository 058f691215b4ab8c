import os

import numpy as np
import pytest
import recorded_run as run
from decoded import decode
from mcap.reader import make_reader
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.multibody.tree import BallRpyJoint, SpatialInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import LogVectorOutput

from drake_blfdmp.recording.mcap_file import RecorderError
from drake_blfdmp.recording.mcap_recorder import McapRecorder
from drake_blfdmp.recording.read import read_mcap

TIMES = np.arange(0, 1_000_000_001, 10_000_000)  # ns


@pytest.fixture
def path(tmp_path):
    return tmp_path / "run.mcap"


def ns(stamp):
    return stamp.sec * 10**9 + stamp.nanosec


def test_an_independent_reader_sees_what_went_in(path):
    run.record(path)
    messages, qos = decode(path)
    for topic in ("/joint_states", "/tf", "/palm", "/margin"):
        assert np.array_equal([time for time, _ in messages[topic]], TIMES), topic
        assert qos[topic].durability.name == "VOLATILE"
    for topic in ("/robot_description", "/tf_static"):
        assert [time for time, _ in messages[topic]] == [0]
        assert qos[topic].durability.name == "TRANSIENT_LOCAL"
    assert messages["/robot_description"][0][1].data == run.URDF

    for time, message in messages["/joint_states"]:
        left, right = run.signal(time * 1e-9, "left_state"), run.signal(time * 1e-9, "right_state")
        assert ns(message.header.stamp) == time
        assert message.name == ["left_a", "left_b", "right_a"]
        np.testing.assert_array_equal(message.position, [*left[:2], *right[:1]])
        np.testing.assert_array_equal(message.velocity, [*left[2:], *right[1:]])
        np.testing.assert_array_equal(
            message.effort, [*run.signal(time * 1e-9, "left_effort"), *run.signal(time * 1e-9, "right_effort")]
        )
    for topic, bodies in (("/tf", run.BODIES), ("/tf_static", run.STATIC)):
        for time, message in messages[topic]:
            poses = run.poses_at(time * 1e-9)
            assert [transform.child_frame_id for transform in message.transforms] == list(bodies)
            for transform, index in zip(message.transforms, bodies.values(), strict=True):
                assert (ns(transform.header.stamp), transform.header.frame_id) == (time, "world")
                p, q = transform.transform.translation, transform.transform.rotation
                wxyz = poses[index].rotation().ToQuaternion().wxyz()
                np.testing.assert_allclose([p.x, p.y, p.z], poses[index].translation(), rtol=1e-7, atol=1e-7)
                np.testing.assert_allclose([q.w, q.x, q.y, q.z], wxyz, atol=1e-7)
    for time, message in messages["/palm"]:
        torque_force = run.signal(time * 1e-9, "palm")
        f, tau = message.wrench.force, message.wrench.torque
        np.testing.assert_array_equal([tau.x, tau.y, tau.z, f.x, f.y, f.z], torque_force)
        assert message.header.frame_id == "world"
    for time, message in messages["/margin"]:
        # An element with a joint's name would move that joint in a viewer.
        assert message.name == ["hands", "margin.left_a"]
        np.testing.assert_array_equal(message.position, run.signal(time * 1e-9, "margin"))
        assert len(message.velocity) == len(message.effort) == 0
    [(time, event)] = messages["/events"]
    assert (time, ns(event.stamp), event.msg, event.level) == (500_000_000, 500_000_000, "grasp", 20)


def test_index_metadata_and_attachment(path):
    run.record(path, chunk_duration=0.25)
    with path.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        header, summary = reader.get_header(), reader.get_summary()
        assert header.profile == "ros2"
        assert "drake_blfdmp" in header.library
        assert summary is not None and summary.statistics is not None
        assert summary.statistics.message_count == 4 * len(TIMES) + 3
        assert {chunk.compression for chunk in summary.chunk_indexes} == {"zstd"}
        # 0.25 s of simulated time each, whatever the wall clock said, and the event in the last.
        assert [chunk.message_end_time for chunk in summary.chunk_indexes] == [
            240_000_000,
            490_000_000,
            740_000_000,
            990_000_000,
            1_000_000_000,
        ]
        assert all(message.publish_time == message.log_time for _, _, message in reader.iter_messages())
        [metadata] = reader.iter_metadata()
        assert (metadata.name, metadata.metadata) == ("run", {"seed": "7", "synthetic": "True"})
        [attachment] = reader.iter_attachments()
        assert (attachment.name, attachment.data, attachment.media_type, attachment.create_time) == (
            "scenario.yaml",
            b"seed: 7\n",
            "application/yaml",
            0,
        )
        assert attachment.log_time == 1_000_000_000
        units = {channel.topic: channel.metadata.get("unit") for channel in summary.channels.values()}
        assert units["/margin"] == "m"


def test_same_run_same_bytes(tmp_path):
    for name in ("one", "two"):
        run.record(tmp_path / name)
    run.record(tmp_path / "other", metadata={"seed": 8})
    one, two, other = ((tmp_path / name).read_bytes() for name in ("one", "two", "other"))
    assert one == two
    assert one != other


def test_without_all_efforts_none_is_recorded(path):
    run.record(path, leave_out=("right_effort",))
    messages, _ = decode(path)
    assert all(len(message.effort) == 0 and len(message.velocity) == 3 for _, message in messages["/joint_states"])
    assert len(messages["/joint_states"]) == len(TIMES)


@pytest.mark.parametrize("port", ["left_state", "body_poses", "palm", "margin"])
def test_unconnected_port_is_named(path, port):
    with pytest.raises(RecorderError, match=f"'{port}' is not connected"):
        run.record(path, leave_out=(port,))


def test_a_file_is_never_overwritten(path):
    path.write_text("precious")
    with pytest.raises(RecorderError, match=r"run\.mcap: already exists"):
        McapRecorder(filename=path)
    assert path.read_text() == "precious"


@pytest.mark.parametrize("folder", ["missing", "file", "read_only"])
def test_a_folder_that_cannot_be_written(tmp_path, folder):
    if folder == "file":
        (tmp_path / folder).write_text("")
    elif folder == "read_only":
        if os.geteuid() == 0:
            pytest.skip("root writes everywhere")
        (tmp_path / folder).mkdir(mode=0o500)
    with pytest.raises(RecorderError, match=r"run\.mcap: cannot be created \(.+\); give") as caught:
        McapRecorder(filename=tmp_path / folder / "run.mcap")
    assert "\n" not in str(caught.value)


def test_time_that_runs_back_is_refused(path):
    diagram, recorder = run.make_run(path)
    simulator = Simulator(diagram)
    with recorder:
        simulator.AdvanceTo(0.1)
        simulator.get_mutable_context().SetTime(0.0)
        with pytest.raises(RecorderError, match=r"time went back from 0\.1 s to 0 s; use a new recorder"):
            simulator.Initialize()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"rate": 0.0}, "rate"),
        ({"rate": np.nan}, "rate"),
        ({"chunk_duration": -1.0}, "chunk_duration"),
        ({"joints": {"left": ["a"], "right": ["a"]}}, "joint name 'a'"),
        ({"bodies": {"a": 1}, "static_bodies": {"a": 2}}, "body name 'a'"),
        ({"static_bodies": {"a": 2}, "static_frames": {"a": RigidTransform()}}, "body name 'a'"),
    ],
)
def test_unusable_arguments_create_no_file(path, options, message):
    with pytest.raises(RecorderError, match=message):
        McapRecorder(filename=path, **options)
    assert not path.exists()


PENDULUM = """
<robot name="pendulum">
  <link name="base"/>
  <link name="bob">
    <inertial><mass value="1"/><origin xyz="0 0 -0.5"/>
      <inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial>
  </link>
  <joint name="world_joint" type="fixed"><parent link="world"/><child link="base"/></joint>
  <joint name="swing" type="continuous"><parent link="base"/><child link="bob"/><axis xyz="0 1 0"/></joint>
  <transmission type="SimpleTransmission"><joint name="swing"/><actuator name="motor"/></transmission>
</robot>
"""


def record_plant(path):
    """Two pendulums and a falling box; returns the log of the first pendulum's state and of the box's pose."""
    builder = DiagramBuilder()
    plant, _ = AddMultibodyPlantSceneGraph(builder, time_step=0.001)
    for arm, angle in (("left", 1.0), ("right", -0.5)):
        parser = Parser(plant)
        parser.SetAutoRenaming(True)
        [instance] = parser.AddModelsFromString(PENDULUM, "urdf")
        plant.RenameModelInstance(instance, arm)
        plant.GetJointByName("swing", instance).set_default_angle(angle)
    plant.AddRigidBody("box", plant.AddModelInstance("box"), SpatialInertia.SolidBoxWithMass(1.0, 0.1, 0.1, 0.1))
    plant.Finalize()
    with McapRecorder.AddToBuilder(filename=path, builder=builder, plant=plant, arms=["left", "right"]) as recorder:
        state = plant.get_state_output_port(plant.GetModelInstanceByName("left"))
        builder.Connect(state, recorder.AddVectorInput("again", 2, ["angle", "rate"], "rad"))
        logger = LogVectorOutput(state, builder, publish_period=0.01)
        box_logger = LogVectorOutput(
            plant.get_state_output_port(plant.GetModelInstanceByName("box")), builder, publish_period=0.01
        )
        simulator = Simulator(builder.Build())
        simulator.AdvanceTo(0.5)
        return logger.FindLog(simulator.get_context()).data(), box_logger.FindLog(simulator.get_context()).data()


def test_a_plant_through_add_to_builder(tmp_path):
    log, box_log = record_plant(tmp_path / "one")
    record_plant(tmp_path / "two")
    assert (tmp_path / "one").read_bytes() == (tmp_path / "two").read_bytes()

    series = read_mcap(tmp_path / "one").series
    joints, tf = series["/joint_states"], series["/tf"]
    n = len(joints.t)
    assert joints.names == ("left_swing", "right_swing")
    np.testing.assert_array_equal(joints.values[:, 0, :2], log.T[:n])
    np.testing.assert_array_equal(series["/again"].values, log.T[:n])
    assert np.all(joints.values[:, 0, 2] == 0.0)  # Nothing drives the motor.
    assert set(tf.names) == {"left_bob", "right_bob", "box"}
    assert set(series["/tf_static"].names) == {"left_base", "right_base"}
    box = tf.values[:, tf.names.index("box")]
    np.testing.assert_allclose(box[:, :3], box_log[4:7].T[:n], atol=1e-7)
    np.testing.assert_allclose(box[-1, 2], -0.5 * 9.81 * joints.t[-1] ** 2, rtol=0.01)


def test_an_arm_that_is_none(path):
    builder = DiagramBuilder()
    plant, _ = AddMultibodyPlantSceneGraph(builder, time_step=0.001)
    plant.AddRigidBody("box", plant.AddModelInstance("box"), SpatialInertia.SolidBoxWithMass(1.0, 0.1, 0.1, 0.1))
    plant.Finalize()
    for arm, message in (("arm", "no model instance 'arm'"), ("box", "'box' has 6 degrees of freedom")):
        with pytest.raises(RecorderError, match=message):
            McapRecorder.AddToBuilder(filename=path, builder=builder, plant=plant, arms=[arm])
    assert not path.exists()


def test_a_joint_that_is_placed_by_drake_alone(tmp_path):
    """A ball joint's body stands in /tf as Drake has it, by way of `body_poses`; so do the others beside it."""
    builder = DiagramBuilder()
    plant, _ = AddMultibodyPlantSceneGraph(builder, time_step=0.001)
    body = plant.AddRigidBody("ball", SpatialInertia.SolidBoxWithMass(1.0, 0.1, 0.2, 0.3))
    joint = plant.AddJoint(BallRpyJoint("joint", plant.world_frame(), body.body_frame()))
    plant.Finalize()
    joint.set_default_angles([0.3, -0.4, 0.5])
    recorder = McapRecorder.AddToBuilder(filename=tmp_path / "run.mcap", builder=builder, plant=plant, arms=[])
    assert recorder.HasInputPort("body_poses")
    state = plant.get_state_output_port()
    logger = LogVectorOutput(state, builder, publish_period=0.01)
    with recorder:
        simulator = Simulator(builder.Build())
        joint.set_angular_velocity(plant.GetMyMutableContextFromRoot(simulator.get_mutable_context()), [2.0, 1.0, -3.0])
        simulator.AdvanceTo(0.3)
        angles = logger.FindLog(simulator.get_context()).data()[:3].T
    found = read_mcap(tmp_path / "run.mcap").series["/tf"].values[:, 0]
    expected = [RollPitchYaw(one).ToQuaternion().wxyz() for one in angles]
    np.testing.assert_allclose(found[:, [6, 3, 4, 5]], expected[: len(found)], atol=1e-7)
    assert np.ptp(found[:, 5]) > 0.1


def test_a_frame_with_the_name_of_a_body_is_refused(path):
    builder = DiagramBuilder()
    plant, _ = AddMultibodyPlantSceneGraph(builder, time_step=0.001)
    plant.AddRigidBody("box", SpatialInertia.SolidBoxWithMass(1.0, 0.1, 0.1, 0.1))
    plant.Finalize()
    with pytest.raises(RecorderError, match="body name 'box' is empty or given twice"):
        McapRecorder.AddToBuilder(
            filename=path, builder=builder, plant=plant, arms=[], static_frames={"box": RigidTransform()}
        )
    assert not path.exists()
