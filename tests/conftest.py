"""What is planned and simulated once and shared by every test that only looks at it."""

import io
import signal
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, settings

# No test is about time, and a busy machine is slow.
settings.register_profile("untimed", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("untimed")

# Jobs in the background may be deaf to these, and so are their children, of which some tests interrupt one.
for number, usual in ((signal.SIGINT, signal.default_int_handler), (signal.SIGHUP, signal.SIG_DFL)):
    if signal.getsignal(number) == signal.SIG_IGN:
        signal.signal(number, usual)

ROOT = Path(__file__).resolve().parents[1]
RECORDINGS = ROOT.parent / "shared" / "recordings"


@dataclass(frozen=True)
class FinishedRun:
    """A run of the command line: exit status, folder, and what it printed."""

    status: int
    folder: Path
    stdout: str
    stderr: str


@pytest.fixture(scope="session")
def command_line():
    """The module `run`, wherever pytest was started."""
    import importlib.util

    spec = importlib.util.spec_from_file_location("run", ROOT / "run.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="session")
def default_scenario(command_line):
    """The scenario that `python run.py` carries out; copy before changing."""
    from drake_blfdmp.planning.scenario import LoadScenario

    return LoadScenario(ROOT / "studies" / "hold_and_place.yaml")


@pytest.fixture(scope="session")
def default_plan(default_scenario):
    """The plan of the default run."""
    from drake_blfdmp.planning.plan import MakePlan

    return MakePlan(default_scenario)


@pytest.fixture(scope="session")
def default_run(command_line, tmp_path_factory):
    """The default run, simulated."""
    folder = tmp_path_factory.mktemp("default") / "run"
    out, err = io.StringIO(), io.StringIO()
    with redirect_stdout(out), redirect_stderr(err):
        status = command_line.main(["--out", str(folder)])
    return FinishedRun(status, folder, out.getvalue(), err.getvalue())


@pytest.fixture(scope="session")
def recordings():
    """The folder of real recordings, which the project may read but not contain."""
    if not RECORDINGS.is_dir():
        pytest.skip(f"the real recordings are not at {RECORDINGS}")
    return RECORDINGS


@pytest.fixture(scope="session")
def person():
    """(t, x) of the modelled person, exact, at 30 Hz."""
    from drake_blfdmp.demonstration.modelled_person import ModelledPerson, hold_and_place

    t, x = hold_and_place(ModelledPerson())
    return np.asarray(t), np.asarray(x)
