"""The studies of Figs. 2 and 6 to 9, quick, as a person's command would run them: their tables are the oracle."""

import runpy
from pathlib import Path

import numpy as np
import pytest

from drake_blfdmp.evaluation.study import StudyContext
from drake_blfdmp.planning.scenario import LoadScenario
from drake_blfdmp.skeleton import POINTS

STUDIES = Path(__file__).resolve().parents[2] / "studies"


def script(name):
    """The names that a study's script defines."""
    return runpy.run_path(str(STUDIES / f"{name}.py"))


def run(name, *settings, recordings=None):
    """The study and what it said of its progress."""
    told = []
    scenario = LoadScenario(STUDIES / f"{name}.yaml", settings)
    context = StudyContext(scenario, True, lambda what, share: told.append(share), recordings)
    study = script(name)["study"](context)
    assert scenario.name == name
    assert told == sorted(told) and told[0] >= 0.0 and told[-1] <= 1.0
    return study


def rows(study, table):
    """A table's rows as dicts, by the first column."""
    columns = study.tables[table].columns
    names = list(columns)
    return {row[0]: dict(zip(names, row, strict=True)) for row in zip(*columns.values(), strict=True)}


def claim(study, words):
    found = [one for one in study.claims if words in one.paper]
    assert len(found) == 1
    return found[0]


@pytest.fixture(scope="module")
def noise():
    return run("measurement_noise")


@pytest.fixture(scope="module")
def trajectories():
    return run("trajectories")


@pytest.fixture(scope="module")
def errors():
    return run("tracking_errors")


@pytest.fixture(scope="module")
def distances():
    return run("joint_distances")


@pytest.mark.parametrize("name", ["noise", "trajectories", "errors", "distances"])
def test_figures_are_drawn_from_their_file_and_say_what_they_are(name, request, redrawn):
    study = request.getfixturevalue(name)
    figures = redrawn(study)
    assert figures and set(figures) == set(study.captions)
    for figure in figures.values():
        assert all(axis.has_data() for axis in figure.axes)
        assert figure.legends and figure.axes[-1].get_title() + figure.axes[-1].get_xlabel()
        units = [axis.get_xlabel() + axis.get_ylabel() for axis in figure.axes]
        assert any("m)" in text for text in units)


def test_the_first_lines_name_the_papers_figures():
    for name, figure in (
        ("measurement_noise", "Fig. 2"),
        ("trajectories", "Fig. 6"),
        ("tracking_errors", "Fig. 7"),
        ("joint_distances", "Figs. 8 and 9"),
    ):
        assert script(name)["__doc__"].startswith(f"{figure}: ")


# Fig. 2


def test_the_sensors_errors_grow_from_shoulder_to_hand(noise):
    table = rows(noise, "errors")
    rms = [table[kind]["rms_m"] for kind in ("shoulders", "elbows", "hands")]
    assert 0.005 < rms[0] < rms[1] < rms[2] < 0.15
    for entry in table.values():
        assert entry["median_m"] < entry["p95_m"] < entry["largest_m"]
        assert np.hypot(np.hypot(entry["rms_x_m"], entry["rms_y_m"]), entry["rms_z_m"]) == pytest.approx(entry["rms_m"])
        assert min(entry["rms_held_m"], entry["rms_free_m"]) <= entry["rms_m"]
        assert max(entry["rms_held_m"], entry["rms_free_m"]) >= entry["rms_m"]
    assert table["hands"]["jump_share"] > table["shoulders"]["jump_share"] == 0.0
    assert claim(noise, "virtual Kinect").holds is True
    assert f"hands {1e3 * rms[2]:.1f} mm" in claim(noise, "virtual Kinect").measured


def test_without_real_recordings_nothing_is_claimed_of_them_and_a_note_tells_how_to_give_them(noise):
    assert [one.holds for one in noise.claims if "real recordings" in one.paper] == [None, None]
    assert any("--recordings" in note for note in noise.notes)
    assert "not_used" not in noise.tables
    assert all(name.startswith("virtual Kinect, seed ") for name in noise.tables["recordings"].columns["recording"])


def write_rows(path, x, rate=30.0):
    names = ("ShoulderLeft", "ElbowLeft", "WristLeft", "ShoulderRight", "ElbowRight", "WristRight")
    header = ",".join(["Timestamp", *(f"{name}{axis}" for name in names for axis in "XYZ")])
    np.savetxt(
        path,
        np.column_stack([np.arange(len(x)) / rate, x.reshape(len(x), 18)]),
        "%.6f",
        ",",
        header=header,
        comments="",
    )


@pytest.mark.parametrize(("sigmas", "holds"), [((1.0, 3.0, 6.0), True), ((6.0, 3.0, 1.0), False)])
def test_real_recordings_decide_their_claims(tmp_path, person, sigmas, holds):
    """Three takes with noise that grows, or shrinks, from shoulder to hand, in mm."""
    rng = np.random.default_rng(1)
    for i in range(3):
        noisy = person[1] + 1e-3 * np.tile(sigmas, 2)[:, None] * rng.standard_normal(person[1].shape)
        write_rows(tmp_path / f"take_{i}.csv", noisy)
    (tmp_path / "README.txt").write_text("what these are\n")
    study = run("measurement_noise", recordings=tmp_path)
    assert claim(study, "jitter").holds is holds
    assert claim(study, "the forearm varies more").holds is holds
    assert rows(study, "not_used")["README.txt"]["reason"].startswith("text of no known format")
    real = {name: row for name, row in rows(study, "recordings").items() if name.startswith("take_")}
    assert sorted(real) == ["take_0.csv", "take_1.csv", "take_2.csv"]
    for row in real.values():
        assert row["jitter_hands_m"] == pytest.approx(1e-3 * sigmas[2], rel=0.25)
        assert row["hands_mean_m"] == pytest.approx(0.30, abs=0.02)


def test_recordings_that_disagree_or_are_too_few_are_not_judged(tmp_path, person):
    rng = np.random.default_rng(2)
    for name, sigmas in (("one", (1.0, 3.0, 6.0)), ("other", (6.0, 3.0, 1.0))):
        noise = 1e-3 * np.tile(sigmas, 2)[:, None] * rng.standard_normal(person[1].shape)
        write_rows(tmp_path / f"{name}.csv", person[1] + noise)
    study = run("measurement_noise", recordings=tmp_path)
    assert claim(study, "the forearm varies more").holds is None
    assert claim(study, "jitter").holds is None
    assert "in 1 of 2 recordings" in claim(study, "jitter").measured


# Fig. 6


def test_the_original_breaks_bones_and_the_modified_none(trajectories):
    found = claim(trajectories, "keep them")
    assert found.holds is True
    assert ": 0 violations" in found.measured


def test_hands_are_moved_most(trajectories):
    table = rows(trajectories, "distances")
    for side in ("left", "right"):
        moved = [table[f"{side}_{joint}"]["original_to_modified_rms_m"] for joint in ("shoulder", "elbow", "wrist")]
        assert 0.0 < moved[0] < moved[1] < moved[2] < 0.2
    assert claim(trajectories, "moved most").holds is True
    for entry in table.values():
        assert entry["original_to_modified_max_m"] >= entry["original_to_modified_rms_m"]
        assert entry["original_to_recorded_rms_m"] < entry["modified_to_recorded_rms_m"]


def test_the_claim_on_the_truth_is_what_its_table_says(trajectories):
    table = trajectories.tables["truth"].columns
    assert list(table["seed"]) == [0, 1]
    better = [
        np.mean(table[f"modified_{kind}_rms_m"]) < np.mean(table[f"original_{kind}_rms_m"])
        for kind in ("shoulders", "elbows", "hands")
    ]
    assert claim(trajectories, "really did").holds is all(better)


def test_the_written_paths_start_together(trajectories):
    columns = trajectories.tables["paths_30_hz"].columns
    np.testing.assert_allclose(np.diff(columns["time_s"]), 1 / 30, atol=0.004)
    for point in POINTS:
        for axis in "xyz":
            assert columns[f"original_{point}_{axis}_m"][0] == columns[f"modified_{point}_{axis}_m"][0]


# Fig. 7


def test_modified_errors_come_inside_soon_and_original_ones_do_not(errors):
    columns = errors.tables["errors"].columns
    joints = [i for i, point in enumerate(columns["point"]) if not point.endswith("shoulder")]
    counts = [int(columns["modified_samples_until_inside"][i]) for i in joints]
    assert len(counts) == 12
    assert claim(errors, "every axis").holds is (max(counts) <= 15) is True
    assert f"after {max(counts)} samples" in claim(errors, "every axis").measured
    never = sum(columns["original_samples_until_inside"][i] == "never" for i in joints)
    assert never >= 6
    assert f"{never} of 12" in claim(errors, "does not stay").measured


def test_the_counts_are_those_of_the_written_series(errors):
    series, table = errors.tables["errors_over_time"].columns, errors.tables["errors"].columns
    t = series["time_s"]
    for point, axis, count in zip(table["point"], table["axis"], table["modified_samples_until_inside"], strict=True):
        if point.endswith("shoulder"):
            continue
        outside = np.abs(series[f"modified_{point}_{axis}_m"]) >= 0.01
        assert np.all(~outside[t > int(count) / 30.0 + 1e-9])
        if int(count):
            assert outside[t < (int(count) - 1) / 30.0].any() or outside[0]


def test_errors_start_alike_since_both_motions_do(errors):
    series = errors.tables["errors_over_time"].columns
    for name, values in series.items():
        if name.startswith("original_"):
            assert series[name.replace("original_", "modified_")][0] == pytest.approx(values[0], abs=1e-12)


def test_without_coupling_the_claims_fail_and_say_so():
    """The law that changes nothing: the modified motion is the original one."""
    study = run("tracking_errors", "law=none")
    assert [claim(study, words).holds for words in ("every axis", "hands' distance")] == [False, False]
    study = run("joint_distances", "law=none")
    assert [claim(study, words).holds for words in ("leaves its funnel", "modified: within")] == [False, False]


# Figs. 8 and 9


def test_no_bone_leaves_its_funnel(distances):
    table = rows(distances, "links")
    assert set(table) == {"left_upper_arm", "left_forearm", "right_forearm", "right_upper_arm"}
    assert claim(distances, "leaves its funnel").holds is True
    assert claim(distances, "modified: within").holds is True
    for entry in table.values():
        assert entry["modified_violations"] == 0 < entry["original_violations"]
        assert entry["original_min_m"] < entry["desired_m"] < entry["original_max_m"]
        assert entry["original_samples_until_inside"] == "never"
        assert int(entry["modified_samples_until_inside"]) <= 15
    assert {round(entry["desired_m"], 9) for entry in table.values()} == {0.22, 0.28}


def test_the_written_lengths_are_inside_the_written_funnel(distances):
    columns = distances.tables["lengths"].columns
    for link, entry in rows(distances, "links").items():
        lower, upper = columns[f"{link}_funnel_lower_m"], columns[f"{link}_funnel_upper_m"]
        for name in ("original", "modified"):
            values = columns[f"{link}_{name}_m"]
            assert np.sum((values <= lower) | (values >= upper)) == entry[f"{name}_violations"]
            assert values.min() == pytest.approx(entry[f"{name}_min_m"])
        assert 0.1 < np.min(columns[f"{link}_recorded_m"]) < np.max(columns[f"{link}_recorded_m"]) < 0.4
        assert upper[-1] - lower[-1] == pytest.approx(0.02, abs=1e-6)


def test_every_study_says_what_stands_in_for_the_papers_recording(noise, trajectories, errors, distances):
    for study in (noise, trajectories, errors, distances):
        assert any("never published" in note for note in study.notes)
