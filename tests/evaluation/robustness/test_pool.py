"""Worker processes: one that dies, hangs or raises costs its own job and no other."""

import os
import select
import subprocess
import sys

import pytest
from pool_jobs import behave

from drake_blfdmp.evaluation.robustness.pool import THREADS, run_in_processes


def ends(jobs, **options):
    options = {"workers": 1, "timeout_s": 60.0} | options
    return {end.job: end for end in run_in_processes(behave, jobs, **options)}


def test_every_job_ends_once_whatever_becomes_of_its_process():
    jobs = [("return", 1), ("raise", 2), ("die", 3), ("exit", 4), ("return", 5)]
    found = ends(jobs, workers=2)
    assert set(found) == set(jobs)
    assert [found[job].result for job in jobs] == [1, None, None, None, 5]
    assert [found[job].error for job in jobs] == [
        "",
        "ValueError: two lines",
        "the process died of SIGKILL",
        "the process died with exit status 3",
        "",
    ]


def test_a_job_that_hangs_is_killed_and_the_rest_goes_on():
    found = ends([("hang", 0), ("return", 1)], timeout_s=3.0)
    assert found["hang", 0].error == "no end after 3 s, killed"
    assert found["return", 1].result == 1


def test_processes_are_recycled():
    jobs = [("pid", i) for i in range(4)]
    pids = [end.result for end in ends(jobs, jobs_a_worker=2).values()]
    assert len(set(pids)) == 2 and os.getpid() not in pids


def test_nothing_to_do_starts_nothing():
    assert ends([]) == {}


def test_workers_end_with_the_iteration_and_threads_are_put_back(monkeypatch):
    monkeypatch.setenv(THREADS[0], "7")
    monkeypatch.delenv(THREADS[1], raising=False)
    running = run_in_processes(behave, [("pid", 0), ("pid", 1)], workers=1, timeout_s=60.0)
    pid = next(running).result
    assert os.environ[THREADS[0]] == os.environ[THREADS[1]] == "1"
    running.close()
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)
    assert os.environ[THREADS[0]] == "7" and THREADS[1] not in os.environ


SCRIPT = """
import sys
from pool_jobs import behave
from drake_blfdmp.evaluation.robustness.pool import run_in_processes

if __name__ == "__main__":
    for end in run_in_processes(behave, [("pid", 0), ("hang", 0)], workers=1, timeout_s=600.0):
        print(end.result, flush=True)
"""


def test_workers_end_with_a_parent_that_is_killed(tmp_path):
    script = tmp_path / "campaign.py"
    script.write_text(SCRIPT, encoding="utf-8")
    path = os.pathsep.join(part for part in sys.path if part)
    with subprocess.Popen(
        [sys.executable, str(script)], stdout=subprocess.PIPE, text=True, env=os.environ | {"PYTHONPATH": path}
    ) as parent:
        assert parent.stdout is not None
        parent.stdout.readline()
        parent.kill()
        # The worker has the same standard output; it ends with the last process that holds it.
        ready, _, _ = select.select([parent.stdout], [], [], 120.0)
        assert ready and parent.stdout.read() == ""
