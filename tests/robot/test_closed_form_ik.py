"""The closed form against the arms' own kinematics: what it finds is a posture, and it finds all there are."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drake_blfdmp.robot.closed_form_ik import BRANCHES, ClosedFormIk
from drake_blfdmp.robot.kinematics import DualArmKinematics
from drake_blfdmp.robot.plant import JOINTS_PER_ARM, MakeKinematicPlant

PLANT = MakeKinematicPlant()
IK = ClosedFormIk(PLANT)
KINEMATICS = DualArmKinematics(PLANT)
FEW = np.linspace(-np.pi, np.pi, 36, endpoint=False)


def palms(arm, q):
    """Positions (n, 3) and normals (n, 3) of an arm's palms, by the project's kinematics."""
    rotation, position, *_ = KINEMATICS.chains.evaluate(np.full(len(q), arm), q)
    return position, rotation[..., 2]


def drawn(arm, count, seed):
    """Random postures (count, 7) within the limits, joint 7 at 0."""
    q = np.random.default_rng(seed).uniform(IK.lower[arm], IK.upper[arm], (count, JOINTS_PER_ARM))
    q[:, 6] = 0.0
    return q


@pytest.mark.parametrize("arm", [0, 1])
@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_what_is_found_is_a_posture(arm, seed):
    position, normal = palms(arm, drawn(arm, 4, seed))
    q = IK.postures(arm, position, normal, FEW)
    assert q.shape == (4, len(FEW), BRANCHES, JOINTS_PER_ARM)
    solved = np.isfinite(q).all(axis=-1)
    assert np.all(solved == np.isfinite(q).any(axis=-1))
    which = np.nonzero(solved)[0]
    at, facing = palms(arm, q[solved])
    np.testing.assert_allclose(at, position[which], atol=1e-9)
    np.testing.assert_allclose(facing, normal[which], atol=1e-9)
    assert np.all(q[solved][:, 6] == 0.0)


def misses(arm, q):
    """By how much the nearest of all postures found for their palms misses postures (n, 7), rad: (n,)."""
    position, normal = palms(arm, q)
    fine = np.linspace(-np.pi, np.pi, 7200, endpoint=False)
    found = [IK.postures(arm, *palm, fine) for palm in zip(position, normal, strict=True)]
    return [np.nanmin(np.abs(all_of - own).max(axis=-1)) for all_of, own in zip(found, q, strict=True)]


@pytest.mark.parametrize("arm", [0, 1])
def test_no_posture_is_missed(arm):
    """Each drawn posture is one of those of its own palm, as near as the grid of angles is fine."""
    q = drawn(arm, 60, 3)
    lean = np.minimum(np.abs(q[:, 1]), np.abs(np.sin(q[:, 5])))
    calm = q[lean > 0.1]  # Where axes meet joints need any speed for a small angle.
    assert len(calm) > 40
    assert np.quantile(misses(arm, calm), 0.95) < 0.005


def test_limits_are_the_plants():
    q = np.array([[IK.lower[0], IK.upper[0]]])
    assert IK.within_limits(0, q).all()
    assert not IK.within_limits(0, np.array([IK.upper[0] + 1e-9, np.full(7, np.nan)])).any()


@pytest.mark.parametrize("arm", [0, 1])
def test_what_is_too_far_away_is_told_at_once_and_nothing_else_is(arm):
    rng = np.random.default_rng(5)
    position = rng.uniform([-1.2, -1.0, -0.6], [1.2, 1.4, 1.8], (400, 3))
    normal = rng.normal(size=(400, 3))
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    solved = np.isfinite(IK.postures(arm, position, normal, np.linspace(-np.pi, np.pi, 720))).all(axis=-1).any((1, 2))
    near = IK.may_reach(arm, position, normal)
    assert not np.any(solved & ~near)
    assert solved.sum() > 30 and near.sum() < 0.2 * len(near)
    assert (near & ~solved).sum() < 0.3 * near.sum()  # Too near to the shoulder.


def test_leading_axes_broadcast():
    position, normal = palms(0, drawn(0, 6, 9))
    both = IK.postures(0, position.reshape(2, 3, 3), normal.reshape(2, 3, 3), FEW)
    one = IK.postures(0, position[4], normal[4], FEW)
    np.testing.assert_array_equal(both[1, 1], one)
