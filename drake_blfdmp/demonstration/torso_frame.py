"""The person's own frame: walking and turning go, bending and lifting stay.

Origin on the floor below the shoulders' midpoint, x along the shoulders' heading (left to right), y forward, z up. z is
not touched. Origin and heading are low-pass filtered without phase, so that noise of the shoulders does not shake
the hands.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy.ndimage import gaussian_filter1d

from drake_blfdmp.demonstration.demonstration import Demonstration
from drake_blfdmp.errors import RecordingError
from drake_blfdmp.quaternions import multiply

CUTOFF_HZ = 1.0
_LEFT_SHOULDER, _RIGHT_SHOULDER = 0, 3


class TorsoFrames(NamedTuple):
    """The frame at every sample: origin (N, 2) in the horizontal plane, m; x_axis (N, 2) unit vectors."""

    origin: np.ndarray
    x_axis: np.ndarray


def low_pass(values: np.ndarray, rate_hz: float, cutoff_hz: float) -> np.ndarray:
    """Gaussian low-pass along the first axis, zero phase, -3 dB at the cutoff; straight lines pass unchanged.

    Args:
        values: (N, ...).
        rate_hz: samples a second.
        cutoff_hz: Hz.

    Returns:
        (N, ...).
    """
    sigma = np.sqrt(np.log(2.0)) / (2.0 * np.pi * cutoff_hz) * rate_hz
    radius = int(np.ceil(4.0 * sigma))
    pad = [(radius, radius)] + [(0, 0)] * (np.ndim(values) - 1)
    padded = np.pad(np.asarray(values, float), pad, mode="reflect", reflect_type="odd")
    return gaussian_filter1d(padded, sigma, axis=0, radius=radius)[radius : radius + len(values)]


def torso_frames(x: np.ndarray, rate_hz: float, cutoff_hz: float = CUTOFF_HZ) -> TorsoFrames:
    """The torso frame at every sample.

    Args:
        x: (N, 6, 3) m, z up.
        rate_hz: samples a second.
        cutoff_hz: of origin and heading, Hz.

    Raises:
        RecordingError: the shoulders stand above each other, so there is no heading.
    """
    left, right = x[:, _LEFT_SHOULDER, :2], x[:, _RIGHT_SHOULDER, :2]
    origin = low_pass((left + right) / 2.0, rate_hz, cutoff_hz)
    across = low_pass(
        right - left, rate_hz, cutoff_hz
    )  # The vector, not its angle: no wrap, and weak evidence weighs less.
    width = np.linalg.norm(across, axis=1)
    worst = int(np.argmin(width))
    if width[worst] < 0.02:
        raise RecordingError(
            f"recording: at {worst / rate_hz:.2f} s the shoulders are {width[worst]:.3f} m apart, "
            "too little for a heading; "
            "cut the recording with --frames or use the world frame"
        )
    return TorsoFrames(origin, across / width[:, None])


def into_frames(x: np.ndarray, frames: TorsoFrames) -> np.ndarray:
    """Points in the torso frames.

    Args:
        x: (N, 6, 3) m, z up, in the world.
        frames: of the same N samples.

    Returns:
        (N, 6, 3) m.
    """
    offset = x[..., :2] - frames.origin[:, None, :]
    c, s = frames.x_axis[:, 0, None], frames.x_axis[:, 1, None]
    return np.stack(
        [c * offset[..., 0] + s * offset[..., 1], c * offset[..., 1] - s * offset[..., 0], x[..., 2]], axis=-1
    )


def to_torso_frame(demonstration: Demonstration, cutoff_hz: float = CUTOFF_HZ) -> Demonstration:
    """The demonstration in the person's torso frame.

    Raises:
        RecordingError: there is no heading at some sample.
    """
    frames = torso_frames(demonstration.x, demonstration.rate_hz, cutoff_hz)
    orientations = demonstration.orientations
    if orientations is not None:
        half = -0.5 * np.arctan2(frames.x_axis[:, 1], frames.x_axis[:, 0])
        heading = np.stack([np.cos(half), 0.0 * half, 0.0 * half, np.sin(half)], axis=-1)
        orientations = multiply(heading[:, None], orientations)
    return replace(demonstration, x=into_frames(demonstration.x, frames), orientations=orientations)
