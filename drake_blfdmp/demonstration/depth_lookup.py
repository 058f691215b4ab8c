"""Joints whose depth was read from a depth image: what stands before a joint, or behind it, was measured instead.

A two-dimensional tracker says where a joint is in the image, the depth image how far that pixel is. Where something
hides the joint the pixel shows that, and where the pixel lies beside it the background, for many frames on end: no test
of speeds finds it, and no interpolation mends it. But the joint still lies on the ray through its pixel, and the arm's
two bones have a length, which leaves two points of that ray. So every frame has a few candidates for elbow and wrist:
as measured, or nearer or farther on the ray where the bone ends; the most probable path through them (Viterbi, IEEE
Trans. Inf. Theory 13, 1967) weighs what a bone may measure, how far a depth was off, and how a joint moves.
"""

from itertools import product
from typing import NamedTuple

import numpy as np

from drake_blfdmp.skeleton import POINTS

UPPER_ARM_SHARE, FOREARM_SHARE = 0.186, 0.146
"""Of a person's height (Winter, "Biomechanics and Motor Control of Human Movement", table 4.1)."""

ADULT_HEIGHT = 1.65  # m, between the world's mean woman and man.

_ARMS = ((0, 1, 2), (3, 4, 5))
_BONE_SPREAD = 0.2  # Standard deviation of a bone's logarithm: people differ, and so do trackers' idea of a joint.
_TOO_FAR, _TOO_NEAR = 0.15, 0.3  # m, by which a depth was off: a hand hides an elbow more often than a pixel misses it.
_REPLACED = 2.0  # What a depth that is not as measured costs at least.
_SPEED = 1.5  # m/s, standard deviation of a joint's.
_MOST_STEP, _MOST_BONE, _MOST_DEPTH = 4.0, 50.0, 25.0  # Squared standard deviations: nothing is impossible.
_WHOLE = 0.99  # Share of coordinates that are whole millimetres where a depth image's are.
_LEAST_STEP_S = 1e-3


class Redone(NamedTuple):
    """Points with the depths that the arms' bones allow.

    Attributes:
        x: (N, 6, 3) m.
        moved: (N, 6) bool, which depths are not as measured.
    """

    x: np.ndarray
    moved: np.ndarray


def is_depth_lookup(x: np.ndarray, up: str | None) -> bool:
    """Whether points look like a depth image's: whole millimetres before the camera, and none where it sees nothing.

    Args:
        x: (N, 6, 3) as recorded, m; NaN or all zeros where missing.
        up: the axis that points up, None where unknown; a camera does not look up.
    """
    blind = np.all(x == 0.0, axis=-1) | ~np.isfinite(x).all(axis=-1)
    seen = x[~blind]
    if up == "z" or not blind.any() or len(seen) == 0 or not np.all(seen[:, 2] > 0.0) or np.all(seen == np.round(seen)):
        return False
    return float(np.mean(np.abs(seen * 1e3 - np.round(seen * 1e3)) < 1e-6)) >= _WHOLE


def redo_depths(t: np.ndarray, x: np.ndarray, upper_arm: float | None = None, forearm: float | None = None) -> Redone:
    """Moves elbows and wrists along their rays, where the arm's bones say that the depth is another joint's or none.

    Frames in which an arm is not seen whole stay as they are. Shoulders are taken as measured.

    Args:
        t: (N,) strictly increasing, s.
        x: (N, 6, 3) m, the camera at the origin; NaN where missing.
        upper_arm: m; an adult's of average height if None.
        forearm: m; likewise.
    """
    lengths = (upper_arm or UPPER_ARM_SHARE * ADULT_HEIGHT, forearm or FOREARM_SHARE * ADULT_HEIGHT)
    out, moved = x.copy(), np.zeros(x.shape[:2], dtype=bool)
    for arm in _ARMS:
        rows = np.flatnonzero((np.linalg.norm(x[:, arm], axis=-1) > 0.0).all(axis=1))  # NaN is not.
        if len(rows) == 0:
            continue
        measured = x[np.ix_(rows, arm)]
        points, replaced = candidates(measured, lengths)
        cost = _misfit(points, measured, lengths) + _REPLACED * replaced.sum(axis=-1)
        best = _path(t[rows], points, cost)
        out[np.ix_(rows, arm[1:])] = points[np.arange(len(rows)), best]
        moved[np.ix_(rows, arm[1:])] = replaced[best]
    return Redone(out, moved)


def candidates(arm: np.ndarray, lengths: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
    """Where elbow and wrist may be: as measured, or on their rays where the bone has its length.

    Args:
        arm: (N, 3, 3) shoulder, elbow and wrist as measured, m.
        lengths: upper arm and forearm, m.

    Returns:
        (N, 9, 2, 3) elbow and wrist, m; and (9, 2) bool, which of them are not as measured.
    """
    shoulder, elbow, wrist = np.moveaxis(arm, 1, 0)
    points, replaced = [], []
    for new_elbow, new_wrist in product(range(3), range(3)):
        e = elbow if new_elbow == 0 else _on_ray(elbow, shoulder, lengths[0])[new_elbow - 1]
        w = wrist if new_wrist == 0 else _on_ray(wrist, e, lengths[1])[new_wrist - 1]
        points.append(np.stack([e, w], axis=1))
        replaced.append((new_elbow > 0, new_wrist > 0))
    return np.stack(points, axis=1), np.array(replaced)


def describe_depths(moved: np.ndarray) -> str:
    """A sentence on what `redo_depths` moved, (N, 6) bool."""
    counts = ", ".join(f"{POINTS[i]} {count}" for i, count in enumerate(moved.sum(axis=0)) if count)
    return (
        "depths looked up in a depth image, which shows what hides a joint: moved along the camera's rays to where the "
        f"bones allow (frames: {counts or 'none'})"
    )


def _on_ray(point: np.ndarray, near: np.ndarray, length: float) -> tuple[np.ndarray, np.ndarray]:
    """The two points (N, 3) on the rays through `point` at `length` from `near`; the nearest one where none is."""
    ray = point / np.linalg.norm(point, axis=-1, keepdims=True)
    foot = np.sum(ray * near, axis=-1, keepdims=True)
    half = np.sqrt(np.maximum(length**2 - np.sum((near - foot * ray) ** 2, axis=-1, keepdims=True), 0.0))
    return np.maximum(foot - half, 0.0) * ray, np.maximum(foot + half, 0.0) * ray


def _misfit(points: np.ndarray, arm: np.ndarray, lengths: tuple[float, float]) -> np.ndarray:
    """(N, K) squared standard deviations of bones and depths."""
    near = np.stack([np.broadcast_to(arm[:, None, 0], points[:, :, 0].shape), points[:, :, 0]], axis=2)
    measured = np.maximum(np.linalg.norm(points - near, axis=-1), 1e-6)
    bones = np.minimum((np.log(measured / np.asarray(lengths)) / _BONE_SPREAD) ** 2, _MOST_BONE)
    off = (points - arm[:, None, 1:])[..., 2]
    depths = np.minimum((off / np.where(off < 0.0, _TOO_FAR, _TOO_NEAR)) ** 2, _MOST_DEPTH)
    return (bones + depths).sum(axis=-1)


def _path(t: np.ndarray, points: np.ndarray, cost: np.ndarray) -> np.ndarray:
    """(N,) which candidate of each sample the cheapest path goes through; as measured where that costs less alone."""
    sound = cost[:, 0] < _REPLACED
    cost = np.where(sound[:, None] & (np.arange(cost.shape[1]) > 0), np.inf, cost)
    reach = _SPEED * np.maximum(np.diff(t), _LEAST_STEP_S)
    came_from = np.zeros(cost.shape, dtype=int)
    total = cost[0]
    for i in np.flatnonzero(~(sound[1:] & sound[:-1])) + 1:  # Between two sound samples there is one way only.
        if sound[i - 1]:
            total = cost[i - 1]
        step = points[i, None] - points[i - 1, :, None]
        way = np.minimum(np.sum(step * step, axis=-1) / reach[i - 1] ** 2, _MOST_STEP).sum(axis=-1) + total[:, None]
        came_from[i] = way.argmin(axis=0)
        total = way.min(axis=0) + cost[i]
    best = np.empty(len(t), dtype=int)
    best[-1] = 0 if sound[-1] else total.argmin()
    for i in range(len(t) - 1, 0, -1):
        best[i - 1] = came_from[i, best[i]]
    return best
