import numpy as np
import pytest
import recorded_run as run
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mcap.writer import Writer

from drake_blfdmp.recording.mcap_file import McapFile, RecorderError
from drake_blfdmp.recording.read import McapRun, read_mcap
from drake_blfdmp.ros2.messages import joint_state_template


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    path = tmp_path_factory.mktemp("recordings") / "run.mcap"
    run.record(path, duration=0.6, chunk_duration=0.1)
    return path


@pytest.fixture(scope="module")
def whole(path):
    return read_mcap(path)


def test_values(whole):
    assert whole.damage == ""
    assert whole.robot_description == run.URDF
    assert whole.events == (("grasp", 0.5),)
    assert whole.metadata == {"run": {"seed": "7", "synthetic": "True"}}
    assert whole.attachments == {"scenario.yaml": b"seed: 7\n"}
    t = np.arange(61) * 0.01
    for topic, series in whole.series.items():
        np.testing.assert_allclose(series.t, t[:1] if topic == "/tf_static" else t, rtol=1e-12)
    joints, palm, margin, tf = (whole.series[topic] for topic in ("/joint_states", "/palm", "/margin", "/tf"))
    assert (margin.names, margin.unit) == (("hands", "margin.left_a"), "m")
    for k in range(61):
        left, right = run.signal(t[k], "left_state"), run.signal(t[k], "right_state")
        efforts = [*run.signal(t[k], "left_effort"), *run.signal(t[k], "right_effort")]
        np.testing.assert_allclose(
            joints.values[k].T, [[*left[:2], right[0]], [*left[2:], right[1]], efforts], rtol=1e-12
        )
        np.testing.assert_allclose(np.roll(palm.values[k].ravel(), 3), run.signal(t[k], "palm"), rtol=1e-12)
        np.testing.assert_allclose(margin.values[k], run.signal(t[k], "margin"), rtol=1e-12)
        for body, index in run.BODIES.items():
            X = run.poses_at(t[k])[index]
            wxyz = X.rotation().ToQuaternion().wxyz()
            expected = [*X.translation(), *wxyz[1:], wxyz[0]]
            np.testing.assert_allclose(tf.values[k, tf.names.index(body)], expected, atol=1e-6)


def test_unrecorded_efforts_are_nan(tmp_path):
    run.record(tmp_path / "run.mcap", duration=0.1, leave_out=("left_effort", "right_effort"))
    values = read_mcap(tmp_path / "run.mcap").series["/joint_states"].values
    assert np.isnan(values[:, :, 2]).all()
    assert np.isfinite(values[:, :, :2]).all()


def is_beginning_of(part: McapRun, whole: McapRun) -> bool:
    return all(
        np.array_equal(series.values, whole.series[topic].values[: len(series.t)], equal_nan=True)
        for topic, series in part.series.items()
    )


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_any_truncation_is_reported_and_read_up_to_the_break(data, path, whole, tmp_path):
    content = path.read_bytes()
    end = data.draw(st.integers(0, len(content) - 1))
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(content[:end])
    with pytest.raises(RecorderError, match=r"cut\.mcap: truncated at byte \d+ of \d+, whole up to t = .* s; run py"):
        read_mcap(cut)
    part = read_mcap(cut, recover=True)
    assert part.damage
    assert is_beginning_of(part, whole)


@settings(max_examples=100, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_a_wrong_byte_is_reported(data, path, whole, tmp_path):
    content = bytearray(path.read_bytes())
    content[data.draw(st.integers(0, len(content) - 1))] ^= data.draw(st.integers(1, 255))
    wrong = tmp_path / "wrong.mcap"
    wrong.write_bytes(content)
    with pytest.raises(RecorderError) as caught:
        read_mcap(wrong)
    assert "\n" not in str(caught.value)


def test_cut_in_the_middle_keeps_whole_chunks(path, whole, tmp_path):
    content = path.read_bytes()
    (tmp_path / "cut.mcap").write_bytes(content[: len(content) // 2])
    part = read_mcap(tmp_path / "cut.mcap", recover=True)
    n = len(part.series["/margin"].t)
    assert n in range(10, 60, 10)
    assert part.robot_description == whole.robot_description


def test_no_such_file(tmp_path):
    with pytest.raises(RecorderError, match=r"none\.mcap: cannot be read \(No such file"):
        read_mcap(tmp_path / "none.mcap")


def test_another_kind_of_file(tmp_path):
    (tmp_path / "a.csv").write_text("t,x,y,z\n0,0,0,0\n")
    with pytest.raises(RecorderError, match=r"a\.csv: not an MCAP file"):
        read_mcap(tmp_path / "a.csv", recover=True)


def test_another_writers_file(tmp_path):
    path = tmp_path / "a.mcap"
    writer = Writer(str(path))
    writer.start(profile="", library="another")
    writer.finish()
    with pytest.raises(RecorderError, match="not a McapRecorder file"):
        read_mcap(path)


@pytest.mark.parametrize("names", [["a", "bc"], ["ab", "d"]])
def test_names_that_change_are_refused(tmp_path, names):
    path = tmp_path / "a.mcap"
    file = McapFile(path)
    channel = file.add_channel("/v", "sensor_msgs/msg/JointState", {"unit": "m"})
    for k, some in enumerate((["ab", "c"], names)):
        template = joint_state_template(some, velocity=False, effort=False)
        file.write(channel, k, template.encode(k, np.zeros(2)))
    file.close()
    with pytest.raises(RecorderError, match="topic /v was not written by McapRecorder"):
        read_mcap(path)
