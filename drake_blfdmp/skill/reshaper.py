"""The least change of all points' accelerations that gives every link the acceleration asked for.

The five demands are linear in the 18 point accelerations. With W the mobility of each point, the least change is

    Delta = W G^T (G W G^T)^-1 need,   need = rho'' - (|r'|^2 - rho'^2) / rho - n^T (x_b'' - x_a'')

It is the "common result" of (15)-(17), found for all links at once in place of the two rounds. The links form a chain,
so G W G^T is tridiagonal, and as the incidence of a path has full row rank it is positive definite as long as no link
has zero length and every mobility is positive. Arrays broadcast; float, AutoDiffXd or Expression entries.
"""

import numpy as np

from drake_blfdmp.errors import SkillError
from drake_blfdmp.skeleton import HANDS, LINKS, POINTS
from drake_blfdmp.skill.geometry import link_states, link_vectors
from drake_blfdmp.vectors import dot

DEFAULT_MOBILITY = np.array([0.2, 0.5, 1.0, 0.2, 0.5, 1.0])
"""Shoulders move least, hands most: the order of the measuring errors in the paper's Fig. 2."""


MOST_UNEQUAL = 10.0
"""The largest factor of `mobility_from_uncertainty` above and below its geometric mean."""

LEAST_UNCERTAINTY = 1e-3
"""m; what skin and shoulder girdle do is more, and a body model's error has no meaning."""


def mobility_from_uncertainty(uncertainty):
    """Mobilities of points whose errors have standard deviations `uncertainty` (..., 6), m: their squares.

    For independent errors with covariances sigma_p^2 I, the positions that meet the links with the least sum of
    |Delta_p|^2 / sigma_p^2 are the most probable ones, and of all linear corrections have the least variance: that is
    W = sigma_p^2 (`docs/learning.md`). Only ratios count, so the geometric mean is made 1; what lies farther than
    MOST_UNEQUAL from it is held there, for an estimate is not so sure, and errors below LEAST_UNCERTAINTY count alike.

    Raises:
        SkillError: not six numbers, or one negative or not finite.
    """
    sigma = np.asarray(uncertainty, dtype=float)
    if sigma.shape[-1:] != (len(POINTS),) or not np.all(np.isfinite(sigma) & (sigma >= 0)):
        raise SkillError("mobility: needs 6 standard deviations, none negative, all finite; one for each point")
    size = np.log(np.maximum(sigma, LEAST_UNCERTAINTY))
    return np.clip(np.exp(2.0 * (size - size.mean(axis=-1, keepdims=True))), 1.0 / MOST_UNEQUAL, MOST_UNEQUAL)


def needs(x, velocity, nominal_acceleration, link_acceleration):
    """What each link's n^T (Delta_b - Delta_a) must be (..., 5), m/s^2, and the unit vectors n (..., 5, 3)."""
    return needs_of(link_states(x, velocity), nominal_acceleration, link_acceleration)


def needs_of(states, nominal_acceleration, link_acceleration):
    """`needs` of links whose `link_states` are known."""
    _, _, n, centripetal = states
    own = dot(n, link_vectors(nominal_acceleration))
    return link_acceleration - centripetal - own, n


def solve_chain(n, need, mobility):
    """(G W G^T)^-1 need by elimination along the chain (Thomas): (..., 5)."""
    points = [LINKS[0].a] + [link.b for link in LINKS]
    weights, need = _columns(mobility), _columns(need)
    w = [weights[p] for p in points]
    count = len(LINKS)
    diagonal = [w[i] + w[i + 1] for i in range(count)]
    between = _columns(dot(n[..., :-1, :], n[..., 1:, :]))
    off = [-w[i + 1] * between[i] for i in range(count - 1)]
    pivot, right = [diagonal[0]], [need[0]]
    for i in range(1, count):
        factor = off[i - 1] / pivot[-1]
        pivot.append(diagonal[i] - factor * off[i - 1])
        right.append(need[i] - factor * right[-1])
    solution = [right[-1] / pivot[-1]]
    for i in range(count - 2, -1, -1):
        solution.append((right[i] - off[i] * solution[-1]) / pivot[i])
    if isinstance(solution[0], float):
        return np.array(solution[::-1])
    return np.stack(solution[::-1], axis=-1)


def _columns(values):
    """The entries (...) along the last axis; of a single vector as Python's numbers, which are ten times as fast."""
    values = np.asarray(values)
    if values.ndim == 1 and values.dtype == float:
        return values.tolist()
    return [values[..., i] for i in range(values.shape[-1])]


_ENDS = np.array([[float(link.b == p) - float(link.a == p) for link in LINKS] for p in range(len(POINTS))])
"""G^T without the directions: which end of which link (5) each point (6) is."""


def spread(n, tension, mobility):
    """Delta = W G^T tension: (..., 6, 3)."""
    return _ENDS @ (n * tension[..., None]) * mobility[..., None]


def reshape(x, velocity, nominal_acceleration, link_acceleration, mobility=DEFAULT_MOBILITY):
    """The coupling acceleration of all points that meets all five links' demands exactly.

    Args:
        x, velocity, nominal_acceleration: (..., 6, 3).
        link_acceleration: (..., 5) demanded rho'', m/s^2.
        mobility: (6,) positive.

    Returns:
        (..., 6, 3), m/s^2.
    """
    need, n = needs(x, velocity, nominal_acceleration, link_acceleration)
    return least_change(n, need, mobility)


def least_change(n, need, mobility=DEFAULT_MOBILITY):
    """The least accelerations (..., 6, 3) that give every link along n (..., 5, 3) what it needs (..., 5)."""
    return spread(n, solve_chain(n, need, mobility), mobility)


def reshape_limited(x, velocity, nominal_acceleration, link_acceleration, limit, mobility=DEFAULT_MOBILITY):
    """`reshape` under a limit on every point's acceleration; the arm links come first (Remark 2).

    The hands' demand is lowered, in a straight line from what is asked to what the arms do if the hands are left
    alone, just so far that no point is asked for more than `limit`. Where no such demand exists, the arms get theirs
    alone, above the limit.

    Args:
        limit: m/s^2, on the norm of each point's acceleration.

    Returns:
        The coupling acceleration (..., 6, 3) and the hands' rho'' given up (...), m/s^2, zero where all is met.
    """
    need, n = needs(x, velocity, nominal_acceleration, link_acceleration)
    full = spread(n, solve_chain(n, need, mobility), mobility)
    unit = np.zeros(len(LINKS))
    unit[HANDS] = 1.0
    tension_unit = solve_chain(n, np.broadcast_to(unit, need.shape), mobility)
    tension = solve_chain(n, need, mobility)
    # No tension between the hands: the arms' least change when the hands are free.
    shortfall = tension[..., HANDS] / tension_unit[..., HANDS]
    direction = spread(n, tension_unit, mobility) * shortfall[..., None, None]
    alone = full - direction
    share = _largest_share(nominal_acceleration + alone, direction, limit)
    return alone + share[..., None, None] * direction, (1.0 - share) * np.abs(shortfall)


def _largest_share(base, direction, limit):
    """The largest lambda in [0, 1] with |base + lambda direction| <= limit for every point (...); 0 if there is none.

    Each point's condition is quadratic in lambda and holds on an interval; what is sought is the end of their
    intersection.
    """
    a = dot(direction, direction)
    b = dot(base, direction)
    c = dot(base, base) - limit**2
    still = a == 0.0
    a = np.where(still, 1.0, a)
    discriminant = b * b - a * c
    root = np.sqrt(np.maximum(discriminant, 0.0))
    possible = np.where(still, c <= 0.0, discriminant >= 0.0).all(axis=-1)
    first = np.where(still, 0.0, (-b - root) / a).max(axis=-1).clip(0.0, None)
    last = np.where(still, 1.0, (-b + root) / a).min(axis=-1).clip(None, 1.0)
    return np.where(possible & (first <= last), last, 0.0)
