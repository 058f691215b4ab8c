"""The command line as a person uses it: a whole run and its folder, and one clear line for anything wrong."""

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
    "plan": {"notes", "scale", "world_m", "palm_rolls_rad", "stretch", "lift_m", "box_width_m"},
    "robot": {
        "min_joint_margin_rad", "max_velocity_ratio", "max_effort_ratio", "min_clearance_m", "palm_tracking_rms_m"
    },
    "box": {"lifted_m", "placement_error_m", "max_tilt_deg", "dropped", "max_slip_m", "squeeze_force_n"},
    "timing": {"simulated_s", "wall_s", "realtime_rate"},
    "versions": {"drake_blfdmp", "drake", "numpy", "scipy", "mcap"},
    "seed": None,
}  # fmt: skip
LINK_KEYS = {
    "desired_m", "min_m", "max_m", "violations", "largest_excess_m", "samples_until_inside", "min_margin"
}  # fmt: skip


def python(*arguments, cwd):
    """`python run.py` in a process of its own."""
    command = [sys.executable, str(ROOT / "run.py"), *map(str, arguments)]
    return subprocess.run(command, cwd=cwd, capture_output=True, text=True, timeout=300)


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
    assert [name for name, _ in run.events] == ["close", "hold", "carry", "set down", "open", "released"]
    times = [t for _, t in run.events]
    assert times == sorted(times)
    assert 0.0 < times[0] < times[-1] < summary["timing"]["simulated_s"]
    entries = {key: value for record in run.metadata.values() for key, value in record.items()}
    assert entries["seed"] == "0"
    assert entries["law"] == "default"
    assert entries["synthetic"].lower() == "true"
    assert {"version_drake", "event_hold"} <= set(entries)
    assert set(run.attachments) == {"scenario.yaml", "skill.json", "summary.json"}
    assert run.attachments["scenario.yaml"] == (default_run.folder / "scenario.yaml").read_bytes()
    timeless = {key: value for key, value in summary.items() if key != "timing"}
    assert json.loads(run.attachments["summary.json"]) == timeless


def test_the_recorded_signals_agree_with_the_summary(default_run, summary):
    series = read_mcap(default_run.folder / "run.mcap").series

    def find(part):
        (name,) = [topic for topic in series if topic.rsplit("/", 1)[-1] == part]
        return series[name]

    margins, force = find("margin"), find("palm_force")
    assert margins.values.min() > 0
    assert margins.names == tuple(link.name for link in LINKS)
    assert len(margins.t) == pytest.approx(100 * summary["timing"]["simulated_s"], abs=2)
    events = dict(read_mcap(default_run.folder / "run.mcap").events)
    held = force.values[(force.t >= events["hold"]) & (force.t <= events["open"])]
    np.testing.assert_allclose([held.min(), held.max()], summary["box"]["squeeze_force_n"], rtol=1e-6)
    points = find("points")
    assert points.values.shape[1] == 18
    assert points.names[0] == f"{POINTS[0]}_x"


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


# Bad input.


def write_csv(path, t, x, names=POINTS):
    header = ",".join(["time_s", *(f"{name}_{axis}" for name in names for axis in "xyz")])
    np.savetxt(path, np.column_stack([t, x.reshape(len(t), -1)]), delimiter=",", header=header, comments="")
    return path


@pytest.fixture(scope="module")
def files(tmp_path_factory, person):
    """A folder with a good recording, several bad ones, and bad scenarios."""
    folder = tmp_path_factory.mktemp("bad")
    t, x = person
    write_csv(folder / "good.csv", t, x)
    write_csv(folder / "names.csv", t, x, ["nose", *POINTS[1:]])
    write_csv(folder / "nan.csv", t, np.full_like(x, np.nan))
    write_csv(folder / "two.csv", t[:2], x[:2])
    write_csv(folder / "swapped.csv", t, x[:, [3, 4, 5, 0, 1, 2]])
    write_csv(folder / "millimetres.csv", t, 1000.0 * x)
    (folder / "empty.csv").write_bytes(b"")
    (folder / "noise.csv").write_bytes(bytes(range(256)) * 8)
    (folder / "folder").mkdir()
    (folder / "broken.yaml").write_text("box: [1,\n mass: }")
    (folder / "key.yaml").write_text("box:\n  weight: 2\n")
    (folder / "list.yaml").write_text("- 1\n- 2\n")
    (folder / "full").mkdir()
    (folder / "full" / "precious.txt").write_text("keep me")
    return folder


BAD = {
    "missing recording": (["--recording", "nowhere.csv"], ["nowhere.csv", "no such file"]),
    "empty file": (["--recording", "empty.csv"], ["empty.csv", "is empty"]),
    "directory": (["--recording", "folder"], ["is a directory"]),
    "binary noise": (["--recording", "noise.csv"], ["noise.csv", "known formats"]),
    "joint not found": (["--recording", "names.csv"], ["left_shoulder", "nose", "right_wrist"]),
    "mapped to nothing": (
        ["--recording", "good.csv", "--joints", "left_wrist=Hand"], ["'Hand'", "left_wrist", "right_elbow"]
    ),
    "unknown point": (["--recording", "good.csv", "--joints", "hip=left_wrist"], ["'hip'", "left_shoulder"]),
    "bad --joints": (["--recording", "good.csv", "--joints", "left_wrist"], ["--joints left_wrist", "NAME=COLUMN"]),
    "nan everywhere": (["--recording", "nan.csv"], ["nan.csv", "missing in every frame"]),
    "two frames": (["--recording", "two.csv"], ["2-frame recording"]),
    "left and right swapped": (["--recording", "swapped.csv"], ["left and right are swapped"]),
    "millimetres as metres": (["--recording", "millimetres.csv", "--unit", "m"], ["220 m", "--unit mm"]),
    "metres as millimetres": (["--recording", "good.csv", "--unit", "mm"], ["--unit m"]),
    "unknown format": (["--recording", "good.csv", "--format", "vhs"], ["'vhs'", "wide_csv"]),
    "bad --frames": (["--recording", "good.csv", "--frames", "7"], ["--frames 7", "FIRST:LAST"]),
    "words in --frames": (["--recording", "good.csv", "--frames", "a:b"], ["--frames a:b", "FIRST:LAST"]),
    "frames beyond the end": (["--recording", "good.csv", "--frames", "900:950"], ["900:950", "0 to 240"]),
    "frames backwards": (["--recording", "good.csv", "--frames", "90:30"], ["90:30"]),
    "unknown scenario key": (["--scenario", "key.yaml"], ["'box.weight'", "width, depth, height, mass, friction"]),
    "scenario missing": (["--scenario", "nowhere.yaml"], ["nowhere.yaml", "cannot be read"]),
    "scenario is no YAML": (["--scenario", "broken.yaml"], ["broken.yaml", "is not YAML"]),
    "scenario is a list": (["--scenario", "list.yaml"], ["must hold keys and values"]),
    "scenario is a folder": (["--scenario", "folder"], ["cannot be read"]),
    "unknown --set key": (["--set", "box.weight=1"], ["'box.weight'", "mass"]),
    "unknown --set section": (["--set", "crate.mass=1"], ["'crate'", "box"]),
    "--set without a value": (["--set", "box.mass"], ["key.path=value"]),
    "--set of a wrong type": (["--set", "box.mass=heavy"], ["box.mass=heavy"]),
    "negative mass": (["--set", "box.mass=-1"], ["box.mass must be positive"]),
    "unknown law": (["--set", "law=magic"], ["'magic'", "default", "published_loop", "gams"]),
    "a law that diverges": (["--set", "law=published_lagged"], ["published_lagged", "without bound", "another law"]),
    "negative seed": (["--seed", "-1"], ["seed is -1"]),
    "unsafe skill step": (["--set", "simulation.skill_time_step=0.03"], ["0.03 s", "k_1", "use at most"]),
    "unsafe gains": (["--set", "gains.k_2=5000"], ["k_2 = 5000", "use at most"]),
    "coarse plant step": (["--set", "simulation.time_step=0.5"], ["simulation.time_step", "0.01 s"]),
    "no duration": (["--set", "task.duration_scale=0"], ["task.duration_scale must be positive"]),
    "negative tail": (["--set", "task.tail=-1"], ["task.tail"]),
    "negative bone": (["--set", "bands.upper_arm=-1"], ["bands.upper_arm must be positive"]),
    "box wider than the arms reach": (["--set", "box.width=1.5"], ["1.50 m", "narrower box"]),
    "box thinner than the squeeze": (["--set", "box.width=0.03"], ["0.030 m", "too narrow"]),
    "box out of range for the palms": (["--set", "task.grasp_above=0.3"], ["task.grasp_above"]),
    "folder in use": (["--out", "full"], ["--out", "not empty", "nothing is overwritten"]),
    "file as folder": (["--out", "good.csv"], ["--out", "nothing is overwritten"]),
}  # fmt: skip
IN_A_PROCESS = ("missing recording", "joint not found", "unknown scenario key", "folder in use")


def absolute(arguments, files, tmp_path):
    """The arguments with file names in `files`, and a folder for the results where none is given."""
    paths = {"--recording", "--scenario", "--out"}
    result = [
        str(files / value) if before in paths else value
        for before, value in zip([None, *arguments], arguments, strict=False)
    ]
    return result if "--out" in result else [*result, "--out", str(tmp_path / "out")]


def check_refused(status, out, err, words, out_folder):
    assert status == 2
    assert "Traceback" not in out + err
    lines = [line for line in err.splitlines() if not line.endswith(" ...")]  # Without the stages done so far.
    assert len(lines) == 1, err
    assert lines[0].startswith("run.py: ")
    for word in words:
        assert word in lines[0]
    assert out == ""
    assert not out_folder.exists()


@pytest.mark.parametrize("case", BAD)
def test_bad_input_gets_one_line_and_status_2(case, command_line, files, tmp_path, capfd):
    arguments, words = BAD[case]
    before = {path: path.stat().st_mtime_ns for path in files.rglob("*")}
    status = command_line.main(absolute(arguments, files, tmp_path))
    check_refused(status, *capfd.readouterr(), words, tmp_path / "out")
    assert {path: path.stat().st_mtime_ns for path in files.rglob("*")} == before


@pytest.mark.parametrize("case", IN_A_PROCESS)
def test_a_process_of_its_own_answers_the_same(case, files, tmp_path):
    arguments, words = BAD[case]
    done = python(*absolute(arguments, files, tmp_path), cwd=tmp_path)
    check_refused(done.returncode, done.stdout, done.stderr, words, tmp_path / "out")
    assert list(tmp_path.iterdir()) == []
    assert (files / "full" / "precious.txt").read_text() == "keep me"


def test_help_names_every_option(tmp_path):
    done = python("--help", cwd=tmp_path)
    assert done.returncode == 0
    for option in (
        "--scenario",
        "--set",
        "--recording",
        "--frames",
        "--joints",
        "--unit",
        "--out",
        "--seed",
        "--meshcat",
    ):
        assert option in done.stdout


def test_an_unknown_option_is_a_usage_error(tmp_path):
    done = python("--colour", "red", cwd=tmp_path)
    assert done.returncode == 2
    assert "--colour" in done.stderr
    assert "Traceback" not in done.stderr


def test_short_options_are_settings(command_line):
    options = command_line.parse(
        ["--recording", "it's.csv", "--frames", "3:9", "--joints", "left_wrist=Hand L", "right_wrist=a,b,c",
         "--unit", "mm", "--seed", "4", "--set", "seed=5"]
    )  # fmt: skip
    from drake_blfdmp.planning.scenario import ApplySetting, Scenario

    scenario = Scenario()
    for setting in command_line.settings(options):
        scenario = ApplySetting(scenario, setting)
    assert Path(scenario.recording.file) == Path("it's.csv").resolve()
    assert scenario.recording.frames == [3, 9]
    assert scenario.recording.joints == {"left_wrist": ["Hand L"], "right_wrist": ["a", "b", "c"]}
    assert (scenario.recording.unit, scenario.seed) == ("mm", 5)
