"""Jobs become rows of a file, whatever happens on the way, and what is there is not run again."""

import json

import pytest
from pool_jobs import FakeJob

from drake_blfdmp.errors import BlfDmpError
from drake_blfdmp.evaluation.robustness.campaign import append_row, read_rows, run_jobs

OPTIONS = {"workers": 1, "timeout_s": 60.0}


def ran(log):
    return log.read_text(encoding="utf-8").split() if log.exists() else []


def test_an_interrupted_campaign_goes_on_where_it_was(tmp_path):
    path, log = tmp_path / "rows.jsonl", tmp_path / "log"
    jobs = [FakeJob(key, what, log) for key, what in (("a", "return"), ("b", "die"), ("c", "return"))]

    class Interrupted(Exception):
        pass

    def interrupt(done, of):
        if done == 2:
            raise Interrupted

    with pytest.raises(Interrupted):
        run_jobs(jobs, path, progress=interrupt, **OPTIONS)
    assert set(read_rows(path)) == {"a", "b"} and ran(log) == ["a", "b"]
    with path.open("a", encoding="utf-8") as file:
        file.write('{"key": "c", "val')  # Cut short, as by a power cut.
    seen = []
    rows = run_jobs(jobs, path, progress=lambda done, of: seen.append((done, of)), **OPTIONS)
    assert ran(log) == ["a", "b", "c"] and seen == [(2, 3), (3, 3)]
    assert rows == [
        {"key": "a", "value": 1},
        {"key": "b", "error": "the process died of SIGKILL"},
        {"key": "c", "value": 1},
    ]
    assert [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()] == rows
    assert run_jobs(list(reversed(jobs)), path, **OPTIONS) == list(reversed(rows)) and ran(log) == ["a", "b", "c"]


def test_rows_of_other_jobs_stay_in_the_file_and_out_of_the_result(tmp_path):
    path = tmp_path / "rows.jsonl"
    append_row(path, {"key": "other"})
    append_row(path, {"key": "a", "value": 7})
    assert run_jobs([FakeJob("a", "return", tmp_path / "log")], path, **OPTIONS) == [{"key": "a", "value": 7}]
    assert set(read_rows(path)) == {"other", "a"}


def test_a_file_of_something_else_is_refused_in_one_line(tmp_path):
    path = tmp_path / "rows.jsonl"
    for text in ("hello\nworld\n", "[1]\n{}\n"):
        path.write_text(text, encoding="utf-8")
        with pytest.raises(BlfDmpError, match=r"line 1 is no row") as caught:
            read_rows(path)
        assert "\n" not in str(caught.value)
    path.write_bytes(b"\xff\xfe")
    with pytest.raises(BlfDmpError, match="cannot be read"):
        read_rows(path)
    with pytest.raises(BlfDmpError, match="cannot be written"):
        append_row(tmp_path / "nowhere" / "rows.jsonl", {"key": "a"})
