"""The command line as a person uses it: a whole run and its folder."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from drake_blfdmp.planning.scenario import LoadScenario
from drake_blfdmp.recording.read import read_mcap
from drake_blfdmp.skeleton import LINKS, POINTS
from drake_blfdmp.skill.skill import Skill
from drake_blfdmp.viewing.figures import FIGURES

ROOT = Path(__file__).resolve().parents[1]
BONES = [link.name for link in LINKS if link.name != "hands"]
SUMMARY_KEYS = {
    "success": None,
    "failures": None,
    "scenario": None,
    "law": None,
    "recording": {"source", "synthetic", "frames", "rate_hz", "duration_s", "repairs", "held_s", "estimated"},
    "fit": {"rms_m"},
    "links": {link.name for link in LINKS},
    "links_uncoupled": {link.name for link in LINKS},
    "barrier": {"max_derivative"},
    "events": {"planned", "recognised"},
    "plan": {"notes", "scale", "world_m", "palm_rolls_rad", "stretch", "lift_m", "box_width_m"},
    "robot": {
        "min_joint_margin_rad", "max_velocity_ratio", "max_effort_ratio", "min_clearance_m", "palm_tracking_rms_m"
    },
    "box": {
        "lifted_m",
        "placement_error_m",
        "max_tilt_deg",
        "dropped",
        "max_slip_m",
        "squeeze_force_n",
        "squeeze_planned_n",
        "squeeze_limit_n",
    },
    "timing": {"simulated_s", "wall_s", "realtime_rate"},
    "versions": {"drake_blfdmp", "drake", "numpy", "scipy", "mcap"},
    "seed": None,
}  # fmt: skip
LINK_KEYS = {
    "desired_m", "min_m", "max_m", "violations", "largest_excess_m", "samples_until_inside", "min_margin"
}  # fmt: skip


# The default run.


@pytest.fixture(scope="module")
def summary(default_run):
    return json.loads((default_run.folder / "summary.json").read_text())


def test_the_default_run_succeeds_and_says_so(default_run, summary):
    assert default_run.status == 0
    assert summary["success"] is True
    assert summary["failures"] == []
    assert "\nsuccess\n" in default_run.stdout
    assert str(default_run.folder) in default_run.stdout
    assert "synthetic" in default_run.stdout
    for link in LINKS:
        assert link.name in default_run.stdout


def test_every_file_of_the_folder_is_there_and_nothing_else(default_run):
    expected = {"run.mcap", "scene.html", "skill.json", "scenario.yaml", "summary.json"}
    expected |= {f"{name}.png" for name in FIGURES}
    assert {path.name for path in default_run.folder.iterdir()} == expected
    assert all(path.stat().st_size > 100 for path in default_run.folder.iterdir())


def test_the_scene_is_one_small_file(default_run):
    page = default_run.folder / "scene.html"
    assert page.stat().st_size < 5e6
    assert "<html" in page.read_text(encoding="utf-8")[:2000].lower()


def test_the_summary_has_every_key_and_only_finite_numbers(summary):
    assert set(SUMMARY_KEYS) <= set(summary)
    for key, parts in SUMMARY_KEYS.items():
        if parts is not None:
            assert parts <= set(summary[key]), key
    for section in ("links", "links_uncoupled"):
        for entry in summary[section].values():
            assert set(entry) >= LINK_KEYS

    def walk(value):
        if isinstance(value, dict):
            for item in value.values():
                walk(item)
        elif isinstance(value, list):
            for item in value:
                walk(item)
        elif isinstance(value, float):
            assert np.isfinite(value)

    walk(summary)


def test_no_link_leaves_its_band_and_all_meet_the_papers_within_15_samples(summary):
    for entry in summary["links"].values():
        assert entry["violations"] == 0
        assert entry["min_margin"] > 0
        assert 0 <= entry["samples_until_inside"] <= 15
    assert summary["barrier"]["max_derivative"] <= 0


def test_without_coupling_the_bones_vary_as_the_paper_found(summary):
    """Figs. 6-7: without the law the recorded bones range over 0.13 to 0.34 m; the bands alone are 0.02 m wide."""
    low = min(summary["links_uncoupled"][bone]["min_m"] for bone in BONES)
    high = max(summary["links_uncoupled"][bone]["max_m"] for bone in BONES)
    assert 0.13 <= low < high <= 0.34
    assert high - low >= 0.10
    for bone in BONES:
        assert summary["links_uncoupled"][bone]["violations"] > 0


def test_the_skill_fits_and_the_box_arrives(summary):
    assert summary["fit"]["rms_m"] <= 1e-4
    assert summary["box"]["lifted_m"] >= 0.15
    assert summary["box"]["placement_error_m"] <= 0.005
    assert summary["box"]["max_tilt_deg"] <= 1.0
    assert summary["box"]["max_slip_m"] <= 0.002
    assert summary["box"]["squeeze_force_n"][0] > 20


def test_the_scenario_of_the_folder_is_the_whole_scenario(default_run, default_scenario):
    assert LoadScenario(default_run.folder / "scenario.yaml") == default_scenario


def test_the_skill_of_the_folder_loads(default_run, default_plan):
    skill = Skill.load(default_run.folder / "skill.json")
    np.testing.assert_array_equal(skill.weights, default_plan.task.skill.weights)
    np.testing.assert_array_equal(skill.goal, default_plan.task.skill.goal)


def test_the_recording_decodes_with_metadata_events_and_attachments(default_run, summary):
    run = read_mcap(default_run.folder / "run.mcap")
    assert run.damage == ""
    assert run.robot_description.startswith("<?xml")
    assert [name for name, _ in run.events] == ["free_space", *(name for name, _ in summary["events"]["recognised"])]
    times = [t for _, t in run.events]
    assert times == sorted(times)
    assert 0.0 == times[0] < times[-1] < summary["timing"]["simulated_s"]
    entries = {key: value for record in run.metadata.values() for key, value in record.items()}
    assert entries["seed"] == "0"
    assert entries["law"] == "default"
    assert entries["synthetic"].lower() == "true"
    assert {"version_drake", "event_hold"} <= set(entries)
    assert set(run.attachments) == {"scenario.yaml", "skill.json", "summary.json", "planned.npz", "measured.npz"}
    assert run.attachments["scenario.yaml"] == (default_run.folder / "scenario.yaml").read_bytes()
    timeless = {key: value for key, value in summary.items() if key != "timing"}
    assert json.loads(run.attachments["summary.json"]) == timeless


def test_what_is_measured_happens_when_the_plan_has_it(default_run, summary):
    """The palms touch while they close and let go while they open; the box is in the air only while it is held."""
    planned, recognised = summary["events"]["planned"], dict(summary["events"]["recognised"])
    assert list(recognised) == ["contact", "lift", "carry", "lower", "release", "placed"]
    assert len(summary["events"]["recognised"]) == 6
    late = 0.1  # Dwell, and a sample.
    assert planned["close"] < recognised["contact"] < planned["hold"] + late
    assert planned["hold"] < recognised["lift"] < recognised["carry"] < recognised["lower"] < planned["set down"]
    assert recognised["lift"] - planned["carry"] < 1.5  # It starts from rest, and the first 5 mm take a while.
    assert planned["open"] < recognised["release"] < recognised["placed"] < planned["released"] + late
    run = read_mcap(default_run.folder / "run.mcap")
    assert {f"carry_phase_{k}" for k in range(8)} <= set(run.metadata["run"])
    assert run.metadata["run"]["carry_phase_2"] == "lift"
    np.testing.assert_allclose([t for _, t in run.events[1:]], list(recognised.values()), atol=1e-6)


def test_the_recorded_signals_agree_with_the_summary(default_run, summary):
    series = read_mcap(default_run.folder / "run.mcap").series

    def find(part):
        (name,) = [topic for topic in series if topic.rsplit("/", 1)[-1] == part]
        return series[name]

    margins, force = find("margin"), find("palm_force")
    assert margins.values.min() > 0
    assert margins.names == tuple(link.name for link in LINKS)
    assert len(margins.t) == pytest.approx(100 * summary["timing"]["simulated_s"], abs=2)
    events = summary["events"]["planned"]
    held = force.values[(force.t >= events["hold"]) & (force.t <= events["open"])]
    np.testing.assert_allclose([held.min(), held.max()], summary["box"]["squeeze_force_n"], rtol=1e-6)
    points = find("points")
    assert points.values.shape[1] == 18
    assert points.names[0] == f"{POINTS[0]}_x"


def test_what_palms_and_motors_bear_is_as_predicted(default_run, tmp_path):
    """By the script that compares them; a folder without a run is refused in a line."""
    script, figure = str(ROOT / "studies" / "predicted_hold.py"), tmp_path / "held.png"

    def compared(*arguments):
        command = [sys.executable, script, *map(str, arguments)]
        return subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)

    done = compared(default_run.folder, "--figure", figure)
    assert done.returncode == 0 and "slips" not in done.stdout and figure.stat().st_size > 10_000
    off = [line.split()[:2] for line in done.stdout.splitlines() if " off in the median" in line]
    most = {"force": 3.0, "centre_x": 6.0, "centre_y": 8.0, "effort": 6.0}
    assert [name for name, _ in off] == [*most, *most]  # For a table that holds the box and for one that lets it slide.
    assert all(float(number) < most[name] for name, number in off), done.stdout
    missing = compared(tmp_path)
    assert missing.returncode == 2 and missing.stderr.count("\n") == 1 and "run.mcap" in missing.stderr


def test_the_shorter_run_is_the_same_twice_to_the_byte(tmp_path):
    """In processes of their own, at the same time: only the clocks differ."""
    short = [
        "--seed", "3", "--set", "timing.approach_s=0.3", "--set", "timing.retreat_s=0.3", "--set", "timing.rest_s=0.2",
        "--set", "timing.dwell_s=0.6", "--set", "task.tail=0.2", "--set", "task.duration_scale=1.0",
        "--set", "retarget.scale=0.7",
    ]  # fmt: skip
    folders = [tmp_path / "first", tmp_path / "second"]
    command = [sys.executable, str(ROOT / "run.py"), *short, "--out"]
    started = [
        subprocess.Popen(
            [*command, str(folder)], cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
        for folder in folders
    ]
    outputs = [process.communicate(timeout=300) for process in started]
    assert [process.returncode for process in started] in ([0, 0], [1, 1]), outputs[0][1]
    first, second = folders
    assert (first / "run.mcap").read_bytes() == (second / "run.mcap").read_bytes()
    for name in ("scenario.yaml", "skill.json", "hands_distance.png"):
        assert (first / name).read_bytes() == (second / name).read_bytes()
    summaries = [json.loads((folder / "summary.json").read_text()) for folder in folders]
    for each in summaries:
        del each["timing"]
    assert summaries[0] == summaries[1]
    assert summaries[0]["seed"] == 3
