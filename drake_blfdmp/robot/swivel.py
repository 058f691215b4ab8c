"""The swivel angle: how far the arm's plane is turned about the line from the shoulder to the wrist; Fig. 4, (19).

0 when the elbow hangs straight down, positive towards z x (wrist - shoulder): an arm that points forward (+y) raises
its elbow towards -x with a positive angle. Points are (..., 3) in a frame with z up, m; angles rad.
"""

import numpy as np

STRAIGHT = 1e-4
"""Below this elbow distance from the shoulder-wrist line, m, the angle is undefined."""


def _components(shoulder, elbow, wrist):
    e, w = elbow - shoulder, wrist - shoulder
    length = np.sqrt(np.sum(w * w, axis=-1))
    # Both carry the common factor length^2, which arctan2 does not see. w . (z x e) is a triple product.
    across = length * (w[..., 0] * e[..., 1] - w[..., 1] * e[..., 0])
    down = w[..., 2] * np.sum(e * w, axis=-1) - length**2 * e[..., 2]
    return e, w, length, across, down


def swivel_angle(shoulder, elbow, wrist):
    """Psi (...): the angle between the arm's plane and the vertical plane through shoulder and wrist."""
    *_, across, down = _components(shoulder, elbow, wrist)
    return np.arctan2(across, down)


def swivel_jacobians(shoulder, elbow, wrist):
    """Derivatives of psi with respect to the elbow's and the wrist's position, each (..., 3), rad/m; shoulder fixed.

    By translation invariance the derivative with respect to the shoulder is minus their sum. Where the arm is straight
    or points straight up or down the angle is undefined and both are zero.
    """
    e, w, length, a, b = _components(shoulder, elbow, wrist)
    r2 = a * a + b * b
    # distance of the elbow from the axis times the axis's horizontal share, in the unit of a and b
    defined = r2 > (STRAIGHT * length**2) ** 2
    scale = 1.0 / np.where(defined, r2, 1.0) * defined
    dot = np.sum(e * w, axis=-1)
    zero = np.zeros_like(length)
    across = w[..., 0] * e[..., 1] - w[..., 1] * e[..., 0]
    lw = length[..., None]
    da_de = lw * np.stack([-w[..., 1], w[..., 0], zero], axis=-1)
    da_dw = (
        lw * np.stack([e[..., 1], -e[..., 0], zero], axis=-1)
        + (across / np.where(length > 0, length, 1.0))[..., None] * w
    )
    z = np.array([0.0, 0.0, 1.0])
    db_de = w[..., 2:3] * w - (length**2)[..., None] * z
    db_dw = dot[..., None] * z + w[..., 2:3] * e - 2.0 * e[..., 2:3] * w
    db, da = b[..., None], a[..., None]
    return scale[..., None] * (db * da_de - da * db_de), scale[..., None] * (db * da_dw - da * db_dw)


def swivel_rate(shoulder, elbow, wrist, shoulder_velocity, elbow_velocity, wrist_velocity):
    """Psi' (...), rad/s, of moving points; 0 where the angle is undefined."""
    je, jw = swivel_jacobians(shoulder, elbow, wrist)
    return np.sum(je * (elbow_velocity - shoulder_velocity) + jw * (wrist_velocity - shoulder_velocity), axis=-1)


def swivel_direction(shoulder, elbow, wrist):
    """U_psi of (19): SE x EW / |SE x EW|, with SE = x_s - x_e and EW = x_e - x_w as printed; the arm plane's normal.

    A positive psi' moves the elbow along -U_psi. Zero where the arm is straight.
    """
    u = np.cross(shoulder - elbow, elbow - wrist)
    norm = np.linalg.norm(u, axis=-1, keepdims=True)
    return np.where(norm > 1e-9, u / np.where(norm > 1e-9, norm, 1.0), 0.0)


def wrap(angle):
    """The same angle in [-pi, pi)."""
    return (angle + np.pi) % (2.0 * np.pi) - np.pi
