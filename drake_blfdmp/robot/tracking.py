"""The closed loop around the redundancy resolution: from where the palms should be to joint velocities of both arms."""

import numpy as np

from drake_blfdmp.errors import ScenarioError
from drake_blfdmp.robot.differential_ik import DEFAULT_GAINS, IkGains, resolve, resolve_null, velocity_bounds
from drake_blfdmp.robot.kinematics import ArmState, DualArmKinematics
from drake_blfdmp.robot.plant import JOINTS_PER_ARM, JointLimits
from drake_blfdmp.robot.redundancy import REDUNDANCIES, ElbowKinematics, persons_angle, published_null_speed
from drake_blfdmp.robot.swivel import wrap


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


class DualArmTracker:
    """Joint velocities that move both palms to their poses and, as far as possible, the elbows to the swivel angles."""

    def __init__(
        self,
        kinematics: DualArmKinematics,
        limits: JointLimits,
        gains: IkGains = DEFAULT_GAINS,
        redundancy: str = "swivel",
        mirrored: bool = True,
    ):
        """Use joint limits (14,) and gains.

        Args:
            kinematics: of both arms.
            limits: of their joints.
            gains: of the closed loop.
            redundancy: what fills the null space, one of `robot.redundancy.REDUNDANCIES`.
            mirrored: the arms hold their elbows up (`Retarget.elbow_up`); `published` alone needs to know.

        Raises:
            ScenarioError: there is no such redundancy.
        """
        if redundancy not in REDUNDANCIES:
            raise ScenarioError(f"redundancy '{redundancy}' is none; choose one of {', '.join(REDUNDANCIES)}")
        self._kinematics, self._limits, self._gains = kinematics, limits, gains
        self._redundancy, self._mirrored = redundancy, mirrored
        self._elbows = ElbowKinematics() if redundancy == "published" else None

    def velocity(self, q, pose, twist, swivel, swivel_rate, previous=None, time_step: float = 0.0):
        """Joint velocities at q.

        Args:
            q: (14,) rad.
            pose: (2, 7) X_WP desired.
            twist: (2, 6) V_WP desired.
            swivel: (2,) desired, rad.
            swivel_rate: (2,) desired, rad/s.
            previous: (14,) the last joint velocities, rad/s, `time_step` s ago; without them the null motion may jump.

        Returns:
            q' (14,), rad/s; the share (2,) of each palm's commanded twist that is met; the swivel angles (2,) now.
        """
        gains, limits = self._gains, self._limits
        low, high = velocity_bounds(q, limits.lower, limits.upper, limits.velocity, gains)
        q_dot, scale, now = np.empty(2 * JOINTS_PER_ARM), np.empty(2), np.empty(2)
        elbows = None if self._elbows is None else self._elbows.evaluate(q)
        for arm, state in enumerate(self._kinematics.evaluate(q)):
            joints = slice(arm * JOINTS_PER_ARM, (arm + 1) * JOINTS_PER_ARM)
            command = twist[arm] + gains.pose * pose_error(state, pose[arm])
            bounds = low[joints], high[joints]
            gentle = None if previous is None else (previous[joints], gains.null_acceleration * time_step)
            if self._redundancy == "swivel":
                rate = swivel_rate[arm] + gains.swivel * wrap(swivel[arm] - state.swivel)
                rate = np.clip(rate, -gains.swivel_rate, gains.swivel_rate)
                solved = resolve(state.jacobian, command, state.swivel_jacobian, rate, *bounds, gains, gentle)
            elif elbows is None:  # J^+ X' alone has no null motion that could jump.
                solved = resolve_null(state.jacobian, command, _no_speed, *bounds, gains)
            else:
                asked = self._published_speed(elbows[0][arm], elbows[1][arm], swivel[arm])
                solved = resolve_null(state.jacobian, command, asked, *bounds, gains, gentle)
            q_dot[joints], scale[arm] = solved
            now[arm] = state.swivel
        return q_dot, scale, now

    def _published_speed(self, jacobian, direction, swivel):
        psi = persons_angle(swivel, self._mirrored)
        return lambda base, n: published_null_speed(n, jacobian, psi, direction)


def _no_speed(base, n) -> float:
    return 0.0
