"""The grasp and the release: the lowest points of the held interval on either side of its highest."""

import numpy as np
import pytest
from synthetic_carry import carry, smooth_step

from drake_blfdmp.demonstration.demonstration import Demonstration
from drake_blfdmp.demonstration.grasp import grasp_and_release
from drake_blfdmp.demonstration.holding import Holding


def demonstration(height, duration=6.0):
    """Hands 0.3 m apart whose middle is at height(t)."""
    t, x = carry(duration=duration)
    x[:, [2, 5], 2] = height(t)[:, None]
    return Demonstration(t=t, x=x, source="test")


def hill(t, down=1.5, up=2.8, back=3.2, end=4.5, start_height=1.2):
    """Comes down to 0.9 m at `down`, rises to 1.3 m, is back at 0.9 m at `end` and rises again."""
    return (
        start_height
        + (0.9 - start_height) * smooth_step(t, 0.2, down)
        + 0.4 * smooth_step(t, down, up)
        - 0.4 * smooth_step(t, back, end)
        + 0.2 * smooth_step(t, end, 5.8)
    )


def test_the_lowest_points_on_either_side_of_the_top_are_taken():
    found = grasp_and_release(demonstration(hill), Holding(0.4, 5.6, 0.3))
    assert found.start_s == pytest.approx(1.5, abs=0.1)
    assert found.end_s == pytest.approx(4.5, abs=0.1)
    assert found.hand_distance == 0.3


def test_the_result_lies_inside_what_was_held():
    found = grasp_and_release(demonstration(hill), Holding(2.0, 4.0, 0.3))
    assert (found.start_s, found.end_s) == (2.0, 4.0)


def test_a_lower_point_outside_the_held_interval_does_not_count():
    def height(t):
        return hill(t) - 0.6 * np.exp(-(((t - 5.6) / 0.2) ** 2))

    found = grasp_and_release(demonstration(height), Holding(0.4, 5.0, 0.3))
    assert found.end_s == pytest.approx(4.5, abs=0.12)


def test_one_hand_alone_does_not_decide_the_height():
    """The middle of the hands counts: what one hand gains and the other loses changes nothing."""
    plain = demonstration(hill)
    x = plain.x.copy()
    wave = 0.3 * np.sin(2 * np.pi * 0.3 * plain.t)
    x[:, 2, 2] += wave
    x[:, 5, 2] -= wave
    holding = Holding(0.4, 5.6, 0.3)
    found = grasp_and_release(Demonstration(t=plain.t, x=x, source="test"), holding)
    expected = grasp_and_release(plain, holding)
    assert (found.start_s, found.end_s) == (expected.start_s, expected.end_s)


def test_noise_does_not_move_the_grasp_by_much():
    plain = demonstration(hill)
    noisy = plain.x + np.random.default_rng(2).normal(0.0, 0.008, plain.x.shape)
    found = grasp_and_release(Demonstration(t=plain.t, x=noisy, source="test"), Holding(0.4, 5.6, 0.3))
    assert found.start_s == pytest.approx(1.5, abs=0.25)
    assert found.end_s == pytest.approx(4.5, abs=0.25)


def test_a_carry_without_a_lift_keeps_its_interval():
    holding = Holding(1.0, 5.0, 0.3)
    # Falling all the time: the top is the first sample, and the lowest point before it is itself.
    found = grasp_and_release(demonstration(lambda t: 1.2 - 0.05 * t), holding)
    assert found == holding


def test_too_short_a_result_is_not_taken():
    def dip(t):
        return 1.0 + 0.3 * np.exp(-(((t - 3.0) / 0.05) ** 2)) - 0.2 * np.abs(t - 3.0)

    holding = Holding(2.9, 3.2, 0.3)
    assert grasp_and_release(demonstration(dip), holding) == holding


def test_an_interval_without_samples_is_returned_as_it_is():
    holding = Holding(3.001, 3.002, 0.3)
    assert grasp_and_release(demonstration(hill), holding) is holding
