import contextlib
import os
import resource
import signal
import subprocess
import sys
import textwrap
import time

import numpy as np
import pytest
from mcap.reader import make_reader

from drake_blfdmp.recording.journal import journal_of
from drake_blfdmp.recording.mcap_file import McapFile, RecorderError
from drake_blfdmp.recording.message_block import MessageBlock
from drake_blfdmp.recording.piece import Piece
from drake_blfdmp.recording.recover import recover
from drake_blfdmp.recording.stream import McapStream
from drake_blfdmp.ros2.messages import joint_state_template

NAMES = ("a", "b", "c")
STEP_NS = 1_000_000


def begin(path, **options):
    """A file with two topics, and a function that writes sample k."""
    file = McapFile(path, **options)
    file.add_metadata("run", {"seed": 7})
    channels = [file.add_channel(f"/{name}", "sensor_msgs/msg/JointState", {"unit": "m"}) for name in ("one", "two")]
    template = joint_state_template(NAMES, velocity=False, effort=False)
    block = MessageBlock([(channel, template) for channel in channels])

    def write(k):
        [records] = block.encode(np.array([k * STEP_NS]), k + np.arange(5.0, -1.0, -1.0)[None])
        file.write_pieces([Piece(records, k * STEP_NS, block)])

    return file, write


def samples(path, topic="/one"):
    """k of every sample in the file, read by its index; the values are checked."""
    with path.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        assert reader.get_summary().statistics.message_count == sum(
            reader.get_summary().statistics.channel_message_counts.values()
        )
        indexed = [message.log_time // STEP_NS for _, _, message in reader.iter_messages(topics=[topic])]
    streamed = []
    for sample in McapStream(path):
        if sample.topic == topic:
            k = round(sample.t * 1e9) // STEP_NS
            first = [5, 4, 3] if topic == "/one" else [2, 1, 0]
            np.testing.assert_array_equal(sample.values, k + np.array(first, dtype=float))
            streamed.append(k)
    assert indexed == streamed
    return indexed


def test_every_message_is_where_the_index_says(tmp_path):
    path = tmp_path / "a.mcap"
    file, write = begin(path, chunk_duration=0.01)
    for k in range(95):
        write(k)
        if k == 50:
            file.write(1, k * STEP_NS, joint_state_template(NAMES, velocity=False, effort=False).encode(0, np.zeros(3)))
            file.add_attachment("notes", b"between chunks", "text/plain")
    file.close()
    with path.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        summary = reader.get_summary()
        assert [index.message_start_time for index in summary.chunk_indexes] == list(range(0, 95_000_000, 10_000_000))
        assert summary.statistics.channel_message_counts == {1: 96, 2: 95}
        assert (summary.statistics.message_start_time, summary.statistics.message_end_time) == (0, 94_000_000)
        [attachment] = reader.iter_attachments()
        assert (attachment.data, attachment.log_time) == (b"between chunks", 50_000_000)
        [metadata] = reader.iter_metadata()
        assert metadata.metadata == {"seed": "7"}
        content = path.read_bytes()
        for chunk in summary.chunk_indexes:
            # Each message index begins where the chunk's entry says, and is that channel's.
            for channel, at in chunk.message_index_offsets.items():
                assert (content[at], int.from_bytes(content[at + 9 : at + 11], "little")) == (7, channel)
    assert samples(path, "/two") == list(range(95))
    assert not journal_of(path).exists()


def child(body, path, *more):
    """A process without pydrake that runs the body, with `begin` and the acknowledging `write`."""
    script = textwrap.dedent(
        """
        import os, sys, time
        from test_mcap_file import *
        file, plain = begin(Path(sys.argv[1]), chunk_duration=0.2)
        def write(k):
            plain(k)
            os.write(1, b"k")
        """
    ) + textwrap.dedent(body)
    script = script.replace("from test_mcap_file", "from pathlib import Path\nfrom test_mcap_file", 1)
    here = os.path.dirname(__file__)  # noqa: PTH120
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([here, *sys.path])}
    return subprocess.Popen(
        [sys.executable, "-c", script, str(path), *more],
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )


@pytest.mark.parametrize("acknowledged", [1, 150, 200, 1234])
def test_killed_at_any_moment_nothing_written_is_lost(tmp_path, acknowledged):
    path = tmp_path / "run.mcap"
    process = child("for k in range(10**9): write(k)", path)
    seen = len(process.stdout.read(acknowledged))
    process.send_signal(signal.SIGKILL)
    seen += len(process.stdout.read())  # What came before the signal.
    process.wait()
    assert process.returncode == -signal.SIGKILL and seen >= acknowledged
    with pytest.raises(RecorderError, match=r"run\.mcap: truncated at byte \d+ of \d+, whole up to t = .*; run python"):
        list(McapStream(path))
    done = recover(path)
    assert done.path == tmp_path / "run-recovered.mcap" and done.left_out == 0
    found = samples(done.path)
    assert found == list(range(len(found)))
    assert seen <= len(found) <= seen + 1
    assert McapStream(done.path, topics=set()).damage == ""
    assert recover(done.path).path is None  # The result is intact.


def test_without_its_journal_what_is_in_chunks_is_left(tmp_path):
    path = tmp_path / "run.mcap"
    process = child("for k in range(250): write(k)\nos.kill(os.getpid(), 9)", path)
    process.communicate()
    journal_of(path).unlink()
    assert samples(recover(path).path) == list(range(200))


def test_a_journal_left_over_by_a_finished_chunk_is_not_taken_twice(tmp_path):
    path = tmp_path / "run.mcap"
    process = child("for k in range(201): write(k)\nos.kill(os.getpid(), 9)", path)
    process.communicate()
    # As if killed between the chunk and the sample after it: the last sample goes, the first chunk's pieces stay.
    content = journal_of(path).read_bytes()
    length = int.from_bytes(content[:4], "little")
    journal_of(path).write_bytes(content[16 + length :])
    assert samples(recover(path).path) == list(range(200))


def test_a_torn_journal_ends_at_the_tear(tmp_path):
    path = tmp_path / "run.mcap"
    process = child("for k in range(100): write(k)\nos.kill(os.getpid(), 9)", path)
    process.communicate()
    content = bytearray(journal_of(path).read_bytes())
    content[len(content.rstrip(b"\0")) // 2] ^= 1
    journal_of(path).write_bytes(content)
    found = samples(recover(path).path)
    assert found == list(range(len(found))) and 30 < len(found) < 70


def test_an_interruption_anywhere_leaves_a_file_that_close_completes(tmp_path):
    # Signals at moments spread over everything that writing does, chunks of three samples and metadata among it.
    rng = np.random.default_rng(0)
    for trial in range(60):
        path = tmp_path / f"{trial}.mcap"
        file, write = begin(path, chunk_duration=0.003)
        written, interrupted = [], []

        def interrupt(number, frame, interrupted=interrupted):
            interrupted.append(number)
            raise KeyboardInterrupt

        # A function of its own: what a signal raises at a loop's jump back passes by an `except` around the loop.
        def write_on(file=file, write=write, written=written, interrupted=interrupted):
            while not interrupted:  # Where Python runs no caller's code, in a finaliser, the exception is lost.
                write(len(written))
                written.append(None)
                if len(written) % 7 == 0:
                    file.add_metadata("more", {"k": len(written)})

        before = signal.signal(signal.SIGALRM, interrupt)
        try:
            signal.setitimer(signal.ITIMER_REAL, rng.uniform(1e-5, 3e-3))
            write_on()
        except KeyboardInterrupt:
            pass
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0)
            signal.signal(signal.SIGALRM, before)
        file.close()
        if written:
            assert samples(path) in (list(range(len(written))), list(range(len(written) + 1)))
        assert not journal_of(path).exists()


def test_an_interrupted_close_can_be_called_again(tmp_path):
    rng = np.random.default_rng(1)
    for trial in range(40):
        path = tmp_path / f"{trial}.mcap"
        file, write = begin(path)
        for k in range(50):
            write(k)

        def interrupt(number, frame):
            raise KeyboardInterrupt

        before = signal.signal(signal.SIGALRM, interrupt)
        with contextlib.suppress(KeyboardInterrupt):
            signal.setitimer(signal.ITIMER_REAL, rng.uniform(1e-5, 1e-3))
            file.close()
            time.sleep(0.01)
        signal.signal(signal.SIGALRM, before)
        file.close()
        assert samples(path) == list(range(50))


@pytest.mark.parametrize("limit", [300_000, 800_000])
def test_a_full_disk_is_one_line_and_what_was_written_stays(tmp_path, limit):
    path = tmp_path / "run.mcap"
    body = """
        import resource
        resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[2]), resource.RLIM_INFINITY))
        rng = np.random.default_rng(0)
        try:
            for k in range(10**6):
                write(k)
                if int(sys.argv[2]) > 500_000:  # Here the file grows, else its journal.
                    file.add_attachment("noise", rng.bytes(5000), "application/octet-stream")
        except RecorderError as error:
            print(error, file=sys.stderr)
        try:
            file.close()
        except RecorderError as error:
            print(error, file=sys.stderr)
        """
    if limit < 500_000:
        body = body.replace("write(k)", "write(k // 1000)")  # No chunk is full.
    out, err = child(body, path, str(limit)).communicate()
    lines = err.decode().splitlines()
    assert lines[0] == (
        f"{path}: writing failed (File too large); free space there or record elsewhere; "
        f"what was written is kept, run python run.py recover {path}"
    )
    done = recover(path)
    recovered = path if done.path is None else done.path
    found = [sample for sample in McapStream(recovered) if sample.topic == "/two"]
    assert len(found) >= len(out) > 10


def test_a_disk_that_is_full_from_the_beginning(tmp_path):
    path = tmp_path / "run.mcap"
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, hard))
    try:
        with pytest.raises(RecorderError, match=r"run\.mcap: cannot be created \(File too large\); give a name in"):
            McapFile(path)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert list(tmp_path.iterdir()) == []


def test_a_journal_of_another_run_is_not_overwritten(tmp_path):
    path = tmp_path / "run.mcap"
    journal_of(path).write_text("precious")
    with pytest.raises(RecorderError, match=r"run\.mcap\.journal: already exists and is not overwritten"):
        McapFile(path)
    assert journal_of(path).read_text() == "precious" and not path.exists()
