"""Takes of the virtual Kinect and their tables, on errors made by hand."""

import numpy as np
import pytest

from drake_blfdmp.demonstration.modelled_person import ModelledPerson, held_interval
from drake_blfdmp.evaluation.studies.noise_metrics import Spread, SurveyedFile
from drake_blfdmp.evaluation.studies.noise_takes import error_table, film, recording_table, spreads_of, statistics


def take(count, size):
    """Errors of `size` along x for shoulders, twice that for elbows, three times for hands."""
    t = np.arange(count) / 30.0
    return t, np.tile(size * np.array([1.0, 2.0, 3.0, 1.0, 2.0, 3.0])[:, None] * [1.0, 0.0, 0.0], (count, 1, 1))


def test_takes_of_different_lengths_count_by_their_samples():
    found = statistics([take(30, 0.01), take(90, 0.02)])
    assert found["shoulders"].rms_m == pytest.approx(np.sqrt((30 * 0.01**2 + 90 * 0.02**2) / 120))
    assert found["hands"].largest_m == pytest.approx(0.06)


def test_only_the_kept_times_count():
    t, errors = take(60, 0.01)
    errors[t >= 1.0] *= 5.0
    assert statistics([(t, errors)], lambda t: t < 1.0)["elbows"].largest_m == pytest.approx(0.02)


def test_errors_while_held_and_while_free_are_told_apart():
    t, errors = take(300, 0.01)
    start, end = held_interval()
    errors[(t >= start) & (t <= end)] *= 2.0
    table = error_table([(t, errors)]).columns
    assert list(table["points"]) == ["shoulders", "elbows", "hands"]
    np.testing.assert_allclose(table["rms_held_m"], [0.02, 0.04, 0.06])
    np.testing.assert_allclose(table["rms_free_m"], [0.01, 0.02, 0.03])
    np.testing.assert_allclose(table["rms_x_m"], table["rms_m"])
    np.testing.assert_array_equal(table["rms_z_m"], 0.0)


def test_filming_gives_a_take_and_a_survey_a_seed():
    told = []
    takes, surveyed = film(ModelledPerson(), range(3, 5), lambda what, share: told.append((what, share)))
    assert [one.name for one in surveyed] == ["virtual Kinect, seed 3", "virtual Kinect, seed 4"]
    assert told == [("filming, seed 3", 0.0), ("filming, seed 4", 0.5)]
    assert all(errors.shape == (len(t), 6, 3) and 0.001 < np.abs(errors).mean() < 0.05 for t, errors in takes)
    assert not np.array_equal(takes[0][1][:50], takes[1][1][:50])


def test_a_length_that_is_not_known_is_nan_in_the_table():
    files = [
        SurveyedFile("one", samples=9, spreads={"forearm": Spread(9, 0.28, 0.01, 0.26, 0.30)}),
        SurveyedFile("other", samples=4, spreads={}),
    ]
    np.testing.assert_array_equal(spreads_of(files, "forearm"), [[0.28, 0.01, 0.26, 0.30], [np.nan] * 4])
    table = recording_table(files, ["forearm"]).columns
    assert list(table["frames"]) == [9, 4]
    np.testing.assert_array_equal(table["forearm_std_m"], [0.01, np.nan])
