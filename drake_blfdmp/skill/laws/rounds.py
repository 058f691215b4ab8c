"""The published law on the skeleton: per axis, own follows partner, two rounds (14) then (15)-(17), Remark 2's order.

A condition (5) or (13) on a distance is decomposed to axes as the paper does: with n the unit vector from own to
partner, d^i = d n^i and sigma^i = sigma / sqrt(3), so every own coordinate must lie within sigma^i of
x_partner^i - d^i. That is sufficient for the distance, but binds three degrees of freedom where the distance is one.
Points are (..., 6, 3) as in `skeleton.POINTS`; a pair of points, left and right, is (..., 2, 3).
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from drake_blfdmp.skeleton import ELBOWS, HANDS, SHOULDERS, WRISTS
from drake_blfdmp.skill.bands import LOWER, UPPER
from drake_blfdmp.skill.laws.follower import PublishedGains, follower_acceleration
from drake_blfdmp.vectors import dot

OTHER_WRISTS = WRISTS[::-1]
UPPER_ARMS, FOREARMS, BETWEEN_HANDS = np.array([0, 4]), np.array([1, 3]), np.array([HANDS, HANDS])

Reading = Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]
"""From the follower's, the uncoupled and the previous sample's acceleration of a pair to the one it takes."""


@dataclass(frozen=True)
class Interval:
    """Bounds on the own coordinates (..., 2, 3), and the partner's motion that carries them along.

    Attributes:
        lower, upper: m.
        velocity, acceleration: of the partner, m/s, m/s^2.
    """

    lower: np.ndarray
    upper: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray


def interval(own, partner, link, x, velocity, acceleration, bands) -> Interval:
    """The condition on a link, decomposed to the axes of its own points.

    Args:
        own, partner: indices (2,) of points; link: indices (2,) of links.
        x, velocity, acceleration: (..., 6, 3), of the partner the latest known.
        bands: (..., 6, 5).
    """
    r = x[..., partner, :] - x[..., own, :]
    n = r / np.sqrt(dot(r, r))[..., None]
    lower, upper = bands[..., LOWER, link], bands[..., UPPER, link]
    centre = x[..., partner, :] - (0.5 * (lower + upper))[..., None] * n
    half = (0.5 * (upper - lower) / np.sqrt(3.0))[..., None]
    return Interval(centre - half, centre + half, velocity[..., partner, :], acceleration[..., partner, :])


def common(first: Interval, second: Interval, widen: bool) -> tuple[Interval, np.ndarray]:
    """The common result of two conditions, and where, per axis, there is none (..., 2, 3).

    Each bound is carried along by the partner that sets it, the middle by their mean. Without an overlap and with
    `widen` (Remark 2), the first condition, a joint distance, stays as it is and the second, the hands' distance, is
    widened until it covers the nearer half of the first; else the coordinate is held in the gap between the two.
    """
    first_sets_lower, first_sets_upper = first.lower >= second.lower, first.upper < second.upper
    lower, upper = np.maximum(first.lower, second.lower), np.minimum(first.upper, second.upper)
    empty = lower >= upper
    if widen:
        middle, above = 0.5 * (first.lower + first.upper), second.lower >= first.upper
        lower = np.where(empty, np.where(above, middle, first.lower), lower)
        upper = np.where(empty, np.where(above, first.upper, middle), upper)
    else:
        lower, upper = np.where(empty, upper, lower), np.where(empty, lower, upper)

    def carried(a, b):
        return 0.5 * (np.where(first_sets_lower, a, b) + np.where(first_sets_upper, a, b))

    return (
        Interval(
            lower,
            upper,
            carried(first.velocity, second.velocity),
            carried(first.acceleration, second.acceleration),
        ),
        empty,
    )


def two_rounds(
    x, velocity, nominal_acceleration, previous_acceleration, bands, tau, gains: PublishedGains, reading: Reading
):
    """The accelerations of all points after both rounds: (..., 6, 3), m/s^2.

    Within a step the rounds pass accelerations on: whoever comes later follows what its partner was given before.
    """
    given = np.array(np.broadcast_to(nominal_acceleration, np.shape(x)))

    def condition(own, partner, link):
        return interval(own, partner, link, x, velocity, given, bands)

    def follow(own, bounds):
        wanted = follower_acceleration(
            x[..., own, :],
            velocity[..., own, :],
            bounds.lower,
            bounds.upper,
            bounds.velocity,
            bounds.acceleration,
            tau,
            gains,
        )
        return reading(wanted, nominal_acceleration[..., own, :], previous_acceleration[..., own, :])

    elbow_side = condition(WRISTS, ELBOWS, FOREARMS)
    given[..., WRISTS, :] = follow(WRISTS, elbow_side)  # (14)
    hand_side = condition(WRISTS, OTHER_WRISTS, BETWEEN_HANDS)
    given[..., WRISTS, :] = follow(WRISTS, common(elbow_side, hand_side, True)[0])  # (15)
    shoulder_side = condition(ELBOWS, SHOULDERS, UPPER_ARMS)
    wrist_side = condition(ELBOWS, WRISTS, FOREARMS)
    given[..., ELBOWS, :] = follow(ELBOWS, common(shoulder_side, wrist_side, False)[0])  # (16)
    given[..., SHOULDERS, :] = follow(SHOULDERS, condition(SHOULDERS, ELBOWS, UPPER_ARMS))  # (17)
    return given
