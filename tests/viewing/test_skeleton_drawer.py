import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from pydrake.math import RotationMatrix
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource

from drake_blfdmp.errors import BlfDmpError
from drake_blfdmp.skeleton import HANDS, LINKS, POINTS
from drake_blfdmp.viewing import person_shape
from drake_blfdmp.viewing.skeleton_drawer import (
    INSIDE,
    NEAR,
    OUTSIDE,
    SkeletonDrawer,
    SkeletonGhost,
    classify,
    rod_pose,
)

STATES = (INSIDE, NEAR, OUTSIDE)
POSE = np.array(
    [[-0.18, 0, 1.4], [-0.3, 0.05, 1.2], [-0.15, 0.3, 1.1], [0.18, 0, 1.4], [0.3, 0.05, 1.2], [0.15, 0.3, 1.1]]
)


class Tree:
    """Stands where Meshcat does and keeps the last of every transform and property."""

    def __init__(self):
        self.objects, self.poses, self.properties, self.times = [], {}, {}, []

    def SetObject(self, path, shape, rgba):
        self.objects.append(path)

    def SetTriangleMesh(self, path, vertices, faces, rgba, side):
        self.objects.append(path)

    def SetTransform(self, path, pose, time_in_recording=None):
        self.poses[path] = pose
        self.times.append(time_in_recording)

    def SetProperty(self, path, name, value, time_in_recording=None):
        self.properties[path, name] = value


def visible(tree, link):
    return [state for state in STATES if tree.properties[f"/skeleton/{link}/rods/{state}", "visible"]]


def test_states_by_margin():
    assert classify([0.5, 0.2, 0.19, 0.0, -1e-9, np.nan, np.inf], near=0.2) == [
        INSIDE,
        INSIDE,
        NEAR,
        NEAR,
        OUTSIDE,
        OUTSIDE,
        INSIDE,
    ]


coordinates = arrays(float, 3, elements=st.floats(-3.0, 3.0))


@given(coordinates, coordinates)
def test_a_rod_reaches_from_start_to_end(start, end):
    pose, length = rod_pose(start, end)
    half = np.array([0.0, 0.0, length / 2])
    np.testing.assert_allclose(pose.multiply(-half), start, atol=2e-6)
    np.testing.assert_allclose(pose.multiply(half), end, atol=2e-6)
    assert length > 0


@given(arrays(float, (6, 3), elements=st.floats(-2.0, 2.0)), arrays(float, 5, elements=st.floats(-1.0, 1.0)))
def test_draws_every_point_and_link_once_and_makes_nothing_new(points, margin):
    tree = Tree()
    ghost = SkeletonGhost(tree, near_margin=0.1)
    made = list(tree.objects)
    ghost.draw(points.ravel(), margin, 0.5)
    assert tree.objects == made, "objects made while recording are not recorded"
    assert set(tree.times) == {0.5}
    for name, point in zip(POINTS, points, strict=True):
        np.testing.assert_array_equal(tree.poses[f"/skeleton/{name}"].translation(), point)
    for link, state in zip(LINKS, classify(margin, 0.1), strict=True):
        assert visible(tree, link.name) == [state]
        scale = tree.properties[f"/skeleton/{link.name}/rods", "scale"]
        length = np.linalg.norm(points[link.b] - points[link.a])
        np.testing.assert_allclose(scale, [1.0, 1.0, max(length, 1e-6)], rtol=1e-9)


def test_the_person_stands_below_the_shoulders_turned_as_they_are_with_feet_on_the_floor():
    tree = Tree()
    ghost = SkeletonGhost(tree)
    turn = RotationMatrix.MakeZRotation(0.7).matrix()
    ghost.draw(POSE @ turn.T + [0.5, -0.2, 0.0], np.ones(5))
    for part in ("body", "legs"):
        np.testing.assert_allclose(tree.poses[f"/skeleton/{part}"].rotation().matrix(), turn, atol=1e-12)
        np.testing.assert_allclose(tree.poses[f"/skeleton/{part}"].translation()[:2], [0.5, -0.2], atol=1e-12)
    assert tree.poses["/skeleton/body"].translation()[2] == pytest.approx(1.4)
    assert tree.poses["/skeleton/legs"].translation()[2] == 0.0
    assert tree.properties["/skeleton/legs", "visible"]
    reach = tree.properties["/skeleton/legs/shape", "scale"][2] * person_shape.LEG
    assert reach == pytest.approx(1.4 - person_shape.SHOULDER_ABOVE_HIP), "legs end elsewhere than at the hips"
    # A recording whose floor is not at z = 0 has no legs rather than stilts.
    ghost.draw(POSE + np.array([0.0, 0.0, 2.0]), np.ones(5))
    assert not tree.properties["/skeleton/legs", "visible"]


def test_an_unseen_point_leaves_the_last_skeleton():
    tree = Tree()
    ghost = SkeletonGhost(tree)
    ghost.draw(POSE, np.ones(5))
    unseen = POSE + 1.0
    unseen[3, 1] = np.nan
    ghost.draw(unseen, np.ones(5))
    np.testing.assert_array_equal(tree.poses["/skeleton/left_elbow"].translation(), POSE[1])


def test_is_hidden_and_shown_as_a_whole():
    tree = Tree()
    ghost = SkeletonGhost(tree, path="/person/")
    ghost.set_visible(False)
    assert tree.properties["/person", "visible"] is False
    assert all(path.startswith("/person/") and "//" not in path for path in tree.objects)


def simulated(margin, bands=None, **drawer):
    tree, builder = Tree(), DiagramBuilder()
    points = builder.AddSystem(ConstantVectorSource(POSE.ravel()))
    port = None if margin is None else builder.AddSystem(ConstantVectorSource(margin)).get_output_port()
    if bands is not None:
        drawer["bands_port"] = builder.AddSystem(ConstantVectorSource(bands)).get_output_port()
    SkeletonDrawer.AddToBuilder(builder, points.get_output_port(), SkeletonGhost(tree), margin_port=port, **drawer)
    simulator = Simulator(builder.Build())
    simulator.Initialize()
    tree.times.clear()
    simulator.AdvanceTo(1.0)
    return tree


def test_the_system_draws_at_its_period_what_its_ports_say():
    tree = simulated([0.5, 0.1, -0.1, 0.5, 0.5], publish_period=0.25)
    assert [time for time in sorted(set(tree.times)) if time > 0] == [0.25, 0.5, 0.75, 1.0]
    assert [visible(tree, link.name) for link in LINKS] == [[INSIDE], [NEAR], [OUTSIDE], [INSIDE], [INSIDE]]


def test_the_hands_band_is_drawn_where_bands_are_connected():
    bands = np.zeros((6, 5))
    bands[:2, HANDS] = 0.28, 0.36
    tree = simulated(None, bands.ravel())
    assert tree.properties["/skeleton/band", "visible"]
    for side, sign in (("left", -1.0), ("right", 1.0)):
        assert tree.poses[f"/skeleton/band/{side}"].translation()[2] == pytest.approx(sign * 0.16)
        assert tree.properties[f"/skeleton/band/{side}/sleeve", "scale"][2] == pytest.approx(0.04)
    assert not simulated(None).properties["/skeleton/band", "visible"]


def test_without_margins_all_links_count_as_inside():
    tree = simulated(None)
    assert [visible(tree, link.name) for link in LINKS] == [[INSIDE]] * 5


@pytest.mark.parametrize("bad", [{"radius": 0.0}, {"opacity": 1.5}, {"near_margin": -0.1}, {"radius": float("nan")}])
def test_numbers_out_of_range_are_refused(bad):
    with pytest.raises(BlfDmpError, match=r"^skeleton /skeleton: [^\n]*change the one that is not$"):
        SkeletonGhost(Tree(), **bad)
    with pytest.raises(BlfDmpError, match="publish_period"):
        SkeletonDrawer(SkeletonGhost(Tree()), publish_period=0.0)
