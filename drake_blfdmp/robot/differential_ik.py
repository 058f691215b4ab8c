"""Redundancy resolution of one 7-joint arm: the palm first, the swivel in what is left; the paper's (18), put right.

(18) adds (I - J^+ J) J_E^+ psi U_psi: it uses the angle psi as a speed and projects outside the pseudo-inverse, so the
elbow task leaks instead of being met. Here the swivel rate that is asked for is reached exactly along the one
direction n, J n = 0, that does not move the palm:

    q' = s J^+ X' + alpha n,   J_psi q' = psi'_cmd  =>  alpha = (psi'_cmd - J_psi J^+ X' s) / (J_psi n)

J_psi is the derivative of the swivel angle itself; for a resting wrist J_psi q' = -U_psi^T J_E q' / r, with r the
elbow's distance from the shoulder-wrist line and U_psi as (19) prints it, which is the form in which the paper speaks
of it. Joint limits, of position, velocity and acceleration, hold by construction: they leave each joint an interval of
velocities (`velocity_bounds`, `within_reach`) that is never empty (`braking`). alpha is kept in what that leaves; where
nothing is left the palm's twist is scaled (0 <= s < 1), which keeps the path; where no scale helps, as the command has
turned faster than the joints can, the nearest velocities are taken (`nearest_velocity`). `robot.redundancy` asks other
alphas of the same resolution, among them (18) as printed.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from drake_blfdmp.robot.braking import braking_speed
from drake_blfdmp.robot.nearest_velocity import nearest_velocities


@dataclass(frozen=True)
class IkGains:
    """Gains of the closed loop.

    Attributes:
        pose: of the palm's pose error, 1/s.
        swivel: of the swivel error, 1/s.
        swivel_rate: largest swivel rate, rad/s.
        swivel_return: largest rate at which a swivel error is taken back, rad/s: an elbow that a joint's limit has held
            off comes back calmly.
        singular_value: below this the inverse is damped (m or rad per rad).
        damping: largest damping.
        null_floor: |J_psi n| below which the swivel fades out (near a straight arm, or where the null motion does
            not turn the arm's plane).
        limit_gain: how fast a joint may approach its limit, and a pair of links its clearance, 1/s.
        limit_margin: distance kept from the position limits, rad.
        velocity_share: share of the joint velocity limits that is used.
        acceleration_share: share of the joint acceleration limits that is used; inf: they do not count.
        null_acceleration: how fast the null motion may change, rad/s^2.
        tempo_fall: how fast the tempo falls while a palm cannot follow at all, s (`tempo`).
        tempo_rise: how fast it comes back, s.
        tempo_floor: slower than this the tempo never is.
    """

    pose: float = 20.0
    swivel: float = 3.0
    swivel_rate: float = 1.0
    swivel_return: float = 0.5
    singular_value: float = 0.05
    damping: float = 0.05
    null_floor: float = 0.15
    limit_gain: float = 5.0
    limit_margin: float = 0.1
    velocity_share: float = 0.9
    acceleration_share: float = 0.9
    null_acceleration: float = 6.0
    tempo_fall: float = 0.02
    tempo_rise: float = 0.5
    tempo_floor: float = 0.05


DEFAULT_GAINS = IkGains()


def damped_inverse(jacobian, singular_value: float, damping: float):
    """The pseudo-inverse (7, 6), damped where a singular value is small, and the null direction n (7,)."""
    u, s, vt = np.linalg.svd(jacobian)
    small = np.maximum(0.0, 1.0 - (s / singular_value) ** 2)
    gain = s / (s * s + small * damping**2)
    return (vt[:6].T * gain) @ u.T, vt[6]


def velocity_bounds(q, lower, upper, velocity, gains: IkGains, acceleration=np.inf, time_step: float = 0.0):
    """The velocities a joint may have at q so that it never passes its limits: arrays like q, lower <= 0 <= upper.

    Args:
        q: (...) rad.
        lower: (...) position limits, rad.
        upper: (...) rad.
        velocity: (...) limits, rad/s.
        gains: of them the limits' gain and margin and the velocity's share.
        acceleration: (...) rad/s^2, with which a joint can brake before its limit; inf: with any.
        time_step: s, for which the velocity will be held.
    """
    top = gains.velocity_share * velocity
    rooms = np.stack([q - (lower + gains.limit_margin), upper - gains.limit_margin - q])
    down, up = np.minimum(braking_speed(rooms, gains.limit_gain, acceleration, time_step), top)
    return -down, up


def within_reach(low, high, previous, change):
    """The bounds that are left to a joint that can change its velocity by `change` in a step: low <= high, never empty.

    A joint that is too fast for its bounds, which does not happen to one that was within them (`braking`), brakes.

    Args:
        low: (...) from `velocity_bounds`, rad/s.
        high: (...) rad/s.
        previous: (...) the last velocity, rad/s.
        change: (...) acceleration times step, rad/s.
    """
    least, most = previous - change, previous + change
    return np.minimum(np.maximum(low, least), most), np.minimum(np.maximum(high, least), most)


def null_interval(base, n, low, high):
    """The alphas with low <= base + alpha n <= high: (smallest, largest), empty when smallest > largest; broadcasts."""
    flat = np.abs(n) < 1e-9
    safe = np.where(flat, 1.0, n)
    a, b = (low - base) / safe, (high - base) / safe
    least, most = np.minimum(a, b), np.maximum(a, b)
    inside = (low <= base + 1e-12) & (base - 1e-12 <= high)
    least = np.where(flat, np.where(inside, -np.inf, np.inf), least)
    most = np.where(flat, np.where(inside, np.inf, -np.inf), most)
    return least.max(axis=-1), most.min(axis=-1)


def scale_interval(base, n, low, high):
    """The s for which some alpha has low <= s base + alpha n <= high: (smallest, largest); none if smallest > largest.

    Each pair of joints bounds alpha from below and from above by lines in s; s is feasible while no lower line is
    above an upper one. A joint the null motion does not move bounds s alone. Needs low <= high. Broadcasts.
    """
    sign = np.where(n < 0, -1.0, 1.0)
    m, b = np.abs(n), base * sign
    low, high = np.where(sign > 0, low, -high), np.where(sign > 0, high, -low)
    # alpha m_i >= low_i - s b_i and alpha m_j <= high_j - s b_j for all i, j
    slope = m[..., :, None] * b[..., None, :] - b[..., :, None] * m[..., None, :]
    room = m[..., :, None] * high[..., None, :] - low[..., :, None] * m[..., None, :]
    # For a joint alone s b <= high and s (-b) <= -low; for the others nothing: 0 s <= 0.
    alone, pairs = m < 1e-9, (*slope.shape[:-2], -1)
    slope = np.concatenate([slope.reshape(pairs), np.where(alone, b, 0.0), np.where(alone, -b, 0.0)], axis=-1)
    room = np.concatenate([room.reshape(pairs), np.where(alone, high, 0.0), np.where(alone, -low, 0.0)], axis=-1)
    rising, falling = slope > 1e-12, slope < -1e-12
    level = ~(rising | falling)
    ends = room / np.where(level, 1.0, slope)
    none = np.any(level & (room < -1e-12), axis=-1)
    largest = np.where(none, -np.inf, np.where(rising, ends, np.inf).min(axis=-1))
    smallest = np.where(none, np.inf, np.where(falling, ends, -np.inf).max(axis=-1))
    return smallest, largest


def largest_scale(base, n, low, high):
    """The largest s in [0, 1] for which some alpha has low <= s base + alpha n <= high. Needs low <= 0 <= high."""
    return min(max(scale_interval(base, n, low, high)[1], 0.0), 1.0)


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


def resolve_null(jacobian, twist, null_speed: Callable, low, high, gains: IkGains, gentle=None, inverse=None):
    """Joint velocities s J^+ X' + alpha n of one arm, within the joint limits.

    Args:
        jacobian: (6, 7) of the palm, angular above translational.
        twist: (6,) commanded palm twist.
        null_speed: (s J^+ X', n), each (7,) -> the alpha that is asked for.
        low: (7,) lower bounds from `velocity_bounds` or `within_reach`.
        high: (7,) upper bounds.
        gains: of them the damping counts here.
        gentle: the last joint velocities (7,) and by how much the null motion may differ from theirs, rad/s: a jump of
            the person's swivel angle then becomes no jump of torque.
        inverse: (J^+, n) from `damped_inverse`, where they are known already.

    Returns:
        q' (7,), rad/s, and the share s in [0, 1] of the palm's twist that is met.
    """
    inverse, n = inverse or damped_inverse(jacobian, gains.singular_value, gains.damping)
    base = inverse @ twist
    scale = 1.0
    least, most = null_interval(base, n, low, high)
    if least > most:
        smallest, largest = scale_interval(base, n, low, high)
        scale = min(max(largest, 0.0), 1.0)
        if smallest > scale + 1e-9 and not np.all((low <= 0.0) & (high >= 0.0)):
            wished = base + _gentle(null_speed(base, n), n, gentle) * n
            stacked = [array[None] for array in (jacobian, base, wished, low, high)]
            nearest, scales = nearest_velocities(*stacked)
            return nearest[0], float(scales[0])
        scale = float(calm_scale(base, n, low, high, max(smallest, 0.0), scale, gentle))
        base = scale * base
        least, most = null_interval(base, n, low, high)
        middle = 0.5 * (least + most)
        least, most = min(least, middle), max(most, middle)
    alpha = _gentle(null_speed(base, n), n, gentle)
    return base + np.clip(alpha, least, most) * n, scale


def calm_scale(base, n, low, high, smallest, largest, gentle=None):
    """A share s of the twist, in [smallest, largest], that does not throw the arm about for a little progress.

    The largest share leaves the null motion no choice but the one that brings it about. With the palm held up, say at
    the end of its reach, a thousandth of progress would be bought with an elbow at full speed, one way and then back.
    Hence the smaller the largest share, the nearer to the one that is possible with the null motion at rest, or
    braking. It does not depend on what is asked of the swivel: the palm comes first. Broadcasts where `gentle` is None.
    """
    rest = 0.0
    if gentle is not None:
        previous, change = gentle
        rest = max(abs(n @ previous) - 0.5 * change, 0.0)
    tied = [
        np.concatenate([values, np.full((*values.shape[:-1], 1), last)], axis=-1)
        for values, last in ((base, 0.0), (n, 1.0), (low, -rest), (high, rest))
    ]
    least, most = scale_interval(*tied)
    calm = largest * largest + (1.0 - largest) * np.maximum(np.minimum(most, largest), smallest)
    return np.where(least > most, largest, calm)


def _gentle(alpha, n, gentle):
    if gentle is None:
        return alpha
    previous, change = gentle
    return np.clip(alpha, n @ previous - change, n @ previous + change)


def resolve(jacobian, twist, swivel_jacobian, swivel_rate, low, high, gains: IkGains, gentle=None, inverse=None):
    """Joint velocities of one arm that meet the palm's twist and then the swivel rate.

    Args:
        jacobian: (6, 7) of the palm, angular above translational.
        twist: (6,) commanded palm twist.
        swivel_jacobian: (7,) J_psi.
        swivel_rate: commanded psi', rad/s.
        low: (7,) lower bounds, as in `resolve_null`.
        high: (7,) upper bounds.
        gains: of them the damping and the null floor count here.
        gentle: as in `resolve_null`.
        inverse: as in `resolve_null`.

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
        inverse,
    )
