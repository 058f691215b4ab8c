"""Many postures at once are what Drake says of each."""

import numpy as np

from drake_blfdmp.robot.kinematics import DualArmKinematics


def test_many_postures_at_once_are_what_drake_says_of_each():
    kinematics, rng = DualArmKinematics(), np.random.default_rng(0)
    q = rng.uniform(-2.0, 2.0, (30, 14))
    arms = np.tile([0, 1], len(q))
    rotation, position, jacobian, swivel, along = kinematics.chains.evaluate(arms, q.reshape(-1, 7))
    states = [state for posture in q for state in kinematics.evaluate(posture)]
    np.testing.assert_allclose(rotation, [state.rotation for state in states], atol=1e-12)
    np.testing.assert_allclose(position, [state.position for state in states], atol=1e-12)
    np.testing.assert_allclose(jacobian, [state.jacobian for state in states], atol=1e-12)
    np.testing.assert_allclose(swivel, [state.swivel for state in states], atol=1e-11)
    np.testing.assert_allclose(along, [state.swivel_jacobian for state in states], rtol=1e-9, atol=1e-11)
