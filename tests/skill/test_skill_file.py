import json
from dataclasses import fields, replace

import numpy as np
import pytest

from drake_blfdmp.demonstration.modelled_person import hold_and_place
from drake_blfdmp.errors import SkillError
from drake_blfdmp.skill.learning import learn_skill
from drake_blfdmp.skill.rollout import roll_out
from drake_blfdmp.skill.skill import Skill


@pytest.fixture(scope="module")
def skill():
    return learn_skill(*hold_and_place(), basis_functions=30, events={"grasp": 1.6}, source="modelled person")


def test_a_saved_skill_comes_back_bit_for_bit(skill, tmp_path):
    skill.save(tmp_path / "a.json")
    loaded = Skill.load(tmp_path / "a.json")
    for field in fields(Skill):
        ours, theirs = getattr(skill, field.name), getattr(loaded, field.name)
        if isinstance(ours, np.ndarray):
            np.testing.assert_array_equal(ours, theirs)
        else:
            assert ours == theirs, field.name


def test_spread_and_mobility_come_back_and_a_file_without_them_is_as_it_was(skill, tmp_path):
    spread = 0.01 * np.random.default_rng(0).random((101, 6, 3))
    rich = replace(skill, spread=spread, mobility=np.arange(1.0, 7.0))
    rich.save(tmp_path / "rich.json")
    loaded = Skill.load(tmp_path / "rich.json")
    np.testing.assert_array_equal(loaded.spread, spread)
    np.testing.assert_array_equal(loaded.mobility, np.arange(1.0, 7.0))
    skill.save(tmp_path / "plain.json")
    assert not {"spread_m", "mobility"} & set(json.loads((tmp_path / "plain.json").read_text()))
    assert Skill.load(tmp_path / "plain.json").spread is None
    assert Skill.load(tmp_path / "plain.json").mobility is None


def test_the_spread_lies_evenly_on_the_skills_clock_and_scales_with_it(skill):
    places = np.linspace(0.0, 1.0, 11)[:, None, None] * np.ones((6, 3))
    spread = replace(skill, spread=0.01 * places)
    at = np.array([-1.0, 0.0, 0.13, 0.5, 1.0, 2.0])
    for one in (spread, spread.with_duration(2.5 * skill.tau)):
        np.testing.assert_allclose(one.spread_at(at * one.tau)[:, 4, 1], 0.01 * np.clip(at, 0.0, 1.0), atol=1e-12)
    assert skill.spread_at(at) is None
    assert spread.spread_at(0.3).shape == (6, 3)


def test_an_existing_file_is_not_overwritten(skill, tmp_path):
    (tmp_path / "a.json").write_text("mine")
    with pytest.raises(SkillError, match="exists already"):
        skill.save(tmp_path / "a.json")
    assert (tmp_path / "a.json").read_text() == "mine"
    with pytest.raises(SkillError, match="cannot be written"):
        skill.save(tmp_path / "no_such_folder" / "a.json")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"version": 99}, "version 99, this program reads 1"),
        ({"format": "other"}, "not a skill file"),
        ({"weights": [[1.0, 2.0], [3.0]]}, "incomplete or damaged"),
        ({"tau_s": -1.0}, "tau must be a positive number"),
        ({"goal_m": [[0.0, 0.0, 0.0]]}, r"goal has shape \(1, 3\), expected \(6, 3\)"),
        ({"start_m": [[float("nan")] * 3] * 6}, "start holds a number that is not finite"),
        ({"points": ["right_wrist"]}, "expected left_shoulder, left_elbow"),
        ({"events_s": {"grasp": "soon"}}, "incomplete or damaged"),
        ({"events_s": 3.0}, "incomplete or damaged"),
        ({"gamma": "DELETE"}, "incomplete or damaged"),
        ({"spread_m": [[[0.0] * 3] * 6]}, r"spread has shape \(1, 6, 3\)"),
        ({"spread_m": [[[-1.0] * 3] * 6] * 2}, "spread holds a number that is negative"),
        ({"spread_m": [[0.0], [0.0, 1.0]]}, "incomplete or damaged"),
        ({"mobility": [1.0, 1.0, 0.0, 1.0, 1.0, 1.0]}, "mobility must be 6 positive numbers"),
    ],
)
def test_a_changed_file_is_refused_with_one_line(skill, tmp_path, change, message):
    path = tmp_path / "a.json"
    skill.save(path)
    document = json.loads(path.read_text())
    document.update(change)
    path.write_text(json.dumps({k: v for k, v in document.items() if v != "DELETE"}))
    with pytest.raises(SkillError, match=message) as caught:
        Skill.load(path)
    assert "\n" not in str(caught.value)
    assert str(path) in str(caught.value)


def test_a_torn_a_binary_and_a_missing_file_are_refused(skill, tmp_path):
    path = tmp_path / "a.json"
    skill.save(path)
    path.write_text(path.read_text()[:5000])
    (tmp_path / "b.json").write_bytes(b"\xff\xfe\x00")
    (tmp_path / "c.json").write_text("[]")
    for name in ("a.json", "b.json", "c.json", "missing.json"):
        with pytest.raises(SkillError, match=name):
            Skill.load(tmp_path / name)


@pytest.mark.parametrize("factor", [0.5, 2.0])
def test_another_duration_keeps_the_path_and_moves_the_events(skill, factor):
    slow = skill.with_duration(factor * skill.tau)
    assert slow.events == {"grasp": pytest.approx(1.6 * factor)}
    a, b = roll_out(skill, time_step=0.01), roll_out(slow, time_step=0.01 * factor)
    np.testing.assert_allclose(a.x, b.x, atol=1e-11)
    np.testing.assert_allclose(a.velocity, b.velocity * factor, atol=1e-10)


def test_another_start_and_goal_are_started_from_and_reached(skill):
    shift = np.array([0.1, -0.05, 0.2])
    moved = skill.with_start(skill.start + shift).with_goal(skill.goal - shift)
    r = roll_out(moved, time_step=0.01)
    np.testing.assert_array_equal(r.x[0], skill.start + shift)
    np.testing.assert_allclose(r.x[-1], skill.goal - shift, atol=2e-3)
    np.testing.assert_array_equal(moved.weights, skill.weights)


@pytest.mark.parametrize("tau", [0.0, -1.0, np.nan, np.inf])
def test_an_impossible_duration_is_refused(skill, tau):
    with pytest.raises(SkillError, match="tau"):
        skill.with_duration(tau)
