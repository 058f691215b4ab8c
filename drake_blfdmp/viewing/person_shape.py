"""The shape of the person who stands as a ghost in the scene: body and legs, life-size, each one surface.

One surface each, for of several translucent ones the seams would show. Arms are not part of it: they are what moves,
and `skeleton_drawer` draws them.
"""

import numpy as np

SHOULDER_ABOVE_HIP = 0.55
"""m"""

LEG = 0.84
"""Height of the hips over the floor for legs as `legs` has them, m."""

_AROUND = 28

# Height, half width, half depth and how far forward the middle is, m, from the shoulders' line, top to bottom.
_BODY = (
    (0.365, 0.000, 0.000, 0.030),
    (0.360, 0.032, 0.040, 0.030),
    (0.340, 0.058, 0.074, 0.030),
    (0.300, 0.074, 0.093, 0.030),
    (0.255, 0.076, 0.096, 0.032),
    (0.205, 0.067, 0.085, 0.037),
    (0.165, 0.051, 0.062, 0.040),
    (0.145, 0.046, 0.050, 0.024),
    (0.085, 0.049, 0.053, 0.006),
    (0.055, 0.075, 0.062, 0.000),
    (0.030, 0.125, 0.078, 0.000),
    (-0.005, 0.172, 0.092, 0.000),
    (-0.060, 0.188, 0.106, 0.004),
    (-0.140, 0.178, 0.114, 0.008),
    (-0.240, 0.156, 0.108, 0.006),
    (-0.330, 0.142, 0.102, 0.002),
    (-0.420, 0.154, 0.110, 0.000),
    (-0.500, 0.170, 0.116, -0.004),
    (-0.560, 0.178, 0.114, -0.004),
    (-0.610, 0.178, 0.106, 0.000),
    (-0.610, 0.000, 0.000, 0.000),
)
_LEG = (  # From the floor, at the middle of one leg; open at the top, where the hips cover it.
    (0.790, 0.084, 0.098, 0.000),
    (0.640, 0.070, 0.080, 0.004),
    (0.480, 0.056, 0.060, 0.006),
    (0.360, 0.053, 0.057, -0.006),
    (0.200, 0.041, 0.044, -0.008),
    (0.090, 0.037, 0.043, 0.000),
    (0.060, 0.043, 0.085, 0.040),
    (0.020, 0.047, 0.115, 0.062),
    (0.000, 0.045, 0.112, 0.062),
    (0.000, 0.000, 0.000, 0.062),
)
_BETWEEN_LEGS = 0.185


def _lofted(sections, right: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """The surface through ellipses stacked top to bottom, their middles at x = `right`, m.

    Returns: vertices (3, V), m, x to the person's right, y forward, z up; and triangles (3, T), counter-clockwise from
        outside.
    """
    z, width, depth, forward = np.asarray(sections, dtype=float).T
    angle = 2.0 * np.pi * np.arange(_AROUND) / _AROUND
    x = right + np.outer(width, np.cos(angle))
    y = forward[:, None] + np.outer(depth, np.sin(angle))
    vertices = np.stack([x, y, np.broadcast_to(z[:, None], x.shape)]).reshape(3, -1)
    ring, around = np.meshgrid(np.arange(len(z) - 1), np.arange(_AROUND), indexing="ij")
    upper, beside = _AROUND * ring + around, _AROUND * ring + (around + 1) % _AROUND
    lower, below_beside = upper + _AROUND, beside + _AROUND
    faces = np.concatenate(
        [np.stack([upper, lower, below_beside]).reshape(3, -1), np.stack([upper, below_beside, beside]).reshape(3, -1)],
        axis=1,
    )
    p = vertices[:, faces]
    area = np.linalg.norm(np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0], axis=0), axis=0)
    return vertices, faces[:, area > 1e-12]


def body() -> tuple[np.ndarray, np.ndarray]:
    """Head to hips: vertices (3, V), m, from the middle between the shoulders, x right, y forward; triangles (3, T)."""
    return _lofted(_BODY)


def legs() -> tuple[np.ndarray, np.ndarray]:
    """Both legs, from the floor below the hips' middle to the hips at `LEG`: as of `body`."""
    parts = [_lofted(_LEG, 0.5 * side * _BETWEEN_LEGS) for side in (-1.0, 1.0)]
    count = parts[0][0].shape[1]
    return np.hstack([vertices for vertices, _ in parts]), np.hstack([parts[0][1], parts[1][1] + count])
