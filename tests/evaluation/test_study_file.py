"""What a study's file holds: figures, tables, claims, and time series that plot; the same bytes from the same study."""

import csv
import hashlib
import io
import json

import numpy as np
import pytest
from mcap.reader import make_reader

from drake_blfdmp.evaluation.study import Claim, Study, Table
from drake_blfdmp.evaluation.study_file import write_study
from drake_blfdmp.planning.scenario import DumpScenario, Scenario
from drake_blfdmp.recording.mcap_file import RecorderError
from drake_blfdmp.recording.read import read_mcap
from drake_blfdmp.viewing.drawing import Drawing
from drake_blfdmp.viewing.study_figures.random_problems import first_times

T = np.array([0.0, 0.25, 0.5])


def make_study(seconds=0.1):
    """`seconds` stands for what a clock said."""
    return Study(
        claims=[
            Claim("it holds", "1 mm", True),
            Claim("it is quick", f"{seconds:g} s", seconds < 1.0, "" if seconds < 1.0 else "it is not", timed=True),
        ],
        figures={"first": Drawing(first_times, {"none": T[1:]})},
        captions={"first": "How soon."},
        tables={
            "series": Table({"time_s": T, "a_m": [1.0, np.nan, 3.0], "name": ["x", "y", "z"], "count": [1, 2, 3]}),
            "other-series": Table({"time_s": T + 0.125, "b_m": -T}),
            "backwards": Table({"time_s": T[::-1], "a_m": T}),
            "rows": Table({"law": ["ü", "b"], "seconds": [seconds, 2 * seconds]}, timed=["seconds"]),
            "cost": Table({"seconds": [seconds]}, timed=["seconds"]),
        },
        notes=["A note."],
        shown=["rows"],
    )


@pytest.fixture
def path(tmp_path):
    write_study(tmp_path / "study.mcap", make_study(), Scenario(seed=7), {"name": "mine", "quick": True})
    return tmp_path / "study.mcap"


def test_what_was_studied_and_with_what_is_said(path):
    found = read_mcap(path)
    about, text = found.metadata["study"], found.attachments["scenario.yaml"]
    assert text.decode() == DumpScenario(Scenario(seed=7))
    assert about["scenario_sha256"] == hashlib.sha256(text).hexdigest()
    expected = {"name": "mine", "quick": "True", "seed": "7", "synthetic": "True", "law": "default", "recording": ""}
    assert {name: about[name] for name in expected} == expected
    assert {"version_drake_blfdmp", "version_drake", "version_mcap"} <= set(about)
    with path.open("rb") as stream:
        assert make_reader(stream).get_header().profile == "ros2"


def test_times_that_were_taken_stay_out(path, tmp_path):
    write_study(tmp_path / "again.mcap", make_study(12.0), Scenario(seed=7), {"name": "mine", "quick": True})
    assert path.read_bytes() == (tmp_path / "again.mcap").read_bytes()
    found = read_mcap(path).attachments
    assert found["tables/rows.csv"].decode() == "law\nü\nb\n"
    assert "tables/cost.csv" not in found
    document = json.loads(found["study.json"])
    assert document["claims"] == [
        {"paper": "it holds", "measured": "1 mm", "holds": True, "why": "", "timed": False},
        {"paper": "it is quick", "timed": True},
    ]
    assert document["timed"] == {"rows": ["seconds"], "cost": ["seconds"]}
    assert (document["captions"], document["notes"], document["shown"]) == (
        {"first": "How soon."},
        ["A note."],
        ["rows"],
    )


def test_tables_over_time_are_topics_in_the_order_of_time(path):
    found = read_mcap(path)
    assert set(found.series) == {"/series", "/other_series"}
    series = found.series["/series"]
    np.testing.assert_array_equal(series.t, T)
    assert series.names == ("a_m", "count")
    np.testing.assert_array_equal(series.values, [[1.0, 1], [np.nan, 2], [3.0, 3]])
    with path.open("rb") as stream:
        times = [message.log_time for _, _, message in make_reader(stream).iter_messages(log_time_order=False)]
    assert times == sorted(times) and len(times) == 6
    rows = list(csv.reader(io.StringIO(found.attachments["tables/series.csv"].decode())))
    assert rows == [["time_s", "a_m", "name", "count"], ["0.0", "1.0", "x", "1"], ["0.25", "nan", "y", "2"],
                    ["0.5", "3.0", "z", "3"]]  # fmt: skip


def test_a_file_that_is_there_is_not_overwritten(path):
    before = path.read_bytes()
    with pytest.raises(RecorderError, match="already exists"):
        write_study(path, make_study(), Scenario(), {})
    assert path.read_bytes() == before
