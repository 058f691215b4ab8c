"""Postures of both arms along a path of palm poses: a start by Newton's method, then closed-loop following."""

from dataclasses import dataclass

import numpy as np

from drake_blfdmp.robot.differential_ik import DEFAULT_GAINS, IkGains
from drake_blfdmp.robot.kinematics import DualArmKinematics
from drake_blfdmp.robot.plant import HOME, JOINTS_PER_ARM, JointLimits
from drake_blfdmp.robot.swivel import wrap
from drake_blfdmp.robot.tracking import DualArmTracker, pose_error, rotation_matrix

ROLL_JOINT = 6  # The palm's normal is the axis of joint 7, so rolling the palm is turning joint 7.

CONVERGED = 1e-4  # m or rad.
SWIVEL_STEPS = 4  # Steps given to the swivel once the palm is there.


@dataclass(frozen=True)
class Following:
    """How well the arms follow a path of N samples.

    Attributes:
        q: (N, 14) rad.
        pose_error: largest error of a palm's position (m) or orientation (rad) over path and arms.
        swivel_error: largest swivel error, rad.
        joint_margin: least distance of any joint from its limits, rad.
    """

    q: np.ndarray
    pose_error: float
    swivel_error: float
    joint_margin: float

    @property
    def shoulder_lean(self) -> float:
        """How far the upper arms stay from straight up, where joints 1 and 3 share an axis, rad; 0 if one crosses.

        There the joints need any speed for a small motion of the elbow.
        """
        lean = self.q[:, [1, 1 + JOINTS_PER_ARM]]
        crosses = (lean.min(axis=0) < 0.0) & (lean.max(axis=0) > 0.0)
        return float(np.where(crosses, 0.0, np.abs(lean).min(axis=0)).min())


def starting_posture(
    kinematics: DualArmKinematics, limits: JointLimits, pose, swivel, *, seeds: int = 12, seed: int = 0
) -> np.ndarray | None:
    """A posture with both palms at `pose` but for their roll, left to joint 7 = 0, and the given swivel angles.

    Position, normal and swivel are six conditions for joints 1-6. Damped Newton from HOME and from random postures;
    of all solutions the one farthest from its limits.

    Args:
        kinematics: of both arms.
        limits: of their joints.
        pose: (2, 7) X_WP.
        swivel: (2,) rad.
        seeds: postures Newton's method starts from, for each arm.
        seed: of the random ones among them.

    Returns:
        q (14,), or None where one of the arms has no solution.
    """
    rng = np.random.default_rng(seed)
    q = np.tile(HOME, 2).astype(float)
    for arm in range(2):
        joints = slice(arm * JOINTS_PER_ARM, (arm + 1) * JOINTS_PER_ARM)
        lower, upper = limits.lower[joints], limits.upper[joints]
        best, best_margin = None, 0.0
        for trial in range(seeds):
            guess = np.array(HOME) if trial == 0 else rng.uniform(lower, upper)
            guess[ROLL_JOINT] = 0.0
            solution = _newton(kinematics, arm, guess, pose[arm], swivel[arm])
            if solution is None:
                continue
            # Joint 6 reaches beyond pi: whole turns are counted from the lower limit, not from -pi.
            solution = lower + (solution - lower) % (2 * np.pi)
            margin = np.minimum(solution - lower, upper - solution).min()
            if margin > best_margin:
                best, best_margin = solution, margin
        if best is None:
            return None
        q[joints] = best
    return q


def _newton(kinematics, arm, guess, pose, swivel, iterations: int = 60):
    normal = rotation_matrix(pose[:4])[:, 2]
    q = np.tile(HOME, 2).astype(float)
    joints = slice(arm * JOINTS_PER_ARM, (arm + 1) * JOINTS_PER_ARM)
    q[joints] = guess
    for _ in range(iterations):
        state = kinematics.evaluate(q)[arm]
        z = state.rotation[:, 2]
        turn = np.cross(z, normal) if z @ normal > -0.9 else state.rotation[:, 0]
        error = np.concatenate([turn, pose[4:] - state.position, [wrap(swivel - state.swivel)]])
        if np.linalg.norm(error) < 1e-6:
            return q[joints].copy()
        jacobian = np.vstack([state.jacobian, state.swivel_jacobian])[:, :ROLL_JOINT]
        jacobian[:3] -= np.outer(z, z @ jacobian[:3])
        step = jacobian.T @ np.linalg.solve(jacobian @ jacobian.T + 1e-4 * np.eye(7), error)
        q[joints][:ROLL_JOINT] += step * min(1.0, 0.5 / np.abs(step).max())
    return None


def palm_rolls(kinematics: DualArmKinematics, q, pose) -> np.ndarray:
    """How far each palm at q is rolled about its normal from `pose` (2, 7): (2,) rad."""
    rolls = np.empty(2)
    for arm, state in enumerate(kinematics.evaluate(q)):
        relative = rotation_matrix(pose[arm][:4]).T @ state.rotation
        rolls[arm] = np.arctan2(relative[1, 0], relative[0, 0])
    return rolls


def follow(
    kinematics: DualArmKinematics,
    limits: JointLimits,
    q,
    pose,
    swivel,
    *,
    gains: IkGains = DEFAULT_GAINS,
    substeps: int = 25,
    give_up: float = np.inf,
) -> Following:
    """Follow (N, 2, 7) palm poses and (N, 2) swivel angles from q, up to `substeps` Newton steps to a sample.

    Joint limits hold as in the running system; speed does not count here. The rest of a path is skipped once a palm
    is off by more than `give_up` (m or rad); its postures are then those of the last sample tried.
    """
    still = JointLimits(limits.lower, limits.upper, np.full(14, np.inf), limits.acceleration, limits.effort)
    newton = IkGains(
        pose=1.0,
        swivel=1.0,
        swivel_rate=0.3,
        singular_value=gains.singular_value,
        damping=gains.damping,
        null_floor=gains.null_floor,
        limit_gain=1.0,
        limit_margin=gains.limit_margin,
        velocity_share=1.0,
    )
    tracker = DualArmTracker(kinematics, still, newton)
    q = np.array(q, dtype=float)
    path, worst_pose, worst_swivel = np.empty((len(pose), 14)), 0.0, 0.0
    rest = np.zeros((2, 6)), np.zeros(2)
    for k in range(len(pose)):
        for trial in range(substeps + 1):
            states = kinematics.evaluate(q)
            off = max(float(np.abs(pose_error(state, pose[k, arm])).max()) for arm, state in enumerate(states))
            turn = max(abs(float(wrap(swivel[k, arm] - state.swivel))) for arm, state in enumerate(states))
            if trial == substeps or (off < CONVERGED and (turn < CONVERGED or trial >= SWIVEL_STEPS)):
                break
            q = q + tracker.velocity(q, pose[k], rest[0], swivel[k], rest[1])[0]
        path[k] = q
        worst_pose, worst_swivel = max(worst_pose, off), max(worst_swivel, turn)
        if worst_pose > give_up:
            path[k:] = q
            break
    margin = float(np.minimum(path - limits.lower, limits.upper - path).min())
    return Following(path, worst_pose, worst_swivel, margin)
