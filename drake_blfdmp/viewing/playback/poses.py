"""Poses as homogeneous matrices (..., 4, 4) and as x y z (m) qx qy qz qw (..., 7), the order of ROS 2 transforms.

`drake_blfdmp.quaternions` needs SciPy; playback does without.
"""

import numpy as np


def matrices(poses) -> np.ndarray:
    """Homogeneous matrices (..., 4, 4) of poses (..., 7); quaternions need not be of unit length, zero means none."""
    poses = np.asarray(poses, dtype=float)
    q = poses[..., 3:]
    norm = np.linalg.norm(q, axis=-1, keepdims=True)
    x, y, z, w = np.moveaxis(np.where(norm > 1e-9, q / np.where(norm > 1e-9, norm, 1.0), [0.0, 0.0, 0.0, 1.0]), -1, 0)
    X = np.zeros((*poses.shape[:-1], 4, 4))
    X[..., 0, 0], X[..., 0, 1], X[..., 0, 2] = 1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)
    X[..., 1, 0], X[..., 1, 1], X[..., 1, 2] = 2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)
    X[..., 2, 0], X[..., 2, 1], X[..., 2, 2] = 2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)
    X[..., :3, 3], X[..., 3, 3] = poses[..., :3], 1.0
    return X


def quaternions(X) -> np.ndarray:
    """Unit quaternions (..., 4), x y z w, of the rotations in X (..., 4, 4) or (..., 3, 3)."""
    R = np.asarray(X, dtype=float)[..., :3, :3]
    trace = np.trace(R, axis1=-2, axis2=-1)
    d = np.stack([R[..., 0, 0], R[..., 1, 1], R[..., 2, 2], trace], axis=-1)
    # Four times the outer product q q^T has its best-conditioned row where the diagonal is largest (Shepperd).
    best = np.argmax(d, axis=-1)
    outer = np.empty((*R.shape[:-2], 4, 4))
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        outer[..., i, i] = 1.0 + R[..., i, i] - R[..., j, j] - R[..., k, k]
        outer[..., i, j] = outer[..., j, i] = R[..., i, j] + R[..., j, i]
        outer[..., i, 3] = outer[..., 3, i] = R[..., k, j] - R[..., j, k]
    outer[..., 3, 3] = 1.0 + trace
    q = np.take_along_axis(outer, best[..., None, None], axis=-2)[..., 0, :]
    return q / np.linalg.norm(q, axis=-1, keepdims=True)


def continuous(q) -> np.ndarray:
    """The same rotations (N, 4) with the signs that make neighbours along the first axis near each other."""
    q = np.asarray(q)
    flips = np.where(np.sum(q[1:] * q[:-1], axis=-1) < 0.0, -1.0, 1.0)
    return q * np.concatenate([[1.0], np.cumprod(flips)])[:, None]


def inverse(X) -> np.ndarray:
    """The inverse (..., 4, 4)."""
    X = np.asarray(X, dtype=float)
    R = np.swapaxes(X[..., :3, :3], -1, -2)
    result = np.zeros_like(X)
    result[..., :3, :3] = R
    result[..., :3, 3] = -np.einsum("...ij,...j->...i", R, X[..., :3, 3])
    result[..., 3, 3] = 1.0
    return result


def translation(p) -> np.ndarray:
    """Pure translations (..., 4, 4) by p (..., 3), m."""
    p = np.asarray(p, dtype=float)
    X = np.zeros((*p.shape[:-1], 4, 4))
    X[..., range(4), range(4)] = 1.0
    X[..., :3, 3] = p
    return X


def about(axis, angle) -> np.ndarray:
    """Rotations (..., 4, 4) by angle (...), rad, about one unit axis (3,)."""
    angle = np.asarray(angle, dtype=float)[..., None]
    q = np.concatenate([np.sin(0.5 * angle) * np.asarray(axis), np.cos(0.5 * angle)], axis=-1)
    return matrices(np.concatenate([np.zeros((*q.shape[:-1], 3)), q], axis=-1))


def from_xyz_rpy(xyz, rpy) -> np.ndarray:
    """URDF's origin (4, 4): translation (3,), m, and roll, pitch, yaw (3,), rad, about fixed axes."""
    roll, pitch, yaw = rpy
    turn = about([0.0, 0.0, 1.0], yaw) @ about([0.0, 1.0, 0.0], pitch) @ about([1.0, 0.0, 0.0], roll)
    return translation(xyz) @ turn


def z_along(direction) -> np.ndarray:
    """Rotations (..., 4, 4) whose z axis points along direction (..., 3); any where that has no length.

    The other axes follow from the shortest turn of z, or for directions below the horizon of -z, so that they move
    smoothly with a direction that does.
    """
    direction = np.asarray(direction, dtype=float)
    norm = np.linalg.norm(direction, axis=-1, keepdims=True)
    d = np.where(norm > 1e-12, direction / np.where(norm > 1e-12, norm, 1.0), [0.0, 0.0, 1.0])
    # Duff et al. 2017, Building an orthonormal basis, revisited.
    x, y, z = np.moveaxis(d, -1, 0)
    sign = np.where(z >= 0.0, 1.0, -1.0)
    a = -1.0 / (sign + z)
    b = x * y * a
    X = np.zeros((*d.shape[:-1], 4, 4))
    X[..., 0, 0], X[..., 1, 0], X[..., 2, 0] = 1.0 + sign * x * x * a, sign * b, -sign * x
    X[..., 0, 1], X[..., 1, 1], X[..., 2, 1] = b, sign + y * y * a, -y
    X[..., :3, 2], X[..., 3, 3] = d, 1.0
    return X


def between(a, b, share) -> np.ndarray:
    """Poses (K, ..., 7) at the shares (K,) of the way from a to b (..., 7): straight, and by the shortest turn."""
    a, b = np.asarray(a, dtype=float), np.asarray(b, dtype=float)
    share = np.asarray(share, dtype=float).reshape(-1, *[1] * a.ndim)
    p = (1.0 - share) * a[..., :3] + share * b[..., :3]
    qa, qb = a[..., 3:], b[..., 3:]
    cosine = np.sum(qa * qb, axis=-1, keepdims=True)
    qb = np.where(cosine < 0.0, -qb, qb)
    half = np.arccos(np.clip(np.abs(cosine), 0.0, 1.0))
    sine = np.sin(half)
    small = sine < 1e-6
    safe = np.where(small, 1.0, sine)
    q = np.where(small, 1.0 - share, np.sin((1.0 - share) * half) / safe) * qa
    q = q + np.where(small, share, np.sin(share * half) / safe) * qb
    return np.concatenate([p, q], axis=-1)
