"""`run.py` when somebody or the disk stops it: one line, a status that says so, and a recording that is complete."""

import errno
import io
import os
import runpy
import signal
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

from drake_blfdmp import interruption
from drake_blfdmp.commands import run as command
from drake_blfdmp.evaluation.console import ProgressBar
from drake_blfdmp.recording.read import read_mcap

ROOT = Path(__file__).resolve().parents[1]


@pytest.mark.parametrize(
    ("name", "status", "line"),
    [
        ("SIGTERM", 143, "run.py: terminated by SIGTERM"),
        ("SIGHUP", 129, "run.py: terminated by SIGHUP"),
        ("SIGINT", 130, "run.py: interrupted"),
    ],
)
def test_a_signal_ends_the_run_with_a_complete_recording(tmp_path, name, status, line):
    # The command line as it is, but a simulation that has no end.
    script = """
        import io, os, runpy, sys
        import recorded_run as run
        from drake_blfdmp.commands import run as command
        from drake_blfdmp.evaluation.console import ProgressBar
        from pydrake.systems.analysis import Simulator

        def endless(arguments, root, description):
            diagram, recorder = run.make_run(arguments[0])
            with recorder:
                simulator = Simulator(diagram)
                simulator.AdvanceTo(0.105)
                os.write(1, b"x")
                bar = ProgressBar(io.StringIO())
                for k in range(10**9):
                    simulator.AdvanceTo(0.2 + 0.1 * k)
                    bar("simulating", 0.0)

        command.main = endless
        runpy.run_path(sys.argv.pop(1), run_name="__main__")
    """
    path = tmp_path / "run.mcap"
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT / "tests" / "recording"), *sys.path])}
    arguments = [sys.executable, "-c", textwrap.dedent(script), str(ROOT / "run.py"), str(path)]
    process = subprocess.Popen(arguments, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        assert process.stdout.read(1) == "x"
        process.send_signal(getattr(signal, name))
        err = process.communicate(timeout=60)[1]
    finally:
        process.kill()
    assert (process.returncode, err.splitlines()) == (status, [line]), err
    recording = read_mcap(path)
    assert recording.damage == ""
    assert recording.series["/margin"].t[-1] > 0.095
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize(
    ("error", "line"),
    [
        (OSError(errno.ENOSPC, "No space left on device"), "run.py: No space left on device; free space there or"),
        (
            OSError(errno.ENOSPC, "No space left on device", "runs/a/b.png"),
            "run.py: runs/a/b.png: No space left",
        ),
    ],
)
def test_a_full_disk_is_one_line_wherever_it_is_met(command_line, monkeypatch, capsys, error, line):
    def fail(*arguments):
        raise error

    monkeypatch.setattr(command, "main", fail)
    assert command_line.main([]) == 2
    err = capsys.readouterr().err
    assert err.startswith(line) and err.count("\n") == 1


@pytest.fixture
def noted(monkeypatch):
    """The signals that came, which a test may add to."""
    monkeypatch.setattr(interruption, "_received", [])
    return interruption._received


@pytest.mark.parametrize(
    ("number", "line"), [(signal.SIGINT, "run.py: interrupted"), (signal.SIGTERM, "run.py: terminated by SIGTERM")]
)
def test_what_bindings_made_of_an_interruption_is_told_as_one(command_line, monkeypatch, capsys, noted, number, line):
    def fail(*arguments):
        noted.append(number)
        raise TypeError("__init__(): incompatible constructor arguments")

    monkeypatch.setattr(command, "main", fail)
    assert command_line.main([]) == 128 + number
    assert capsys.readouterr().err == line + "\n"


def test_an_error_without_an_interruption_is_none(command_line, monkeypatch, noted):
    monkeypatch.setattr(command, "main", lambda *arguments: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        command_line.main([])


def test_an_interruption_that_bindings_lost_comes_again_with_the_progress(noted):
    bar = ProgressBar(io.StringIO())
    bar("working", 0.1)
    noted.append(signal.SIGTERM)
    with pytest.raises(interruption.Terminated, match=str(int(signal.SIGTERM))):
        bar("working", 0.2)


def test_nohup_stays_nohup():
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    term, interrupt = signal.getsignal(signal.SIGTERM), signal.getsignal(signal.SIGINT)
    try:
        with pytest.MonkeyPatch.context() as patch, pytest.raises(SystemExit):
            patch.setattr(sys, "argv", ["run.py", "recover", "--help"])
            runpy.run_path(str(ROOT / "run.py"), run_name="__main__")
        assert signal.getsignal(signal.SIGHUP) == signal.SIG_IGN
        assert signal.getsignal(signal.SIGTERM) != signal.SIG_DFL
    finally:
        signal.signal(signal.SIGHUP, before)
        signal.signal(signal.SIGTERM, term)
        signal.signal(signal.SIGINT, interrupt)
