"""The swivel angle: how far the arm's plane is turned about the line from the shoulder to the wrist; Fig. 4, (19).

0 when the elbow hangs straight down, positive towards z x (wrist - shoulder): an arm that points forward (+y) raises
its elbow towards -x with a positive angle. Points are (..., 3) in a frame with z up, m; angles rad.
"""

import numpy as np

from drake_blfdmp.vectors import cross, dot

STRAIGHT = 1e-4
"""Below this elbow distance from the shoulder-wrist line, m, the angle is undefined."""


def _components(shoulder, elbow, wrist):
    e, w = elbow - shoulder, wrist - shoulder
    length = np.sqrt(dot(w, w))
    # Both carry the common factor length^2, which arctan2 does not see. w . (z x e) is a triple product.
    across = length * (w[..., 0] * e[..., 1] - w[..., 1] * e[..., 0])
    down = w[..., 2] * dot(e, w) - length**2 * e[..., 2]
    return across, down


def swivel_angle(shoulder, elbow, wrist):
    """Psi (...): the angle between the arm's plane and the vertical plane through shoulder and wrist."""
    across, down = _components(shoulder, elbow, wrist)
    return np.arctan2(across, down)


def swivel_jacobians(shoulder, elbow, wrist):
    """Derivatives of psi with respect to the elbow's and the wrist's position, each (..., 3), rad/m; shoulder fixed.

    By translation invariance the derivative with respect to the shoulder is minus their sum. Where the arm is straight
    or points straight up or down the angle is undefined and both are zero.
    """
    e, w = elbow - shoulder, wrist - shoulder
    length2, flat2 = dot(w, w), w[..., 0] ** 2 + w[..., 1] ** 2
    normal = cross(w, e)
    area2 = dot(normal, normal)  # (length times the elbow's distance from the axis)^2
    defined = area2 * flat2 > (STRAIGHT * length2) ** 2 * length2
    length = np.sqrt(length2)
    # Turning about the axis moves the elbow along the normal; moving the wrist turns the axis, which carries the arm's
    # plane and the vertical plane along by different angles.
    d_elbow = (length / np.where(defined, area2, 1.0) * defined)[..., None] * normal
    tilt = w[..., 2] / np.where(defined, length * flat2, 1.0) * defined
    d_wrist = (-dot(e, w) / np.where(defined, length2, 1.0))[..., None] * d_elbow
    d_wrist[..., 0] += tilt * w[..., 1]
    d_wrist[..., 1] -= tilt * w[..., 0]
    return d_elbow, d_wrist


def swivel_rate(shoulder, elbow, wrist, shoulder_velocity, elbow_velocity, wrist_velocity):
    """Psi' (...), rad/s, of moving points; 0 where the angle is undefined."""
    je, jw = swivel_jacobians(shoulder, elbow, wrist)
    return dot(je, elbow_velocity - shoulder_velocity) + dot(jw, wrist_velocity - shoulder_velocity)


def swivel_direction(shoulder, elbow, wrist):
    """U_psi of (19): SE x EW / |SE x EW|, with SE = x_s - x_e and EW = x_e - x_w as printed; the arm plane's normal.

    A positive psi' moves the elbow along -U_psi. Zero where the arm is straight.
    """
    u = cross(shoulder - elbow, elbow - wrist)
    norm = np.linalg.norm(u, axis=-1, keepdims=True)
    return np.where(norm > 1e-9, u / np.where(norm > 1e-9, norm, 1.0), 0.0)


def wrap(angle):
    """The same angle in [-pi, pi)."""
    return (angle + np.pi) % (2.0 * np.pi) - np.pi
