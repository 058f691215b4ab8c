"""Joint velocities where limits leave no room for the palms' task as a whole: a small quadratic programme.

Two cases need it. The acceleration limits keep the joints near their last velocities, and none of those carries the
palm along the commanded twist, be it scaled (the command jumped to another direction). Or a pair of links comes near,
and its clearance couples both arms. In descending weight, as near as the limits allow:

    clearance:  rows q' >= least
    path:       J q' = sigma J b          b = J^+ X', so that what damping takes away is not asked for again
    progress:   sigma = 1
    null space: q' as `differential_ik.resolve` would have had it

Joint limits are hard. The weights differ by so much that a lower line costs a higher one less than 1e-4 m/s; where path
and progress are possible together they are met to that.
"""

import numpy as np
from pydrake.solvers import ClarabelSolver, MathematicalProgram

CLEARANCE, PATH, PROGRESS, NULL = 1e4, 1e3, 1.0, 0.1
"""Weights, inside the squares."""

PALM = 0.1
"""A palm's size, m: a rotation by 1 rad counts as this motion."""

FULL = 2.0
"""No joint of b is counted as faster than this, rad/s: a command in the thousands must not upset the numbers."""

_METRIC = np.array([PALM, PALM, PALM, 1.0, 1.0, 1.0])


def twist_size(twist):
    """The size (...) of twists (..., 6), m/s, rotations counted at `PALM`."""
    return np.linalg.norm(_METRIC * twist, axis=-1)


def nearest_velocities(jacobians, bases, wished, low, high, rows=None, least=None):
    """Joint velocities of A arms within their limits, nearest to what is asked.

    Args:
        jacobians: (A, 6, 7) of the palms.
        bases: (A, 7) J^+ X', rad/s.
        wished: (A, 7) rad/s, what counts where everything else leaves room.
        low: (A, 7) lower bounds, rad/s.
        high: (A, 7) upper bounds, >= low.
        rows: (m, 7 A) gradients of distances, joints of all arms; None where there are none.
        least: (m,) least rates of these distances, m/s.

    Returns:
        q' (A, 7), rad/s, and the shares (A,) in [0, 1] of the twists that are met.
    """
    arms = len(bases)
    sizes = np.maximum(np.abs(bases).max(axis=1) / FULL, 1.0)
    full = np.minimum(sizes, 3.0)
    programme = MathematicalProgram()
    q_dot = programme.NewContinuousVariables(7 * arms)
    sigma = programme.NewContinuousVariables(arms)
    off = programme.NewContinuousVariables(6 * arms)
    for arm in range(arms):
        # The weight belongs to a residual of its own: squared into q', it would spoil the solver's numbers.
        of, weighted = slice(7 * arm, 7 * arm + 7), PATH * _METRIC[:, None] * jacobians[arm]
        residual = off[6 * arm : 6 * arm + 6]
        programme.AddLinearEqualityConstraint(
            np.hstack([weighted, -(weighted @ bases[arm] / sizes[arm])[:, None], -np.eye(6)]),
            np.zeros(6),
            np.concatenate([q_dot[of], sigma[arm : arm + 1], residual]),
        )
    programme.Add2NormSquaredCost(np.eye(6 * arms), np.zeros(6 * arms), off)
    programme.Add2NormSquaredCost(PROGRESS * np.eye(arms), PROGRESS * full, sigma)
    programme.Add2NormSquaredCost(NULL * np.eye(7 * arms), NULL * np.clip(wished, low, high).ravel(), q_dot)
    programme.AddBoundingBoxConstraint(low.ravel(), high.ravel(), q_dot)
    programme.AddBoundingBoxConstraint(np.zeros(arms), full, sigma)
    if rows is not None:
        missing = programme.NewContinuousVariables(1)
        programme.AddBoundingBoxConstraint(0.0, np.inf, missing)
        programme.Add2NormSquaredCost(np.eye(1), np.zeros(1), missing)
        programme.AddLinearConstraint(
            np.hstack([rows, np.full((len(rows), 1), 1.0 / CLEARANCE)]),
            least,
            np.full(len(rows), np.inf),
            np.append(q_dot, missing),
        )
    result = ClarabelSolver().Solve(programme)
    if not result.is_success():  # Rare, and braking is always allowed.
        return np.clip(0.0, low, high), np.zeros(arms)
    share = np.clip(result.GetSolution(sigma) / sizes, 0.0, 1.0)
    reached = np.clip(result.GetSolution(q_dot).reshape(arms, 7), low, high)
    return reached, np.where(share > 1.0 - 1e-6, 1.0, share)
