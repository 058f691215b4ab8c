"""Palm Jacobians and swivel Jacobians of both arms against finite differences of Drake's forward kinematics."""

import numpy as np
import pytest
from pydrake.multibody.plant import MultibodyPlant
from scipy.spatial.transform import Rotation

from drake_blfdmp.robot.kinematics import DualArmKinematics
from drake_blfdmp.robot.plant import ARMS, HOME, AddDualPanda, MakeKinematicPlant, ReadJointLimits
from drake_blfdmp.robot.swivel import swivel_angle, wrap

STEP = 1e-6
PLANT = MakeKinematicPlant()
INSTANCES = [PLANT.GetModelInstanceByName(arm) for arm in ARMS]
LIMITS = ReadJointLimits(PLANT, INSTANCES)


@pytest.fixture(scope="module")
def kinematics():
    return DualArmKinematics(PLANT)


def postures(count, seed=0):
    """Postures inside the limits, elbows bent by at least 0.3 rad."""
    return np.random.default_rng(seed).uniform(LIMITS.lower + 0.25, LIMITS.upper - 0.25, (count, 14))


@pytest.mark.parametrize("q", postures(8))
def test_palm_jacobians_are_the_derivatives_of_the_palm_poses(kinematics, q):
    states = kinematics.evaluate(q)
    for joint in range(14):
        before, after = (kinematics.evaluate(q + h * np.eye(14)[joint]) for h in (-STEP, STEP))
        for arm in range(2):
            turned = Rotation.from_matrix(after[arm].rotation @ before[arm].rotation.T).as_rotvec() / (2 * STEP)
            moved = (after[arm].position - before[arm].position) / (2 * STEP)
            own = joint - 7 * arm
            column = states[arm].jacobian[:, own] if 0 <= own < 7 else np.zeros(6)
            np.testing.assert_allclose(column, np.concatenate([turned, moved]), atol=1e-7)


@pytest.mark.parametrize("q", postures(8, seed=1))
def test_swivel_jacobians_are_the_derivatives_of_the_swivel_angles(kinematics, q):
    states = kinematics.evaluate(q)
    for joint in range(14):
        before, after = (kinematics.evaluate(q + h * np.eye(14)[joint]) for h in (-STEP, STEP))
        for arm in range(2):
            own = joint - 7 * arm
            column = states[arm].swivel_jacobian[own] if 0 <= own < 7 else 0.0
            difference = wrap(after[arm].swivel - before[arm].swivel) / (2 * STEP)
            assert column == pytest.approx(difference, rel=1e-5, abs=1e-6)


def test_poses_and_angles_are_those_of_the_plants_frames(kinematics):
    q = postures(1, seed=2)[0]
    context = PLANT.CreateDefaultContext()
    PLANT.SetPositions(context, q)
    for state, instance in zip(kinematics.evaluate(q), INSTANCES, strict=True):
        palm, *points = (
            PLANT.GetFrameByName(name, instance).CalcPoseInWorld(context)
            for name in ("palm", "shoulder", "elbow", "wrist")
        )
        np.testing.assert_allclose(state.rotation, palm.rotation().matrix(), atol=1e-12)
        np.testing.assert_allclose(state.position, palm.translation(), atol=1e-12)
        assert state.swivel == pytest.approx(swivel_angle(*(X.translation() for X in points)))


def test_at_home_the_elbows_stand_straight_up_and_joint_1_swings_them_sideways(kinematics):
    """The shoulder is where the axes of joints 1-3 meet, so the arm's plane is vertical while joints 1, 3, 5 are 0."""
    q = np.tile(HOME, 2)
    for arm, state in enumerate(kinematics.evaluate(q)):
        assert abs(state.swivel) == pytest.approx(np.pi, abs=1e-9)
        np.testing.assert_allclose(state.rotation[:2, 2], [0.0, state.rotation[1, 2]], atol=1e-9)
        assert state.position[0] == pytest.approx([-0.2, 0.2][arm], abs=1e-9)
        assert state.position[1] > 0.3
        # Turning the whole arm about the vertical changes no swivel; turning its plane by joint 3 does.
        assert state.swivel_jacobian[0] == pytest.approx(0.0, abs=1e-9)
        assert abs(state.swivel_jacobian[2]) > 0.1
        # The palm hangs on joints 6 and 7, elbow and wrist do not.
        np.testing.assert_array_equal(state.swivel_jacobian[5:], 0.0)


def test_a_plant_of_ones_own_gives_the_same(kinematics):
    own = MultibodyPlant(time_step=0.0)
    AddDualPanda(own)
    own.Finalize()
    q = postures(1, seed=3)[0]
    for one, other in zip(kinematics.evaluate(q), DualArmKinematics(own).evaluate(q), strict=True):
        for a, b in zip(one, other, strict=True):
            np.testing.assert_array_equal(a, b)
