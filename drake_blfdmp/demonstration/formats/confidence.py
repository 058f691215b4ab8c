"""What sensors say of how well they see a point, on one scale: 0 not seen, 0.5 guessed, 1 tracked."""

import re

import numpy as np

_WORDS = {
    "nottracked": 0.0, "untracked": 0.0, "notseen": 0.0, "none": 0.0, "lost": 0.0, "missing": 0.0,
    "false": 0.0, "no": 0.0,
    "inferred": 0.5, "guessed": 0.5, "estimated": 0.5, "occluded": 0.5, "low": 0.5,
    "tracked": 1.0, "medium": 1.0, "high": 1.0, "visible": 1.0, "seen": 1.0, "true": 1.0, "yes": 1.0,
}  # fmt: skip
_STATES = np.array([0.0, 0.5, 1.0])  # Kinect: not tracked, inferred, tracked.
_LEVELS = np.array([0.0, 0.5, 1.0, 1.0])  # Azure Kinect: none, low, medium, high.


def confidence_of_word(word: str) -> float:
    """Of `Inferred`, `NOT_TRACKED`, `K4ABT_JOINT_CONFIDENCE_LOW`, ...; NaN of any other word."""
    plain = re.sub(r"^(trackingstate|k4abtjointconfidence)", "", re.sub(r"[^a-z0-9]", "", word.lower()))
    return _WORDS.get(plain, np.nan)


def confidence_of_numbers(values: np.ndarray, x: np.ndarray) -> tuple[np.ndarray | None, str]:
    """A sensor's numbers on the common scale.

    Args:
        values: (N, K) states 0 to 2, levels 0 to 3, or shares 0 to 1; NaN where missing. Give those of all joints, for
            which scale it is shows in the largest. The first six columns are those of the points.
        x: (N, 6, 3) the points; where nothing is said of a point it counts as tracked if it is there.

    Returns:
        (N, 6), or None where the numbers are on no known scale or absent; and a sentence.
    """
    finite = values[np.isfinite(values)]
    if len(finite) == 0:
        return None, ""
    least, most, whole = finite.min(), finite.max(), bool(np.all(finite == np.round(finite)))
    if least < 0.0 or most > 3.0 or (most > 1.0 and not whole):
        return None, f"confidence: left aside, numbers from {least:g} to {most:g} are on no known scale"
    said = values[:, :6]
    known = np.isfinite(said)
    if most > 1.0:
        scale = _STATES if most == 2.0 else _LEVELS
        said = scale[np.where(known, said, 0.0).astype(int)]
        sentence = "confidence: " + (
            "0 not seen, 1 inferred, 2 tracked" if most == 2.0 else "0 none, 1 low, 2 medium, 3 high"
        )
    else:
        sentence = "confidence: 0 to 1, as it stands"
    return np.where(known, said, np.isfinite(x).all(axis=-1)), sentence
