"""Bone lengths of a recorded person, robust to jumps of single joints."""

import numpy as np

from drake_blfdmp.errors import RecordingError
from drake_blfdmp.skeleton import HANDS, LINKS

BONES = tuple(index for index in range(len(LINKS)) if index != HANDS)
UPPER_ARMS = (0, 4)  # Indices into LINKS.
FOREARMS = (1, 3)

PLAUSIBLE_BONE = (0.1, 0.6)
"""m, children to giants; a bone that is plausible in m is not in cm or mm."""

_MAD_TO_SIGMA = 1.4826  # For a normal distribution.


def link_lengths(x: np.ndarray) -> np.ndarray:
    """Lengths of the five links.

    Args:
        x: (..., 6, 3) points, m.

    Returns:
        (..., 5) in the order of `skeleton.LINKS`, m; NaN where a point is missing.
    """
    a = [link.a for link in LINKS]
    b = [link.b for link in LINKS]
    return np.linalg.norm(x[..., b, :] - x[..., a, :], axis=-1)


def robust_sigma(values: np.ndarray) -> np.ndarray:
    """Standard deviation by the median absolute deviation along the first axis, NaN ignored."""
    return _MAD_TO_SIGMA * np.nanmedian(np.abs(values - np.nanmedian(values, axis=0)), axis=0)


def length_jumps(lengths: np.ndarray, *, least_share: float = 0.25, sigmas: float = 8.0) -> np.ndarray:
    """The jump test: lengths too far from their bone's median to be that bone.

    Args:
        lengths: (N, K) one column a bone, m; NaN where unknown.
        least_share: deviations below this share of the median always pass.
        sigmas: deviations below so many robust standard deviations pass too; a Kinect's bones wobble by 15 %.

    Returns:
        (N, K) bool; False where the length is NaN.
    """
    if np.isnan(lengths).all(axis=0).any():
        return np.zeros(lengths.shape, dtype=bool)
    median = np.nanmedian(lengths, axis=0)
    limit = np.maximum(least_share * median, sigmas * robust_sigma(lengths))
    return np.abs(lengths - median) > limit


def estimate_bone_lengths(x: np.ndarray) -> tuple[float, float]:
    """The person's upper arm and forearm, each the median over both arms' samples that pass the jump test.

    Args:
        x: (N, 6, 3) points, m; NaN where missing. Give the samples as recorded where there is a choice: filled gaps
            count like measurements.

    Returns:
        (upper_arm, forearm), m.

    Raises:
        RecordingError: one of the bones is never seen whole.
    """
    lengths = link_lengths(x)
    estimates: list[float] = []
    for name, pair in (("upper arm", UPPER_ARMS), ("forearm", FOREARMS)):
        both = lengths[:, pair]
        both = both[np.isfinite(both) & ~length_jumps(both)]
        if len(both) == 0:
            raise RecordingError(f"recording: no sample shows both ends of an {name}; give the bone lengths instead")
        estimates.append(float(np.median(both)))
    return estimates[0], estimates[1]
