"""The most probable skeleton whose bones have their lengths: measured points, corrected where a tracker errs most.

A tracker's joints are off along a chain: the elbow by its shoulder's error and one of its own, the wrist by the
elbow's and one of its own. With the variances s, e, w of the three the errors of an arm's points have the covariance

        [ s    s      s     ]
    C = [ s   s+e    s+e    ]      per axis, the same for both arms
        [ s   s+e   s+e+w   ]

or rather what the recording tells of it (`uncertainty`), which is less off the diagonal where joints err on their own.
Of all skeletons with the given lengths the most probable one is nearest to the measured in the metric C^-1. Where
`skill/projection.py` asks for the least change of points that err on their own, a bone that is too short here moves all
that hangs on it. Gauss-Newton on the links' lengths rho(y) = d, directions n and Jacobian G at the last y:

    y <- (1 - a) y + a [x + C G^T (G C G^T)^-1 (d - rho(y) + G (y - x))]
"""

import numpy as np

from drake_blfdmp.demonstration.bones import BONES, link_lengths
from drake_blfdmp.demonstration.demonstration import Demonstration
from drake_blfdmp.demonstration.holding import find_holding
from drake_blfdmp.demonstration.modelled_person import minimum_jerk
from drake_blfdmp.demonstration.uncertainty import SensorError
from drake_blfdmp.errors import RecordingError
from drake_blfdmp.skeleton import HANDS, LINKS

_RELAXATION = 0.7  # The a above: links that grow by a third swing from side to side without.
_TOLERANCE = 1e-7  # m; the last step moves no point farther.
_LARGEST_COUNT = 200
_LEAST_ERROR = 1e-4  # m; keeps C regular for a perfect sensor.
_BLEND_S = 0.4  # In which the box's width takes over the hands' distance, at either end of the hold.
_BATCH = 20000  # Frames at a time, for the memory's sake.

_INCIDENCE = np.zeros((len(LINKS), 6))
for _index, _link in enumerate(LINKS):
    _INCIDENCE[_index, [_link.a, _link.b]] = -1.0, 1.0


def chain_covariance(error: SensorError) -> np.ndarray:
    """C, (6, 6), m^2: what the points' errors have in common along each arm; nothing across."""
    variance = error.variance + _LEAST_ERROR**2
    shoulder_elbow, elbow_wrist = error.shared
    shoulder_wrist = (
        shoulder_elbow * elbow_wrist / variance[1]
    )  # A chain: the wrist knows of the shoulder by the elbow.
    arm = np.diag(variance)
    arm[0, 1] = arm[1, 0] = shoulder_elbow
    arm[1, 2] = arm[2, 1] = elbow_wrist
    arm[0, 2] = arm[2, 0] = shoulder_wrist
    return np.kron(np.eye(2), arm)


def fit_skeleton(x: np.ndarray, lengths: np.ndarray, covariance: np.ndarray) -> np.ndarray:
    """The most probable points whose five links have the given lengths.

    Args:
        x: (N, 6, 3) m.
        lengths: (N, 5) in the order of `skeleton.LINKS`, m; NaN leaves a link free.
        covariance: (6, 6) of the points' errors, m^2.

    Returns:
        (N, 6, 3) m. Where lengths contradict each other, links are off as little as the last iteration left them.
    """
    parts = [slice(start, start + _BATCH) for start in range(0, len(x), _BATCH)]
    return np.concatenate([_fit(x[part], lengths[part], covariance) for part in parts])


def scale_bones(x: np.ndarray, measured: tuple[float, float], bones: tuple[float, float]) -> np.ndarray:
    """Takes out what a tracker always makes of the bones' lengths; all that hangs on a bone moves with its end.

    Args:
        x: (N, 6, 3) m.
        measured: upper arm and forearm as usually measured, m.
        bones: as they are, m.
    """
    arms = x.reshape(-1, 2, 3, 3)
    vectors = np.diff(arms, axis=2) * (np.array(bones) / np.array(measured))[:, None]
    return np.concatenate([arms[:, :, :1], arms[:, :, :1] + np.cumsum(vectors, axis=2)], axis=2).reshape(x.shape)


def restore_lengths(
    demonstration: Demonstration, x: np.ndarray, bones: tuple[float, float], error: SensorError, *, hold: bool
) -> tuple[np.ndarray, str]:
    """Gives the bones their lengths, and the hands the box's width while they hold it.

    Args:
        demonstration: cleaned, not smoothed, in which the hold is looked for.
        x: (N, 6, 3) points to restore, m: the demonstration's or smoothed ones.
        bones: upper arm and forearm, m.
        error: of the demonstration's points.
        hold: whether to look for the hold; its width is the known one, or else the median distance.

    Returns:
        (N, 6, 3) m, and a sentence on what was done.
    """
    covariance = chain_covariance(error)
    lengths = np.full((len(x), len(LINKS)), np.nan)
    lengths[:, BONES] = [bones[0], bones[1], bones[1], bones[0]]
    out = fit_skeleton(x, lengths, covariance)
    said = f"bones restored: upper arms {bones[0]:.3f} m, forearms {bones[1]:.3f} m"
    if not hold:
        return out, said
    try:
        holding = find_holding(demonstration)
    except RecordingError:
        return out, f"{said}; the hands' distance is as measured, no hold was found"
    width = demonstration.known.box_width or holding.hand_distance
    t = demonstration.t
    share = np.minimum(
        minimum_jerk((t - holding.start_s) / _BLEND_S + 1.0) if holding.start_s > t[0] else 1.0,
        minimum_jerk((holding.end_s - t) / _BLEND_S + 1.0) if holding.end_s < t[-1] else 1.0,
    )
    lengths[:, HANDS] = share * width + (1.0 - share) * link_lengths(out)[:, HANDS]
    out = fit_skeleton(x, lengths, covariance)
    return out, f"{said}; hands {width:.3f} m apart from {holding.start_s:.2f} to {holding.end_s:.2f} s"


def _fit(x: np.ndarray, lengths: np.ndarray, covariance: np.ndarray) -> np.ndarray:
    y, free = x.copy(), np.isnan(lengths)
    moving = np.arange(len(x))
    for _ in range(_LARGEST_COUNT):
        part, desired, loose = y[moving], lengths[moving], free[moving]
        r = np.einsum("lp,npc->nlc", _INCIDENCE, part)
        rho = np.linalg.norm(r, axis=-1)
        jacobian = _INCIDENCE[None, :, :, None] * (r / np.maximum(rho, 1e-9)[..., None])[:, :, None, :]
        need = desired - rho + np.einsum("nlpc,npc->nl", jacobian, part - x[moving])
        spread = np.einsum("pq,nlqc->nlpc", covariance, jacobian)
        normal = np.einsum("nlpc,nkpc->nlk", spread, jacobian)
        normal[loose[:, :, None] | loose[:, None, :]] = 0.0
        index = np.arange(len(LINKS))
        # A trace of damping stands links that lie in one line and contradict each other.
        normal[:, index, index] += np.where(loose, 1.0, 1e-9 * np.trace(covariance))
        tension = np.linalg.solve(normal, np.where(loose, 0.0, need)[..., None])[..., 0]
        step = _RELAXATION * (x[moving] - part + np.einsum("nlpc,nl->npc", spread, np.where(loose, 0.0, tension)))
        y[moving] += step
        moving = moving[np.abs(step).max(axis=(1, 2)) > _TOLERANCE]
        if len(moving) == 0:
            break
    return y
