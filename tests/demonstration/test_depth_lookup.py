"""Depths of a camera that looks down on a person: what hides a joint, or lies beside it, is measured in its place."""

import numpy as np
import pytest
from synthetic_carry import carry

from drake_blfdmp.demonstration.cleaning import CleaningOptions, clean
from drake_blfdmp.demonstration.demonstration import KnownDimensions, Recording
from drake_blfdmp.demonstration.depth_lookup import candidates, describe_depths, is_depth_lookup, redo_depths

CAMERA_HEIGHT = 2.4
T, WORLD = carry()
X = np.stack([WORLD[..., 0], -WORLD[..., 1], CAMERA_HEIGHT - WORLD[..., 2]], axis=-1)  # Camera: x right, z down.
LENGTHS = (0.29, 0.26)


def at_depth(points, depth):
    return points * (depth / points[..., 2])[..., None]


def looked_up(x=X):
    """Left elbow under the shoulder's depth, right wrist on the floor for 2 s, a point without depth."""
    out = x.copy()
    out[20:150, 1] = at_depth(x[20:150, 1], x[20:150, 0, 2] + 0.05)
    out[60:120, 5] = at_depth(x[60:120, 5], np.full(60, 2.2))
    return np.round(out, 3)


def rms(a, b):
    return np.sqrt(np.mean(np.sum((a - b) ** 2, axis=-1), axis=0))


def test_hidden_joints_come_back_and_others_stay():
    x = looked_up()
    redone = redo_depths(T, x, *LENGTHS)
    raw, left = rms(x, X), rms(redone.x, X)
    assert left[1] < 0.25 * raw[1]
    assert left[5] < 0.25 * raw[5]
    assert redone.moved[20:150, 1].mean() > 0.9
    assert redone.moved[60:120, 5].mean() > 0.9
    for point in (0, 2, 3, 4):
        np.testing.assert_array_equal(redone.x[:, point], x[:, point])
    assert "left_elbow" in describe_depths(redone.moved)


def test_points_stay_on_their_rays():
    x = looked_up()
    y = redo_depths(T, x).x
    np.testing.assert_allclose(np.cross(x, y), 0.0, atol=1e-12)
    assert (y[..., 2] > 0).all()


def test_candidates_have_the_bones_lengths_where_the_ray_reaches_them():
    points, replaced = candidates(X[:, :3], LENGTHS)
    upper = np.linalg.norm(points[:, :, 0] - X[:, None, 0], axis=-1)
    fore = np.linalg.norm(points[:, :, 1] - points[:, :, 0], axis=-1)
    np.testing.assert_allclose(upper[:, replaced[:, 0]], LENGTHS[0], atol=1e-9)
    assert (np.abs(fore[:, replaced[:, 1]] - LENGTHS[1]) < 1e-9).mean() > 0.5
    np.testing.assert_array_equal(points[:, 0], X[:, 1:3])


def test_arms_that_are_not_whole_are_left_alone():
    x = looked_up()
    x[30:40, 2] = np.nan
    redone = redo_depths(T, x, *LENGTHS)
    assert not redone.moved[30:40, :3].any()
    assert np.isnan(redone.x[30:40, 2]).all()


def test_what_a_depth_image_looks_like():
    blind = looked_up()
    blind[5, 1] = 0.0
    assert is_depth_lookup(blind, None)
    assert is_depth_lookup(blind, "-z")
    assert is_depth_lookup(np.where(blind == 0, np.nan, blind), None)
    assert not is_depth_lookup(blind, "z")
    assert not is_depth_lookup(looked_up(), None)
    assert not is_depth_lookup(X + np.where(blind == 0, -X, 0.0), None)
    assert not is_depth_lookup(np.zeros_like(X), None)


def recording(x, known=None):
    return Recording(T, x, "test.json", "test", np.arange(len(T)), up="-z", known=known or KnownDimensions())


def in_world(demonstration):
    """As `X` was made: z up is undone by the height, the rotation about x by its own."""
    x = demonstration.x
    return np.stack([x[..., 0], x[..., 1], x[..., 2] + CAMERA_HEIGHT], axis=-1)


@pytest.mark.parametrize("known", [KnownDimensions(*LENGTHS), KnownDimensions()])
def test_clean_finds_and_mends_them_by_itself(known):
    blind = looked_up()
    blind[5, 1] = 0.0
    demonstration = clean(recording(blind, known))
    assert demonstration.repairs["depths_redone"] > 150
    assert any("depth image" in note for note in demonstration.notes)
    assert len(demonstration.t) == len(T)
    raw, left = rms(looked_up(), X), rms(in_world(demonstration), WORLD)
    assert left[1] < 0.5 * raw[1]
    assert left[5] < 0.5 * raw[5]


def test_clean_does_as_told():
    blind = np.round(X, 3)
    blind[40:70, 1] = np.round(at_depth(X[40:70, 1], X[40:70, 1, 2] - 0.12), 3)
    blind[5, 1] = 0.0
    left = clean(recording(blind), CleaningOptions(redo_depths=False, remove_jumps=False))
    assert left.repairs["depths_redone"] == 0
    np.testing.assert_allclose(left.x[40:70, 1, 2], -blind[40:70, 1, 2])
    seen = np.round(X, 3)
    seen[40:70, 1] = blind[40:70, 1]
    assert clean(recording(seen)).repairs["depths_redone"] == 0
    assert clean(recording(seen), CleaningOptions(redo_depths=True)).repairs["depths_redone"] > 0
