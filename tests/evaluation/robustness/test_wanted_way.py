"""What a refused carry asks for, and what stands around it while it is looked at again."""

from dataclasses import replace

import numpy as np
import pytest

from drake_blfdmp.evaluation.robustness.wanted_way import SAMPLES, SUNK, clear_of, every_other, tables_of, wanted_way
from drake_blfdmp.planning.scenario import Scenario
from drake_blfdmp.planning.sources import LoadSource
from drake_blfdmp.robot.box import BoxParameters
from drake_blfdmp.robot.plant import HOME

BOX = BoxParameters(width=0.3, depth=0.2, height=0.2)
NO_YAW = np.zeros(3)
STILL = np.array([HOME])
FAR = np.array([[0.0, 0.45, 0.6], [0.0, 0.7, 0.9], [0.0, 0.95, 0.8]])
"""A way from a table up to a shelf that leaves both room."""


def moved():
    scenario = Scenario()
    return replace(scenario, task=replace(scenario.task, place_offset=[0.1, 0.0, 0.0]))


def test_the_way_is_the_persons_and_the_boxs():
    scenario = moved()
    way, middle = wanted_way(scenario, LoadSource(scenario))
    assert way.level and len(way.apart) == len(way.share) == SAMPLES
    assert way.apart[0][0] < 0.30 < way.apart[0][1] and len(way.apart[1]) == 1
    np.testing.assert_allclose(way.shift, [0.1, 0.0, 0.0])
    assert way.share[0] == 0.0 and way.share[-1] == pytest.approx(1.0) and np.all(np.diff(way.share) >= 0)
    assert way.way[:, 2].max() > 0.15
    assert 0.1 < middle[1] < 0.6 and middle[2] < 0.0  # In front of the shoulders and below them.
    half = every_other(way)
    assert len(half.apart) == len(half.yaw) == len(half.way) == len(half.share) == (SAMPLES + 1) // 2
    np.testing.assert_array_equal(half.way[[0, -1]], way.way[[0, -1]])


def test_one_table_or_two_stand_under_the_ends():
    scenario = Scenario()
    [table] = tables_of(scenario, BOX, True, FAR, NO_YAW)
    under = scenario.task.grasp_above + 0.5 * BOX.height
    assert table.top_center[2] == pytest.approx(0.6 - under) and table.top_center[1] == pytest.approx(0.7)
    assert table.size[1] > 0.7
    low, high = tables_of(scenario, BOX, False, FAR, NO_YAW)
    assert low.top_center[1:] == pytest.approx((0.45, 0.6 - under))
    assert high.top_center[1:] == pytest.approx((0.95, 0.8 - under))


def test_where_two_tables_have_no_room_none_is_known():
    """The planner moves the release then."""
    near = FAR.copy()
    near[:, 1] = [0.45, 0.5, 0.55]
    assert tables_of(Scenario(), BOX, False, near, NO_YAW) == []


@pytest.mark.parametrize("level", [True, False])
@pytest.mark.parametrize(("begin", "clear"), [((-0.2, 0.0, 0.75), False), ((0.0, 0.45, 0.6), True)])
def test_tables_stand_all_along(level, begin, clear):
    """One under the first end may be where the left arm is, its base; it then stands there at the other end, too."""
    scenario = Scenario()
    over = np.array([begin, [0.0, 0.7, 0.9], [0.0, 1.4, begin[2] if level else 0.95]])
    asked = clear_of(scenario, LoadSource(scenario), level, over, NO_YAW)
    assert asked is not None
    found = [asked(k, STILL, STILL) for k in (1, 2)]
    assert [one.shape for one in found] == [(1, 1)] * 2
    assert [bool(one[0, 0]) for one in found] == [clear, clear]


def test_the_box_counts_all_along():
    scenario = Scenario()
    into = FAR.copy()
    into[1] = [-0.2, 0.0, 0.9]  # Where the left arm stands.
    clear = clear_of(scenario, LoadSource(scenario), False, into, NO_YAW)
    assert clear is not None
    assert [bool(clear(k, STILL, STILL)[0, 0]) for k in range(3)] == [True, False, True]


@pytest.mark.parametrize("level", [True, False])
def test_a_box_that_is_led_through_a_table_is_on_no_way(level):
    """A little deeper than it stands it may be: the planner leads it higher."""
    scenario = Scenario()
    source, way = LoadSource(scenario), FAR.copy()
    way[1] = way[2] - [0.0, 0.1, 0.0]
    for sunk, there in ((0.5 * SUNK, True), (1.5 * SUNK, False)):
        way[1, 2] = way[2, 2] - sunk
        if level:
            way[:, 2] = 0.6 - sunk * np.array([0, 1, 0])
        assert (clear_of(scenario, source, level, way, NO_YAW) is not None) is there
