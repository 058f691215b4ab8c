"""Places where the arms would jump: elbow straight above the arm's line, upper arm straight up, crossed hands."""

from dataclasses import replace

import numpy as np
import pytest

from drake_blfdmp.robot.following import Following
from drake_blfdmp.robot.plant import HOME
from drake_blfdmp.robot.retargeting import Retarget, faded_at_half_a_turn, retarget_motion

MAP = Retarget(1.0, np.zeros(3), np.array([0.0, 0.4, 0.8]), np.zeros(2))


def test_the_fade_is_one_in_common_postures_zero_overhead_and_its_slope_is_its_derivative():
    angle = np.linspace(-3.13, 3.13, 1001)
    fade, slope = faded_at_half_a_turn(angle)
    np.testing.assert_array_equal(fade[np.abs(angle) < np.deg2rad(119.0)], 1.0)
    np.testing.assert_allclose(faded_at_half_a_turn(np.array([np.pi, -np.pi]))[0], 0.0, atol=1e-15)
    h = 1e-6
    np.testing.assert_allclose(
        slope, (faded_at_half_a_turn(angle + h)[0] - faded_at_half_a_turn(angle - h)[0]) / (2 * h), atol=1e-8
    )


def test_the_robots_swivel_does_not_jump_where_the_persons_elbow_passes_overhead():
    turn = np.linspace(np.pi - 0.05, np.pi + 0.05, 201)
    arm = np.zeros((len(turn), 3, 3))
    arm[:, 2] = [0.0, 0.4, 0.0]
    # psi = 0 hangs down; positive towards -x.
    arm[:, 1] = np.stack([-0.15 * np.sin(turn), np.full_like(turn, 0.2), -0.15 * np.cos(turn)], axis=-1)
    x = np.concatenate([arm, arm + np.array([0.4, 0.0, 0.0])], axis=1)
    psi = retarget_motion(x, np.zeros_like(x), MAP)[2]
    steps = np.abs((np.diff(psi, axis=0) + np.pi) % (2 * np.pi) - np.pi)
    assert steps.max() < 0.01


@pytest.mark.parametrize("share", [1.0, 0.2])
def test_the_palms_do_not_jump_where_the_hands_cross_and_their_twist_is_their_rate(share):
    """A line between the hands that passes half a turn has turned neither way."""
    retarget, t = replace(MAP, yaw_share=share), np.linspace(0.0, 4.0, 4001)
    yaw = np.pi + 1.3 * np.sin(t)
    hand = 0.1 * np.stack([np.cos(yaw), np.sin(yaw), 0.0 * yaw], axis=-1)
    x = np.tile(np.array([0.0, 0.4, 1.0]), (len(t), 6, 1))
    x[:, 2], x[:, 5] = x[:, 2] - hand, x[:, 5] + hand
    pose, twist, *_ = retarget_motion(x, np.gradient(x, t, axis=0), retarget)
    assert np.abs(np.diff(pose[..., 4:], axis=0)).max() < 1e-3
    rate = np.gradient(pose[..., 4:], t, axis=0)
    np.testing.assert_allclose(twist[5:-5, :, 3:], rate[5:-5], atol=2e-4)  # Of up to 0.1, with kinks in the rate.


@pytest.mark.parametrize(("angles", "lean"), [((0.4, 0.6), 0.4), ((-0.3, -0.5), 0.3), ((-0.2, 0.3), 0.0)])
def test_the_shoulders_lean(angles, lean):
    q = np.tile(np.tile(HOME, 2), (len(angles), 1))
    q[:, 1], q[:, 8] = angles, 1.0
    assert Following(q, 0.0, 0.0, 1.0).shoulder_lean == pytest.approx(lean)
