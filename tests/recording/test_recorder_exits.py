"""What a recorder leaves behind: closed, killed, forgotten, interrupted."""

import os
import subprocess
import sys
import textwrap
from pathlib import Path

import numpy as np
import pytest
import recorded_run as run
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource

from drake_blfdmp.recording import sampler
from drake_blfdmp.recording.mcap_file import RecorderError
from drake_blfdmp.recording.read import read_mcap
from drake_blfdmp.recording.recover import recover
from drake_blfdmp.recording.stream import McapStream
from drake_blfdmp.recording.topic_recorder import TopicRecorder
from drake_blfdmp.ros2.messages import STRING, string_message


@pytest.fixture
def path(tmp_path):
    return tmp_path / "run.mcap"


def test_an_exception_in_the_run_leaves_a_complete_file(path):
    diagram, recorder = run.make_run(path, fail_at=0.305)
    with pytest.raises(ZeroDivisionError, match="controller broke"), recorder:
        Simulator(diagram).AdvanceTo(1.0)
    recording = read_mcap(path)
    assert recording.damage == ""
    assert recording.series["/margin"].t[-1] == pytest.approx(0.30)


def test_close_again_and_what_comes_after(path):
    diagram, recorder = run.make_run(path)
    simulator = Simulator(diagram)
    simulator.AdvanceTo(0.1)
    recorder.Close()
    size = path.stat().st_size
    recorder.Close()
    simulator.AdvanceTo(0.2)
    recorder.Event("late", 0.2)
    assert path.stat().st_size == size
    with pytest.raises(RecorderError, match=r"after Close\(\)"):
        recorder.AddAttachment("late", b"")
    assert read_mcap(path).series["/margin"].t[-1] < 0.105


def run_script(script, *arguments):
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(Path(__file__).parent), *sys.path])}
    command = [sys.executable, "-c", textwrap.dedent(script), *map(str, arguments)]
    return subprocess.run(command, env=environment, check=False, capture_output=True, text=True)


@pytest.mark.parametrize("pace_s", [0.02, 0.15])
def test_a_killed_process_loses_half_a_second_of_wall_time_at_most(path, pace_s):
    """It says after every sample how long it has run; what it had half a second before its end must be there."""
    script = """
        import os, sys, time
        import recorded_run as run
        from pydrake.systems.analysis import Simulator
        diagram, recorder = run.make_run(sys.argv[1])
        simulator, started = Simulator(diagram), time.monotonic()
        while True:
            simulator.AdvanceTo(simulator.get_context().get_time() + 0.01)
            time.sleep(float(sys.argv[2]))
            print(simulator.get_context().get_time(), time.monotonic() - started, flush=True)
            if time.monotonic() - started > 1.3:
                os.kill(os.getpid(), 9)
    """
    ended = run_script(script, path, pace_s)
    assert ended.returncode == -9
    t, wall = np.array([line.split() for line in ended.stdout.splitlines()], dtype=float).T
    with pytest.raises(RecorderError, match=r"truncated at byte .*; run python run\.py recover .*run\.mcap"):
        read_mcap(path)
    recording = read_mcap(recover(path).path)
    assert recording.damage == ""
    assert recording.robot_description == run.URDF
    assert recording.metadata["run"]["seed"] == "7"
    safe = t[wall < wall[-1] - 0.5]
    assert len(safe) > 3
    assert recording.series["/margin"].t[-1] >= safe[-1] - 1e-9


@pytest.mark.parametrize("call", ["Flush()", "Event('here', 0.9)", "AddAttachment('notes', 'here')"])
def test_a_killed_process_loses_nothing_that_was_flushed(path, call):
    script = f"""
        import os, sys
        import recorded_run as run
        from pydrake.systems.analysis import Simulator
        diagram, recorder = run.make_run(sys.argv[1])
        Simulator(diagram).AdvanceTo(0.905)
        recorder.{call}
        os.kill(os.getpid(), 9)
    """
    assert run_script(script, path).returncode == -9
    assert read_mcap(recover(path).path).series["/margin"].t[-1] == pytest.approx(0.9)


@pytest.mark.parametrize("longest", [0.0, 1e9])
def test_the_bytes_do_not_depend_on_when_samples_are_written(tmp_path, monkeypatch, longest):
    run.record(tmp_path / "one")
    monkeypatch.setattr(sampler, "LONGEST_S", longest)
    monkeypatch.setattr(sampler, "SLOWEST_S", longest)
    run.record(tmp_path / "two")
    assert (tmp_path / "one").read_bytes() == (tmp_path / "two").read_bytes()


def test_a_recorder_nobody_closes_is_complete_at_exit(path):
    script = """
        import sys
        import recorded_run as run
        from pydrake.systems.analysis import Simulator
        diagram, recorder = run.make_run(sys.argv[1])
        Simulator(diagram).AdvanceTo(0.905)
        raise SystemExit(3)
    """
    assert run_script(script, path).returncode == 3
    assert read_mcap(path).series["/margin"].t[-1] == pytest.approx(0.9)
    assert list(path.parent.iterdir()) == [path]


@pytest.mark.parametrize("error", [KeyboardInterrupt, ZeroDivisionError])
def test_a_close_that_an_encoder_or_an_interruption_breaks_off(path, error):
    """An interruption costs the sample in hand alone; after an error the file is complete up to it."""
    broken = [error()]

    def encode(t_ns, value):
        if t_ns == 30_000_000 and broken:
            raise broken.pop()
        return string_message("here")

    builder = DiagramBuilder()
    recorder = builder.AddSystem(TopicRecorder(filename=path))
    source = builder.AddSystem(ConstantVectorSource([1.0]))
    builder.Connect(source.get_output_port(), recorder.AddMessageInput("text", 1, STRING, encode))
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(0.105)
    with pytest.raises(error):
        recorder.Close()
    recorder.Close()
    times = [sample.t for sample in McapStream(path) if sample.topic == "/text"]
    kept = {KeyboardInterrupt: [*range(3), *range(4, 11)], ZeroDivisionError: range(3)}[error]
    np.testing.assert_allclose(times, 0.01 * np.array(kept), atol=1e-9)
