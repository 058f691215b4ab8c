"""Random tasks: the same ones always, inside their ranges, and scenarios that say what they say."""

from dataclasses import fields

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drake_blfdmp.evaluation.robustness.tasks import RandomTask, Ranges, draw_task, task_scenario
from drake_blfdmp.planning.scenario import ApplySetting, CheckScenario, DumpScenario, LoadScenario, Scenario
from drake_blfdmp.planning.scenario_sections import RobustnessConfig

RANGES = Ranges()


@given(seed=st.integers(0, 2**40), index=st.integers(0, 10**6))
@settings(max_examples=200, deadline=None)
def test_every_task_lies_in_its_ranges(seed, index):
    task = draw_task(seed, index)
    for name in ("width_m", "mass_kg", "friction", "duration"):
        low, high = getattr(RANGES, name)
        assert low <= getattr(task, name) <= high
    for offset in (task.take_offset_m, task.place_offset_m):
        assert np.all(np.abs(offset) <= 0.5 * np.array(RANGES.region_m))
    for scale in (task.mass_scale, task.friction_scale):
        assert abs(scale - 1.0) <= RANGES.error
    assert task.sensor in RANGES.sensors and task.recording_seed >= 0


@given(seed=st.integers(0, 1000), indices=st.lists(st.integers(0, 1000), min_size=1, max_size=8))
@settings(max_examples=50, deadline=None)
def test_a_task_does_not_depend_on_the_others(seed, indices):
    assert [draw_task(seed, i) for i in indices] == [draw_task(seed, i) for i in reversed(indices)][::-1]


def test_a_task_is_for_ever_the_same():
    """A result of today can be made again tomorrow."""
    task = draw_task(0, 0)
    assert (task.recording_seed, task.sensor) == (1826701615, "kinect_v2")
    assert task.width_m == pytest.approx(0.3458993121967997)
    assert task.friction_scale == pytest.approx(1.1429617106350278)


def test_many_tasks_fill_their_ranges_and_are_all_different():
    tasks = [draw_task(3, i) for i in range(2000)]
    for name in ("width_m", "mass_kg", "friction", "duration"):
        low, high = getattr(RANGES, name)
        drawn = (np.array([getattr(task, name) for task in tasks]) - low) / (high - low)
        assert drawn.min() < 0.01 and drawn.max() > 0.99 and drawn.mean() == pytest.approx(0.5, abs=0.03)
    numbers = np.array(
        [
            np.hstack([getattr(task, f.name) for f in fields(RandomTask) if f.name not in ("seed", "index", "sensor")])
            for task in tasks
        ]
    )
    correlation = np.corrcoef(numbers.T) - np.eye(numbers.shape[1])
    assert np.abs(correlation).max() < 0.1
    assert len({task.recording_seed for task in tasks}) == len(tasks)
    share = {sensor: np.mean([task.sensor == sensor for task in tasks]) for sensor in RANGES.sensors}
    assert all(value == pytest.approx(1 / len(share), abs=0.05) for value in share.values())
    assert draw_task(3, 1) != draw_task(4, 1)


def test_the_scenario_says_what_the_task_says_and_can_be_loaded_again(tmp_path):
    base = ApplySetting(ApplySetting(Scenario(), "timing.speed=2"), "robustness.tasks.default=1000")
    task = draw_task(1, 7)
    scenario = task_scenario(base, task, "gams")
    assert scenario.law == "gams" and scenario.seed == task.recording_seed and scenario.name == "robustness-1-0007-gams"
    assert scenario.timing.speed == pytest.approx(2.0 / task.duration)
    assert scenario.box.mass == task.mass_kg and scenario.reality.mass_scale == task.mass_scale
    assert scenario.box.width is None and scenario.synthetic.box_width == task.width_m
    assert scenario.task.take_offset == list(task.take_offset_m)
    assert scenario.task.place_offset == list(task.place_offset_m)
    # How many tasks are tried is not part of any.
    assert scenario.robustness == RobustnessConfig()
    CheckScenario(scenario)
    path = tmp_path / "task.yaml"
    path.write_text(DumpScenario(scenario), encoding="utf-8")
    assert LoadScenario(path) == scenario
    assert base.timing.speed == 2.0 and base.task.place_offset == [0.0, 0.0, 0.0]
