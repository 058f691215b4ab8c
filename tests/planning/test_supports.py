"""Tables: under both ends, never over each other, out of the way of what passes above."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drake_blfdmp.planning.supports import GAP, LEVEL_WITHIN, RIM, Ends, MakeSupports, ShiftForSupports, half_extent_y
from drake_blfdmp.robot.box import BoxParameters

boxes = st.builds(BoxParameters, width=st.floats(0.1, 0.5), depth=st.floats(0.08, 0.4), height=st.floats(0.1, 0.4))
yaws = st.tuples(st.floats(-np.pi / 4, np.pi / 4), st.floats(-np.pi / 4, np.pi / 4))
positions = st.tuples(st.floats(-0.3, 0.3), st.floats(0.2, 0.8), st.floats(0.5, 1.2)).map(np.array)


@st.composite
def two_levels(draw):
    """Ends whose heights differ enough for two tables, the box, its yaws."""
    grasp, release = draw(positions), draw(positions)
    step = draw(st.floats(LEVEL_WITHIN, 0.5)) * draw(st.sampled_from([-1.0, 1.0]))
    release[2] = grasp[2] + step
    top = max(grasp[2], release[2]) + draw(st.floats(0.0, 0.3))
    return Ends(grasp, release, top), draw(boxes), draw(yaws)


def corners(box, pose):
    """The box's outline on the ground, by rotating its corners: (4, 2)."""
    c, s = np.cos(pose[3]), np.sin(pose[3])
    flat = 0.5 * np.array([[a * box.width, b * box.depth] for a in (-1, 1) for b in (-1, 1)])
    return flat @ np.array([[c, s], [-s, c]]) + pose[:2]


def edges(table):
    middle, half = np.array(table.top_center[:2]), 0.5 * np.array(table.size)
    return middle - half, middle + half


def supported(box, table, pose):
    low, high = edges(table)
    outline = corners(box, pose)
    return np.all(outline >= low - 1e-9) and np.all(outline <= high + 1e-9)


@given(box=boxes, yaw=st.floats(-np.pi, np.pi))
def test_the_extent_is_that_of_the_rotated_corners(box, yaw):
    outline = corners(box, np.array([0.0, 0.0, 0.0, yaw]))
    assert half_extent_y(box, yaw) == pytest.approx(outline[:, 1].max(), abs=1e-12)


@given(box=boxes, yaws=yaws, start=positions, goal=positions)
def test_one_table_carries_the_box_at_both_ends(box, yaws, start, goal):
    goal[2] = start[2]
    ends = [np.append(start, yaws[0]), np.append(goal, yaws[1])]
    (table,) = MakeSupports(*ends, box, True)
    for end in ends:
        assert supported(box, table, end)
        assert table.top_center[2] == pytest.approx(end[2] - 0.5 * box.height)


@given(case=two_levels())
def test_two_tables_carry_one_end_each_and_never_overlap_after_the_shift(case):
    ends, box, yaws = case
    shift = ShiftForSupports(ends, box, yaws, False)
    poses = [np.append(ends.grasp, yaws[0]), np.append(ends.release + shift.release, yaws[1])]
    tables = MakeSupports(*poses, box, False)
    assert len({table.name for table in tables}) == 2
    for table, pose in zip(tables, poses, strict=True):
        assert supported(box, table, pose)
        assert table.top_center[2] == pytest.approx(pose[2] - 0.5 * box.height)
    (low_a, high_a), (low_b, high_b) = (edges(table) for table in tables)
    gap = max(low_b[1] - high_a[1], low_a[1] - high_b[1])
    assert gap >= GAP - 1e-9


@given(case=two_levels())
def test_the_higher_table_is_the_farther_one_and_nothing_moves_more_than_needed(case):
    ends, box, yaws = case
    shift = ShiftForSupports(ends, box, yaws, False).release
    distance = ends.release[1] + shift[1] - ends.grasp[1]
    upward = ends.release[2] > ends.grasp[2]
    needed = half_extent_y(box, yaws[0]) + half_extent_y(box, yaws[1]) + RIM + GAP
    assert (distance if upward else -distance) >= needed - 1e-9
    assert shift[0] == shift[2] == 0.0
    if shift[1]:
        assert (shift[1] > 0) == upward
        assert abs(distance) == pytest.approx(needed)


@given(case=two_levels())
def test_the_carry_passes_above_the_higher_table(case):
    ends, box, yaws = case
    shift = ShiftForSupports(ends, box, yaws, False)
    higher = max(ends.grasp[2], ends.release[2])
    assert shift.raise_by >= 0.0
    assert ends.top + shift.raise_by >= higher + 2 * GAP - 1e-9
    if ends.top >= higher + 2 * GAP:
        assert shift.raise_by == 0.0


@given(box=boxes, yaws=yaws, grasp=positions, release=positions, rise=st.floats(-0.06, 0.06))
def test_ends_that_share_a_table_come_to_the_same_height(box, yaws, grasp, release, rise):
    release[2] = grasp[2] + rise
    shift = ShiftForSupports(Ends(grasp, release, grasp[2] + 0.2), box, yaws, True)
    assert (release + shift.release)[2] == pytest.approx(grasp[2], abs=1e-12)
    np.testing.assert_array_equal(shift.release[:2], 0.0)
    assert shift.raise_by == 0.0


def test_sentences_say_how_far_and_are_empty_when_nothing_changes():
    box = BoxParameters()

    def sentence(release, top=1.3, same_level=False):
        ends = Ends(np.array([0.0, 0.45, 0.8]), np.array(release), top)
        return ShiftForSupports(ends, box, (0.0, 0.0), same_level).sentence

    assert sentence([0.0, 0.45, 0.83], same_level=True) == (
        "release moved by -30 mm in height, on to the table of the grasp"
    )
    assert sentence([0.2, 0.45, 0.8002], same_level=True) == ""
    assert sentence([0.0, 0.80, 1.0]) == ""
    assert sentence([0.0, 0.50, 1.0]) == "release moved 200 mm forward to a table of its own"
    assert sentence([0.0, 0.40, 0.6]) == "release moved 200 mm back to a table of its own"
    assert "carry raised by 30 mm" in sentence([0.0, 0.80, 1.0], top=1.01)
