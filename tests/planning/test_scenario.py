"""Scenarios: defaults, settings, unknown keys at every level, types, ranges, and the way out to YAML and back."""

from dataclasses import asdict, fields, is_dataclass, replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from drake_blfdmp.demonstration.cleaning import CleaningOptions
from drake_blfdmp.errors import ScenarioError
from drake_blfdmp.planning.scenario import (
    ApplySetting,
    BoxConfig,
    CheckScenario,
    DumpScenario,
    LoadScenario,
    RecordingConfig,
    Scenario,
    TaskConfig,
)


def sections():
    return [item.name for item in fields(Scenario) if is_dataclass(getattr(Scenario(), item.name))]


def loaded(tmp_path, text, *settings):
    path = tmp_path / "scenario.yaml"
    path.write_text(text)
    return LoadScenario(path, settings)


def refused(action, *args):
    """The message of the one-line ScenarioError that `action` must raise."""
    with pytest.raises(ScenarioError) as caught:
        action(*args)
    message = str(caught.value)
    assert "\n" not in message
    return message


@pytest.mark.parametrize("text", ["", "# nothing but a remark\n", "name: hold_and_place\n", "box:\n  mass: 1.0\n"])
def test_what_a_file_does_not_say_has_its_default(tmp_path, text):
    assert loaded(tmp_path, text) == Scenario()


def test_the_default_run_is_the_default_scenario(default_scenario):
    assert default_scenario == Scenario()


def test_a_file_changes_what_it_says_and_nothing_else(tmp_path):
    scenario = loaded(tmp_path, "seed: 4\nbox: {mass: 2.5}\ntask:\n  held: [1.5, 4]\n")
    assert scenario == Scenario(seed=4, box=BoxConfig(mass=2.5), task=TaskConfig(held=[1.5, 4.0]))


def test_settings_apply_in_order_over_the_file(tmp_path):
    scenario = loaded(tmp_path, "box: {mass: 2.5}\nlaw: none\n", "box.mass=3", "box.depth=0.25", "box.mass=4")
    assert scenario == Scenario(law="none", box=BoxConfig(mass=4.0, depth=0.25))


@pytest.mark.parametrize(
    ("setting", "get", "value"),
    [
        ("law=none", lambda s: s.law, "none"),
        ("seed = 7", lambda s: s.seed, 7),
        ("recording.file='my data: 1.csv'", lambda s: s.recording.file, "my data: 1.csv"),
        ("recording.frames=[3, 9]", lambda s: s.recording.frames, [3, 9]),
        ("recording.joints={left_wrist: [a, b, c]}", lambda s: s.recording.joints, {"left_wrist": ["a", "b", "c"]}),
        ("recording.joints={left_wrist: Hand}", lambda s: s.recording.joints, {"left_wrist": ["Hand"]}),
        ("task.place_offset=[0, -0.1, 0]", lambda s: s.task.place_offset, [0.0, -0.1, 0.0]),
        ("retarget.level=false", lambda s: s.retarget.level, False),
        ("timing.dwell_s=2", lambda s: s.timing.dwell_s, 2.0),
        ("recording.also=[b.csv, c.csv]", lambda s: s.recording.also, ["b.csv", "c.csv"]),
        ("recording.also=b.csv", lambda s: s.recording.also, ["b.csv"]),
        ("recording.weights=[1, 2.5]", lambda s: s.recording.weights, [1.0, 2.5]),
        ("recording.time_unit=100ns", lambda s: s.recording.time_unit, "100ns"),
        ("recording.rate_hz=25", lambda s: s.recording.rate_hz, 25.0),
        ("recording.body=2", lambda s: s.recording.body, "2"),
        ("recording.body='7'", lambda s: s.recording.body, "7"),
        ("recording.cleaning.max_gap_s=0.5", lambda s: s.recording.cleaning.max_gap_s, 0.5),
        ("synthetic.takes=3", lambda s: s.synthetic.takes, 3),
        ("bands.weigh_by_uncertainty=true", lambda s: s.bands.weigh_by_uncertainty, True),
        ("learning.basis_functions=77", lambda s: s.learning.basis_functions, 77),
    ],
)
def test_a_setting_has_its_effect(setting, get, value):
    changed = ApplySetting(Scenario(), setting)
    assert get(changed) == value
    assert type(get(changed)) is type(value)


def test_applying_a_setting_leaves_the_given_scenario_alone():
    before = Scenario()
    ApplySetting(before, "task.place_offset=[1, 2, 3]")
    assert before == Scenario()


@pytest.mark.parametrize("section", ["", *sections()])
def test_an_unknown_key_is_named_with_the_keys_there_are(tmp_path, section):
    target = getattr(Scenario(), section) if section else Scenario()
    dotted = f"{section}.colour" if section else "colour"
    text = f"{section}: {{colour: 1}}\n" if section else "colour: 1\n"
    for message in (refused(loaded, tmp_path, text), refused(ApplySetting, Scenario(), f"{dotted}=1")):
        assert f"unknown key '{dotted}'" in message
        for item in fields(target):
            assert item.name in message.split("there are")[1]


@pytest.mark.parametrize("section", sections())
@pytest.mark.parametrize("value", ["3", "[1, 2]", "text"])
def test_a_section_is_no_single_value(section, value):
    assert f"'{section}' holds keys of its own" in refused(ApplySetting, Scenario(), f"{section}={value}")


@pytest.mark.parametrize(
    "setting",
    ["box.mass=heavy", "box.mass=[1]", "box.mass=", "seed=1.5", "seed=abc", "recording.frames=[a, b]", "box.mass.x=1",
     "task.place_offset=3", "retarget.level=7", "recording.joints=[1]"],
)  # fmt: skip
def test_a_value_of_the_wrong_type_is_refused_in_one_line_with_the_setting(setting):
    assert refused(ApplySetting, Scenario(), setting).startswith(f"--set {setting}: ")


@pytest.mark.parametrize("setting", ["box", "", "=1", "  =2"])
def test_a_setting_without_key_and_value_is_explained(setting):
    assert "write it as key.path=value" in refused(ApplySetting, Scenario(), setting)


@pytest.mark.parametrize("text", ["- 1\n", "just words\n", "3\n"])
def test_a_file_without_keys_is_refused(tmp_path, text):
    assert "must hold keys and values" in refused(loaded, tmp_path, text)


@pytest.mark.parametrize("value", ["[" * 3000, "[" * 3000 + "]" * 3000, "{a: " * 3000])
def test_brackets_nested_too_deeply_are_refused_in_one_line(tmp_path, value):
    assert "brackets are nested too deeply" in refused(ApplySetting, Scenario(), f"box.mass={value}")
    assert "brackets are nested too deeply" in refused(loaded, tmp_path, f"box: {value}")


def test_a_file_that_is_not_yaml_or_not_there_is_refused_by_name(tmp_path):
    assert "is not YAML" in refused(loaded, tmp_path, "a: [1,\n b: }")
    assert "scenario.yaml" in refused(loaded, tmp_path, "a: [1,\n b: }")
    (tmp_path / "binary.yaml").write_bytes(b"\xff\xfe\x00\x81")
    for name in ("missing.yaml", "binary.yaml", ""):
        assert "cannot be read" in refused(LoadScenario, tmp_path / name)


@pytest.mark.parametrize(
    ("setting", "expected"),
    [
        ("law=magic", "law is 'magic'; choose one of"),
        ("learning.method=magic", "learning.method is 'magic'; choose one of ridge, lwr|lwr, ridge"),
        ("recording.frame=moon", "choose one of torso, world"),
        ("task.kind=juggle", "task.kind is 'juggle'; choose one of hold, motion"),
        ("synthetic.sensor=radar", "synthetic.sensor is 'radar'; choose one of steady, kinect_v1, kinect_v2"),
        ("box.mass=0", "box.mass must be positive"),
        ("box.mass=.nan", "box.mass must be positive"),
        ("box.width=-0.1", "box.width must be positive"),
        ("simulation.time_step=0", "simulation.time_step must be positive"),
        ("simulation.skill_time_step=-1", "simulation.skill_time_step must be positive"),
        ("retarget.scale=0", "retarget.scale must be positive"),
        ("task.clearance=0", "task.clearance must be positive"),
        ("box.mass=.inf", "box.mass must be positive and finite"),
        ("simulation.time_step=0.02", "simulation.time_step is 0.02 s; contact needs at most 0.01 s"),
        ("task.duration_scale=0", "task.duration_scale must be positive"),
        ("task.squeeze=-0.01", "task.squeeze must be positive"),
        ("task.tail=-0.1", "task.tail must not be negative"),
        ("bands.upper_arm=-1", "bands.upper_arm must be positive"),
        ("bands.forearm=0", "bands.forearm must be positive"),
        ("learning.basis_functions=0", "learning.basis_functions must be at least 2"),
        ("task.held=[1, 2, 3]", "task.held must have 2 numbers, not 3"),
        ("task.place_offset=[1]", "task.place_offset must have 3 numbers, not 1"),
        ("retarget.world=[1, 2]", "retarget.world must have 3 numbers, not 2"),
        ("recording.frames=[1]", "recording.frames must have 2 numbers, not 1"),
        ("learning.basis_functions=1", "learning.basis_functions must be at least 2"),
        ("task.grasp_above=0.09", "task.grasp_above is 0.09 m"),
        ("synthetic.takes=0", "synthetic.takes must be at least 1"),
        ("recording.also=[b.csv]", "recording.also goes with recording.file"),
        ("recording.weights=[1, 1]", "recording.weights must have 1 numbers, one for each recording, not 2"),
        ("recording.weights=[-1]", "recording.weights[0] must be positive"),
        ("recording.rate_hz=0", "recording.rate_hz must be positive"),
        ("reality.mass_scale=0", "reality.mass_scale must be positive"),
        ("reality.width_error=.nan", "reality.width_error must be finite"),
        ("reality.push_force=[.inf, 0, 0]", "reality.push_force must be finite"),
        ("reality.push_force=[1]", "reality.push_force must have 3 numbers"),
        ("reality.push_at=-1", "reality.push_at must not be negative"),
        ("reality.push_arm=middle", "choose one of left, right"),
    ],
)
def test_a_value_out_of_range_is_named_with_what_is_allowed(tmp_path, setting, expected):
    message = refused(loaded, tmp_path, "", setting)
    assert any(part in message for part in expected.split("|"))


@pytest.mark.parametrize(
    "scenario",
    [
        Scenario(),
        Scenario(
            name="other: # name",
            recording=RecordingConfig(file="a 'b'.csv", frames=[1, 9], joints={"left_wrist": ["x y"]}, up="-y"),
            task=TaskConfig(held=[1.0, 2.5], duration_scale=1.25, place_offset=[0.1, 0.0, 1e-17]),
            box=BoxConfig(width=0.1 + 0.2),
        ),
    ],
)
def test_a_dumped_scenario_loads_to_itself(tmp_path, scenario):
    assert loaded(tmp_path, DumpScenario(scenario)) == scenario


@given(
    mass=st.floats(1e-6, 1e6), offset=st.lists(st.floats(-9, 9), min_size=3, max_size=3), seed=st.integers(0, 2**31 - 1)
)
def test_numbers_survive_dumping_to_the_last_bit(tmp_path_factory, mass, offset, seed):
    scenario = Scenario(seed=seed, box=BoxConfig(mass=mass), task=TaskConfig(place_offset=offset))
    path = tmp_path_factory.mktemp("dump") / "s.yaml"
    path.write_text(DumpScenario(scenario))
    assert asdict(LoadScenario(path)) == asdict(scenario)


def test_two_scenarios_share_no_list():
    first, second = Scenario(), Scenario()
    first.task.place_offset[0] = 9.0
    assert second.task.place_offset[0] == 0.0


def test_there_is_a_weight_for_every_recording(tmp_path):
    text = "recording: {file: a.csv, also: [b.csv, c.csv]}\n"
    assert "must have 3 numbers" in refused(loaded, tmp_path, text, "recording.weights=[1, 2]")
    assert loaded(tmp_path, text, "recording.weights=[1, 2, 3]").recording.weights == [1.0, 2.0, 3.0]
    assert "must have 2 numbers" in refused(loaded, tmp_path, "synthetic: {takes: 2}", "recording.weights=[1]")


def test_cleaning_is_told_all_that_it_can_be_told():
    config, options = Scenario().recording, CleaningOptions()
    assert vars(config.cleaning) | {"up": config.up} == vars(options)
    assert "unknown key 'recording.cleaning.up'" in refused(ApplySetting, Scenario(), "recording.cleaning.up=z")
    assert "'recording.cleaning' holds keys of its own" in refused(ApplySetting, Scenario(), "recording.cleaning=3")


def test_the_default_passes_its_own_check():
    CheckScenario(Scenario())
    CheckScenario(replace(Scenario(), box=BoxConfig(width=0.2)))
