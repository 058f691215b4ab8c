"""Real recordings become sources with a person's dimensions, or are refused with the reason; nothing is simulated."""

from dataclasses import replace

import pytest

from drake_blfdmp.planning.scenario import RecordingConfig, Scenario
from drake_blfdmp.planning.sources import LoadSource

FILES = {
    "omomo": ("omomo_largebox/sub3_largebox_003_extracted.csv", None, (0.33, 0.44)),
    "vicon": ("vicon_box_lift/yerden_alma_hatasiz.trc", None, (0.22, 0.34)),
    "utkinect": ("kinect_v1_utkinect/joints_s01_e01.txt", [1016, 1242], (0.05, 0.6)),
}


def load(recordings, name):
    file, frames, _ = FILES[name]
    return LoadSource(replace(Scenario(), recording=RecordingConfig(file=str(recordings / file), frames=frames)))


@pytest.mark.parametrize("name", FILES)
def test_dimensions_are_a_persons_and_estimated(recordings, name):
    source = load(recordings, name)
    low, high = FILES[name][2]
    assert not source.recording.synthetic
    assert set(source.estimated) == {"upper_arm", "forearm", "box_width"}
    assert 0.18 <= source.dimensions.upper_arm <= 0.36
    assert 0.18 <= source.dimensions.forearm <= 0.36
    assert low <= source.dimensions.box_width <= high


@pytest.mark.parametrize("name", FILES)
def test_the_held_interval_lies_inside_and_lasts(recordings, name):
    source = load(recordings, name)
    assert 0.0 <= source.holding.start_s < source.holding.end_s <= source.demonstration.duration_s
    assert source.holding.end_s - source.holding.start_s >= 0.5


def test_who_walks_stays_in_front_of_the_arms(recordings):
    """The person of omomo walks 2 m with the box; in the torso frame the shoulders stay where they are."""
    x = load(recordings, "omomo").demonstration.x
    shoulders = 0.5 * (x[:, 0] + x[:, 3])
    assert abs(shoulders[:, :2]).max() < 0.15


def test_a_box_in_one_hand_is_refused_with_the_reason(recordings, command_line, capsys, tmp_path):
    file = recordings / "vicon_box_lift" / "yantasima2.trc"
    assert command_line.main(["--recording", str(file), "--out", str(tmp_path / "out")]) == 2
    (line,) = [line for line in capsys.readouterr().err.splitlines() if line.startswith("run.py:")]
    assert "yantasima2.trc" in line
    assert "one hand" in line
    assert "record" in line
    assert not (tmp_path / "out").exists()
