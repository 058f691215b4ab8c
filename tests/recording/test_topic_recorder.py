"""Inputs that are added to a recorder: vectors, several in one port, wrenches, messages, events."""

import numpy as np
import pytest
import recorded_run as run
from decoded import decode
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder, LeafSystem
from pydrake.systems.primitives import ConstantVectorSource

from drake_blfdmp.recording.mcap_file import RecorderError
from drake_blfdmp.recording.mcap_recorder import McapRecorder
from drake_blfdmp.recording.read import read_mcap
from drake_blfdmp.recording.topic_recorder import TopicRecorder
from drake_blfdmp.recording.topics import VectorTopic
from drake_blfdmp.ros2.messages import MARKERS, STRING, Lines, markers_template, string_message

TIMES = np.arange(0, 1_000_000_001, 10_000_000)  # ns


@pytest.fixture
def path(tmp_path):
    return tmp_path / "run.mcap"


def ends(rows):
    """A line's two ends, then their colours."""
    return np.hstack([rows, 2.0 * rows, rows[:, 1:2] * np.arange(8.0)])


def test_inputs_that_are_rounded_slow_or_messages_of_ones_own(path):
    builder = DiagramBuilder()
    value = np.array([1.0 / 3.0, np.pi, 1e-9])
    source = builder.AddSystem(ConstantVectorSource(value))
    wrench = builder.AddSystem(ConstantVectorSource(np.arange(1.0, 7.0) / 3.0))
    recorder = builder.AddSystem(
        McapRecorder(
            filename=path,
            bodies={"arm": 0},
            static_frames={"person": RigidTransform(RollPitchYaw(0.0, 0.0, np.pi / 2), [1.0, 2.0, 3.0])},
        )
    )
    poses = builder.AddSystem(run.Signals(np.inf))
    builder.Connect(poses.GetOutputPort("body_poses"), recorder.GetInputPort("body_poses"))
    names, line = ["a", "b", "c"], markers_template("arm", [], [Lines("a", 0, 0.1, 1)])
    ports = [
        recorder.AddVectorInput("exact", 3, names, "m"),
        recorder.AddVectorInput("rounded", 3, names, "m", single_precision=True, every=4),
        recorder.AddMessageInput("text", 3, STRING, lambda t_ns, x: string_message(f"{t_ns} {x[1]:.3f}"), every=2),
        recorder.AddTemplateInput("lines", 3, MARKERS, line, ends, every=5),
    ]
    for port in ports:
        builder.Connect(source.get_output_port(), port)
    builder.Connect(wrench.get_output_port(), recorder.AddWrenchInput("push", "arm", single_precision=True))
    with recorder:
        Simulator(builder.Build()).AdvanceTo(0.1)
    messages, _ = decode(path)
    assert all(np.array_equal(message.position, value) for _, message in messages["/exact"])
    assert [time for time, _ in messages["/exact"]] == list(TIMES[:11])
    assert [time for time, _ in messages["/rounded"]] == list(TIMES[:11:4])
    assert all(np.array_equal(m.position, np.float32(value)) for _, m in messages["/rounded"])
    assert [message.data for _, message in messages["/text"]] == [f"{time} 3.142" for time in TIMES[:11:2]]
    assert [time for time, _ in messages["/lines"]] == list(TIMES[:11:5])
    for _, message in messages["/lines"]:
        [marker] = message.markers
        np.testing.assert_array_equal([[p.x, p.y, p.z] for p in marker.points], [value, 2.0 * value])
        colours = [[c.r, c.g, c.b, c.a] for c in marker.colors]
        np.testing.assert_array_equal(colours, np.float32(value[1] * np.arange(8.0)).reshape(2, 4))
    force = messages["/push"][0][1].wrench.force
    np.testing.assert_array_equal([force.x, force.y, force.z], np.float32([4 / 3, 5 / 3, 2.0]))
    [person] = messages["/tf_static"][0][1].transforms
    assert (person.header.frame_id, person.child_frame_id) == ("world", "person")
    where, turn = person.transform.translation, person.transform.rotation
    assert (where.x, where.y, where.z) == (1.0, 2.0, 3.0)
    np.testing.assert_allclose([turn.z, turn.w], np.sqrt(0.5), rtol=1e-6)


def test_unusable_inputs(path):
    diagram, recorder = run.make_run(path)
    with recorder:
        for name in ("margin", "palm", "tf", "events", "left_state"):
            with pytest.raises(RecorderError, match=f"'{name}' is taken"):
                recorder.AddVectorInput(name, 1, ["a"], "m")
        for name in ("", "/a", "a//b", "a b", "1a", "a/"):
            with pytest.raises(RecorderError, match="is no topic name"):
                recorder.AddWrenchInput(name, "world")
        with pytest.raises(RecorderError, match="size 2 but 1 names"):
            recorder.AddVectorInput("new", 2, ["a"], "m")
        with pytest.raises(RecorderError, match="element name 'a'"):
            recorder.AddVectorInput("new", 2, ["a", "a"], "m")
        with pytest.raises(RecorderError, match="every 0 samples; give 1 or more"):
            recorder.AddVectorInput("new", 1, ["a"], "m", every=0)
        with pytest.raises(RecorderError, match="no unit"):
            recorder.AddVectorInput("new", 1, ["a"], "")
        for t in (-1.0, np.nan):
            with pytest.raises(RecorderError, match="event 'grasp' at t"):
                recorder.Event("grasp", t)
        Simulator(diagram).AdvanceTo(0.01)
        with pytest.raises(RecorderError, match="after the first sample"):
            recorder.AddVectorInput("new", 1, ["a"], "m")


def constant(builder, value):
    return builder.AddSystem(ConstantVectorSource(np.asarray(value, dtype=float))).get_output_port()


def test_several_topics_in_one_port(path):
    builder = DiagramBuilder()
    recorder = builder.AddSystem(TopicRecorder(filename=path))
    topics = [
        VectorTopic("plain", ["a", "b"], "m"),
        VectorTopic("made", ["sum"], "rad", size=3, make=lambda rows: rows.sum(axis=1, keepdims=True)),
        VectorTopic("rounded", ["c"], "1", single_precision=True),
    ]
    port = recorder.AddVectorInputs("signals", topics, every=2)
    assert port.size() == 6 and port.get_name() == "signals"
    builder.Connect(constant(builder, [1.0, 2.0, 10.0, 20.0, 30.0, 1 / 3]), port)
    with recorder:
        Simulator(builder.Build()).AdvanceTo(0.1)
    series = read_mcap(path).series
    for name, values in (("/plain", [1.0, 2.0]), ("/made", [60.0]), ("/rounded", [np.float32(1 / 3)])):
        np.testing.assert_array_equal(series[name].values, np.tile(values, (6, 1)))
        np.testing.assert_allclose(series[name].t, np.arange(6) * 0.02)
    assert (series["/plain"].names, series["/made"].unit) == (("a", "b"), "rad")


def test_several_wrenches_in_one_port(path):
    builder = DiagramBuilder()
    recorder = builder.AddSystem(TopicRecorder(filename=path))
    port = recorder.AddWrenchInputs("contact", {"contact/left": "left_palm", "contact/right": "right_palm"})
    builder.Connect(constant(builder, np.arange(12.0)), port)
    with recorder:
        Simulator(builder.Build()).AdvanceTo(0.02)
    series = read_mcap(path).series
    np.testing.assert_array_equal(series["/contact/left"].values[0], [[3, 4, 5], [0, 1, 2]])
    np.testing.assert_array_equal(series["/contact/right"].values[0], [[9, 10, 11], [6, 7, 8]])


def test_events_are_written_where_a_number_changes_and_has_a_name(path):
    class Number(LeafSystem):
        def __init__(self):
            super().__init__()
            self.DeclareVectorOutputPort("number", 1, self._calc, {self.time_ticket()})

        def _calc(self, context, output):
            output.SetFromVector([np.searchsorted([0.025, 0.055, 0.075], context.get_time()) % 3])

    builder = DiagramBuilder()
    recorder = builder.AddSystem(TopicRecorder(filename=path))
    builder.Connect(builder.AddSystem(Number()).get_output_port(), recorder.AddEventInput("state", ["off", "on", ""]))
    with recorder:
        Simulator(builder.Build()).AdvanceTo(0.1)
    events = read_mcap(path).events
    assert [name for name, _ in events] == ["off", "on", "off"]
    np.testing.assert_allclose([t for _, t in events], [0.0, 0.03, 0.08])


def test_a_number_without_a_source_is_named(path):
    recorder = TopicRecorder(filename=path)
    recorder.AddEventInput("state", ["off"])
    with recorder, pytest.raises(RecorderError, match="'state' is not connected"):
        Simulator(recorder).AdvanceTo(0.1)
    with pytest.raises(RecorderError, match="'late' comes after the first sample"):
        recorder.AddEventInput("late", ["off"])


def test_poses_that_nothing_tells(path):
    recorder = TopicRecorder(filename=path)
    builder = DiagramBuilder()
    builder.AddSystem(recorder)
    source = builder.AddSystem(ConstantVectorSource(np.zeros(6)))
    builder.Connect(source.get_output_port(), recorder.AddWrenchInputs("contact", {"contact": "palm"}, bodies=[1]))
    with recorder, pytest.raises(RecorderError, match="poses of bodies are wanted, which only a recorder of a plant"):
        Simulator(builder.Build()).Initialize()
