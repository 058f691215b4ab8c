"""Every format, every accident: a recording or one line that names the file; never a crash, a hang or a full memory."""

import json
import os
import subprocess
import sys
from pathlib import Path

import file_samples
import numpy as np
import pytest
import ros_samples
import text_samples
from corruptions import CORRUPTIONS
from synthetic_carry import carry

from drake_blfdmp.demonstration.cleaning import clean
from drake_blfdmp.demonstration.formats import FORMATS, read_recording
from drake_blfdmp.errors import RecordingError

SAMPLES = {**text_samples.SAMPLES, **file_samples.SAMPLES, **ros_samples.SAMPLES}
T, X = carry(duration=1.5)
LONGEST_S, MOST_BYTES = 5.0, 1_000_000_000
INDEXED = ("rosbag2", "mcap")  # Read by their index: what stands behind the data is never looked at.

# In a process of its own: a hang, a crash or a full memory there is a failed test here, not the end of the tests.
READER = """
import json, resource, signal, sys, warnings
from drake_blfdmp.demonstration.cleaning import clean
from drake_blfdmp.demonstration.formats import read_recording
from drake_blfdmp.errors import RecordingError
warnings.simplefilter("error")
def hang(number, frame): raise TimeoutError("hangs")
signal.signal(signal.SIGALRM, hang)
for line in sys.stdin:
    path, format = json.loads(line)
    signal.setitimer(signal.ITIMER_REAL, float(sys.argv[1]))
    try:
        recording = read_recording(path, format=format)
        outcome = ["read", len(recording.t)]
        clean(recording)
    except RecordingError as error:
        outcome = ["refused", str(error)]
    except BaseException as error:
        outcome = ["crashed", type(error).__name__ + ": " + str(error)[:300]]
    signal.setitimer(signal.ITIMER_REAL, 0.0)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024)
    print(json.dumps([*outcome, peak]), flush=True)
"""


def read_apart(files):
    """What reading and cleaning each of (path, format or None) comes to: [(kind, text or count, peak bytes)]."""
    asked = "".join(json.dumps([str(path), format]) + "\n" for path, format in files)
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(map(str, [Path(__file__).parents[3], *sys.path[1:]]))}
    done = subprocess.run(
        [sys.executable, "-c", READER, str(LONGEST_S)],
        input=asked,
        capture_output=True,
        text=True,
        env=environment,
        timeout=600,
    )
    outcomes = [json.loads(line) for line in done.stdout.splitlines()]
    assert len(outcomes) == len(files), f"died on {files[len(outcomes)]}: {done.stderr[-500:]}"
    return outcomes


def judge(path, kind, what, peak):
    assert kind != "crashed", what
    assert peak < MOST_BYTES
    if kind == "refused":
        assert str(path) in what and "\n" not in what and len(what) < 2000, what


def content_of(path):
    """The file, or of a bag's directory its largest file."""
    return path if path.is_file() else max((f for f in path.iterdir() if f.is_file()), key=lambda f: f.stat().st_size)


def test_every_format_has_a_sample_that_is_recognised(tmp_path):
    assert set(SAMPLES) == set(FORMATS)
    for name, write in SAMPLES.items():
        recording = read_recording(write(tmp_path / name, T, X))
        assert recording.format == name
        np.testing.assert_allclose(recording.x, X, atol=1e-5)


@pytest.mark.parametrize("name", SAMPLES)
def test_accidents(tmp_path, name):
    files = []
    for k, corrupt in enumerate(CORRUPTIONS.values()):
        path = SAMPLES[name](tmp_path / f"{k}{'' if name != 'mcap' else '.mcap'}", T, X)
        content = content_of(path)
        content.write_bytes(corrupt(content.read_bytes()))
        files += [(path, None), (path, name)]  # As found, and as the user insists.
    for (path, _), outcome in zip(files, read_apart(files), strict=True):
        judge(path, *outcome)


def test_there_are_hundreds_of_them_and_they_do_harm(tmp_path):
    assert len(CORRUPTIONS) * len(SAMPLES) >= 200
    path = SAMPLES["wide_csv"](tmp_path / "a", T, X)
    good = path.read_bytes()
    for name, corrupt in CORRUPTIONS.items():
        assert corrupt(good) != good, name


def test_places_instead_of_files(tmp_path):
    loop, dangling, folder = tmp_path / "loop", tmp_path / "dangling", tmp_path / "folder"
    loop.symlink_to(loop)
    dangling.symlink_to(tmp_path / "nowhere")
    folder.mkdir()
    (folder / "metadata.yaml").mkdir()
    unreadable = tmp_path / ("x" * 300)
    files = [(place, None) for place in (loop, dangling, folder, tmp_path, unreadable, Path("/dev/null"))]
    for (place, _), (kind, what, peak) in zip(files, read_apart(files), strict=True):
        assert kind == "refused", (place, what)
        judge(place, kind, what, peak)


@pytest.mark.parametrize("name", SAMPLES)
def test_a_line_of_a_gigabyte_is_refused_by_size(tmp_path, name):
    path = SAMPLES[name](tmp_path / f"a{'' if name != 'mcap' else '.mcap'}", T, X)
    content = content_of(path)
    with content.open("r+b") as file:
        file.seek(0, os.SEEK_END)
        file.truncate(file.tell() + (1 << 30) + 1)  # Sparse: costs no room on the disk.
    for outcome in read_apart([(path, None), (path, name)]):
        judge(path, *outcome)
        assert outcome[0] == "refused" or name in INDEXED


def test_times_that_run_nowhere(tmp_path):
    for k, t in enumerate((T[::-1], 0 * T, -T, T * 1e300, np.where(T > 1, np.nan, T))):
        path = text_samples.write_wide_csv(tmp_path / str(k), t, X)
        with pytest.raises(RecordingError) as refused:
            clean(read_recording(path))
        assert str(path) in str(refused.value)
