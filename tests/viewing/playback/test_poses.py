import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation, Slerp

from drake_blfdmp.viewing.playback import poses

numbers = st.floats(-3.0, 3.0, allow_subnormal=False)
quaternions = arrays(float, 4, elements=numbers).filter(lambda q: np.linalg.norm(q) > 0.1)


@given(arrays(float, 3, elements=numbers), quaternions)
def test_matrices_are_scipys_and_quaternions_come_back(p, q):
    X = poses.matrices(np.concatenate([p, q]))
    assert np.allclose(X[:3, :3], Rotation.from_quat(q).as_matrix(), atol=1e-12)
    assert np.allclose(X[:3, 3], p)
    assert abs(np.dot(poses.quaternions(X), q / np.linalg.norm(q))) == pytest.approx(1.0, abs=1e-12)
    assert np.allclose(poses.inverse(X) @ X, np.eye(4), atol=1e-12)


@given(arrays(float, 3, elements=numbers))
def test_z_points_along_whatever_direction(direction):
    X = poses.z_along(direction)
    assert np.allclose(X[:3, :3].T @ X[:3, :3], np.eye(3), atol=1e-9)
    assert np.linalg.det(X[:3, :3]) == pytest.approx(1.0)
    if np.linalg.norm(direction) > 1e-6:
        assert np.allclose(X[:3, 2], direction / np.linalg.norm(direction), atol=1e-6)


@given(quaternions, quaternions, st.floats(0.0, 1.0))
def test_between_is_the_shortest_turn(a, b, share):
    a, b = a / np.linalg.norm(a), b / np.linalg.norm(b)
    if abs(a @ b) < 1e-3:  # Half a turn has no shortest way.
        return
    here = poses.between(np.concatenate([np.zeros(3), a]), np.concatenate([np.ones(3), b]), [share])[0]
    assert np.allclose(here[:3], share)
    expected = Slerp([0.0, 1.0], Rotation.from_quat([a, b]))(share)
    assert (Rotation.from_quat(here[3:]).inv() * expected).magnitude() < 1e-5


def test_a_zero_quaternion_is_no_rotation():
    assert np.allclose(poses.matrices([1.0, 2.0, 3.0, 0, 0, 0, 0]), poses.translation([1.0, 2.0, 3.0]))


def test_urdfs_angles_are_about_fixed_axes():
    X = poses.from_xyz_rpy([1.0, 2.0, 3.0], [0.3, -0.4, 1.1])
    assert np.allclose(X[:3, :3], Rotation.from_euler("xyz", [0.3, -0.4, 1.1]).as_matrix())


def test_signs_that_flip_are_put_right():
    turns = np.linspace(0.0, 6.0, 20)[:, None] * [0.0, 0.0, 1.0]
    q = Rotation.from_rotvec(turns).as_quat() * np.where(np.arange(20) % 3, 1.0, -1.0)[:, None]
    assert (np.sum(np.diff(poses.continuous(q), axis=0) ** 2, axis=-1) < 0.1).all()
