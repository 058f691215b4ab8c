"""A motion without a box as a person runs it: a made-up recording, and a piece of a real one where it is at hand."""

import json

import numpy as np
import pytest
from waving import wave, write_csv

from drake_blfdmp.recording.read import read_mcap
from drake_blfdmp.skeleton import LINKS

PLACE = ["--set", "retarget.scale=0.8", "--set", "retarget.world=[0, 0.3, 1.0]"]  # A short search.


@pytest.fixture(scope="module")
def run(command_line, tmp_path_factory):
    """(status, folder, what it printed) of a short motion."""
    import io
    from contextlib import redirect_stderr, redirect_stdout

    folder = tmp_path_factory.mktemp("motion")
    file = write_csv(folder / "waving.csv", *wave(duration_s=3.0))
    out = io.StringIO()
    with redirect_stdout(out), redirect_stderr(io.StringIO()):
        status = command_line.main(
            ["--recording", str(file), "--set", "task.kind=motion", *PLACE, "--out", str(folder / "run")]
        )
    return status, folder / "run", out.getvalue()


@pytest.fixture(scope="module")
def summary(run):
    return json.loads((run[1] / "summary.json").read_text())


def test_it_succeeds_with_zero_violations_and_says_so(run, summary):
    status, _, out = run
    assert status == 0 and summary["success"] is True and summary["failures"] == []
    assert [summary["links"][link.name]["violations"] for link in LINKS] == [0] * 5
    assert summary["barrier"]["max_derivative"] <= 0
    assert summary["robot"]["palm_tracking_rms_m"] < 0.003
    assert "without a box" in out and "moving" in out and "\nsuccess\n" in out


def test_the_summary_has_nulls_where_a_box_would_be(summary):
    assert summary["box"] is None
    assert summary["recording"]["held_s"] is None
    assert summary["recording"]["played_s"] == pytest.approx([0.0, 3.0])
    assert summary["plan"]["lift_m"] is None and summary["plan"]["box_width_m"] is None
    assert summary["links"]["hands"]["desired_m"] is None
    assert summary["links"]["left_forearm"]["desired_m"] == pytest.approx(0.24, abs=1e-3)


def test_every_file_but_the_figures_of_the_box_is_there(run):
    names = {path.name for path in run[1].iterdir()}
    assert names == {
        "run.mcap", "scene.html", "skill.json", "scenario.yaml", "summary.json",
        "link_lengths.png", "hands_distance.png", "paths.png", "joint_angles.png", "swivel.png", "feedback.png",
    }  # fmt: skip


def test_the_recording_has_the_two_arms_the_two_events_and_no_box(run, summary):
    recorded = read_mcap(run[1] / "run.mcap")
    assert recorded.damage == ""
    assert [name for name, _ in recorded.events] == ["start", "end"]
    start, end = (t for _, t in recorded.events)
    assert 0.0 < start < end < summary["timing"]["simulated_s"]
    assert not any(topic.endswith("palm_force") for topic in recorded.series)
    assert 'link name="box"' not in recorded.robot_description
    (margins,) = [series for topic, series in recorded.series.items() if topic.endswith("margin")]
    assert margins.values.min() > 0.0


def test_the_hands_keep_to_a_band_that_moves_with_them(run, summary):
    """The waving hands' distance goes through 0.4 m."""
    bands = read_mcap(run[1] / "run.mcap").series["/link_lengths"]
    hands = bands.values[:, [bands.names.index("hands_lower"), bands.names.index("hands_upper")]].mean(axis=1)
    assert np.ptp(hands) > 0.3
    assert summary["links"]["hands"]["max_m"] - summary["links"]["hands"]["min_m"] == pytest.approx(
        np.ptp(hands), abs=0.01
    )


def test_the_same_recording_as_a_hold_is_refused_with_the_way_out(command_line, tmp_path, capsys):
    file = write_csv(tmp_path / "waving.csv", *wave(duration_s=3.0))
    assert command_line.main(["--recording", str(file), "--out", str(tmp_path / "out")]) == 2
    (line,) = [line for line in capsys.readouterr().err.splitlines() if line.startswith("run.py:")]
    assert line.endswith("or play the motion without a box with --set task.kind=motion")


def test_studies_are_of_a_held_box(command_line, tmp_path, capsys):
    arguments = ["studies", "trajectories", "--set", "task.kind=motion", "--out", str(tmp_path / "out")]
    assert command_line.main(arguments) == 2
    assert "is about a held box" in capsys.readouterr().err


def test_a_piece_of_a_real_recording_in_which_nothing_is_held(recordings, command_line, tmp_path):
    """Azure Kinect, a person who moves both arms."""
    status = command_line.main(
        [
            "--recording", str(recordings / "azure_kinect" / "body_tracking_data.bag"),
            "--set", "task.kind=motion", "--set", "task.held=[20, 23]", "--set", "retarget.scale=0.5",
            "--set", "retarget.world=[0.03, 0.48, 0.7]", "--out", str(tmp_path / "out"),
        ]
    )  # fmt: skip
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert status == 0 and summary["success"] is True
    assert sum(link["violations"] for link in summary["links"].values()) == 0
