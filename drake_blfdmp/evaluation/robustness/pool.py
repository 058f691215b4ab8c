"""Worker processes that are recycled, and killed where they hang: a job that takes its process down costs no other.

`concurrent.futures` cannot do that: there a worker that dies breaks the whole pool, and none can be killed alone.
"""

import os
import signal
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing import get_context, parent_process
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from typing import Any

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")

JOBS_A_WORKER = 25
"""A worker is replaced after so many: Drake 1.51 never frees a system written in Python, about 1 MB a scene."""

START_S = 120.0
"""How long a process may take to start and to load its libraries, s, before its first job's own time begins."""


@dataclass(frozen=True)
class Finished:
    """A job's end: `result`, or `error` in one line where its process raised, died or was killed."""

    job: Any
    result: Any
    error: str
    seconds: float


class _Worker:
    """One process, its pipe, and what it is at."""

    def __init__(self, function: Callable[[Any], Any]):
        # Spawned, not forked: Drake and NumPy have threads.
        context = get_context("spawn")
        self.pipe, theirs = context.Pipe()
        self.process: BaseProcess = context.Process(target=_serve, args=(function, theirs), daemon=True)
        self.process.start()
        theirs.close()
        self.job: Any = None
        self.busy = False
        self.ready = False
        self.started = 0.0
        self.done = 0

    def give(self, job: Any) -> None:
        self.job, self.busy, self.started = job, True, time.monotonic()
        self.pipe.send(job)

    def stop(self) -> None:
        self.process.kill()
        self.process.join()
        self.pipe.close()


def run_in_processes(
    function: Callable[[Any], Any],
    jobs: Sequence[Any],
    *,
    workers: int,
    timeout_s: float,
    jobs_a_worker: int = JOBS_A_WORKER,
) -> Iterator[Finished]:
    """Run `function(job)` for every job in processes of one thread each; yields each job's end as it comes.

    Ending the iteration early, by an interruption too, kills the workers.

    Args:
        function: importable by name, as `multiprocessing` wants it.
        workers: how many processes at once.
        timeout_s: a job that takes longer is killed with its process, s; the process's start does not count.
        jobs_a_worker: after so many a process makes way for a new one.
    """
    waiting = list(reversed(jobs))
    running: list[_Worker] = []
    with one_thread_each():
        try:
            while waiting or any(worker.busy for worker in running):
                for worker in running:
                    if waiting and not worker.busy:
                        worker.give(waiting.pop())
                while waiting and len(running) < workers:
                    running.append(_Worker(function))
                    running[-1].give(waiting.pop())
                for worker, finished, alive in _next_ends(running, timeout_s):
                    if not alive or worker.done >= jobs_a_worker or not waiting:
                        running.remove(worker)
                        worker.stop()
                    yield finished
        finally:
            for worker in running:
                worker.stop()


def _next_ends(running: Sequence[_Worker], timeout_s: float) -> Iterator[tuple[_Worker, Finished, bool]]:
    """Those busy workers that answer, die or are out of time within a second, their jobs' ends, and whether they live.

    May be none.
    """
    busy = [worker for worker in running if worker.busy]
    answered = set(wait([worker.pipe for worker in busy], timeout=min(1.0, timeout_s)))
    for worker in busy:
        seconds = time.monotonic() - worker.started
        result, error, alive = None, "", True
        if worker.pipe in answered:
            try:
                answer = worker.pipe.recv()
            except (EOFError, ConnectionResetError):
                worker.process.join()
                error, alive = f"the process died {_how(worker.process)}", False
            else:
                if answer is None:  # It has started.
                    worker.ready, worker.started = True, time.monotonic()
                    continue
                result, error = answer
        elif seconds > timeout_s + (0.0 if worker.ready else START_S):
            error, alive = f"no end after {timeout_s:g} s, killed", False
        else:
            continue
        worker.busy, worker.done = False, worker.done + 1
        yield worker, Finished(worker.job, result, error, seconds), alive


def _how(process: BaseProcess) -> str:
    code = process.exitcode
    if code is not None and code < 0:
        return f"of {signal.Signals(-code).name}"
    return f"with exit status {code}"


def _serve(function: Callable[[Any], Any], pipe: Connection) -> None:
    """A worker's life: take a job, answer, until the pipe is closed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches the workers too; the parent kills them.
    threading.Thread(target=_end_with_parent, daemon=True).start()
    pipe.send(None)
    while True:
        try:
            job = pipe.recv()
        except EOFError:
            return
        try:
            answer = function(job), ""
        except Exception as error:
            answer = None, f"{type(error).__name__}: {' '.join(str(error).split())}".rstrip(": ")
        try:
            pipe.send(answer)
        except (BrokenPipeError, ConnectionResetError):
            return  # The parent is gone.


def _end_with_parent() -> None:
    """A parent that is killed cannot kill its workers: they do it themselves, in the middle of a job."""
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


@contextmanager
def one_thread_each() -> Iterator[None]:
    """Processes started meanwhile leave the cores to each other: their linear algebra has one thread."""
    before = {name: os.environ.get(name) for name in THREADS}
    os.environ.update(dict.fromkeys(THREADS, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value
