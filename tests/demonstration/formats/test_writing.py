"""Our own files: what is written reads back, here and elsewhere."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from mcap.reader import make_reader
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from synthetic_carry import carry

from drake_blfdmp.demonstration.demonstration import Recording
from drake_blfdmp.demonstration.formats import read_recording
from drake_blfdmp.demonstration.formats.writing import WRITERS, check_suffix, write_recording
from drake_blfdmp.errors import RecordingError
from drake_blfdmp.skeleton import POINTS

T, X = carry(duration=1.0)
FRAMES = np.cumsum(1 + np.arange(len(T)) % 3) + 100
CONFIDENCE = np.tile([1.0, 0.5, 0.0, 1.0, 1.0, 0.5], (len(T), 1))


def recording(t=T, x=X, frames=FRAMES, confidence=None, up="-y", synthetic=False):
    return Recording(t, x, "somewhere/over/there.trc", "trc", frames, synthetic, confidence=confidence, up=up)


def with_holes():
    x = X.copy()
    x[3, 2] = x[7:9, 4] = x[7, 0] = np.nan
    return x


@pytest.mark.parametrize("suffix", WRITERS)
@pytest.mark.parametrize("told", [False, True])
def test_round_trip(tmp_path, suffix, told):
    x = with_holes()
    confidence = np.where(np.isfinite(x).all(axis=2), CONFIDENCE, 0.0) if told else None
    path = tmp_path / f"a{suffix}"
    write_recording(path, recording(x=x, confidence=confidence))
    back = read_recording(path)
    np.testing.assert_array_equal(back.x, x)
    np.testing.assert_allclose(back.t, T, atol=0.0 if suffix == ".csv" else 1e-9)
    np.testing.assert_array_equal(back.frames, FRAMES)
    if told:
        np.testing.assert_array_equal(back.confidence, confidence)
    else:
        assert back.confidence is None
    if suffix == ".mcap":
        assert back.up == "-y"


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    x=arrays(float, (4, 6, 3), elements=st.floats(-9.0, 9.0).filter(lambda v: v != 0.0)),
    t=st.lists(st.floats(-1e6, 1e6), min_size=4, max_size=4, unique=True),
)
@pytest.mark.parametrize("suffix", WRITERS)
def test_any_numbers_in_any_order_of_time(tmp_path, suffix, x, t):
    path = tmp_path / f"a{suffix}"
    path.unlink(missing_ok=True)
    write_recording(path, recording(np.array(t), x, np.arange(4)))
    back = read_recording(path, unit="m", time_unit="s")
    np.testing.assert_array_equal(back.x, x)
    if suffix == ".csv" or len(set(np.round(np.array(t), 9))) == 4:
        np.testing.assert_allclose(back.t, t, atol=1e-9 * max(1.0, np.abs(t).max()))


@pytest.mark.parametrize(
    ("up", "frame"), [("z", "world"), ("-y", "camera_optical_frame"), ("y", "recording"), (None, "recording")]
)
def test_the_axis_that_points_up(tmp_path, up, frame):
    path = tmp_path / "a.mcap"
    write_recording(path, recording(up=up))
    assert read_recording(path).up == up
    assert frame.encode() in b"".join(message.data for _, _, message in messages(path))


def messages(path):
    with path.open("rb") as file:
        return list(make_reader(file).iter_messages())


def test_mcap_is_what_ros2_reads(tmp_path):
    """Decoded by an independent implementation with the definition that the file embeds."""
    path = tmp_path / "a.mcap"
    x = with_holes()
    write_recording(path, recording(x=x, confidence=CONFIDENCE, synthetic=True))
    read = messages(path)
    schema, channel, _ = read[0]
    assert (channel.topic, channel.message_encoding, schema.encoding) == ("/skeleton", "cdr", "ros2msg")
    store, humble = get_typestore(Stores.EMPTY), get_typestore(Stores.ROS2_HUMBLE)
    store.register(get_types_from_msg(schema.data.decode(), schema.name))
    assert store.hash_rihs01(schema.name) == humble.hash_rihs01(schema.name)
    for k, (_, _, message) in enumerate(read):
        decoded = humble.deserialize_cdr(message.data, schema.name)
        expected = [j for j in range(6) if np.isfinite(x[k, j]).all()]
        assert [marker.ns for marker in decoded.markers] == [POINTS[j] for j in expected]
        for j, marker in zip(expected, decoded.markers, strict=True):
            p = marker.pose.position
            assert [p.x, p.y, p.z] == x[k, j].tolist()
            assert marker.color.a == CONFIDENCE[k, j]
            stamp = marker.header.stamp
            assert stamp.sec * 10**9 + stamp.nanosec == round(T[k] * 1e9) == message.log_time
    with path.open("rb") as file:
        reader = make_reader(file)
        metadata = next(reader.iter_metadata()).metadata
        header = reader.get_header()
    assert header.profile == "ros2"
    # The name alone: where a person keeps their files is nobody's business.
    assert (metadata["source"], metadata["synthetic"]) == ("there.trc", "True")


def test_equal_recordings_give_equal_files(tmp_path):
    for suffix in WRITERS:
        for name in "ab":
            write_recording(tmp_path / f"{name}{suffix}", recording())
        assert (tmp_path / f"a{suffix}").read_bytes() == (tmp_path / f"b{suffix}").read_bytes()


def test_csv_is_readable_by_people(tmp_path):
    path = tmp_path / "a.csv"
    write_recording(path, recording(x=with_holes()))
    header, *rows = path.read_text().splitlines()
    assert header.startswith("time_s,frame,ShoulderLeftX,ShoulderLeftY,ShoulderLeftZ,ElbowLeftX")
    assert header.endswith("WristRightX,WristRightY,WristRightZ")
    assert rows[3].split(",")[8:11] == ["", "", ""]


@pytest.mark.parametrize("name", ["a.txt", "a", "a.csv.bak", "csv"])
def test_unknown_suffixes_are_refused(tmp_path, name):
    for act in (check_suffix, lambda path: write_recording(path, recording())):
        with pytest.raises(RecordingError, match=r"give a name that ends in \.csv or \.mcap"):
            act(tmp_path / name)
    assert not (tmp_path / name).exists()


@pytest.mark.parametrize("suffix", WRITERS)
def test_nothing_is_overwritten(tmp_path, suffix):
    path = tmp_path / f"a{suffix.upper()}"
    path.write_text("precious")
    with pytest.raises(RecordingError, match="is there already and is not overwritten"):
        write_recording(path, recording())
    assert path.read_text() == "precious"
    with pytest.raises(RecordingError, match="cannot be written"):
        write_recording(tmp_path / "none" / f"a{suffix}", recording())


def test_a_time_no_stamp_can_hold(tmp_path):
    with pytest.raises(RecordingError, match="more than a ROS 2 stamp holds"):
        write_recording(tmp_path / "a.mcap", recording(t=T + 1e10))
    assert not (tmp_path / "a.mcap").exists()
