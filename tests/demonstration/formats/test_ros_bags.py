"""The containers: ROS 1 bags, ROS 2 bags and MCAP, whole and damaged; what they hold is in test_marker_arrays.py."""

import shutil
import sqlite3
from pathlib import Path

import numpy as np
import pytest
import ros_samples as samples
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mcap.writer import Writer
from rosbags.typesys import Stores
from synthetic_carry import SHARED, carry

from drake_blfdmp.demonstration.bones import FOREARMS, UPPER_ARMS, link_lengths
from drake_blfdmp.demonstration.formats import read_recording
from drake_blfdmp.errors import RecordingError

T, X = carry(duration=2.0)
T1, X1 = T[:9], X[:9]


def check(recording, name, t=T, x=X):
    assert recording.format == name
    np.testing.assert_array_equal(recording.x, x)
    np.testing.assert_allclose(recording.t, t, atol=1e-9)
    np.testing.assert_array_equal(recording.frames, np.arange(len(t)))
    assert recording.up == "z"
    assert any(sentence.startswith("unit: m, the file or its format says") for sentence in recording.evidence)
    assert "clock: s, as the file or its format says, 30 samples a second" in recording.evidence


@pytest.mark.parametrize("name", samples.SAMPLES)
def test_round_trip(tmp_path, name):
    check(read_recording(samples.SAMPLES[name](tmp_path / "bag", T, X)), name)


@pytest.mark.parametrize("compression", [None, "BZ2", "LZ4"])
def test_rosbag1_compressions(tmp_path, compression):
    check(read_recording(samples.write_rosbag1(tmp_path / "a.bag", T, X, compression=compression)), "rosbag1")


@pytest.mark.parametrize("compression", [None, "MESSAGE", "FILE"])
@pytest.mark.parametrize("storage", ["sqlite3", "mcap"])
@pytest.mark.parametrize("store", [Stores.ROS2_FOXY, Stores.ROS2_JAZZY])
def test_rosbag2_storages_compressions_and_versions(tmp_path, compression, storage, store):
    bag = samples.write_bag2(tmp_path / "bag", samples.named_topics(T1, X1), storage, store, compression)
    check(read_recording(bag), "rosbag2", T1, X1)
    check(read_recording(bag / "metadata.yaml"), "rosbag2", T1, X1)
    alone = read_recording(next(file for file in bag.iterdir() if file.suffix != ".yaml"))
    check(alone, "mcap" if storage == "mcap" and compression != "FILE" else "rosbag2", T1, X1)


@pytest.mark.parametrize("store", [Stores.ROS2_FOXY, Stores.ROS2_HUMBLE])
def test_rosbag2_without_definitions(tmp_path, store):
    """As up to Humble: which fields a marker has must then be found from the bytes."""
    path = samples.write_rosbag2(tmp_path / "a.db3", T1, X1, store=store)
    with sqlite3.connect(path) as connection:
        connection.execute("DROP TABLE message_definitions")
    connection.close()
    check(read_recording(path), "rosbag2", T1, X1)


def test_rosbag2_split_into_files(tmp_path):
    bag = samples.write_bag2(tmp_path / "bag", samples.named_topics(T[:30], X[:30]))
    second = samples.write_bag2(tmp_path / "second", samples.named_topics(T[30:], X[30:]))
    shutil.copyfile(second / "second.db3", bag / "bag_1.db3")
    index = bag / "metadata.yaml"
    text = index.read_text().replace("- bag.db3\n", "- bag/bag.db3\n  - bag_1.db3\n", 1)
    assert "bag_1.db3" in text
    index.write_text(text)
    check(read_recording(bag), "rosbag2")


def test_a_bag_that_was_never_closed(tmp_path):
    """Without the index at its end, as a killed recorder leaves it."""
    path = samples.write_rosbag1(tmp_path / "a.bag", T, X)
    content = path.read_bytes()
    index = int.from_bytes(content[content.index(b"index_pos=") + 10 :][:8], "little")
    path.write_bytes(content[:index])
    check(read_recording(path), "rosbag1")


def test_mcap_with_ros1_messages(tmp_path):
    types = samples.typestore(Stores.ROS1_NOETIC)
    path = tmp_path / "a.mcap"
    writer = Writer(str(path))
    writer.start(profile="ros1")
    definition, _ = types.generate_msgdef(samples.MARKERS, ros_version=1)
    schema = writer.register_schema("visualization_msgs/MarkerArray", "ros1msg", definition.encode())
    channel = writer.register_channel("/people", "ros1", schema)
    _, make = samples.named_topics(T, X)["/people"]
    for ns, message in make(types.types):
        writer.add_message(channel, ns, bytes(types.serialize_ros1(message, samples.MARKERS)), ns)
    writer.finish()
    check(read_recording(path), "mcap")


def test_messages_without_stamps_have_the_times_of_recording(tmp_path):
    def make(types):
        return [
            (a, samples.array(types, samples.named(types, 0, x))) for a, x in zip(samples.stamps(T), X, strict=True)
        ]

    recording = read_recording(samples.write_bag1(tmp_path / "a.bag", {"/people": (samples.MARKERS, make)}))
    np.testing.assert_allclose(recording.t, T, atol=1e-9)
    assert any("since the messages' stamps tell none" in sentence for sentence in recording.evidence)


def refused(said, path, **options):
    with pytest.raises(RecordingError) as caught:
        read_recording(path, **options)
    message = str(caught.value)
    assert said in message
    assert "\n" not in message
    assert path.name in message


def test_bags_that_hold_nobody(tmp_path):
    text = {"/chatter": ("std_msgs/msg/String", lambda types: [(5, types["std_msgs/msg/String"]("hello"))])}
    empty = {"/people": (samples.MARKERS, lambda types: [(5, samples.array(types, []))])}
    refused("it has /chatter (std_msgs/String)", samples.write_bag1(tmp_path / "a.bag", text))
    refused("it has /chatter (std_msgs/String)", samples.write_bag2(tmp_path / "a", text))
    refused("/people: 1 messages without any marker", samples.write_bag1(tmp_path / "b.bag", empty))
    refused("it has no topics", samples.write_bag1(tmp_path / "c.bag", {}))


def test_files_that_are_no_bags(tmp_path):
    old = tmp_path / "old.bag"
    old.write_bytes(b"#ROSBAG V1.2\n" + bytes(100))
    refused("is no ROS bag of version 2.0; convert it with rosbag fix", old)
    other = tmp_path / "other.db3"
    with sqlite3.connect(other) as connection:
        connection.execute("CREATE TABLE photos (id INTEGER)")
    connection.close()
    refused("no tables of topics and messages", other)
    for name, text, said in (
        ("a", "rosbag2_bagfile_information:\n  version: 5\n", "names no files (KeyError)"),
        ("b", "rosbag2_bagfile_information:\n  relative_file_paths: [gone.db3]\n", "'gone.db3', which is not there"),
        ("c", "rosbag2_bagfile_information:\n  relative_file_paths: [{]\n", "names no files"),
        ("d", "rosbag2_bagfile_information:\n  relative_file_paths: []\n", "names no file;"),
        ("e", "rosbag2_bagfile_information:\n  relative_file_paths: 7\n", "which is not there"),
        ("f", "rosbag2_bagfile_information:\n" + "  - " + "[" * 5000, "names no files"),
    ):
        folder = tmp_path / name
        folder.mkdir()
        (folder / "metadata.yaml").write_text(text)
        refused(said, folder)
    # A path out of the bag's directory is not followed.
    samples.write_rosbag2(tmp_path / "secret.db3", T1, X1)
    (tmp_path / "b" / "metadata.yaml").write_text(
        "rosbag2_bagfile_information:\n  relative_file_paths: [../secret.db3]\n"
    )
    refused("'secret.db3', which is not there", tmp_path / "b")


def test_an_encrypted_bag_is_refused(tmp_path):
    path = samples.write_rosbag1(tmp_path / "a.bag", T1, X1)
    content = path.read_bytes()
    at = content.index(b"chunk_count=")
    header = int.from_bytes(content[13:17], "little")
    field = b"encryptor=aes"
    grown = content[13 + 4 : 13 + 4 + header] + len(field).to_bytes(4, "little") + field
    assert at < 13 + 4 + header
    path.write_bytes(content[:13] + len(grown).to_bytes(4, "little") + grown + content[17 + header :])
    refused("is encrypted", path)


@pytest.mark.parametrize("size", [2**27, 2**31, 2**32 - 1])
@pytest.mark.parametrize("name", ["rosbag1", "rosbag2", "mcap"])
def test_counts_that_lie_are_refused_without_asking_for_the_memory(tmp_path, name, size):
    """The number of markers in a message, of bytes in a chunk and so on; 2^31 of anything would be 100 GB."""
    path = samples.SAMPLES[name](tmp_path / "bag", T1, X1)
    content = path.read_bytes()
    if name == "rosbag1":
        places = [content.index(b"op=\x05") - 8, content.index(b"size=") + 5, content.index(b"left_shoulder") - 4]
    elif name == "rosbag2":
        places = [content.index(b"left_shoulder") - 4, content.index(b"\x00\x01\x00\x00\x06") + 4]
    else:
        places = [content.index(b"zstd") - 20, content.index(b"zstd") + 4]
    for place in places:
        path.write_bytes(content[:place] + size.to_bytes(4, "little") + content[place + 4 :])
        refused("", path)


@pytest.fixture(scope="module", params=[*samples.SAMPLES, "lz4", "zstd"])
def valid(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp("bags")
    if request.param == "lz4":
        path = samples.write_rosbag1(folder / "a", T1, X1, compression="LZ4")
    elif request.param == "zstd":
        path = samples.write_rosbag2(folder / "a", T1, X1, compression="MESSAGE")
    else:
        path = samples.SAMPLES[request.param](folder / "a", T1, X1)
    return path.read_bytes()


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_mutated_bytes_give_a_recording_or_a_refusal(data, valid, tmp_path):
    content = bytearray(valid)
    for _ in range(data.draw(st.integers(1, 3))):
        start = data.draw(st.integers(0, len(content)))
        end = min(len(content), start + data.draw(st.sampled_from([1, 4, 100, 5000])))
        what = data.draw(st.sampled_from(["flip", "cut", "truncate", "insert", "repeat", "fill"]))
        if what == "flip" and start < len(content):
            content[start] ^= data.draw(st.integers(1, 255))
        elif what == "cut":
            del content[start:end]
        elif what == "truncate":
            del content[start:]
        elif what == "insert":
            content[start:start] = data.draw(st.binary(max_size=20))
        elif what == "repeat":
            content[start:start] = content[start:end]
        elif what == "fill":
            content[start:end] = data.draw(st.sampled_from([b"\0", b"\xff", b"\x7f"])) * (end - start)
    path = tmp_path / "mutated"
    path.write_bytes(content)
    try:
        recording = read_recording(path)
    except RecordingError as error:
        assert "\n" not in str(error)
        return
    assert recording.x.shape == (len(recording.t), 6, 3)
    assert np.isfinite(recording.t).all()


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(content=st.binary(max_size=200))
@pytest.mark.parametrize("magic", [b"#ROSBAG V2.0\n", b"SQLite format 3\0", b"\x89MCAP0\r\n", b"\x28\xb5\x2f\xfd"])
def test_junk_behind_the_magic_is_refused(tmp_path, magic, content):
    path = tmp_path / "junk"
    path.write_bytes(magic + content)
    refused("", path)


def azure_bag() -> Path:
    path = SHARED / "azure_kinect" / "body_tracking_data.bag"
    if not path.is_file():
        pytest.skip(f"{path} is not here")
    return path


def test_real_azure_kinect_bag():
    recording = read_recording(azure_bag())
    assert (recording.format, recording.up, len(recording.t)) == ("rosbag1", "-y", 933 - 60)
    assert "60 frames hold no person" in recording.evidence
    assert np.isfinite(recording.x).all()
    lengths = link_lengths(recording.x)
    for links, mean in ((UPPER_ARMS, 0.261), (FOREARMS, 0.219)):  # As measured on the whole set.
        assert abs(lengths[:, links].mean() - mean) < 0.003
        assert lengths[:, links].std() < 0.012
    assert 1 / np.median(np.diff(recording.t)) == pytest.approx(15.0, abs=0.1)
    jumps = np.linalg.norm(np.diff(recording.x[:, [2, 5]], axis=0), axis=-1)
    assert jumps.max() == pytest.approx(0.49, abs=0.005)
    low = np.mean(recording.confidence == 0.5, axis=0)
    assert np.all((low[[2, 5]] > 0.12) & (low[[2, 5]] < 0.18))  # 12 to 18 % of the wrists' samples.
    assert set(np.unique(recording.confidence)) == {0.5, 1.0}


def test_real_bag_cut_anywhere_is_refused(tmp_path):
    content = azure_bag().read_bytes()
    for end in np.linspace(20, len(content) - 1, 12).astype(int):
        path = tmp_path / "cut.bag"
        path.write_bytes(content[:end])
        refused("cut off or damaged before byte", path)


def test_a_truncated_mcap_says_where_and_what_to_do(tmp_path):
    topics = {"/chatter": ("std_msgs/msg/String", lambda types: [(5, types["std_msgs/msg/String"]("hello"))])}
    [whole] = samples.write_bag2(tmp_path / "bag", topics, storage="mcap").glob("*.mcap")
    content = whole.read_bytes()
    path = tmp_path / "cut.mcap"
    path.write_bytes(content[:-20])
    refused(f"of {len(content) - 20}, whole up to t = 5e-09 s; run python run.py recover {path}", path)
    refused("cut.mcap: truncated at byte ", path)
