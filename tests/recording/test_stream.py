import json
import subprocess
import sys

import numpy as np
import pytest
import recorded_run as run
from foreign import PEAK, joints, write_foreign
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mcap.writer import CompressionType, Writer

from drake_blfdmp.recording.mcap_file import RecorderError
from drake_blfdmp.recording.stream import McapStream


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    path = tmp_path_factory.mktemp("stream") / "run.mcap"
    run.record(path)
    return path


def test_samples_are_what_the_plant_had(path):
    stream = McapStream(path)
    samples = list(stream)
    assert stream.damage == ""
    assert stream.metadata["run"]["seed"] == "7"
    assert stream.attachments == {"scenario.yaml": b"seed: 7\n"}
    assert {name: topic.messages for name, topic in stream.topics.items()} == {
        "/robot_description": 1,
        "/tf_static": 1,
        "/joint_states": 101,
        "/tf": 101,
        "/palm": 101,
        "/margin": 101,
        "/events": 1,
    }
    for sample in samples:
        if sample.topic == "/joint_states":
            left, right = run.signal(sample.t, "left_state"), run.signal(sample.t, "right_state")
            assert sample.names == ("left_a", "left_b", "right_a")
            np.testing.assert_array_equal(sample.values[:, 1], [*left[2:], *right[1:]])
        elif sample.topic == "/palm":
            np.testing.assert_array_equal(np.roll(sample.values.ravel(), 3), run.signal(sample.t, "palm"))
            assert (sample.frames, sample.unit) == (("world",), "N, N m")
        elif sample.topic == "/margin":
            np.testing.assert_array_equal(sample.values, run.signal(sample.t, "margin"))
        elif sample.topic == "/tf":
            assert (sample.names, sample.frames) == (tuple(run.BODIES), ("world", "world"))
            np.testing.assert_allclose(sample.values[1, :3], run.poses_at(sample.t)[3].translation(), atol=1e-6)
        elif sample.topic == "/events":
            assert sample.text == "grasp"
        elif sample.topic == "/robot_description":
            assert sample.text == run.URDF


def test_only_the_topics_asked_for(path):
    stream = McapStream(path, topics={"/margin"})
    assert {sample.topic for sample in stream} == {"/margin"}
    assert stream.topics["/tf"].messages == 101


@pytest.mark.parametrize("compression", list(CompressionType))
@pytest.mark.parametrize("use_chunking", [True, False])
def test_another_writers_files(tmp_path, compression, use_chunking):
    path = tmp_path / "a.mcap"
    messages = [(0, joints(0)), (5, joints(5, velocity=False, effort=False)), (9, joints(9, names=("c",)))]
    write_foreign(path, messages, compression=compression, use_chunking=use_chunking)
    first, second, third = McapStream(path)
    np.testing.assert_array_equal(first.values, [[0, 2, 4], [1, 3, 5]])
    np.testing.assert_array_equal(second.values, [[5, np.nan, np.nan], [6, np.nan, np.nan]])
    assert (third.names, third.t) == (("c",), 9 * 1e-9)


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_any_truncation_says_so_and_where(data, path, tmp_path):
    content = path.read_bytes()
    end = data.draw(st.integers(0, len(content) - 1))
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(content[:end])
    stream = McapStream(cut, recover=True)
    times = [sample.t for sample in stream]
    with pytest.raises(RecorderError) as caught:
        list(McapStream(cut))
    offset = int(str(caught.value).split("at byte ")[1].split()[0])
    assert offset <= end
    assert str(caught.value) == (
        f"{cut}: truncated at byte {offset} of {end}, whole up to t = {max(times, default=0):.6g} s; "
        f"run python run.py recover {cut}"
    )


@settings(max_examples=100, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_a_wrong_byte_is_always_found(data, path, tmp_path):
    content = bytearray(path.read_bytes())
    content[data.draw(st.integers(0, len(content) - 1))] ^= data.draw(st.integers(1, 255))
    wrong = tmp_path / "wrong.mcap"
    wrong.write_bytes(content)
    with pytest.raises(RecorderError) as caught:
        list(McapStream(wrong))
    assert "\n" not in str(caught.value)


def test_bad_input_is_one_line(tmp_path):
    def line(path):
        with pytest.raises(RecorderError) as caught:
            list(McapStream(path))
        return str(caught.value).removeprefix(f"{path}: ")

    assert line(tmp_path / "none.mcap") == "cannot be read (No such file or directory); check the name"
    (tmp_path / "a.csv").write_text("t,x,y,z\n0,0,0,0\n")
    assert line(tmp_path / "a.csv").startswith("not an MCAP file")
    write_foreign(tmp_path / "ros1.mcap", [], profile="ros1")
    assert line(tmp_path / "ros1.mcap") == "profile 'ros1' instead of ros2; convert it to ROS 2 first"
    write_foreign(tmp_path / "empty.mcap", [])
    assert line(tmp_path / "empty.mcap").startswith("holds no message")
    write_foreign(tmp_path / "back.mcap", [(3, joints(3)), (10**9, joints(4)), (5, joints(5))])
    assert line(tmp_path / "back.mcap").startswith("/joint_states: time goes back from 1 s to 5e-09 s at message 3;")
    write_foreign(tmp_path / "json.mcap", [(0, json.dumps({"name": ["a"]}).encode())])
    assert "/joint_states: message 1 at t = 0 s is no sensor_msgs/msg/JointState" in line(tmp_path / "json.mcap")


def test_memory_stays_bounded_and_pydrake_unneeded(tmp_path):
    # 400 MB of messages in a few MB: what is decompressed is the memory in question.
    path = tmp_path / "long.mcap"
    writer = Writer(str(path), chunk_size=8_000_000)
    writer.start(profile="ros2", library="another")
    channel = writer.register_channel("/zeros", "cdr", writer.register_schema("std_msgs/msg/Empty", "ros2msg", b""))
    for t in range(400):
        writer.add_message(channel, log_time=t, data=bytes(1_000_000), publish_time=t)
    writer.finish()
    script = (
        "import sys\n"
        "from drake_blfdmp.recording.stream import McapStream\n"
        "n = sum(1 for _ in McapStream(sys.argv[1]))\n"
        f"{PEAK}\n"
        "print(n, peak, 'pydrake' in sys.modules)\n"
    )
    done = subprocess.run([sys.executable, "-c", script, str(path)], capture_output=True, text=True, check=True)
    n, megabytes, pydrake = done.stdout.split()
    assert (n, pydrake) == ("400", "False")
    assert int(megabytes) < 300
