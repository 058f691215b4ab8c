"""How what two hands hold turns about the line between them: from the hands' orientations, whatever their axes.

The line frame L has its x axis from the left hand to the right one and its y axis horizontal. Hands that hold a rigid
thing keep their orientations in it, so it has turned in L since the grasp by r = (L^T R)(L^T R at the grasp)^T, R being
either hand's orientation. r does not depend on which axes a sensor gives a hand, nor on the frame of the recording.
"""

from collections.abc import Sequence

import numpy as np
from scipy.interpolate import make_interp_spline

from drake_blfdmp.demonstration.demonstration import Demonstration
from drake_blfdmp.demonstration.smoothing import smooth
from drake_blfdmp.quaternions import (
    conjugate,
    continuous,
    from_rotation_vector,
    middle,
    multiply,
    normalised,
    rotation_vector,
)
from drake_blfdmp.skeleton import WRISTS

MOST_DISAGREEMENT = np.deg2rad(25.0)
"""rad, root mean square, by which hands on one rigid thing may turn it differently; a real carry has 6 degrees."""


def line_quaternions(x: np.ndarray) -> np.ndarray:
    """The line frame R_z(yaw) R_y(-elevation) (..., 4) of points (..., 6, 3), z up."""
    r = x[..., WRISTS[1], :] - x[..., WRISTS[0], :]
    yaw = 0.5 * np.arctan2(r[..., 1], r[..., 0])
    elevation = 0.5 * np.arctan2(r[..., 2], np.linalg.norm(r[..., :2], axis=-1))
    cy, sy, ce, se = np.cos(yaw), np.sin(yaw), np.cos(elevation), np.sin(elevation)
    return np.stack([cy * ce, sy * se, -cy * se, sy * ce], axis=-1)


def turn_since(
    demonstration: Demonstration, times: np.ndarray, since_s: float, cutoff_hz: float | None
) -> np.ndarray | None:
    """How what is held has turned since `since_s`, in the line frame: (M, 4) at times (M,), s, signs continuous.

    Args:
        demonstration: cleaned; of hands without orientations the other one's count.
        cutoff_hz: of the smoothing, as of the points; None for none.

    Returns:
        None where the demonstration has no orientations.
    """
    turns = hand_turns(demonstration, times, since_s, cutoff_hz)
    return continuous(middle(np.array(turns))) if turns else None


def hand_turns(
    demonstration: Demonstration, times: np.ndarray, since_s: float, cutoff_hz: float | None
) -> list[np.ndarray]:
    """The same by each hand that has orientations, left before right: none to two of (M, 4)."""
    if demonstration.orientations is None:
        return []
    t, x = demonstration.t, demonstration.x
    if cutoff_hz is not None:
        x = smooth(t, x, cutoff_hz)
    line = line_quaternions(x)
    turns = []
    for hand in range(2):
        q = demonstration.orientations[:, hand]
        if not np.isfinite(q).all():
            continue
        q = continuous(q)
        q = q if cutoff_hz is None else normalised(smooth(t, q, cutoff_hz))
        # Quintic as the points' own spline; between samples the unit length is lost by next to nothing.
        spline = make_interp_spline(t, continuous(multiply(conjugate(line), q)), k=5)
        shown = normalised(spline(np.clip([since_s, *times], t[0], t[-1])))
        turns.append(multiply(shown[1:], conjugate(shown[0])))
    return turns


def disagreement(turns: Sequence[np.ndarray]) -> float:
    """How far two hands' turns (M, 4) about the line are apart, root mean square, rad; 0 for one hand or none."""
    if len(turns) < 2:
        return 0.0
    apart = multiply(turns[1], conjugate(turns[0]))
    return float(np.sqrt(np.mean((2.0 * np.arctan2(np.abs(apart[:, 1]), np.abs(apart[:, 0]))) ** 2)))


def ended_level(turn: np.ndarray, share: np.ndarray) -> tuple[np.ndarray, float]:
    """Turns (N, 4) that end with none: what is left at the end is taken out, by its `share` (N,), 0 to 1, so far done.

    What is put on a level table stands on it as it stood before.

    Returns:
        The turns (N, 4), and how much was left about the line, rad.
    """
    left = rotation_vector(turn[-1])
    correction = from_rotation_vector(-np.asarray(share)[:, None] * left)
    return multiply(correction, turn), float(2.0 * np.arctan2(turn[-1, 1], turn[-1, 0]))


def mean_orientations(
    x: np.ndarray,
    demonstrations: Sequence[Demonstration],
    recorded: np.ndarray,
    since_s: Sequence[float],
    weights: np.ndarray,
) -> np.ndarray | None:
    """Orientations (N, 2, 4) for the mean x (N, 6, 3) of n recordings, of hands that turn as theirs do on average.

    Args:
        recorded: (n, N) the recordings' times that belong to the mean's, s; since_s: (n,) their grasps; weights: (n,).

    Returns:
        None where no recording has orientations; those that have none do not count.
    """
    shown = [
        (turn_since(one, times, start, None), weight)
        for one, times, start, weight in zip(demonstrations, recorded, since_s, weights, strict=True)
    ]
    turns = [turn for turn, _ in shown if turn is not None]
    if not turns:
        return None
    mean = middle(np.array(turns), [weight for turn, weight in shown if turn is not None])
    return np.repeat(continuous(multiply(line_quaternions(x), mean))[:, None], 2, axis=1)
