"""What is left of a motion that was carried to another start, goal or duration: its end and its shape.

Shape is compared in normalised time t / tau, so a change of the duration alone changes nothing. An uncoupled primitive
(1) carries its shape to any start, goal and duration in a known way; so a coupled motion is compared with the uncoupled
one of the same problem, and what is left is what the coupling did.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from drake_blfdmp.skeleton import HANDS, LINKS

SAMPLES = 501
"""Of a motion in normalised time."""


def hands_middle(x: np.ndarray) -> np.ndarray:
    """The middle (..., 3) between the hands of points (..., 6, 3)."""
    return 0.5 * (x[..., LINKS[HANDS].a, :] + x[..., LINKS[HANDS].b, :])


def in_normalised_time(t: np.ndarray, values: np.ndarray, tau: ArrayLike, samples: int = SAMPLES) -> np.ndarray:
    """A batch of series at u = 0 ... 1, linearly between the samples.

    Args:
        t: (N,) s, uniform from 0; after its end the last value holds.
        values: (N, P, ...).
        tau: duration of each member (P,), s, or of all.

    Returns:
        (samples, P, ...).
    """
    count = values.shape[1]
    taus = np.broadcast_to(np.asarray(tau, dtype=float), (count,))
    place = np.linspace(0.0, 1.0, samples)[:, None] * taus / (t[1] - t[0])
    place = np.minimum(place, len(t) - 1.0)
    before = np.minimum(place.astype(int), len(t) - 2)
    share = (place - before).reshape(samples, count, *([1] * (values.ndim - 2)))
    member = np.arange(count)
    return (1.0 - share) * values[before, member] + share * values[before + 1, member]


def path_distance(path: np.ndarray, reference: np.ndarray) -> np.ndarray:
    """RMS distance (P,), m, between motions (M, P, ..., 3) at the same normalised times, over all their points."""
    squared = np.sum((path - reference) ** 2, axis=-1)
    return np.sqrt(np.mean(squared, axis=(0, *range(2, squared.ndim))))


def profile_correlation(path: np.ndarray, reference: np.ndarray) -> np.ndarray:
    """How alike the velocities of two motions (M, P, 3) are: sum(a . b) / sqrt(sum(a . a) sum(b . b)), (P,).

    1 for the same profile up to a positive factor, whatever the place and the duration.
    """
    a, b = np.diff(path, axis=0), np.diff(reference, axis=0)
    return np.sum(a * b, axis=(0, 2)) / np.sqrt(np.sum(a * a, axis=(0, 2)) * np.sum(b * b, axis=(0, 2)))


@dataclass(frozen=True)
class EndErrors:
    """Distances from the goal at the end, m: of the hands' middle (P,), and of all six points, RMS (P,)."""

    hands: np.ndarray
    points: np.ndarray


def end_errors(x: np.ndarray, goal: np.ndarray) -> EndErrors:
    """How far points (P, 6, 3) are from their goals (P, 6, 3), m."""
    hands = np.linalg.norm(hands_middle(x) - hands_middle(goal), axis=-1)
    return EndErrors(hands, np.sqrt(np.mean(np.sum((x - goal) ** 2, axis=-1), axis=-1)))
