"""Redundancy resolution of one 7-joint arm: the palm first, the swivel in what is left; the paper's (18), put right.

(18) adds (I - J^+ J) J_E^+ psi U_psi: it uses the angle psi as a speed and projects outside the pseudo-inverse, so the
elbow task leaks instead of being met. Here the swivel rate that is asked for is reached exactly along the one
direction n, J n = 0, that does not move the palm:

    q' = s J^+ X' + alpha n,   J_psi q' = psi'_cmd  =>  alpha = (psi'_cmd - J_psi J^+ X' s) / (J_psi n)

J_psi is the derivative of the swivel angle itself; for a resting wrist J_psi q' = -U_psi^T J_E q' / r, with r the
elbow's distance from the shoulder-wrist line and U_psi as (19) prints it, which is the form in which the paper speaks
of it. Joint limits hold by construction: alpha is kept in the interval they leave, and where that is empty the palm's
twist is scaled (0 <= s < 1). `robot.redundancy` asks other alphas of the same resolution, among them (18) as printed.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class IkGains:
    """Gains of the closed loop.

    Attributes:
        pose: of the palm's pose error, 1/s.
        swivel: of the swivel error, 1/s.
        swivel_rate: largest swivel rate, rad/s.
        singular_value: below this the inverse is damped (m or rad per rad).
        damping: largest damping.
        null_floor: |J_psi n| below which the swivel fades out (near a straight arm, or where the null motion does
            not turn the arm's plane).
        limit_gain: how fast a joint may approach its limit, 1/s.
        limit_margin: distance kept from the position limits, rad.
        velocity_share: share of the joint velocity limits that is used.
        null_acceleration: how fast the null motion may change, rad/s^2.
    """

    pose: float = 20.0
    swivel: float = 3.0
    swivel_rate: float = 1.0
    singular_value: float = 0.05
    damping: float = 0.05
    null_floor: float = 0.15
    limit_gain: float = 5.0
    limit_margin: float = 0.1
    velocity_share: float = 0.9
    null_acceleration: float = 6.0


DEFAULT_GAINS = IkGains()


def damped_inverse(jacobian, singular_value: float, damping: float):
    """The pseudo-inverse (7, 6), damped where a singular value is small, and the null direction n (7,)."""
    u, s, vt = np.linalg.svd(jacobian)
    small = np.maximum(0.0, 1.0 - (s / singular_value) ** 2)
    gain = s / (s * s + small * damping**2)
    return (vt[:6].T * gain) @ u.T, vt[6]


def velocity_bounds(q, lower, upper, velocity, gains: IkGains):
    """The velocities a joint may have at q so that it never passes its limits: arrays like q, lower <= 0 <= upper."""
    top = gains.velocity_share * velocity
    low = np.clip(gains.limit_gain * (lower + gains.limit_margin - q), -top, 0.0)
    high = np.clip(gains.limit_gain * (upper - gains.limit_margin - q), 0.0, top)
    return low, high


def null_interval(base, n, low, high):
    """The alphas with low <= base + alpha n <= high: (smallest, largest), empty when smallest > largest."""
    flat = np.abs(n) < 1e-9
    safe = np.where(flat, 1.0, n)
    a, b = (low - base) / safe, (high - base) / safe
    least, most = np.minimum(a, b), np.maximum(a, b)
    inside = (low <= base + 1e-12) & (base - 1e-12 <= high)
    least = np.where(flat, np.where(inside, -np.inf, np.inf), least)
    most = np.where(flat, np.where(inside, np.inf, -np.inf), most)
    return least.max(), most.min()


def largest_scale(base, n, low, high):
    """The largest s in [0, 1] for which some alpha has low <= s base + alpha n <= high. Needs low <= 0 <= high.

    Each pair of joints bounds alpha from below and from above by lines in s; s is feasible while no lower line is
    above an upper one.
    """
    scale = 1.0
    sign = np.where(n < 0, -1.0, 1.0)
    m, b = np.abs(n), base * sign
    low, high = np.where(sign > 0, low, -high), np.where(sign > 0, high, -low)
    # alpha m_i >= low_i - s b_i and alpha m_j <= high_j - s b_j for all i, j
    slope = np.outer(m, b) - np.outer(b, m)
    room = np.outer(m, high) - np.outer(low, m)
    tight = slope > 1e-12
    if np.any(tight):
        scale = min(scale, float((room[tight] / slope[tight]).min()))
    # A joint the null motion does not move bounds s alone.
    for value, least, most in zip(b[m < 1e-9], low[m < 1e-9], high[m < 1e-9], strict=True):
        if value > 0:
            scale = min(scale, most / value)
        elif value < 0:
            scale = min(scale, least / value)
    return max(scale, 0.0)


def swivel_null_speed(base, n, swivel_jacobian, swivel_rate, gains: IkGains) -> float:
    """The alpha with which base + alpha n turns the arm's plane at the swivel rate, fading out near a flat null motion.

    Args:
        base: (7,) joint velocities of the palm's task.
        n: (7,) the null direction.
        swivel_jacobian: (7,) J_psi.
        swivel_rate: commanded psi', rad/s.
        gains: of them the null floor.
    """
    along = swivel_jacobian @ n
    # Damped division: exact far from zero, fading to no null motion near it.
    floor = max(0.0, 1.0 - (along / gains.null_floor) ** 2) * gains.null_floor**2
    return (swivel_rate - swivel_jacobian @ base) * along / (along * along + floor)


def resolve_null(jacobian, twist, null_speed: Callable, low, high, gains: IkGains, gentle=None):
    """Joint velocities s J^+ X' + alpha n of one arm, within the joint limits.

    Args:
        jacobian: (6, 7) of the palm, angular above translational.
        twist: (6,) commanded palm twist.
        null_speed: (s J^+ X', n), each (7,) -> the alpha that is asked for.
        low: (7,) lower bounds from `velocity_bounds`.
        high: (7,) upper bounds.
        gains: of them the damping counts here.
        gentle: the last joint velocities (7,) and by how much the null motion may differ from theirs, rad/s: a jump of
            the person's swivel angle then becomes no jump of torque.

    Returns:
        q' (7,), rad/s, and the share s in [0, 1] of the palm's twist that is met.
    """
    inverse, n = damped_inverse(jacobian, gains.singular_value, gains.damping)
    base = inverse @ twist
    scale = 1.0
    least, most = null_interval(base, n, low, high)
    if least > most:
        scale = largest_scale(base, n, low, high)
        base = scale * base
        least, most = null_interval(base, n, low, high)
        middle = 0.5 * (least + most)
        least, most = min(least, middle), max(most, middle)
    alpha = null_speed(base, n)
    if gentle is not None:
        previous, change = gentle
        alpha = np.clip(alpha, n @ previous - change, n @ previous + change)
    return base + np.clip(alpha, least, most) * n, scale


def resolve(jacobian, twist, swivel_jacobian, swivel_rate, low, high, gains: IkGains, gentle=None):
    """Joint velocities of one arm that meet the palm's twist and then the swivel rate.

    Args:
        jacobian: (6, 7) of the palm, angular above translational.
        twist: (6,) commanded palm twist.
        swivel_jacobian: (7,) J_psi.
        swivel_rate: commanded psi', rad/s.
        low: (7,) lower bounds from `velocity_bounds`.
        high: (7,) upper bounds.
        gains: of them the damping and the null floor count here.
        gentle: as in `resolve_null`.

    Returns:
        q' (7,), rad/s, and the share s in [0, 1] of the palm's twist that is met.
    """
    return resolve_null(
        jacobian,
        twist,
        lambda base, n: swivel_null_speed(base, n, swivel_jacobian, swivel_rate, gains),
        low,
        high,
        gains,
        gentle,
    )
