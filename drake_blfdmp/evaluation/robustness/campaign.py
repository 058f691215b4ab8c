"""Many jobs, in processes, into a file of rows: what is there already is not run again, and nothing is lost."""

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Protocol

from drake_blfdmp.errors import BlfDmpError
from drake_blfdmp.evaluation.robustness.pool import run_in_processes

LONGEST_ROW = 100_000
"""Bytes; a row has some two thousand."""


class Job(Protocol):
    """What is run in a process of its own and leaves a row, which has the job's key."""

    @property
    def key(self) -> str:
        """What its row is known by."""
        ...

    def run(self) -> dict:
        """The row, in plain numbers and text, for JSON."""
        ...

    def crashed(self, error: str) -> dict:
        """The row where `run` came to no end."""
        ...


def run_jobs(
    jobs: Sequence[Job],
    path: Path,
    *,
    workers: int,
    timeout_s: float,
    progress: Callable[[int, int], None] = lambda done, of: None,
) -> list[dict]:
    """The rows of jobs, in their order; each is appended to the file, a JSON object a line, as soon as it is there.

    Args:
        path: of the file; rows in it that belong to these very jobs are taken from it, others are left alone.
        workers: processes.
        timeout_s: a job that takes longer is killed and has crashed, s.
        progress: called with how many rows there are, and of how many.

    Raises:
        BlfDmpError: the file cannot be read or written.
    """
    keys = [job.key for job in jobs]
    there = read_rows(path)
    rows = {key: there[key] for key in keys if key in there}
    missing = [job for job, key in zip(jobs, keys, strict=True) if key not in rows]
    progress(len(rows), len(jobs))
    for end in run_in_processes(_run, missing, workers=workers, timeout_s=timeout_s):
        row = end.job.crashed(end.error) if end.error else end.result
        rows[row["key"]] = row
        append_row(path, row)
        progress(len(rows), len(jobs))
    return [rows[key] for key in keys]


def _run(job: Job) -> dict:
    return job.run()


def read_rows(path: Path) -> dict[str, dict]:
    """The rows of a file by key, the last of each; a line that an interruption cut short is passed over.

    Raises:
        BlfDmpError: the file is there and cannot be read, or holds something else.
    """
    if not path.exists():
        return {}
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise BlfDmpError(f"{path}: cannot be read as rows of results ({error.__class__.__name__})") from error
    rows = {}
    for number, line in enumerate(lines, start=1):
        try:
            row = json.loads(line)
            rows[row["key"]] = row
        except (json.JSONDecodeError, TypeError, KeyError) as error:
            if number == len(lines):
                break
            raise BlfDmpError(f"{path}: line {number} is no row of results; name another file") from error
    return rows


def append_row(path: Path, row: dict) -> None:
    """Add a row to the file, in place of a last line that an interruption cut short.

    Raises:
        BlfDmpError: the file cannot be written.
    """
    try:
        with path.open("a+b") as file:
            file.seek(max(0, file.tell() - LONGEST_ROW))
            cut = len(file.read().rpartition(b"\n")[2])
            if cut:
                file.truncate(path.stat().st_size - cut)
            file.write(json.dumps(row).encode() + b"\n")
    except OSError as error:
        raise BlfDmpError(f"{path}: cannot be written ({error.strerror})") from error
