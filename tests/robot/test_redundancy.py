"""What fills the null space: (18) as printed, projected numerically; its faults; limits; the default to the bit."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from drake_blfdmp.errors import ScenarioError
from drake_blfdmp.robot.differential_ik import (
    DEFAULT_GAINS,
    damped_inverse,
    largest_scale,
    null_interval,
    resolve,
    resolve_null,
    velocity_bounds,
)
from drake_blfdmp.robot.kinematics import DualArmKinematics
from drake_blfdmp.robot.plant import ARMS, HOME, MakeKinematicPlant, ReadJointLimits
from drake_blfdmp.robot.redundancy import (
    REDUNDANCIES,
    ElbowKinematics,
    leak,
    persons_angle,
    published_null_speed,
)
from drake_blfdmp.robot.retargeting import OUTWARD, Retarget, retarget_motion
from drake_blfdmp.robot.swivel import swivel_angle, wrap
from drake_blfdmp.robot.tracking import DualArmTracker

PLANT = MakeKinematicPlant()
LIMITS = ReadJointLimits(PLANT, [PLANT.GetModelInstanceByName(arm) for arm in ARMS])
KINEMATICS, ELBOWS = DualArmKinematics(PLANT), ElbowKinematics()
GAINS = DEFAULT_GAINS
WIDE = np.full(7, 1e3)
seeds = st.integers(0, 2**32 - 1)


def posture(seed):
    """Both arms near HOME, away from limits and singularities (14,)."""
    return np.tile(HOME, 2) + np.random.default_rng(seed).uniform(-0.2, 0.2, 14)


def goal(q, rng):
    """Palm poses (2, 7) where they are, twists (2, 6), swivel angles and rates (2,)."""
    states = KINEMATICS.evaluate(q)
    pose = np.array([[*np.roll(Rotation.from_matrix(s.rotation).as_quat(), 1), *s.position] for s in states])
    return pose, rng.uniform(-0.2, 0.2, (2, 6)), rng.uniform(-np.pi, np.pi, 2), rng.uniform(-0.5, 0.5, 2)


def old_resolve(jacobian, twist, swivel_jacobian, swivel_rate, low, high, gains, gentle=None):
    """`resolve` as it was before there was a choice."""
    inverse, n = damped_inverse(jacobian, gains.singular_value, gains.damping)
    base = inverse @ twist
    along = swivel_jacobian @ n
    floor = max(0.0, 1.0 - (along / gains.null_floor) ** 2) * gains.null_floor**2
    scale = 1.0
    least, most = null_interval(base, n, low, high)
    if least > most:
        scale = largest_scale(base, n, low, high)
        base = scale * base
        least, most = null_interval(base, n, low, high)
        middle = 0.5 * (least + most)
        least, most = min(least, middle), max(most, middle)
    alpha = (swivel_rate - swivel_jacobian @ base) * along / (along * along + floor)
    if gentle is not None:
        previous, change = gentle
        alpha = np.clip(alpha, n @ previous - change, n @ previous + change)
    return base + np.clip(alpha, least, most) * n, scale


@given(seeds, st.booleans(), st.floats(0.02, 10.0))
def test_the_default_is_what_it_was_to_the_bit_where_limits_leave_the_twist_whole(seed, gently, size):
    rng = np.random.default_rng(seed)
    jacobian, swivel_jacobian = rng.normal(size=(6, 7)), rng.normal(size=7)
    low, high = -rng.uniform(0, 1.5, 7), rng.uniform(0, 1.5, 7)
    gentle = (rng.normal(size=7), 0.02) if gently else None
    arguments = jacobian, size * rng.normal(size=6), swivel_jacobian, rng.normal(), low, high, GAINS, gentle
    (new, new_scale), (old, old_scale) = resolve(*arguments), old_resolve(*arguments)
    assert (new_scale == 1.0) == (old_scale == 1.0)
    if old_scale == 1.0:
        np.testing.assert_array_equal(new, old)
    else:  # Nearer to a null motion at rest, never faster.
        assert 0.0 <= new_scale <= old_scale + 1e-12


def test_a_tracker_that_is_told_nothing_uses_the_swivel():
    rng = np.random.default_rng(1)
    q = posture(1)
    values = goal(q, rng)
    one, other, none = (
        DualArmTracker(KINEMATICS, LIMITS, **options).velocity(q, *values)[0]
        for options in ({}, {"redundancy": "swivel"}, {"redundancy": "none"})
    )
    np.testing.assert_array_equal(one, other)
    assert np.abs(one - none).max() > 1e-2


@given(seeds, st.floats(-1.5, 1.5))
def test_published_is_18_projected_numerically(seed, psi):
    """J^+ X' + (I - J^+ J) J_E^+ psi U_psi with NumPy's pseudo-inverses, at postures of the real arms."""
    q, rng = posture(seed), np.random.default_rng(seed)
    jacobians, directions = ELBOWS.evaluate(q)
    for arm, state in enumerate(KINEMATICS.evaluate(q)):
        twist, inverse = rng.uniform(-0.3, 0.3, 6), np.linalg.pinv(state.jacobian)
        projector = np.eye(7) - inverse @ state.jacobian
        elbow = np.linalg.pinv(jacobians[arm], rcond=1e-8)
        printed = inverse @ twist + projector @ elbow @ (psi * directions[arm])

        def asked(base, n, arm=arm):
            return published_null_speed(n, jacobians[arm], psi, directions[arm])

        q_dot, scale = resolve_null(state.jacobian, twist, asked, -WIDE, WIDE, GAINS)
        assert scale == 1.0
        np.testing.assert_allclose(q_dot, printed, atol=1e-9)


def test_the_tracker_gives_18_the_persons_angle():
    """Mirrored arms are asked for pi - psi; (18) gets psi."""
    q, rng = posture(3), np.random.default_rng(3)
    pose, twist, _, rate = goal(q, rng)
    psi = np.array([0.2, -0.1])
    jacobians, directions = ELBOWS.evaluate(q)
    states = KINEMATICS.evaluate(q)
    for mirrored, swivel in ((True, wrap(np.pi - psi)), (False, psi)):
        tracker = DualArmTracker(KINEMATICS, LIMITS, redundancy="published", mirrored=mirrored)
        q_dot, _, now, *_ = tracker.velocity(q, pose, 0.0 * twist, swivel, rate)
        for arm, state in enumerate(states):
            n = damped_inverse(state.jacobian, GAINS.singular_value, GAINS.damping)[1]
            alpha = published_null_speed(n, jacobians[arm], psi[arm], directions[arm])
            np.testing.assert_allclose(q_dot[7 * arm : 7 * arm + 7], alpha * n, atol=1e-9)
        np.testing.assert_allclose(now, [state.swivel for state in states])


@given(seeds)
def test_none_is_the_pseudo_inverse_alone(seed):
    q, rng = posture(seed), np.random.default_rng(seed)
    pose, twist, swivel, rate = goal(q, rng)
    gains = replace(GAINS, acceleration_share=np.inf)
    tracker = DualArmTracker(KINEMATICS, LIMITS, gains, redundancy="none")
    # A last velocity that is nothing like the next one must not matter: there is no null motion to soften.
    q_dot, *_ = tracker.velocity(q, pose, 0.2 * twist, swivel, rate, rng.normal(size=14), 0.004)
    for arm, state in enumerate(KINEMATICS.evaluate(q)):
        expected = np.linalg.pinv(state.jacobian) @ (0.2 * twist[arm])
        np.testing.assert_allclose(q_dot[7 * arm : 7 * arm + 7], expected, atol=1e-6)


@given(seeds)
def test_the_elbows_jacobian_is_the_points_derivative_and_has_rank_two(seed):
    q, step = posture(seed), 1e-6
    jacobians, directions = ELBOWS.evaluate(q)
    for arm in range(2):
        numeric = np.zeros((3, 7))
        for joint in range(7):
            shift = np.zeros(14)
            shift[7 * arm + joint] = step
            numeric[:, joint] = (ELBOWS.points(q + shift) - ELBOWS.points(q - shift))[arm, 1] / (2 * step)
        np.testing.assert_allclose(jacobians[arm], numeric, atol=1e-8)
        assert np.linalg.matrix_rank(jacobians[arm], tol=1e-9) == 2
        points = ELBOWS.points(q)[arm]
        np.testing.assert_allclose(directions[arm] @ (points[1] - points[0]), 0.0, atol=1e-12)
        np.testing.assert_allclose(directions[arm] @ (points[2] - points[0]), 0.0, atol=1e-12)


def test_the_points_are_those_of_which_the_swivel_is_measured():
    q = posture(5)
    np.testing.assert_allclose(
        swivel_angle(*np.moveaxis(ELBOWS.points(q), 1, 0)), [s.swivel for s in KINEMATICS.evaluate(q)], atol=1e-12
    )


@given(seeds)
def test_published_leaks_the_elbow_task(seed):
    """Asked for the speed psi along its own null motion, the elbow gets |J_E^+ J_E n|^2 psi."""
    q, psi = posture(seed), 0.6
    jacobians, directions = ELBOWS.evaluate(q)
    for state, elbow, direction in zip(KINEMATICS.evaluate(q), jacobians, directions, strict=True):
        n = damped_inverse(state.jacobian, GAINS.singular_value, GAINS.damping)[1]
        share = leak(n, elbow)
        assert 0.0 <= share <= 1.0
        own = elbow @ n / np.linalg.norm(elbow @ n)
        assert own @ elbow @ n * published_null_speed(n, elbow, psi, own) == pytest.approx(share * psi, abs=1e-12)
        # The null motion moves the elbow along U_psi but for the wrist's offset.
        reached = direction @ elbow @ n * published_null_speed(n, elbow, psi, direction)
        assert reached == pytest.approx(share * psi, abs=0.02 * psi)
        assert reached < 0.95 * psi


def test_in_published_the_palms_own_motion_moves_the_elbow_too():
    q = posture(11)
    twist = np.array([0.0, 0.0, 0.0, 0.0, 0.1, 0.1])
    jacobians, directions = ELBOWS.evaluate(q)
    state, elbow, direction = KINEMATICS.evaluate(q)[0], jacobians[0], directions[0]
    speeds = [
        direction
        @ elbow
        @ resolve_null(
            state.jacobian, v, lambda base, n: published_null_speed(n, elbow, 0.3, direction), -WIDE, WIDE, GAINS
        )[0]
        for v in (0.0 * twist, twist)
    ]
    expected = direction @ elbow @ np.linalg.pinv(state.jacobian) @ twist
    assert speeds[1] - speeds[0] == pytest.approx(expected, abs=1e-9)
    assert abs(expected) > 1e-3


@pytest.mark.parametrize("swing", [0.5, -0.5])
def test_published_knows_no_goal(swing):
    """The robot's elbow is where it should be and the person's rests; (18) moves on, outward where the person's is."""
    q = posture(7)
    pose, twist, _, _ = goal(q, np.random.default_rng(7))
    tracker = DualArmTracker(KINEMATICS, LIMITS, redundancy="published")
    swivel = wrap(np.pi - np.array([swing, -swing]))
    states = KINEMATICS.evaluate(q)
    q_dot, *_ = tracker.velocity(q, pose, 0.0 * twist, swivel, np.zeros(2))
    rates = np.array([state.swivel_jacobian @ q_dot[7 * arm : 7 * arm + 7] for arm, state in enumerate(states)])
    # Mirrored arms: the robot's angle falls where the person's is positive.
    assert np.all(rates * [swing, -swing] < -0.01)
    at_rest = np.array([state.swivel for state in states])
    still, *_ = DualArmTracker(KINEMATICS, LIMITS).velocity(q, pose, 0.0 * twist, at_rest, np.zeros(2))
    np.testing.assert_allclose(still, 0.0, atol=1e-6)


@pytest.mark.parametrize("redundancy", REDUNDANCIES)
def test_joint_limits_hold_and_the_palms_do_not_notice(redundancy):
    rng = np.random.default_rng(4)
    tracker, reference = (DualArmTracker(KINEMATICS, LIMITS, redundancy=name) for name in (redundancy, "none"))
    blocked = 0
    for _ in range(60):
        q = rng.uniform(LIMITS.lower + 0.02, LIMITS.upper - 0.02)
        pose, twist, swivel, rate = goal(q, rng)
        q_dot, scale, *_ = tracker.velocity(q, pose, twist, swivel, rate)
        low, high = velocity_bounds(q, LIMITS.lower, LIMITS.upper, LIMITS.velocity, GAINS)
        assert np.all(q_dot >= low - 1e-7)
        assert np.all(q_dot <= high + 1e-7)
        other, other_scale, *_ = reference.velocity(q, pose, twist, swivel, rate)
        np.testing.assert_array_equal(scale, other_scale)
        for arm, state in enumerate(KINEMATICS.evaluate(q)):
            joints = slice(7 * arm, 7 * arm + 7)
            np.testing.assert_allclose(state.jacobian @ (q_dot - other)[joints], 0.0, atol=1e-7)
        blocked += bool(np.any(np.isclose(q_dot, low, atol=1e-9) | np.isclose(q_dot, high, atol=1e-9)))
    assert blocked > 5  # Else nothing was tried.


def test_published_stops_at_a_joints_limit():
    """The elbow is swung on and on, as nothing tells it to stop, until a joint is `limit_margin` from its limit."""
    q = np.tile(HOME, 2).astype(float)
    pose, twist, _, rate = goal(q, np.random.default_rng(0))
    tracker = DualArmTracker(KINEMATICS, LIMITS, redundancy="published")
    start = np.array([state.swivel for state in KINEMATICS.evaluate(q)])
    v = np.zeros(14)
    for _ in range(3000):
        v = tracker.velocity(q, pose, 0.0 * twist, wrap(np.pi - np.array([0.8, -0.8])), 0.0 * rate, v, 0.01)[0]
        q = q + 0.01 * v
    margin = np.minimum(q - LIMITS.lower, LIMITS.upper - q)
    assert margin.min() == pytest.approx(GAINS.limit_margin, abs=1e-3)
    turned = [wrap(state.swivel - angle) for state, angle in zip(KINEMATICS.evaluate(q), start, strict=True)]
    assert np.abs(turned).min() > 0.5
    for arm, state in enumerate(KINEMATICS.evaluate(q)):
        np.testing.assert_allclose(state.position, pose[arm, 4:], atol=2e-3)


@given(st.floats(-0.17, 0.78), st.booleans())
def test_the_persons_angle_comes_back_from_what_the_robot_is_asked(swing, mirrored):
    """For swings that `Retarget` passes on unchanged: up to 45 degrees outward, 10 inward."""
    psi, x = swing * OUTWARD, np.empty((6, 3))
    for arm, side in enumerate((-0.2, 0.2)):
        # An arm that points forward; its elbow swings by psi from straight down towards -x.
        elbow = [-0.1 * np.sin(psi[arm]), 0.2, -0.1 * np.cos(psi[arm])]
        x[3 * arm : 3 * arm + 3] = np.array([[0.0, 0.0, 0.0], elbow, [0.0, 0.4, 0.0]]) + np.array([side, 0.0, 1.4])
    retarget = Retarget(1.0, np.zeros(3), np.zeros(3), np.zeros(2), elbow_up=mirrored)
    asked = retarget_motion(x, np.zeros_like(x), retarget)[2]
    np.testing.assert_allclose(persons_angle(asked, mirrored), psi, atol=1e-12)


def test_an_unknown_redundancy_is_refused_in_one_line():
    with pytest.raises(
        ScenarioError, match="redundancy 'elbows' is none; choose one of swivel, none, published"
    ) as error:
        DualArmTracker(KINEMATICS, LIMITS, replace(GAINS), redundancy="elbows")
    assert "\n" not in str(error.value)
