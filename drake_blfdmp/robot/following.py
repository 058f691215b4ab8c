"""Postures of both arms along paths of palm poses: closed-loop following, of many paths side by side.

A path's samples come one after the other, but paths do not know of each other: the candidates of a search are followed
in lockstep, their kinematics evaluated together.
"""

from dataclasses import dataclass

import numpy as np

from drake_blfdmp.robot.differential_ik import (
    DEFAULT_GAINS,
    IkGains,
    calm_scale,
    null_interval,
    scale_interval,
    velocity_bounds,
)
from drake_blfdmp.robot.kinematics import DualArmKinematics
from drake_blfdmp.robot.plant import JOINTS_PER_ARM, JointLimits
from drake_blfdmp.robot.swivel import wrap
from drake_blfdmp.robot.tracking import bent_limits, rotation_matrix

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


def follow(
    kinematics: DualArmKinematics, limits: JointLimits, q, pose, swivel, *, substeps: int = 25, give_up: float = np.inf
) -> Following:
    """`follow_all` of one path: q (14,), pose (N, 2, 7), swivel (N, 2)."""
    one = (np.asarray(array)[None] for array in (q, pose, swivel))
    return follow_all(kinematics, limits, *one, substeps=substeps, give_up=give_up)[0]


def follow_all(
    kinematics: DualArmKinematics, limits: JointLimits, q, pose, swivel, *, substeps: int = 25, give_up: float = np.inf
) -> list[Following]:
    """Follow M paths of N palm poses and swivel angles, up to `substeps` Newton steps to a sample.

    Joint limits hold as in the running system (`tracking`); speed does not count here. The rest of a path is skipped
    once a palm is off by more than `give_up` (m or rad); its postures are then those of the last sample tried.

    Args:
        kinematics: of both arms.
        limits: of their joints.
        q: (M, 14) where the paths begin, rad.
        pose: (M, N, 2, 7) X_WP.
        swivel: (M, N, 2) rad.
        substeps: at most so many to a sample.
        give_up: m or rad.
    """
    count, samples = pose.shape[:2]
    bent = bent_limits(limits, kinematics.straight_elbow)
    lower, upper = (array.reshape(2, JOINTS_PER_ARM) for array in (bent.lower, bent.upper))
    q = np.array(q, dtype=float).reshape(count, 2, JOINTS_PER_ARM)
    turned = np.moveaxis(rotation_matrix(np.moveaxis(pose[..., :4], -1, 0)), (0, 1), (-2, -1))
    path = np.empty((count, samples, 2, JOINTS_PER_ARM))
    worst_pose, worst_turn = np.zeros(count), np.zeros(count)
    alive = np.arange(count)
    for k in range(samples):
        rows = alive
        off, turn = np.zeros(count), np.zeros(count)
        for trial in range(substeps + 1):
            arms = np.tile([0, 1], len(rows))
            rotation, position, jacobian, psi, along = kinematics.chains.evaluate(arms, q[rows].reshape(-1, 7))
            errors = _pose_errors(rotation, position, turned[rows, k].reshape(-1, 3, 3), pose[rows, k, :, 4:])
            swing = wrap(swivel[rows, k].ravel() - psi)
            off[rows] = np.abs(errors).max(axis=1).reshape(-1, 2).max(axis=1)
            turn[rows] = np.abs(swing).reshape(-1, 2).max(axis=1)
            done = (off[rows] < CONVERGED) & ((turn[rows] < CONVERGED) | (trial >= SWIVEL_STEPS))
            if trial == substeps or done.all():
                break
            more = np.repeat(~done, 2)
            rows = rows[~done]
            now = q[rows].reshape(-1, JOINTS_PER_ARM)
            bounds = velocity_bounds(now, lower[arms[more]], upper[arms[more]], np.inf, _NEWTON)
            q[rows] += _step(jacobian[more], errors[more], along[more], swing[more], *bounds).reshape(-1, 2, 7)
        path[:, k] = q
        worst_pose[alive] = np.maximum(worst_pose[alive], off[alive])
        worst_turn[alive] = np.maximum(worst_turn[alive], turn[alive])
        alive = alive[worst_pose[alive] <= give_up]
        if len(alive) == 0:
            path[:, k:] = q[:, None]
            break
    path = path.reshape(count, samples, 2 * JOINTS_PER_ARM)
    margin = np.minimum(path - limits.lower, limits.upper - path).min(axis=(1, 2))
    return [Following(path[i], float(worst_pose[i]), float(worst_turn[i]), float(margin[i])) for i in range(count)]


_NEWTON = IkGains(pose=1.0, swivel=1.0, swivel_rate=0.3, limit_gain=1.0, velocity_share=1.0)
"""With these gains a second's motion is one Newton step."""


def _pose_errors(rotation, position, turned, wanted):
    """`tracking.pose_error` of n palms: (n, 6)."""
    turn = turned @ rotation.swapaxes(1, 2)
    errors = np.empty((len(turn), 6))
    errors[:, 0], errors[:, 1] = turn[:, 2, 1] - turn[:, 1, 2], turn[:, 0, 2] - turn[:, 2, 0]
    errors[:, 2] = turn[:, 1, 0] - turn[:, 0, 1]
    errors[:, :3] *= 0.5
    errors[:, 3:] = wanted.reshape(-1, 3) - position
    return errors


def _step(jacobian, errors, along, swing, low, high):
    """The step (n, 7) of n arms at rest: `differential_ik.resolve`, whose bounds at rest always contain 0."""
    u, s, vt = np.linalg.svd(jacobian)
    small = np.maximum(0.0, 1.0 - (s / DEFAULT_GAINS.singular_value) ** 2)
    gain = s / (s * s + small * DEFAULT_GAINS.damping**2)
    base = (vt[:, :6].swapaxes(1, 2) @ (gain * (u.swapaxes(1, 2) @ errors[..., None])[..., 0])[..., None])[..., 0]
    n = vt[:, 6]
    least, most = null_interval(base, n, low, high)
    tight = np.flatnonzero(least > most)
    if len(tight):
        limits = n[tight], low[tight], high[tight]
        smallest, largest = scale_interval(base[tight], *limits)
        scale = np.clip(largest, 0.0, 1.0)
        scale = calm_scale(base[tight], *limits, np.maximum(smallest, 0.0), scale)
        base[tight] *= scale[:, None]
        least[tight], most[tight] = null_interval(base[tight], *limits)
        middle = 0.5 * (least[tight] + most[tight])
        least[tight], most[tight] = np.minimum(least[tight], middle), np.maximum(most[tight], middle)
    rate = np.clip(swing, -_NEWTON.swivel_rate, _NEWTON.swivel_rate)
    slope = np.sum(along * n, axis=1)
    floor = np.maximum(0.0, 1.0 - (slope / _NEWTON.null_floor) ** 2) * _NEWTON.null_floor**2
    alpha = (rate - np.sum(along * base, axis=1)) * slope / (slope * slope + floor)
    step = base + np.clip(alpha, least, most)[:, None] * n
    return np.minimum(np.maximum(step, low), high)
