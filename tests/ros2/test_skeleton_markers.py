"""The skeleton's markers, decoded by an independent implementation."""

import numpy as np
import pytest
from rosbags.typesys import Stores, get_typestore

from drake_blfdmp.link_state import COLOURS, INSIDE, NEAR, OUTSIDE, rgb
from drake_blfdmp.ros2.messages import MARKERS
from drake_blfdmp.ros2.skeleton_markers import skeleton_numbers, skeleton_template
from drake_blfdmp.skeleton import HANDS, LINKS, POINTS

HUMBLE = get_typestore(Stores.ROS2_HUMBLE)
SPHERE, LINE_LIST = 2, 5


def decode(t_ns, points, margins):
    template, numbers = skeleton_template("person"), skeleton_numbers(np.concatenate([points.ravel(), margins])[None])
    message = template.encode(t_ns, *np.split(numbers[0], [template.float64_count]))
    return HUMBLE.deserialize_cdr(message, MARKERS).markers


def ends(marker):
    return np.array([[p.x, p.y, p.z] for p in marker.points]).reshape(-1, 2, 3)


def colours(marker):
    return np.array([[c.r, c.g, c.b, c.a] for c in marker.colors]).reshape(-1, 2, 4)


@pytest.fixture
def points():
    return np.random.default_rng(3).uniform(-1.0, 2.0, (6, 3))


def test_six_spheres_and_two_lists_of_lines_at_the_points(points):
    markers = decode(1_250_000_000, points, np.full(5, 0.5))
    assert [marker.type for marker in markers] == [SPHERE] * 6 + [LINE_LIST] * 2
    assert [marker.ns for marker in markers] == [*POINTS, "bones", "hands"]
    for marker in markers:
        assert marker.header.frame_id == "person" and marker.action == 0
        assert (marker.header.stamp.sec, marker.header.stamp.nanosec) == (1, 250_000_000)
        assert marker.pose.orientation.w == 1.0 and marker.scale.x > 0
    for marker, point in zip(markers[:6], points, strict=True):
        centre = marker.pose.position
        np.testing.assert_allclose([centre.x, centre.y, centre.z], point, atol=1e-6)
    bones = [link for k, link in enumerate(LINKS) if k != HANDS]
    for drawn, link in zip(ends(markers[6]), bones, strict=True):
        np.testing.assert_allclose(drawn, points[[link.a, link.b]], atol=1e-6)
    np.testing.assert_allclose(ends(markers[7])[0], points[[LINKS[HANDS].a, LINKS[HANDS].b]], atol=1e-6)
    assert markers[7].scale.x < markers[6].scale.x


def test_every_link_has_the_colour_of_its_margin(points):
    *_, bones, hands = decode(0, points, np.array([0.5, 0.1, -0.1, np.nan, 0.2]))
    expected = [INSIDE, NEAR, OUTSIDE, INSIDE]
    for drawn, state in zip(colours(bones), expected, strict=True):
        np.testing.assert_allclose(drawn, [(*rgb(COLOURS[state]), 1.0)] * 2, atol=1e-6)
    np.testing.assert_allclose(colours(hands)[0], [(*rgb(COLOURS[OUTSIDE]), 1.0)] * 2, atol=1e-6)


def test_many_instants_are_those_of_each():
    rows = np.random.default_rng(4).uniform(-1.0, 1.0, (7, 23))
    np.testing.assert_array_equal(skeleton_numbers(rows), np.vstack([skeleton_numbers(row[None]) for row in rows]))
