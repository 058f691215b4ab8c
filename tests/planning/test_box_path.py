"""The carried box and the tables: how far apart, how much room is lacking, and the way up, over and down."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import lsq_linear
from scipy.spatial.transform import Rotation

from drake_blfdmp.demonstration.timing import TaskMotion
from drake_blfdmp.planning.box_path import OVER_S, ROOM, CarriedSlower, LedOver, UpOverDown, lacking_room, table_gaps
from drake_blfdmp.robot.box import BoxParameters, TableParameters

BOX = BoxParameters()
LOW = TableParameters(name="table", top_center=(0.0, 0.40, 0.40), size=(0.3, 0.23))
HIGH = TableParameters(name="shelf", top_center=(0.0, 0.70, 0.55), size=(0.3, 0.23))


def pose(p, turn=(0.0, 0.0, 0.0)):
    x, y, z, w = Rotation.from_euler("zyx", turn).as_quat()
    return np.array([w, x, y, z, *p])


def standing(table):
    return pose([*table.top_center[:2], table.top_center[2] + 0.5 * BOX.height])


@pytest.mark.parametrize(
    ("p", "gap"),
    [([0.0, 0.4, 0.5], 0.0), ([0.0, 0.4, 0.53], 0.03), ([0.36, 0.4, 0.3], 0.06), ([0.0, 0.4, 0.48], -0.02)],
)
def test_gaps_of_boxes_that_are_not_turned_are_plain_differences(p, gap):
    assert table_gaps(pose(p)[None], BOX, LOW)[0] == pytest.approx(gap, abs=1e-12)


@given(
    p=st.tuples(st.floats(-0.6, 0.6), st.floats(-0.2, 1.0), st.floats(0.1, 0.9)),
    turn=st.tuples(*3 * [st.floats(-0.8, 0.8)]),
)
def test_a_gap_is_never_more_than_the_distance_and_tells_apart_from_touching(p, turn):
    """The distance by least squares over both boxes: x = c + R u with u in its half sizes."""
    gap = table_gaps(pose(p, turn)[None], BOX, LOW)[0]
    half, other = 0.5 * BOX.size, np.array([0.15, 0.115, 0.20])
    matrix = np.hstack([Rotation.from_euler("zyx", turn).as_matrix(), -np.eye(3)])
    bound = np.concatenate([half, other])
    distance = np.sqrt(2.0 * lsq_linear(matrix, np.array([0.0, 0.4, 0.2]) - p, (-bound, bound)).cost)
    assert gap <= distance + 1e-6
    assert (gap <= 1e-6) == (distance <= 1e-5) or abs(gap) < 1e-4


def test_a_box_that_rises_off_its_table_has_room_and_one_that_comes_down_on_an_edge_lacks_it():
    ends = np.array([standing(HIGH), standing(LOW)])
    up = ends[0] + np.linspace(0, 0.15, 30)[:, None] * [0, 0, 0, 0, 0, 0, 1]
    over = up[-1] + np.linspace(0, 1, 60)[:, None] * [0, 0, 0, 0, 0, -0.3, 0]
    down = over[-1] + np.linspace(0, 1, 60)[:, None] * [0, 0, 0, 0, 0, 0, ends[1, 6] - over[-1, 6]]
    assert lacking_room(np.concatenate([up, over, down]), BOX, [HIGH, LOW], ends).max() <= 0.0
    slanted = up[-1] + np.linspace(0, 1, 60)[:, None] * (ends[1] - up[-1])
    assert lacking_room(np.concatenate([up, slanted]), BOX, [HIGH, LOW], ends).max() > 0.03


def test_a_box_that_is_dragged_along_its_table_lacks_room():
    ends = np.array([standing(LOW), pose([0.1, 0.4, 0.5])])
    dragged = ends[0] + np.linspace(0, 1, 50)[:, None] * (ends[1] - ends[0])
    assert 0.0 < lacking_room(dragged, BOX, [LOW], ends).max() < ROOM
    assert lacking_room(ends, BOX, [LOW], ends).max() <= 0.0


@pytest.fixture
def slanted():
    """Hands that go down on a slant within 1.5 s."""
    t = np.arange(601) / 100.0
    u = np.clip((t - 2.0) / 1.5, 0.0, 1.0)
    share = u**3 * (10.0 - 15.0 * u + 6.0 * u**2)
    x = np.zeros((601, 6, 3))
    x[:, 2, 0], x[:, 5, 0] = -0.15, 0.15
    x += share[:, None, None] * [0.05, -0.3, -0.2]
    events = {"grasp": 1.0, "grasp_end": 2.0, "release": 3.5, "release_end": 4.5}
    return TaskMotion(t=t, x=x, recorded=t, events=events)


def test_a_slower_carry_is_the_same_path_in_more_time(slanted):
    slow = CarriedSlower(slanted, 3.0)
    assert slow.events == {"grasp": 1.0, "grasp_end": 2.0, "release": 6.5, "release_end": 7.5}
    assert slow.t[-1] == pytest.approx(9.0)
    np.testing.assert_allclose(slow.x[200:651:3], slanted.x[200:351], atol=1e-9)
    np.testing.assert_allclose(slow.x[:200], slanted.x[:200], atol=1e-12)
    np.testing.assert_allclose(slow.x[650:], slanted.x[350:], atol=1e-9)


def test_over_happens_within_the_window_and_heights_stay(slanted):
    moved = UpOverDown(slanted, (2.4, 2.9))
    factor = OVER_S / 0.5
    begin, end = 2.0 + factor * 0.4, 2.0 + factor * 0.9
    before, after = (moved.t >= 2.0) & (moved.t <= begin), (moved.t >= end) & (moved.t <= moved.events["release"])
    np.testing.assert_allclose(moved.x[before][..., 1], 0.0, atol=1e-9)
    np.testing.assert_allclose(moved.x[after][..., 1], -0.3, atol=1e-9)
    np.testing.assert_allclose(moved.x[..., 2], CarriedSlower(slanted, factor).x[..., 2], atol=1e-12)
    assert np.abs(np.diff(moved.x, 2, axis=0)).max() * 100.0**2 < 1.0  # No jump of speed.


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_way_that_gets_above_its_ends_nowhere_is_led_over_on_a_level_of_its_own(slanted, sign):
    x = slanted.x * [1.0, 1.0, sign]  # Straight up on to a shelf, or down from one.
    moved, (begin, end) = LedOver(replace(slanted, x=x), 0.04)
    assert (begin, end) == pytest.approx((2.5, 3.0))
    level = (moved.t >= begin) & (moved.t <= end)
    np.testing.assert_allclose(moved.x[level][..., 2], max(-0.2 * sign, 0.0) + 0.04, atol=1e-9)
    outside = (moved.t <= 2.0) | (moved.t >= 3.5)
    np.testing.assert_allclose(moved.x[outside], x[outside], atol=1e-12)
    np.testing.assert_array_equal(moved.x[..., :2], x[..., :2])
    assert np.abs(np.diff(moved.x, 2, axis=0)).max() * 100.0**2 < 8.0  # No jump of speed.
