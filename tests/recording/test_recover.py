import subprocess
import sys

import numpy as np
import pytest
import recorded_run as run
from foreign import PEAK, joints, write_foreign
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer
from rosbags.rosbag2 import Reader

from drake_blfdmp.recording.mcap_file import RecorderError
from drake_blfdmp.recording.recover import recover


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    path = tmp_path_factory.mktemp("recover") / "run.mcap"
    run.record(path, duration=0.6, chunk_duration=0.1)
    return path


def content(path):
    """Everything in a file, by its index, every checksum verified."""
    with path.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        messages = [(c.topic, m.log_time, m.sequence, m.data) for _, c, m in reader.iter_messages(log_time_order=False)]
        attachments = [(a.name, a.data, a.log_time) for a in reader.iter_attachments()]
        metadata = [(m.name, m.metadata) for m in reader.iter_metadata()]
        return messages, attachments, metadata


@settings(max_examples=50, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_any_truncation_is_recovered_up_to_the_break(data, path, tmp_path):
    whole = path.read_bytes()
    end = data.draw(st.integers(0, len(whole) - 1))
    cut, out = tmp_path / "cut.mcap", tmp_path / "out.mcap"
    cut.write_bytes(whole[:end])
    out.unlink(missing_ok=True)
    try:
        done = recover(cut, out)
    except RecorderError as error:
        assert "nothing in it is whole" in str(error)
        assert end < 2000 and not out.exists()
        return
    for found, expected in zip(content(out), content(path), strict=True):
        assert found == expected[: len(found)]
    assert done.messages == len(content(out)[0])
    assert recover(out, tmp_path / "none").path is None
    assert cut.read_bytes() == whole[:end]


@settings(max_examples=50, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_a_wrong_byte_costs_a_chunk_at_most_or_what_follows(data, path, tmp_path):
    whole = bytearray(path.read_bytes())
    whole[data.draw(st.integers(8, len(whole) - 1))] ^= data.draw(st.integers(1, 255))
    wrong, out = tmp_path / "wrong.mcap", tmp_path / "out.mcap"
    wrong.write_bytes(whole)
    out.unlink(missing_ok=True)
    try:
        recover(wrong, out)
    except RecorderError as error:
        assert "\n" not in str(error)
        return
    found, expected = content(out), content(path)
    assert set(found[0]) <= set(expected[0])
    assert set(found[1]) <= set(expected[1])


def test_a_damaged_chunk_is_left_out_and_the_rest_kept(path, tmp_path):
    with path.open("rb") as stream:
        chunks = make_reader(stream).get_summary().chunk_indexes
    for k in (0, 3):  # The first describes the channels.
        whole = bytearray(path.read_bytes())
        whole[chunks[k].chunk_start_offset + 200] ^= 1
        wrong = tmp_path / f"{k}.mcap"
        wrong.write_bytes(whole)
        done = recover(wrong)
        assert (done.left_out, done.damage) == (1, "1 damaged record left out")
        expected = [
            message
            for message in content(path)[0]
            if not chunks[k].message_start_time <= message[1] <= chunks[k].message_end_time
        ]
        assert content(done.path)[0] == expected
        with Reader(done.path) as reader:
            assert reader.message_count == len(expected)


@pytest.mark.parametrize("compression", list(CompressionType))
@pytest.mark.parametrize("use_chunking", [True, False])
@pytest.mark.parametrize("profile", ["ros2", "ros1"])
def test_another_writers_file(tmp_path, compression, use_chunking, profile):
    path = tmp_path / "a.mcap"
    messages = [(t, joints(t)) for t in range(0, 1000, 7)]
    write_foreign(path, messages, profile=profile, compression=compression, use_chunking=use_chunking)
    whole = path.read_bytes()
    (tmp_path / "cut.mcap").write_bytes(whole[: len(whole) // 2])
    done = recover(tmp_path / "cut.mcap")
    with done.path.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        assert reader.get_header().profile == profile
        assert len(reader.get_summary().chunk_indexes) > 0
    found = [(t, data) for _, t, _, data in content(done.path)[0]]
    assert found == messages[: len(found)] and 30 < len(found) < 143


def test_command(command_line, path, tmp_path, capsys):
    assert command_line.main(["recover", str(path)]) == 0
    assert capsys.readouterr().out == f"{path}: intact, nothing to recover\n"
    whole = path.read_bytes()
    cut = tmp_path / "run.mcap"
    cut.write_bytes(whole[: len(whole) - 5])
    assert command_line.main(["recover", str(cut)]) == 0
    first, second = capsys.readouterr().out.splitlines()
    assert first == f"{cut}: no index at its end"
    assert second == f"{tmp_path / 'run-recovered.mcap'}: {4 * 61 + 3} messages on 7 topics, up to t = 0.6 s"
    assert content(tmp_path / "run-recovered.mcap") == content(path)
    for arguments, line in (
        ([str(cut)], f"run.py: {tmp_path / 'run-recovered.mcap'}: already exists and is not overwritten; name another"),
        ([str(tmp_path / "none.mcap")], f"run.py: {tmp_path / 'none.mcap'}: cannot be read (No such file"),
        ([__file__], f"run.py: {__file__}: not an MCAP file"),
        ([str(cut), "--out", str(tmp_path / "no" / "a.mcap")], f"run.py: {tmp_path / 'no' / 'a.mcap'}: cannot be wri"),
    ):
        assert command_line.main(["recover", *arguments]) == 2
        error = capsys.readouterr().err.splitlines()[-1]
        assert error.startswith(line)


def test_memory_stays_bounded(tmp_path):
    path = tmp_path / "long.mcap"
    writer = Writer(str(path), compression=CompressionType.NONE, chunk_size=8_000_000)
    writer.start(profile="ros2", library="another")
    channel = writer.register_channel("/zeros", "cdr", writer.register_schema("std_msgs/msg/Empty", "ros2msg", b""))
    noise = np.random.default_rng(0).bytes(1_000_000)
    for t in range(100):
        writer.add_message(channel, log_time=t, data=noise, publish_time=t)
    # An attachment that is not taken into memory as a whole, then one more chunk, and no end.
    writer.add_attachment(0, 0, "large", "application/octet-stream", bytes(60_000_000))
    writer.flush()
    script = (
        "import sys\n"
        "from drake_blfdmp.recording.recover import recover\n"
        "done = recover(sys.argv[1])\n"
        f"{PEAK}\n"
        "print(done.messages, peak, 'pydrake' in sys.modules)\n"
    )
    done = subprocess.run([sys.executable, "-c", script, str(path)], capture_output=True, text=True, check=True)
    messages, megabytes, pydrake = done.stdout.split()
    assert (messages, pydrake) == ("100", "False")
    assert int(megabytes) < 300
    with (tmp_path / "long-recovered.mcap").open("rb") as stream:
        [attachment] = make_reader(stream, validate_crcs=True).iter_attachments()
        assert (attachment.name, len(attachment.data)) == ("large", 60_000_000)
