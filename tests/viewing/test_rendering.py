"""Rendering: shapes against closed forms, the camera against hand-computed points, and who hides whom."""

import numpy as np
import pytest
from pydrake.geometry import Box, Capsule, Convex, Cylinder, Ellipsoid, HalfSpace, Sphere

from drake_blfdmp.errors import BlfDmpError
from drake_blfdmp.viewing import rendering
from drake_blfdmp.viewing.planned_scene import shape_solid
from drake_blfdmp.viewing.solids import Solid, posed, solid_triangles

N = rendering.AROUND
FRONT = rendering.Camera(np.array([0.0, 5.0, 0.0]), np.zeros(3))  # Looks along -y: x is to the left.


def corners_of(shape):
    return solid_triangles(shape_solid(shape, (0.5, 0.5, 0.5))).corners


def area(corners):
    return 0.5 * np.linalg.norm(rendering.normals(corners), axis=-1).sum()


def volume(corners):
    """By the divergence theorem: positive where all normals point outward."""
    return np.einsum("ti,ti->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6.0


def square(y, colour, size=1.0, middle=(0.0, 0.0)):
    """A square that faces +y, at that y."""
    x, z = middle
    a, b, c, d = ([x + size * u, y, z + size * v] for u, v in ((1, -1), (-1, -1), (-1, 1), (1, 1)))
    return rendering.coloured(np.array([[a, b, c], [a, c, d]]), colour)


SHAPES = {
    "sphere": (Sphere(0.3), 4 * np.pi * 0.09, 4 / 3 * np.pi * 0.027),
    "cylinder": (Cylinder(0.2, 0.5), 2 * np.pi * 0.2 * (0.5 + 0.2), np.pi * 0.04 * 0.5),
    "capsule": (Capsule(0.1, 0.4), 2 * np.pi * 0.1 * 0.4 + 4 * np.pi * 0.01, np.pi * 0.01 * 0.4 + 4 / 3 * np.pi * 1e-3),
    "box": (Box(0.3, 0.2, 0.1), 2 * (0.06 + 0.03 + 0.02), 0.006),
    # A spheroid, whose area has a closed form: a = b > c.
    "ellipsoid": (
        Ellipsoid(0.3, 0.3, 0.18),
        2 * np.pi * 0.09 * (1 + (1 - 0.64) / 0.8 * np.arctanh(0.8)),
        4 / 3 * np.pi * 0.09 * 0.18,
    ),
}


@pytest.mark.parametrize("name", SHAPES)
def test_area_and_volume_are_the_shapes(name, monkeypatch):
    """Corners lie on the surface, so a polyhedron has less of both, and four times as nearly with half the step."""
    shape, *expected = SHAPES[name]
    short = []
    for around in (N, 2 * N, 8 * N):
        monkeypatch.setattr(rendering, "AROUND", around)
        corners = corners_of(shape)
        short.append(1.0 - np.array([area(corners), volume(corners)]) / expected)
    if name == "box":
        np.testing.assert_allclose(short, 0.0, atol=1e-12)
        return
    assert np.all(short[0] > 0)
    assert np.all(short[0] < 0.04)
    # The polar rings are AROUND // 2 + 1, so their step is not quite halved.
    np.testing.assert_allclose(short[0] / short[1], 4.0, rtol=0.1)
    np.testing.assert_allclose(short[2], 0.0, atol=1e-3)


@pytest.mark.parametrize("name", SHAPES)
def test_shapes_are_closed_and_every_triangle_faces_outward(name):
    corners = corners_of(SHAPES[name][0])
    np.testing.assert_allclose(rendering.normals(corners).sum(axis=0), 0.0, atol=1e-12)
    # All are convex and hold the origin.
    assert np.all(np.einsum("ti,ti->t", rendering.normals(corners), corners.mean(axis=1)) > 0)


def test_a_cylinder_is_exactly_the_prism_of_its_segments():
    corners = rendering.cylinder_corners(0.2, 0.5)
    base = 0.5 * N * 0.04 * np.sin(2 * np.pi / N)
    assert volume(corners) == pytest.approx(0.5 * base, rel=1e-12)
    assert area(corners) == pytest.approx(2 * base + N * 2 * 0.2 * np.sin(np.pi / N) * 0.5, rel=1e-12)


def test_a_convex_shape_is_its_hull():
    tetrahedron = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    corners = corners_of(Convex(points=tetrahedron.T, label="tetrahedron"))
    assert volume(corners) == pytest.approx(1 / 6)
    assert area(corners) == pytest.approx(1.5 + 0.5 * np.sqrt(3))


def test_what_cannot_be_drawn_is_named():
    with pytest.raises(BlfDmpError, match="a HalfSpace cannot be drawn"):
        corners_of(HalfSpace())


@pytest.mark.parametrize("solid", [Solid("cone", (0.1, 0.2), (1, 1, 1)), Solid("box", (0.1, 0.2), (1, 1, 1))])
def test_a_solid_of_no_kind_or_of_another_size_is_named(solid):
    with pytest.raises(BlfDmpError, match=f"a {solid.kind} of size"):
        solid_triangles(solid)


def test_solids_stand_where_their_poses_are():
    """A quarter turn about z, then up by 2 m and forward by 1 m; the other stays."""
    turn = np.array([[0.0, -1.0, 0.0, 0.0], [1.0, 0.0, 0.0, 1.0], [0.0, 0.0, 1.0, 2.0]])
    shapes = [
        solid_triangles(Solid("box", (0.4, 0.2, 0.6), (1, 0, 0))),
        solid_triangles(Solid("ball", (1.0,), (0, 0, 1))),
    ]
    whole = posed(shapes, np.array([turn, np.eye(3, 4)]))
    box, ball = whole.corners[:12].reshape(-1, 3), whole.corners[12:]
    np.testing.assert_allclose([box.min(axis=0), box.max(axis=0)], [[-0.1, 0.8, 1.7], [0.1, 1.2, 2.3]])
    np.testing.assert_array_equal(ball, shapes[1].corners)
    np.testing.assert_array_equal(whole.colours, np.repeat([[1, 0, 0], [0, 0, 1]], [12, len(ball)], axis=0))


def test_the_camera_projects_as_by_hand():
    place, depth = FRONT.project(np.array([[0.0, 0, 0], [1, 0, 0], [0, 0, 1], [1, 3, 1], [0, -5, 2]]))
    np.testing.assert_allclose(place, [[0, 0], [-0.2, 0], [0, 0.2], [-0.5, 0.5], [0, 0.2]], atol=1e-15)
    np.testing.assert_allclose(depth, [5, 5, 5, 2, 10])


def test_a_tilted_camera_projects_as_by_hand():
    """From (3, 0, 4) down to the origin: up in the picture is (-4, 0, 3)/5, to the right is y."""
    camera = rendering.Camera(np.array([3.0, 0, 4]), np.zeros(3))
    place, depth = camera.project(np.array([[0.0, 0, 0], [0, 1, 0], [0, 0, 1]]))
    np.testing.assert_allclose(place, [[0, 0], [0.2, 0], [0, 0.6 / 4.2]], atol=1e-15)
    np.testing.assert_allclose(depth, [5, 5, 4.2])


@pytest.mark.parametrize("order", [1, -1])
def test_the_nearer_hides_the_farther_whatever_the_order(order):
    far, near = square(0.0, (1, 0, 0)), square(0.001, (0, 0, 1), size=0.5)
    image = rendering.picture(rendering.joined(*(far, near)[::order]), FRONT, (-0.15, 0.15, -0.15, 0.15), 120)
    assert image.shape == (120, 120, 4)
    np.testing.assert_array_equal(image[..., 3], 1.0)  # A large face has no holes.
    bright = rendering.lit(near)[0, 2]
    np.testing.assert_allclose(image[60, 60], [0, 0, bright, 1], atol=1e-12)
    np.testing.assert_allclose(image[8, 8], [bright, 0, 0, 1], atol=1e-12)
    # A square of half side 0.5 at a depth of 4.999 covers +-0.100 of +-0.15.
    assert np.sqrt(image[..., 2].sum() / bright) == pytest.approx(0.2 / 0.3 * 120, abs=1.0)  # Pixels.


def test_intersecting_shapes_hide_each_other_where_they_should():
    """Two squares that cross, one leaning: the upper half is one's, the lower the other's; no order does that."""
    upright, leaning = square(0.0, (1, 0, 0)), square(0.0, (0, 0, 1))
    leaning.corners[..., 1] = 0.5 * leaning.corners[..., 2]
    image = rendering.picture(rendering.joined(upright, leaning), FRONT, (-0.1, 0.1, -0.1, 0.1), 20)
    assert np.all(image[:9, :, 2] > 0)
    assert np.all(image[:9, :, 0] == 0)
    assert np.all(image[11:, :, 0] > 0)
    assert np.all(image[11:, :, 2] == 0)


def test_only_what_is_there_is_opaque_and_it_is_where_it_should_be():
    """Right of the picture is -x for this camera, the first row is the top."""
    image = rendering.picture(square(0.0, "white", 0.245, (-0.5, 0.5)), FRONT, (-0.2, 0.2, -0.2, 0.2), 40)
    rows, columns = np.nonzero(image[..., 3])
    # x in -0.745..-0.255 is 0.051..0.149 to the right, z in 0.255..0.745 as much up; a pixel is 0.01.
    assert (columns.min(), columns.max()) == (25, 34)
    assert (rows.min(), rows.max()) == (5, 14)
    assert image[0, 0, 3] == 0.0


def test_faces_turned_away_are_not_drawn():
    away = square(0.0, "white")
    away.corners[:] = away.corners[:, ::-1]
    assert not rendering.picture(away, FRONT, (-0.2, 0.2, -0.2, 0.2), 10)[..., 3].any()


def test_light_follows_lambert():
    ball = rendering.coloured(rendering.capsule_corners(1.0, 0.0), "white")
    bright = rendering.lit(ball)[:, 0]
    outward = rendering.normals(ball.corners)
    cosine = outward @ rendering.LIGHT / np.linalg.norm(outward, axis=-1)
    np.testing.assert_allclose(bright, rendering.AMBIENT + (1 - rendering.AMBIENT) * np.maximum(cosine, 0))
    assert bright.max() > 0.98
    assert bright.min() == pytest.approx(rendering.AMBIENT)


def test_silhouettes_are_darkened_inside_the_shape():
    small = square(1.0, "white", 0.4)
    image = rendering.picture(rendering.joined(square(0.0, "white"), small), FRONT, (-0.2, 0.2, -0.2, 0.2), 80)
    plain = rendering.lit(small)[0, 0]
    line = image[40, :, 0]
    assert line[40] == pytest.approx(plain)
    edges = np.flatnonzero(line < 0.9 * plain)
    # The small one covers +-0.1, columns 20 to 59; nothing else is dark.
    assert set(edges) <= {19, 20, 59, 60, 0, 79}
    assert {20, 59} & set(edges)


def test_a_window_holds_the_scene():
    scene = rendering.coloured(np.array([0.1, 0.3, 1.2]) + rendering.box_corners([0.6, 0.4, 0.5]), "white")
    left, right, bottom, top = rendering.window_of([scene], FRONT)
    place = FRONT.project(scene.corners)[0]
    assert left < place[..., 0].min() < place[..., 0].max() < right
    assert bottom < place[..., 1].min() < place[..., 1].max() < top
    assert right - left < 1.1 * np.ptp(place[..., 0])
