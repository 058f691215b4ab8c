"""Unit quaternions (..., 4) in the order w x y z: products, logarithm and exponential, the shortest way.

q and -q are one rotation; every function gives the same rotation for both. Broadcasting over leading axes.
"""

import numpy as np
from scipy.spatial.transform import Rotation

IDENTITY = np.array([1.0, 0.0, 0.0, 0.0])


def multiply(a, b):
    """Quaternion product a b, (..., 4) in the order w x y z."""
    a, b = np.asarray(a), np.asarray(b)
    aw, ax, ay, az = a[..., 0], a[..., 1], a[..., 2], a[..., 3]
    bw, bx, by, bz = b[..., 0], b[..., 1], b[..., 2], b[..., 3]
    product = np.empty(np.broadcast_shapes(a.shape, b.shape))
    product[..., 0] = aw * bw - ax * bx - ay * by - az * bz
    product[..., 1] = aw * bx + ax * bw + ay * bz - az * by
    product[..., 2] = aw * by - ax * bz + ay * bw + az * bx
    product[..., 3] = aw * bz + ax * by - ay * bx + az * bw
    return product


def conjugate(q):
    """The inverse rotation (..., 4)."""
    return np.asarray(q) * np.array([1.0, -1.0, -1.0, -1.0])


def normalised(q):
    """Quaternions (..., 4) brought to unit length; NaN where there is no direction in them."""
    q = np.asarray(q, dtype=float)
    with np.errstate(all="ignore"):
        norm = np.linalg.norm(q, axis=-1, keepdims=True)
        return np.where((norm > 1e-9) & (norm < 1e9), q / norm, np.nan)


def rotation_vector(q):
    """The rotation vector 2 log q (..., 3), rad, of the shortest way: never longer than pi."""
    q = np.asarray(q)
    q = np.where(q[..., :1] < 0.0, -q, q)
    sine = np.linalg.norm(q[..., 1:], axis=-1, keepdims=True)
    # Below 1e-9 the quotient is 2 to the last bit.
    small = sine < 1e-9
    angle = 2.0 * np.arctan2(sine, q[..., :1])
    return q[..., 1:] * np.where(small, 2.0, angle / np.where(small, 1.0, sine))


def from_rotation_vector(e):
    """The quaternion exp(e / 2) (..., 4) of a rotation vector (..., 3), rad."""
    e = np.asarray(e)
    half = 0.5 * np.linalg.norm(e, axis=-1, keepdims=True)
    return np.concatenate([np.cos(half), 0.5 * np.sinc(half / np.pi) * e], axis=-1)


def from_matrix(matrix):
    """The quaternion (4,) of a rotation matrix (3, 3)."""
    return np.roll(Rotation.from_matrix(matrix).as_quat(), 1)


def rotated(q, v):
    """Vectors (..., 3) turned by q (..., 4)."""
    q, v = np.asarray(q), np.asarray(v)
    u, w = q[..., 1:], q[..., :1]
    across = 2.0 * np.cross(u, v)
    return v + w * across + np.cross(u, across)


def angle_between(a, b):
    """The angle (...), rad, of the rotation from a to b."""
    return np.linalg.norm(rotation_vector(multiply(b, conjugate(a))), axis=-1)


def continuous(q):
    """The same rotations (N, ..., 4) with the signs that make neighbours along the first axis near each other."""
    q = np.asarray(q)
    sign = np.where(np.sum(q[1:] * q[:-1], axis=-1) < 0.0, -1.0, 1.0)
    return q * np.concatenate([np.ones_like(q[:1, ..., 0]), np.cumprod(sign, axis=0)])[..., None]


def middle(q, weights=None):
    """The mean rotation (..., 4) of n rotations (n, ..., 4) with weights (n,), all on the side of the first.

    The chordal mean; of two alike weighted rotations it is the middle of the shortest way from one to the other.
    """
    q = np.asarray(q)
    q = np.where(np.sum(q * q[:1], axis=-1, keepdims=True) < 0.0, -q, q)
    return normalised(np.average(q, axis=0, weights=weights))


def interpolated(t, q, times):
    """Rotations (N, 4) at increasing t (N,) brought to other times (M,), by the shortest way; held outside."""
    t, q = np.asarray(t), np.asarray(q)
    if len(t) == 1:
        return np.broadcast_to(q[0], (len(times), 4)).copy()
    after = np.clip(np.searchsorted(t, times), 1, len(t) - 1)
    share = np.clip((times - t[after - 1]) / (t[after] - t[after - 1]), 0.0, 1.0)
    way = rotation_vector(multiply(q[after], conjugate(q[after - 1])))
    return multiply(from_rotation_vector(share[:, None] * way), q[after - 1])


def interpolated_poses(t, poses, times):
    """Poses (N, 7), qw qx qy qz x y z, at increasing t (N,) brought to other times (M,); held outside."""
    poses = np.asarray(poses)
    places = [np.interp(times, t, column) for column in poses[:, 4:].T]
    return np.column_stack([interpolated(t, poses[:, :4], times), *places])
