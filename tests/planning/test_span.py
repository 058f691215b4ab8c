"""The bound on how far apart the palms can be: never exceeded, and not idle."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drake_blfdmp.planning.span import WidestSpan
from drake_blfdmp.robot.kinematics import DualArmKinematics
from drake_blfdmp.robot.plant import ARMS, MakeKinematicPlant, ReadJointLimits

PLANT = MakeKinematicPlant()
LIMITS = ReadJointLimits(PLANT, [PLANT.GetModelInstanceByName(arm) for arm in ARMS])
KINEMATICS = DualArmKinematics(PLANT)


def test_the_bound_is_that_of_two_pandas_0_4_m_apart():
    """0.316 m and 0.384 m with 0.0825 m offsets, all but straight; the palm 0.167 m in front of the wrist."""
    bone = [np.hypot(0.316, 0.0825), np.hypot(0.384, 0.0825)]
    inner = np.arctan2(0.316, 0.0825) + np.arctan2(0.384, 0.0825) + 0.0698
    reach = np.sqrt(bone[0] ** 2 + bone[1] ** 2 - 2 * bone[0] * bone[1] * np.cos(inner))
    assert WidestSpan(PLANT) == pytest.approx(0.4 + 2 * reach - 2 * 0.167, abs=2e-3)


@given(shares=st.lists(st.floats(0.0, 1.0), min_size=14, max_size=14))
def test_no_posture_within_the_limits_passes_the_bound(shares):
    """The part of the palms' distance along their normals, as if they faced each other, counts what lies between."""
    q = LIMITS.lower + np.array(shares) * (LIMITS.upper - LIMITS.lower)
    left, right = KINEMATICS.evaluate(q)
    # Turned to face each other, the palms would lie this far in front of wrists that stay where they are.
    wrists = [state.position - 0.167 * state.rotation[:, 2] for state in (left, right)]
    offset = 0.088  # The wrist's centre is this far from the axis of joint 7.
    assert np.linalg.norm(wrists[1] - wrists[0]) - 2 * 0.167 <= WidestSpan(PLANT, LIMITS) + 2 * offset
