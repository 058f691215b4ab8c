import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from synthetic_carry import carry, turn

from drake_blfdmp.demonstration.upright import AXES, rotation_to_z_up, sidedness, up_axis, up_from_heads

_, X = carry(duration=2.0)


@pytest.mark.parametrize("up", AXES)
def test_the_rotation_is_proper_and_lifts_its_axis(up):
    rotation = rotation_to_z_up(up)
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3))
    assert np.linalg.det(rotation) == pytest.approx(1.0)
    axis = np.eye(3)["xyz".index(up[-1])] * (-1 if up[0] == "-" else 1)
    np.testing.assert_allclose(rotation @ axis, [0, 0, 1])


def test_the_rotations_by_coordinates():
    np.testing.assert_allclose(rotation_to_z_up("y") @ [1, 2, 3], [1, -3, 2])
    np.testing.assert_allclose(rotation_to_z_up("-y") @ [1, 2, 3], [1, 3, -2])
    np.testing.assert_allclose(rotation_to_z_up("z") @ [1, 2, 3], [1, 2, 3])


@given(angle=st.floats(-np.pi, np.pi), up=st.sampled_from(["z", "y", "-y"]))
def test_up_is_found_whatever_the_heading(angle, up):
    assert up_axis(turn(X, angle) @ rotation_to_z_up(up)) == up


def test_raised_arms_need_the_formats_word():
    raised = X.copy()
    raised[:, [1, 4], 2] = 2 * raised[:, [0, 3], 2] - raised[:, [1, 4], 2]
    in_kinect = raised @ rotation_to_z_up("y")
    assert up_axis(in_kinect, "y") == "y"
    forward = X.copy()
    forward[:, [1, 4]] = forward[:, [0, 3]] + [0.0, 0.2, -0.2]
    assert up_axis(forward @ rotation_to_z_up("y")) is None
    assert up_axis(forward @ rotation_to_z_up("y"), "y") == "y"


@given(angle=st.floats(-np.pi, np.pi))
def test_sidedness_changes_sign_with_the_sides(angle):
    x = turn(X, angle)
    reach, behind = sidedness(x)
    assert reach > 0.2 and behind == 0.0
    assert sidedness(x[:, [3, 4, 5, 0, 1, 2]])[0] == pytest.approx(-reach)


@pytest.mark.parametrize("up", AXES)
def test_heads_tell_up_even_of_a_person_who_leans_forward(up):
    neck = np.array([0.0, np.sin(0.7), np.cos(0.7)]) * 250.0  # z up, 40 degrees forward, mm.
    shoulders = np.random.default_rng(0).normal(size=(30, 3))
    heads = shoulders + neck @ rotation_to_z_up(up) + 20.0 * np.random.default_rng(1).normal(size=(30, 3))
    heads[3:9] = np.nan
    assert up_from_heads(heads, shoulders) == up


@pytest.mark.parametrize("heads", [np.full((5, 3), np.nan), np.zeros((5, 3)), np.tile([1.0, 1.0, 1.0], (5, 1))])
def test_heads_that_are_not_seen_or_lie_between_all_axes_tell_nothing(heads):
    assert up_from_heads(heads, np.zeros((5, 3))) is None
