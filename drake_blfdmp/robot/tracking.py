"""The closed loop around the redundancy resolution: from where the palms should be to joint velocities of both arms."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from drake_blfdmp.errors import ScenarioError
from drake_blfdmp.robot.braking import ENDLESS, braking_share, braking_speed
from drake_blfdmp.robot.differential_ik import (
    DEFAULT_GAINS,
    IkGains,
    damped_inverse,
    resolve,
    resolve_null,
    velocity_bounds,
    within_reach,
)
from drake_blfdmp.robot.kinematics import ArmState, DualArmKinematics
from drake_blfdmp.robot.nearest_velocity import nearest_velocities, twist_size
from drake_blfdmp.robot.pair_clearance import PairClearance
from drake_blfdmp.robot.plant import JOINTS_PER_ARM, JointLimits
from drake_blfdmp.robot.redundancy import REDUNDANCIES, ElbowKinematics, persons_angle, published_null_speed
from drake_blfdmp.robot.swivel import wrap

CORRECTION_SHARE = 0.5
"""Share of the joint accelerations with which corrections count on being braked; the motion itself needs the rest."""

ELBOW_JOINT = 3

REACHED = 1e-9
"""Rates of distances that are missed by less, m/s, count as met."""


def rotation_matrix(q):
    """Rotation matrix (3, 3) of a unit quaternion w x y z."""
    w, x, y, z = q
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def pose_error(state: ArmState, pose) -> np.ndarray:
    """The error (6,) from the arm's palm to a pose (qw qx qy qz x y z): a rotation vector (rad) in W, then metres.

    The rotation vector is sin(angle) times the axis, which for the small errors of a closed loop is the angle itself
    and beyond 90 degrees still turns the right way.
    """
    desired = rotation_matrix(pose[:4])
    turn = desired @ state.rotation.T
    error = np.empty(6)
    error[0], error[1], error[2] = turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]
    error[:3] *= 0.5
    error[3:] = pose[4:] - state.position
    return error


def bent_limits(limits: JointLimits, straight_elbow) -> JointLimits:
    """The limits (14,) that keep the elbows bent the way they are: joint 4 no further than straight (2,), rad.

    A Panda's arm is longest at -0.47 rad, before joint 4's own limit. Beyond, the same palm poses have a second
    solution; an arm that is asked for more than it can reach would slip into it, turn its swivel over by pi, and come
    back on the wrong side until joint 4 stops it for good.
    """
    upper = np.array(limits.upper, dtype=float)
    elbows = [ELBOW_JOINT, ELBOW_JOINT + JOINTS_PER_ARM]
    upper[elbows] = np.minimum(upper[elbows], straight_elbow)
    return replace(limits, upper=upper)


class Tracked(NamedTuple):
    """What `DualArmTracker.velocity` returns.

    Attributes:
        velocity: (14,) q', rad/s.
        scale: (2,) the share of each palm's commanded twist that is met, in [0, 1].
        swivel: (2,) the swivel angles now, rad.
        deviation: (2,) m/s, the size (`nearest_velocity.twist_size`) of what each palm does beside that share: what
            damping near a singularity takes away, and what the joints cannot brake or turn in time.
        clearance: least distance of the arms now, m; inf where none is near or nobody asked.
        palms: (2, 3) where the palms are one step on, m in W.
        near: record of the near pairs of links (`PairClearance.near`), to be given back; empty if nobody asked.
    """

    velocity: np.ndarray
    scale: np.ndarray
    swivel: np.ndarray
    deviation: np.ndarray
    clearance: float
    palms: np.ndarray
    near: np.ndarray


class DualArmTracker:
    """Joint velocities that move both palms to their poses and, as far as possible, the elbows to the swivel angles.

    The corrections of pose and swivel brake in time: an error's linear decay that the joints could not follow down is
    replaced by the parabola they can (`braking`). Without that, a bounded acceleration makes the loop overshoot and
    swing (docs/redundancy.md).
    """

    def __init__(
        self,
        kinematics: DualArmKinematics,
        limits: JointLimits,
        gains: IkGains = DEFAULT_GAINS,
        redundancy: str = "swivel",
        mirrored: bool = True,
        clearance: float | None = None,
    ):
        """Use joint limits (14,) and gains.

        Args:
            kinematics: of both arms.
            limits: of their joints.
            gains: of the closed loop.
            redundancy: what fills the null space, one of `robot.redundancy.REDUNDANCIES`.
            mirrored: the arms hold their elbows up (`Retarget.elbow_up`); `published` alone needs to know.
            clearance: m, that the arms keep from themselves and each other, in the null space first, then by scaling;
                None: not looked at, which saves the time.

        Raises:
            ScenarioError: there is no such redundancy, or `clearance` is not > 0.
        """
        if redundancy not in REDUNDANCIES:
            raise ScenarioError(f"redundancy '{redundancy}' is none; choose one of {', '.join(REDUNDANCIES)}")
        if clearance is not None and not 0.0 < clearance < np.inf:
            raise ScenarioError(f"clearance {clearance} of the inverse kinematics must be > 0 m, or None")
        self._kinematics, self._gains = kinematics, gains
        self._limits = bent_limits(limits, kinematics.straight_elbow)
        self._redundancy, self._mirrored = redundancy, mirrored
        self._elbows = ElbowKinematics() if redundancy == "published" else None
        self._pairs = None if clearance is None else PairClearance(clearance)

    def velocity(
        self, q, pose, twist, swivel, swivel_rate, previous=None, time_step: float = 0.0, commanded=None, near=None
    ) -> Tracked:
        """Joint velocities at q.

        Args:
            q: (14,) rad.
            pose: (2, 7) X_WP desired.
            twist: (2, 6) V_WP desired.
            swivel: (2,) desired, rad.
            swivel_rate: (2,) desired, rad/s.
            previous: (14,) the last joint velocities, rad/s, `time_step` s ago; without them accelerations are not
                limited and the null motion may jump.
            time_step: s.
            commanded: (14,) rad, the position that the velocities are integrated from, where that is not q: it too
                stays within its limits.
            near: `Tracked.near` of the last call, which saves looking for near pairs while the arms have hardly moved.
        """
        gains = self._gains
        acceleration = np.full(2 * JOINTS_PER_ARM, ENDLESS)
        if previous is not None:
            acceleration = gains.acceleration_share * self._limits.acceleration
        low, high = self._bounds(q, previous, acceleration, time_step, commanded)
        states = self._kinematics.evaluate(q)
        jacobians = np.array([state.jacobian for state in states])
        inverses = [damped_inverse(jacobian, gains.singular_value, gains.damping) for jacobian in jacobians]
        commands = gains.pose * np.array([pose_error(state, pose[arm]) for arm, state in enumerate(states)])
        if previous is not None:
            commands *= self._brakeable(inverses, commands, acceleration, time_step)[:, None]
        commands += twist
        now = np.array([state.swivel for state in states])
        rates = np.zeros(2)
        if self._redundancy == "swivel":
            reserve = ENDLESS if previous is None else CORRECTION_SHARE * gains.null_acceleration
            along = [state.swivel_jacobian @ n for state, (_, n) in zip(states, inverses, strict=True)]
            back = self._swivel_correction(swivel - now, along, reserve, time_step)
            rates = swivel_rate + np.clip(back, -gains.swivel_return, gains.swivel_return)
            rates = np.clip(rates, -gains.swivel_rate, gains.swivel_rate)
        elbows = None if self._elbows is None else self._elbows.evaluate(q)

        shape = 2, JOINTS_PER_ARM
        low, high, q_dot, scale = low.reshape(shape), high.reshape(shape), np.empty(shape), np.empty(2)
        for arm, (state, inverse) in enumerate(zip(states, inverses, strict=True)):
            bounds = low[arm], high[arm]
            gentle = None
            if previous is not None:
                gentle = previous.reshape(shape)[arm], gains.null_acceleration * time_step
            task = state.jacobian, commands[arm]
            if self._redundancy == "swivel":
                solved = resolve(*task, state.swivel_jacobian, rates[arm], *bounds, gains, gentle, inverse)
            elif elbows is None:  # J^+ X' alone has no null motion that could jump.
                solved = resolve_null(*task, _no_speed, *bounds, gains, None, inverse)
            else:
                asked = self._published_speed(elbows[0][arm], elbows[1][arm], swivel[arm])
                solved = resolve_null(*task, asked, *bounds, gains, gentle, inverse)
            q_dot[arm], scale[arm] = solved
        nearest, record = np.inf, np.zeros(0)
        if self._pairs is not None:
            record = self._pairs.near(q, near)
            distances, rows = self._pairs.carried_on(record, q)
            nearest = float(distances.min(initial=np.inf))
            least = self._pairs.least_rates(
                distances, rows, gains.limit_gain, CORRECTION_SHARE * acceleration, time_step
            )
            if np.any(rows @ q_dot.ravel() < least - REACHED):
                bases = np.array([inverse @ command for (inverse, _), command in zip(inverses, commands, strict=True)])
                q_dot, scale = nearest_velocities(jacobians, bases, q_dot, low, high, rows, least)
        # The last digit is the bounds'.
        q_dot = np.minimum(np.maximum(q_dot, low), high)
        moved = (jacobians @ q_dot[..., None])[..., 0]
        palms = np.array([state.position for state in states]) + time_step * moved[:, 3:]
        return Tracked(q_dot.ravel(), scale, now, twist_size(moved - scale[:, None] * commands), nearest, palms, record)

    def _bounds(self, q, previous, acceleration, time_step, commanded):
        """The interval of each joint's velocity, (14,) and (14,): from its limits at q, and what it can reach."""
        gains, limits = self._gains, self._limits
        low, high = -np.inf, np.inf
        for where in (q,) if commanded is None else (q, commanded):
            least, most = velocity_bounds(
                where, limits.lower, limits.upper, limits.velocity, gains, acceleration, time_step
            )
            low, high = np.maximum(low, least), np.minimum(high, most)
        if previous is None:
            return low, high
        return within_reach(low, high, previous, acceleration * time_step)

    def _brakeable(self, inverses, corrections, acceleration, time_step):
        """The shares (2,) of pose corrections (2, 6) that the joints can brake as they decay."""
        speeds = np.concatenate([inverse @ twist for (inverse, _), twist in zip(inverses, corrections, strict=True)])
        demand = np.abs(speeds) / (CORRECTION_SHARE * acceleration)
        return braking_share(
            self._gains.pose * demand.reshape(2, JOINTS_PER_ARM).max(axis=1), self._gains.pose, time_step
        )

    def _swivel_correction(self, errors, along, null_acceleration, time_step):
        """The rates (2,), rad/s, that take the swivel errors (2,) away and can be braked by null motion.

        `along` (2,) is J_psi n, `null_acceleration` in rad/s^2 along n.
        """
        errors = wrap(errors)
        speed = braking_speed(np.abs(errors), self._gains.swivel, null_acceleration * np.abs(along), time_step)
        return np.copysign(speed, errors)

    def _published_speed(self, jacobian, direction, swivel):
        psi = persons_angle(swivel, self._mirrored)
        return lambda base, n: published_null_speed(n, jacobian, psi, direction)


def _no_speed(base, n) -> float:
    return 0.0
