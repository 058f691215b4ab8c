"""Which way is up, and which side is left: what the body itself says about a recording's frame."""

import numpy as np

AXES = ("x", "-x", "y", "-y", "z", "-z")
_CONVENTIONS = ("z", "y", "-y")  # Mocap; Kinect v1 and v2, OpenSim; Azure Kinect and OpenCV cameras.
_LEAST_AGREEMENT = 0.3  # Length of the mean of the arms' unit vectors; shorter ones say little.
_CLEAR = 0.6  # Cosine between an axis and the mean upper arm above which the axis is taken.
_MARGIN = 0.15  # Over the next best axis: arms held forward point along two axes at once.


def up_axis(x: np.ndarray, by_format: str | None = None) -> str | None:
    """The axis that points up: the one along which shoulders lie above elbows.

    Args:
        x: (N, 6, 3) m, in the file's frame.
        by_format: the format's own convention, for a person who holds the arms up.

    Returns:
        One of "z", "y", "-y" (or `by_format`), or None where the evidence is weak and no convention is known.
    """
    arms = x[:, [0, 3]] - x[:, [1, 4]]
    arms = arms / np.maximum(np.linalg.norm(arms, axis=-1, keepdims=True), 1e-9)
    mean = np.nanmean(arms, axis=(0, 1))
    mean = mean / max(float(np.linalg.norm(mean)), _LEAST_AGREEMENT)
    cosines = {name: float(mean @ _direction(name)) for name in _CONVENTIONS}
    second, best = sorted(cosines, key=lambda name: cosines[name])[-2:]
    clear = cosines[best] >= _CLEAR and cosines[best] - cosines[second] >= _MARGIN
    if by_format is not None and (not clear or _direction(best) @ _direction(by_format) < 0.0):
        return by_format
    return best if clear else None


def up_from_heads(heads: np.ndarray, shoulders: np.ndarray) -> str | None:
    """The axis along which heads lie above shoulders, whichever it is: cameras look from above, too.

    Args:
        heads: (N, 3) a point of the head, in any unit and frame; NaN where missing.
        shoulders: (N, 3) the middle between the shoulders.

    Returns:
        One of AXES, or None where nothing is seen or no axis is near (a head leans forward by up to 45 degrees).
    """
    neck = heads - shoulders
    length = np.linalg.norm(neck, axis=-1)
    seen = np.isfinite(length) & (length > 0.0)
    if not seen.any():
        return None
    mean = np.mean(neck[seen] / length[seen, None], axis=0)
    best = max(AXES, key=lambda name: float(mean @ _direction(name)))
    return best if float(mean @ _direction(best)) >= _CLEAR else None


def rotation_to_z_up(up: str) -> np.ndarray:
    """The proper rotation R that makes `up` the z axis, x_zup = R x; (x, -z, y) for y up, (x, z, -y) for y down.

    Args:
        up: one of AXES.

    Returns:
        (3, 3), det = +1; horizontal axes turn no more than needed.
    """
    z = _direction(up)
    x = np.array([0.0, 1.0, 0.0]) if "x" in up else np.array([1.0, 0.0, 0.0])
    return np.stack([x, np.cross(z, x), z])


def sidedness(x: np.ndarray) -> tuple[float, float]:
    """How far the hands reach to the front, if left is left: arms bend forward, hands work in front.

    Args:
        x: (N, 6, 3) m, z up.

    Returns:
        The mean over the samples of (hands ahead of shoulders) + (forearms' reach - upper arms' reach), m, forward
        being the horizontal normal of the line from left to right shoulder; and the share of samples in
        which it is negative.
    """
    across = (x[:, 3] - x[:, 0])[:, :2]
    forward = np.stack([-across[:, 1], across[:, 0]], axis=-1)
    forward = forward / np.maximum(np.linalg.norm(forward, axis=-1, keepdims=True), 1e-9)
    shoulders, elbows, wrists = (((x[:, i] + x[:, i + 3]) / 2)[:, :2] for i in range(3))
    reach = np.einsum("ni,ni->n", forward, (wrists - shoulders) + (wrists - elbows) - (elbows - shoulders))
    return float(np.mean(reach)), float(np.mean(reach < 0.0))


def _direction(axis: str) -> np.ndarray:
    return (-1.0 if axis.startswith("-") else 1.0) * np.eye(3)["xyz".index(axis[-1])]
