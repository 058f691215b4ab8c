"""Postures in which a grasp can be taken: Newton's method from many guesses at once, and the palms' rolls in them."""

import numpy as np

from drake_blfdmp.robot.kinematics import DualArmKinematics
from drake_blfdmp.robot.plant import HOME, JOINTS_PER_ARM, JointLimits
from drake_blfdmp.robot.swivel import wrap
from drake_blfdmp.robot.tracking import rotation_matrix
from drake_blfdmp.vectors import cross, dot

ROLL_JOINT = 6  # The palm's normal is the axis of joint 7, so rolling the palm is turning joint 7.

ITERATIONS = 60


def starting_posture(
    kinematics: DualArmKinematics, limits: JointLimits, pose, swivel, *, seeds: int = 12, seed: int = 0
) -> np.ndarray | None:
    """`starting_postures` of one pose (2, 7) with swivel angles (2,): q (14,), or None."""
    one = np.asarray(pose)[None], np.asarray(swivel)[None]
    return starting_postures(kinematics, limits, *one, seeds=seeds, seed=seed)[0]


def starting_postures(
    kinematics: DualArmKinematics, limits: JointLimits, pose, swivel, *, seeds: int = 12, seed: int = 0
) -> list[np.ndarray | None]:
    """Postures with both palms at M poses but for their roll, left to joint 7 = 0, and the given swivel angles.

    Position, normal and swivel are six conditions for joints 1-6. Damped Newton from HOME and from random postures;
    of all solutions the one farthest from its limits.

    Args:
        kinematics: of both arms.
        limits: of their joints.
        pose: (M, 2, 7) X_WP.
        swivel: (M, 2) rad.
        seeds: postures Newton's method starts from, for each arm.
        seed: of the random ones among them.

    Returns:
        For each pose q (14,), or None where one of the arms has no solution.
    """
    count, rng = len(pose), np.random.default_rng(seed)
    lower, upper = (array.reshape(2, JOINTS_PER_ARM) for array in (limits.lower, limits.upper))
    guesses = rng.uniform(lower[:, None], upper[:, None], (2, seeds, JOINTS_PER_ARM))
    guesses[:, 0] = HOME
    guesses[..., ROLL_JOINT] = 0.0
    shape = count, 2, seeds
    rows = (np.broadcast_to(array, shape).ravel() for array in np.ix_(range(count), range(2), range(seeds)))
    which, arm, trial = rows
    q, solved = newton_postures(kinematics, arm, guesses[arm, trial], pose[which, arm], swivel[which, arm])
    # Joint 6 reaches beyond pi: whole turns are counted from the lower limit, not from -pi.
    q = lower[arm] + (q - lower[arm]) % (2 * np.pi)
    margin = np.where(solved, np.minimum(q - lower[arm], upper[arm] - q).min(axis=1), 0.0).reshape(shape)
    best = margin.argmax(axis=-1)
    chosen = np.take_along_axis(q.reshape(*shape, JOINTS_PER_ARM), best[..., None, None], axis=2)[:, :, 0]
    found = np.take_along_axis(margin, best[..., None], axis=2).min(axis=(1, 2)) > 0.0
    return [posture.ravel() if ok else None for posture, ok in zip(chosen, found, strict=True)]


def newton_postures(kinematics, arm, guess, pose, swivel, iterations: int = ITERATIONS):
    """Joints (n, 7) of n arms at palm poses (n, 7) and swivel angles (n,), joint 7 as guessed; and who got there."""
    normal = rotation_matrix(pose[:, :4].T)[:, 2].T
    q, solved = guess.copy(), np.zeros(len(guess), dtype=bool)
    rows = np.arange(len(q))
    for _ in range(iterations):
        rotation, position, jacobian, psi, along = kinematics.chains.evaluate(arm[rows], q[rows])
        z, wanted = rotation[..., 2], normal[rows]
        turn = np.where((dot(z, wanted) > -0.9)[:, None], cross(z, wanted), rotation[..., 0])
        swing = wrap(swivel[rows] - psi)
        error = np.concatenate([turn, pose[rows, 4:] - position, swing[:, None]], axis=1)
        near = np.linalg.norm(error, axis=1) < 1e-6
        solved[rows[near]] = True
        if near.all():
            break
        rows, error, z = rows[~near], error[~near], z[~near]
        slopes = np.concatenate([jacobian[~near], along[~near, None]], axis=1)[..., :ROLL_JOINT]
        slopes[:, :3] -= z[..., None] * (z[:, None] @ slopes[:, :3])  # Turning about the normal is the roll's.
        damped = slopes @ slopes.swapaxes(1, 2) + 1e-4 * np.eye(7)
        step = (slopes.swapaxes(1, 2) @ np.linalg.solve(damped, error[..., None]))[..., 0]
        q[rows, :ROLL_JOINT] += step * np.minimum(1.0, 0.5 / np.abs(step).max(axis=1))[:, None]
    return q, solved


def palm_rolls(kinematics: DualArmKinematics, q, pose) -> np.ndarray:
    """How far each palm at q is rolled about its normal from `pose` (2, 7): (2,) rad."""
    rolls = np.empty(2)
    for arm, state in enumerate(kinematics.evaluate(q)):
        relative = rotation_matrix(pose[arm][:4]).T @ state.rotation
        rolls[arm] = np.arctan2(relative[1, 0], relative[0, 0])
    return rolls
