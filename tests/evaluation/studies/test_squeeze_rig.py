"""The rig: the palms are the model's, forces are what was set, and a box is held, lost and turned as it should be."""

import numpy as np
import pytest

from drake_blfdmp.evaluation.studies.squeeze_metrics import Limits, box_friction, pad_deformation
from drake_blfdmp.evaluation.studies.squeeze_rig import LIFT_AT, Lift, SqueezeRig, _path
from drake_blfdmp.robot.box import BoxParameters
from drake_blfdmp.robot.grasp_force import least_squeeze

LIMITS = Limits()


@pytest.fixture(scope="module")
def rig():
    """The main job's box, taken 20 mm above its centre; friction of box and pad 0.8."""
    return SqueezeRig(BoxParameters(), (0.0, -0.02))


def test_the_pad_is_the_models(rig):
    assert (rig.pad.radius, rig.pad.thickness, rig.pad.modulus, rig.pad.friction) == (0.045, 0.015, 1e6, 0.8)


def test_palms_press_with_what_is_set_and_sit_as_deep_as_a_foundation(rig):
    for force in (20.0, 80.0):
        depth, patch = rig.press(force)
        assert patch.force == pytest.approx(force, rel=1e-4)
        np.testing.assert_allclose(depth, pad_deformation(force, 1e6, rig.pad.depth, rig.pad.area), rtol=0.01)
        assert patch.area.sum() == pytest.approx(rig.pad.area, rel=2e-3)
        assert patch.pressure == pytest.approx(force / rig.pad.area, rel=0.01)


def test_a_softer_pad_yields_more():
    soft = SqueezeRig(BoxParameters(), modulus=1e5)
    assert soft.pad.modulus == 1e5
    depth, _ = soft.press(50.0)
    assert depth[0] == pytest.approx(pad_deformation(50.0, 1e5, soft.pad.depth, soft.pad.area), rel=0.05)


def test_too_little_drops_the_box_at_once_and_enough_holds_it(rig):
    estimate = least_squeeze(1.0, 0.8, factor=1.0)
    lost = rig.hold(0.9 * estimate, 1.0)
    assert not lost.held and lost.t[-1] < 0.6
    assert lost.moved[-1, 2] < -5e-3 and abs(lost.moved[-1, 0]) < 1e-5
    kept = rig.hold(1.2 * estimate, 1.0, LIMITS)
    assert kept.held and kept.t[-1] == pytest.approx(1.0)
    np.testing.assert_allclose(kept.force, 1.2 * estimate, rtol=1e-3)
    slip, pivot = kept.creep()
    assert 1e-7 < slip < 5e-5 and pivot < 1e-6


def test_every_trial_starts_anew(rig):
    first = rig.hold(10.0, 0.3)
    rig.hold(1.0, 0.3)
    again = rig.hold(10.0, 0.3)
    np.testing.assert_array_equal(first.moved, again.moved)


def test_limits_end_a_trial_that_only_creeps(rig):
    estimate = least_squeeze(1.0, 0.8, factor=1.0)
    creeping = rig.hold(1.001 * estimate, 0.6, LIMITS)
    assert not creeping.held and creeping.t[-1] < 0.4
    assert rig.hold(1.001 * estimate, 0.6).held


def test_the_least_force_is_the_friction_cones_and_was_held(rig):
    estimate = least_squeeze(1.0, 0.8, factor=1.0)
    least, hold = rig.least(estimate, 0.6, LIMITS)
    assert 1.0 < least / estimate < 1.03
    assert hold.held and hold.creep()[0] <= LIMITS.slip


def test_only_the_dynamic_coefficient_of_the_pad_counts():
    """Its static one, 0.9, would hold this box with a ninth less than its dynamic one, 0.8."""
    rig = SqueezeRig(BoxParameters(friction=0.8))
    at = {mu: least_squeeze(1.0, mu, factor=1.0) for mu in (0.8, 2 * 0.9 * 0.8 / 1.7)}
    forces = sorted(at.values())
    assert not rig.hold(0.5 * sum(forces), 0.5, LIMITS).held
    assert rig.hold(1.03 * forces[1], 0.5, LIMITS).held


def test_a_centre_aside_turns_the_box_downwards():
    rig = SqueezeRig(BoxParameters(), (0.02, 0.0))
    sliding = least_squeeze(1.0, 0.8, factor=1.0)
    turned = rig.hold(1.1 * sliding, 0.6)
    assert not turned.held
    assert turned.turned[-1] < -np.radians(4.0)  # About +x: y towards z; the centre, at +y, sinks.
    assert rig.hold(1.6 * sliding, 0.6, LIMITS).held


def test_a_lift_goes_as_high_as_asked_with_the_accelerations_asked():
    lift = Lift(0.2, 1.2)
    path = _path(lift)
    assert path.start_time() == LIFT_AT and path.end_time() == pytest.approx(LIFT_AT + lift.duration_s)
    t = np.linspace(path.start_time(), path.end_time(), 2001)
    height = np.array([path.value(time)[0, 0] for time in t])
    assert (height[0], height[-1]) == pytest.approx((0.0, 0.2))
    acceleration = np.gradient(np.gradient(height, t), t)[20:-20]
    assert acceleration.max() == pytest.approx(1.2, rel=0.01) and acceleration.min() == pytest.approx(-1.2, rel=0.01)


def test_a_lift_needs_more_than_rest_and_as_much_as_predicted():
    box = BoxParameters(mass=2.0, friction=float(box_friction(0.5, 0.8)))
    still, lifted = least_squeeze(2.0, 0.5, factor=1.0), least_squeeze(2.0, 0.5, 1.5, factor=1.0)
    rig = SqueezeRig(box, lift=Lift())
    assert not rig.hold(1.05 * still, 1.0, LIMITS).held
    assert rig.hold(1.03 * lifted, 1.4, LIMITS).held
