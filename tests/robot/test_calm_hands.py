"""Calmer hands: half or a fifth of the yaw, within half or a fifth of the limits, and none that is thrown about."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drake_blfdmp.robot.kinematics import DualArmKinematics
from drake_blfdmp.robot.plant import ARMS, MakeKinematicPlant, ReadJointLimits
from drake_blfdmp.robot.reach import CALM, calmed, find_reach
from drake_blfdmp.robot.retargeting import Retarget, retarget_motion
from drake_blfdmp.robot.swivel import wrap
from drake_blfdmp.robot.yaw_rate import LEAST, RATE, TURN, gentle_yaw_share, yaw_rates

MAP = Retarget(0.8, np.array([0.0, 0.0, 1.4]), np.array([0.0, 0.2, 0.95]), np.zeros(2))
TIME = np.linspace(0.0, 6.0, 1501)


def person(yaw):
    """(N, 6, 3): hands 0.3 m apart whose line has the yaw (N,), the rest at rest."""
    x = np.zeros((len(yaw), 6, 3))
    for first, side in ((0, -1.0), (3, 1.0)):
        x[:, first] = [0.18 * side, 0.0, 1.40]
        hand = np.stack([np.cos(yaw), np.sin(yaw), 0.0 * yaw], axis=-1)
        x[:, first + 2] = np.array([0.0, 0.35, 1.10]) + 0.15 * side * hand
        x[:, first + 1] = 0.5 * (x[:, first] + x[:, first + 2]) + [0.08 * side, -0.05, -0.12]
    return x


WANDERING = person(0.9 * np.sin(TIME) + 0.3 * np.sin(2.7 * TIME))


def yaw_of(retarget):
    """The yaw (N,) of the palms' line and its greatest change of rate, rad/s^2."""
    pose, *_ = retarget_motion(WANDERING, 0 * WANDERING, retarget)
    line = pose[:, 1, 4:] - pose[:, 0, 4:]
    yaw = np.arctan2(line[:, 1], line[:, 0])
    return yaw, np.abs(np.gradient(np.gradient(yaw, TIME), TIME)).max()


@pytest.mark.parametrize("share", [0.5, 0.2])
def test_calmer_hands_turn_less_and_are_not_thrown_from_limit_to_limit(share):
    calm, clipped = calmed(MAP, share), calmed(MAP, share, keep_yaw=True)
    assert (calm.yaw_share, clipped.yaw_share) == (share, 1.0)
    assert calm.yaw == clipped.yaw == (share * MAP.yaw[0], share * MAP.yaw[1])
    yaw, turn = yaw_of(calm)
    assert np.abs(yaw).max() <= calm.yaw[1]
    # The same hands with the narrow limits alone are stopped there so much more suddenly.
    assert turn < 1.1 * share**2 * yaw_of(clipped)[1]
    # What is within the limits is the person's, scaled.
    within = np.abs(yaw) < calm.yaw[0]
    asked = np.arctan2(*(WANDERING[:, 5] - WANDERING[:, 2])[:, 1::-1].T)
    np.testing.assert_allclose(yaw[within], share * asked[within], atol=1e-12)


def test_the_elbows_are_limited_and_not_scaled():
    half = calmed(MAP, 0.5)
    swing, calm = (np.abs(wrap(np.pi - retarget_motion(WANDERING, 0 * WANDERING, by)[2])) for by in (MAP, half))
    small = swing < half.swing_out[0]  # These elbows swing outward.
    assert 100 < np.sum(small) < small.size - 100
    np.testing.assert_allclose(calm[small], swing[small], atol=1e-12)
    assert np.all(calm[~small] < swing[~small]) and calm.max() <= half.swing_out[1]


def test_the_search_keeps_the_yaw_if_asked_to():
    plant = MakeKinematicPlant()
    limits = ReadJointLimits(plant, [plant.GetModelInstanceByName(arm) for arm in ARMS])
    asked = {"kinematics": DualArmKinematics(plant), "limits": limits, "scale": 0.8, "world": MAP.world}
    still = person(0.1 * np.sin(TIME))
    for keep in (False, True):
        found = [find_reach(TIME, still, 750, calms=(calm,), keep_yaw=keep, **asked).retarget for calm in CALM]
        assert [retarget.yaw_share for retarget in found] == ([1.0] * 3 if keep else list(CALM))


def test_the_rates_are_those_of_the_palms_line():
    turn = person(0.3 * np.sin(2.0 * TIME))
    rate, change = yaw_rates(TIME, turn, MAP)
    assert (rate, change) == (pytest.approx(0.6, rel=1e-3), pytest.approx(1.2, rel=1e-2))
    half = yaw_rates(TIME, turn, replace(MAP, yaw_share=0.5))
    assert half == (pytest.approx(0.5 * rate), pytest.approx(0.5 * change))


@given(
    amplitude=st.floats(0.0, 3.0),
    speed=st.floats(0.1, 30.0),
    stretch=st.floats(1.0, 5.0),
    calm=st.sampled_from(CALM),
)
def test_what_is_taken_of_the_yaw_is_never_too_fast_and_gentle_hands_keep_all(amplitude, speed, stretch, calm):
    x, retarget = person(amplitude * np.sin(speed * TIME)), calmed(MAP, calm)
    share = gentle_yaw_share(TIME, x, retarget, stretch)
    assert share == 0.0 or LEAST / 2 < share <= retarget.yaw_share
    rate, change = yaw_rates(TIME, x, replace(retarget, yaw_share=share))
    assert rate <= RATE * stretch * (1 + 1e-9) and change <= TURN * stretch**2 * (1 + 1e-9)
    all_rate, all_change = yaw_rates(TIME, x, retarget)
    assert (share == retarget.yaw_share) == (all_rate <= RATE * stretch and all_change <= TURN * stretch**2)


def test_the_search_takes_back_what_is_thrown_about():
    plant = MakeKinematicPlant()
    limits = ReadJointLimits(plant, [plant.GetModelInstanceByName(arm) for arm in ARMS])
    asked = {"kinematics": DualArmKinematics(plant), "limits": limits, "scale": 0.8, "world": MAP.world}
    thrown = person(0.4 * np.tanh(25.0 * (TIME - 2.5)))
    for keep in (False, True):
        reach = find_reach(TIME, thrown, 750, calms=(1.0,), keep_yaw=keep, **asked)
        rate, change = yaw_rates(TIME, thrown, reach.retarget)
        assert reach.sound
        assert (rate <= RATE * reach.stretch and change <= TURN * reach.stretch**2) == (not keep)
