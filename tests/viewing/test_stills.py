"""Stills: rods, the person, the planned scene against its plant, and the strip of pictures."""

import numpy as np
import pytest
from matplotlib.colors import to_rgb
from pydrake.math import RigidTransform

from drake_blfdmp.robot.rigid import rigid
from drake_blfdmp.viewing import stills, style
from drake_blfdmp.viewing.planned_scene import PlannedScene
from drake_blfdmp.viewing.rendering import capsule_corners
from drake_blfdmp.viewing.solids import posed, solid_triangles

POINTS = np.array(
    [[-0.2, 0, 1.4], [-0.3, 0.1, 1.2], [-0.15, 0.3, 1.1], [0.2, 0, 1.4], [0.3, 0.1, 1.2], [0.15, 0.3, 1.1]]
)


def volume(corners):
    """By the divergence theorem: positive where all normals point outward."""
    return np.einsum("ti,ti->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6.0


def test_a_rod_reaches_from_end_to_end():
    start, end = np.array([0.1, -0.2, 0.3]), np.array([0.4, 0.5, 0.1])
    shape = stills.rod(start, end, 0.02, "black")
    length = np.linalg.norm(end - start)
    assert volume(shape.corners) == pytest.approx(volume(capsule_corners(0.02, length)))
    along = (shape.corners - start) @ (end - start) / length
    assert (along.min(), along.max()) == pytest.approx((-0.02, length + 0.02), abs=1e-12)
    for axis in range(3):  # Rods along every axis, z among them, have a frame.
        assert np.isfinite(stills.rod(np.zeros(3), np.eye(3)[axis], 0.02, "black").corners).all()


def test_a_link_outside_its_band_is_vermillion_and_thicker():
    inside = stills.skeleton(POINTS, [True] * 5)
    outside = stills.skeleton(POINTS, [True, False, True, True, True])
    green, vermillion = to_rgb(style.GREEN), to_rgb(style.VERMILLION)

    def of(shape, colour):
        return shape.corners[np.all(np.isclose(shape.colours, colour), axis=-1)]

    assert len(of(inside, vermillion)) == 0
    link = of(outside, vermillion)
    assert len(of(inside, green)) == len(of(outside, green)) + len(link)
    length = np.linalg.norm(POINTS[2] - POINTS[1])
    assert volume(link) == pytest.approx(volume(capsule_corners(1.5 * 0.025, length)))


def test_the_planned_scene_shows_every_shape_where_the_plant_has_it(default_plan):
    scene = PlannedScene(default_plan)
    shapes = [solid_triangles(solid) for solid in scene.solids]
    pose = np.array([np.cos(0.2), 0.0, 0.0, np.sin(0.2), 0.1, 0.5, 0.9])
    q = np.asarray(default_plan.reach.start)
    whole = posed(shapes, scene.at(q, pose))
    size = default_plan.box.size
    corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]) * size
    X_WB = rigid(pose)
    assert isinstance(X_WB, RigidTransform)
    drawn = whole.corners.reshape(-1, 3)
    for corner in corners:
        assert np.linalg.norm(drawn - X_WB @ corner, axis=-1).min() < 1e-9
    # The pedestals stand on the floor, nothing lies below it, and moving a joint moves what is drawn.
    assert drawn[:, 2].min() == pytest.approx(0.0, abs=1e-9)
    moved = posed(shapes, scene.at(q + 0.1 * np.eye(14)[8], pose))
    changed = np.abs(moved.corners - whole.corners).max(axis=(1, 2)) > 1e-6
    assert 0.1 < changed.mean() < 0.6
    assert np.all(whole.corners[changed].reshape(-1, 3)[:, 0] > -0.3)
    assert np.all((whole.colours >= 0) & (whole.colours <= 1))


def test_a_strip_is_a_page_wide_and_shows_every_picture():
    pictures = [np.full((20, 30, 4), share) for share in (0.2, 0.5, 0.8)]
    rows = {"upper": pictures, "lower": [picture[:10] for picture in pictures]}
    figure = stills.strip(rows, ["(a) one", "(b) two", "(c) three"], stills.LEGEND)
    assert figure.get_figwidth() == style.PAGE
    assert [axis.get_title() for axis in figure.axes] == ["(a) one", "(b) two", "(c) three", "", "", ""]
    for axis, image in zip(figure.axes, [*rows["upper"], *rows["lower"]], strict=True):
        np.testing.assert_array_equal(axis.get_images()[0].get_array(), image)
        box = axis.get_position()
        shown = figure.get_figwidth() * box.width / (figure.get_figheight() * box.height)
        assert shown == pytest.approx(image.shape[1] / image.shape[0])  # Nothing is stretched.
    assert [text.get_text() for text in figure.legends[0].get_texts()] == list(stills.LEGEND)
