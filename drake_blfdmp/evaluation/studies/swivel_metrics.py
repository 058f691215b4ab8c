"""How far the robot's elbows are from where the person's swivel angle wants them: pure functions of arrays."""

import numpy as np

from drake_blfdmp.vectors import dot
from drake_blfdmp.viewing.robot_figures import unwrap_known


def swivel_error(swivel, desired) -> np.ndarray:
    """Robot minus desired swivel angle (N, A), rad, without jumps of a whole turn; within half a turn where it begins.

    An elbow that has gone round once is then a whole turn off, not right again. NaN stays NaN.

    Args:
        swivel, desired: (N, A) rad, one column an arm; NaN where unknown.
    """
    pairs = zip(np.asarray(swivel, dtype=float).T, np.asarray(desired, dtype=float).T, strict=True)
    error = np.stack([unwrap_known(robot) - unwrap_known(asked) for robot, asked in pairs], axis=-1)
    for column in error.T:
        known = column[np.isfinite(column)]
        if known.size:
            column -= 2.0 * np.pi * np.round(known[0] / (2.0 * np.pi))
    return error


def swivel_rms(swivel, desired) -> np.ndarray:
    """Root mean square (A,) of `swivel_error` over its known samples, rad; NaN for an arm without any."""
    error = swivel_error(swivel, desired)
    known = np.isfinite(error)
    count = known.sum(axis=0)
    total = np.sum(np.where(known, error, 0.0) ** 2, axis=0)
    return np.sqrt(np.where(count > 0, total, np.nan) / np.maximum(count, 1))


def elbow_distance(points, error) -> np.ndarray:
    """How far (...) each elbow is from where it would be with no swivel error, shoulder and wrist as they are, m.

    The chord of the circle about the line from shoulder to wrist on which the elbow swings.

    Args:
        points: (..., 3, 3) shoulder, elbow and wrist, m.
        error: (...) rad.
    """
    points = np.asarray(points, dtype=float)
    e, w = points[..., 1, :] - points[..., 0, :], points[..., 2, :] - points[..., 0, :]
    radius = np.sqrt(np.maximum(dot(e, e) - dot(e, w) ** 2 / dot(w, w), 0.0))
    return 2.0 * radius * np.abs(np.sin(0.5 * np.asarray(error)))
