"""What a study hands back is checked as it is made."""

import csv
import io

import numpy as np
import pytest

from drake_blfdmp.errors import BlfDmpError
from drake_blfdmp.evaluation.study import Claim, Study, Table
from drake_blfdmp.evaluation.study_file import csv_text
from drake_blfdmp.viewing.drawing import Drawing
from drake_blfdmp.viewing.study_figures.random_problems import first_times


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("a", "b", False), ["does not hold", "say why"]),
        (("a", "b", None, "  "), ["cannot be judged", "say why"]),
        (("a", "b", 1), ["holds is 1"]),
        (("a", "b", "yes", "so"), ["holds is 'yes'"]),
        (("", "b", True), ["what the paper says"]),
        (("a", " ", True), ["what was measured"]),
    ],
)
def test_an_incomplete_claim_is_refused(arguments, words):
    with pytest.raises(BlfDmpError) as caught:
        Claim(*arguments)
    assert all(word in str(caught.value) for word in words)


def test_a_claim_takes_numpys_truth():
    assert Claim("a", "b", np.float64(1) < 2).holds is True
    assert Claim("a", "b", np.float64(3) < 2, "too large").holds is False


@pytest.mark.parametrize(
    "columns",
    [{}, {"a": [1, 2], "b": [1]}, {"a": np.zeros((2, 2))}, {"a": 3.0}, {"a": "text"}, {"a": [[1], [1, 2]]}],
)
def test_columns_that_make_no_table_are_refused(columns):
    with pytest.raises(BlfDmpError, match="one-dimensional and of one length"):
        Table(columns)


def test_a_timed_column_must_be_there():
    assert Table({"a": [1], "seconds": [0.1]}, timed=["seconds"]).timed == ["seconds"]
    with pytest.raises(BlfDmpError, match="timed names 'secs', which is no column; columns: a, seconds"):
        Table({"a": [1], "seconds": [0.1]}, timed=["secs"])


def test_a_table_comes_back_from_csv_digit_for_digit():
    values = np.array([0.1, 1 / 3, -1e-300, np.nan, 6.02e23])
    names = ["plain", "comma, and", 'a "quote"', "two\nlines", "ü"]
    text = csv_text(Table({"name": names, "value_m": values, "count": np.arange(5)}))
    header, *rows = csv.reader(io.StringIO(text, newline=""))
    assert header == ["name", "value_m", "count"]
    assert [row[0] for row in rows] == names
    np.testing.assert_array_equal([float(row[1]) for row in rows], values)
    assert [int(row[2]) for row in rows] == [0, 1, 2, 3, 4]


PARTS = {
    "claims": [],
    "figures": {"f": Drawing(first_times, {})},
    "captions": {"f": "A figure."},
    "tables": {"t": Table({"a": [1]})},
}


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"captions": {}}, "figure 'f' has no caption"),
        ({"captions": {"f": " "}}, "figure 'f' has no caption"),
        ({"captions": {"f": "a", "g": "b"}}, "'g' belongs to no figure; figures: f"),
        ({"shown": ["u"]}, "'u', which is no table; tables: t"),
        ({"tables": {"../t": Table({"a": [1]})}}, "no file stem"),
        ({"tables": {"t": {"a": [1]}}}, "tables holds a dict; use Table"),
        ({"figures": {"f": None}}, "figures holds a NoneType; use Drawing"),
        ({"claims": ["it holds"]}, "claims holds a str; use Claim"),
        ({"notes": "one string, not several"}, "notes holds a str"),
    ],
)
def test_a_study_with_a_part_missing_is_refused(change, words):
    Study(**PARTS)
    with pytest.raises(BlfDmpError) as caught:
        Study(**(PARTS | change))
    assert words in str(caught.value)
