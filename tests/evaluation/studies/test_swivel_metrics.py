"""Metrics of the swivel angle, on series whose answer is known."""

import numpy as np
import pytest

from drake_blfdmp.evaluation.studies.swivel_metrics import elbow_distance, swivel_error, swivel_rms
from drake_blfdmp.robot.swivel import wrap

T = np.linspace(0.0, 1.0, 401)


def test_a_constant_error_is_its_own_rms():
    desired = np.stack([np.sin(5 * T), 3.0 + 0.5 * T], axis=-1)  # The second passes pi.
    np.testing.assert_allclose(swivel_rms(wrap(desired + np.array([0.1, -0.2])), wrap(desired)), [0.1, 0.2], atol=1e-12)


def test_the_rms_of_a_sine_is_its_amplitude_over_root_two():
    t = np.arange(1000) / 1000.0
    error = 0.3 * np.sin(2 * np.pi * 4 * t)[:, None]
    assert swivel_rms(wrap(3.1 + error), np.full((1000, 1), 3.1))[0] == pytest.approx(0.3 / np.sqrt(2), abs=1e-12)


def test_an_elbow_that_has_gone_round_is_a_whole_turn_off():
    error = swivel_error(wrap(2.0 * np.pi * T)[:, None], np.zeros((len(T), 1)))
    np.testing.assert_allclose(error[:, 0], 2.0 * np.pi * T, atol=1e-12)


@pytest.mark.parametrize("turns", [-2, 1, 3])
def test_whole_turns_at_the_beginning_do_not_count(turns):
    desired = np.full((5, 1), 0.4)
    np.testing.assert_allclose(swivel_error(desired + 0.05 + 2 * np.pi * turns, desired), 0.05, atol=1e-12)


def test_unknown_samples_are_stepped_over():
    desired = np.stack([np.full(len(T), 3.1)] * 2, axis=-1)
    swivel = wrap(desired + 0.1)
    swivel[:30, 0] = swivel[100:150, 0] = np.nan
    desired[380:, 1] = np.nan
    error = swivel_error(swivel, desired)
    np.testing.assert_array_equal(np.isnan(error), np.isnan(swivel) | np.isnan(desired))
    np.testing.assert_allclose(swivel_rms(swivel, desired), 0.1, atol=1e-12)


def test_an_arm_that_is_never_known_has_no_rms():
    swivel = np.stack([np.full(4, np.nan), np.zeros(4)], axis=-1)
    np.testing.assert_array_equal(np.isnan(swivel_rms(swivel, np.zeros((4, 2)))), [True, False])


def test_the_elbows_distance_is_the_chord():
    # Shoulder and wrist on the y axis, the elbow 0.3 m from it.
    points = np.array([[0.0, 0.0, 0.0], [0.0, 0.4, -0.3], [0.0, 1.0, 0.0]])
    angle = np.array([0.0, 0.5, -0.5, np.pi, 2 * np.pi])
    turned = 0.3 * np.stack([-np.sin(angle), -np.cos(angle)], axis=-1)
    chord = np.linalg.norm(turned - [0.0, -0.3], axis=-1)
    np.testing.assert_allclose(elbow_distance(np.broadcast_to(points, (5, 3, 3)), angle), chord, atol=1e-12)
    assert chord[3] == pytest.approx(0.6)


def test_a_straight_arms_elbow_is_where_it_should_be():
    points = np.array([[0.0, 0, 0], [0, 0.3, 0], [0, 0.6, 0]])
    assert elbow_distance(points, 2.0) == pytest.approx(0.0, abs=1e-9)
