"""Many trials, in processes, into a file of rows: what is there already is not run again, and nothing is lost."""

import json
from collections.abc import Callable, Sequence
from pathlib import Path

from drake_blfdmp.errors import BlfDmpError
from drake_blfdmp.evaluation.robustness.pool import run_in_processes
from drake_blfdmp.evaluation.robustness.trial import Trial, crash_row, run_trial

LONGEST_ROW = 100_000
"""Bytes; a row has some two thousand."""


def run_trials(
    trials: Sequence[Trial],
    path: Path,
    *,
    workers: int,
    timeout_s: float,
    progress: Callable[[int, int], None] = lambda done, of: None,
    function: Callable[[Trial], dict] = run_trial,
) -> list[dict]:
    """The rows of trials, in their order; each is appended to the file, a JSON object a line, as soon as it is there.

    Args:
        path: of the file; rows in it that belong to these very trials are taken from it, others are left alone.
        workers: processes.
        timeout_s: a trial that takes longer is killed and is a crash, s.
        progress: called with how many rows there are, and of how many.
        function: what makes a row of a trial.

    Raises:
        BlfDmpError: the file cannot be read or written.
    """
    keys = [trial.key for trial in trials]
    rows = {key: row for key, row in read_rows(path).items() if key in set(keys)}
    missing = [trial for trial, key in zip(trials, keys, strict=True) if key not in rows]
    progress(len(rows), len(trials))
    for end in run_in_processes(function, missing, workers=workers, timeout_s=timeout_s):
        row = crash_row(end.job, end.error) if end.error else end.result
        rows[row["key"]] = row
        append_row(path, row)
        progress(len(rows), len(trials))
    return [rows[key] for key in keys]


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
        raise BlfDmpError(f"{path}: cannot be read as rows of trials ({error.__class__.__name__})") from error
    rows = {}
    for number, line in enumerate(lines, start=1):
        try:
            row = json.loads(line)
            rows[row["key"]] = row
        except (json.JSONDecodeError, TypeError, KeyError) as error:
            if number == len(lines):
                break
            raise BlfDmpError(f"{path}: line {number} is no row of a trial; name another file") from error
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
