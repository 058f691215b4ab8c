"""Removal of measuring noise before differentiation."""

import numpy as np
from scipy.signal import butter, sosfiltfilt

from drake_blfdmp.errors import RecordingError


def smooth(t: np.ndarray, x: np.ndarray, cutoff_hz: float = 1.2) -> np.ndarray:
    """Zero-lag low-pass filter: a fourth-order Butterworth run forwards and backwards, as usual in biomechanics.

    Args:
        t: (N,) uniform time, s.
        x: (N, ...) positions.
        cutoff_hz: frequency at which amplitude has fallen to one half; a person carries a box below about 1 Hz.

    Raises:
        RecordingError: the recording is too slow or too short for the filter.
    """
    rate = (len(t) - 1) / (t[-1] - t[0])
    if not 0 < cutoff_hz < rate / 2:
        raise RecordingError(
            f"smoothing: cut-off {cutoff_hz:g} Hz must lie between 0 and half the rate, {rate / 2:g} Hz"
        )
    # Padding by the filter's own time constant keeps the ends where they are.
    pad = min(len(t) - 1, int(2.0 * rate / cutoff_hz))
    return sosfiltfilt(butter(4, cutoff_hz, fs=rate, output="sos"), x, axis=0, padtype="odd", padlen=pad)
