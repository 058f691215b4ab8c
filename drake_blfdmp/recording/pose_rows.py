"""Poses of many bodies as ROS 2 writes them, at once."""

import numpy as np


def _candidates() -> tuple[np.ndarray, np.ndarray]:
    """M (12, 16), c (16,): X M + c of poses X (N, 12), rows of [R p], are the candidates 4 q_i q, i = x y z w."""
    M, c = np.zeros((3, 4, 4, 4)), np.zeros((4, 4))
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        M[i, i, i, i], M[j, j, i, i], M[k, k, i, i], c[i, i] = 1, -1, -1, 1
        M[i, j, i, j] = M[j, i, i, j] = M[i, k, i, k] = M[k, i, i, k] = 1
        M[k, j, i, 3], M[j, k, i, 3] = 1, -1
        M[k, j, 3, i], M[j, k, 3, i], M[i, i, 3, 3] = 1, -1, 1
    c[3, 3] = 1
    return M.reshape(12, 16), c.ravel()


_M, _C = _candidates()


def pose_rows(matrices: np.ndarray) -> np.ndarray:
    """Rows (N, 7) x y z (m) qx qy qz qw, qw >= 0, as geometry_msgs/Transform has them, of N matrices [R p] (N, 3, 4).

    Rounded to single precision (60 nm at 1 m), float32, far below what a pose is read for, because it halves what poses
    take after compression.
    """
    X = np.reshape(matrices, (-1, 12))
    candidates = X @ _M
    candidates += _C
    diagonal = candidates[:, ::5]
    # The largest component divides with the least error (Shepperd).
    best, every = diagonal.argmax(axis=1), np.arange(len(X))
    q = candidates.reshape(-1, 4, 4)[every, best]
    scale = np.copysign(0.5 / np.sqrt(diagonal[every, best]), q[:, 3])
    rows = np.empty((len(X), 7), dtype=np.float32)
    rows[:, :3] = X[:, 3::4]
    rows[:, 3:] = q * scale[:, None]
    return rows
