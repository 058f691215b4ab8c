"""How large a recording's errors are, and how slow, as the recording itself tells.

A bone keeps its length, so what its measured length does is error, whatever the person does: the difference of the
errors at its ends, of which it shows one component of three; taken to be alike in all directions, that is the
difference's variance per axis. Both arms are taken to be alike. A skeleton tracker fits a chain, so an elbow is off by
what its shoulder is off and by an error of its own, and variances add up along the arm: S_elbow = S_shoulder +
S_upper_arm, frequency by frequency. Noise that each joint has for itself would be counted twice that way. But the
fastest of it is seen directly: third differences of a point hardly see a person move. So a constant is taken off the
sum, such that its own third differences become those measured.

Two shoulders' distance shows both shoulders' error, and the shoulder girdle's motion, so what an elbow adds is the most
that is believed of it. Not seen: an error common to all six points, one of both hands that leaves the bones alone, and
a bone that is always too short, unless its length is known beforehand. A body's own changes count as error.
"""

from dataclasses import dataclass

import numpy as np
from scipy.fft import dct

from drake_blfdmp.demonstration.bones import FOREARMS, UPPER_ARMS, link_lengths, robust_sigma
from drake_blfdmp.demonstration.demonstration import KnownDimensions
from drake_blfdmp.skeleton import ELBOWS, SHOULDERS, WRISTS

_CLIP = 4.0  # Robust standard deviations; farther lengths are jumps that were left.
_THIRD_DIFFERENCE = 20.0  # Variance of 1, -3, 3, -1 times white noise of unit variance.
_BAND_SHARE = 0.2  # Width of the bands over which the spectrum is averaged, of their frequency;
_LEAST_LINES = 4  # but so many lines at least.
_MOST_SHARED = 0.98  # Correlation of a bone's two ends.


@dataclass(frozen=True)
class SensorError:
    """What a sensor adds to shoulders, elbows and wrists; per axis, the same in all directions and for both arms.

    Attributes:
        spectrum: (3, N) expected squared coefficient of the error's orthonormal DCT-II, m^2; its mean is the variance.
        shared: (2,) covariance of the errors of shoulder and elbow, and of elbow and wrist, m^2.
        bias: (2,) how much longer upper arm and forearm are than known beforehand, m; 0 where unknown.
    """

    spectrum: np.ndarray
    shared: np.ndarray
    bias: np.ndarray

    @property
    def variance(self) -> np.ndarray:
        """(3,) without the bias, m^2."""
        return np.mean(self.spectrum, axis=1)

    @property
    def per_point(self) -> np.ndarray:
        """(6,) standard deviation of each point's error about the truth, bias included, per axis, m."""
        return np.tile(np.sqrt(self.variance + np.cumsum(np.r_[0.0, self.bias**2]) / 3.0), 2)


def estimate_error(x: np.ndarray, known: KnownDimensions | None = None) -> SensorError:
    """The error of points on a uniform clock, not smoothed.

    Args:
        x: (N, 6, 3) m, N of 8 or more, without gaps.
        known: the person's dimensions.
    """
    known = known or KnownDimensions()
    lengths = link_lengths(x)
    width = np.linalg.norm(x[:, SHOULDERS[1]] - x[:, SHOULDERS[0]], axis=-1)[:, None]
    both, upper, fore = (_spectrum(series) for series in (width, lengths[:, UPPER_ARMS], lengths[:, FOREARMS]))
    # A shoulder girdle moves by centimetres of its own; but no tracker sees a shoulder worse than an elbow.
    alone = 0.5 * both * min(1.0, 2.0 * float(np.mean(upper)) / max(float(np.mean(both)), 1e-30))
    white = white_noise(x)
    total, spectra = np.zeros(len(x)), []
    for points, added in ((SHOULDERS, alone), (ELBOWS, upper), (WRISTS, fore)):
        total = _anchored(total + added, float(np.mean(white[points] ** 2)))
        spectra.append(total)
    shoulder, elbow, wrist = variance = np.mean(spectra, axis=1)
    shared = 0.5 * np.array([shoulder + elbow - np.mean(upper), elbow + wrist - np.mean(fore)])
    most = _MOST_SHARED * np.sqrt(variance[:-1] * variance[1:])
    bias = [
        float(np.median(lengths[:, pair])) - length if length is not None else 0.0
        for pair, length in ((UPPER_ARMS, known.upper_arm), (FOREARMS, known.forearm))
    ]
    return SensorError(np.array(spectra), np.clip(shared, 0.0, most), np.array(bias))


def white_noise(x: np.ndarray) -> np.ndarray:
    """(6,) standard deviation per axis of the noise from frame to frame, m.

    Args:
        x: (N, 6, 3) m on a uniform clock.
    """
    third = np.diff(x, n=3, axis=0)
    scale = robust_sigma(third.transpose(0, 2, 1).reshape(-1, x.shape[1]))
    return np.asarray(scale) / np.sqrt(_THIRD_DIFFERENCE)


def _anchored(spectrum: np.ndarray, white: float) -> np.ndarray:
    """(N,) a spectrum less the constant that makes its third differences those of white noise of this variance.

    Nowhere is it below that noise: an error that is not white is slow.
    """
    fast = (2.0 * np.sin(0.5 * np.pi * np.arange(len(spectrum)) / len(spectrum))) ** 6 / _THIRD_DIFFERENCE
    return np.maximum(spectrum - float(np.mean(fast * spectrum)) + white, white)


def _deviation(lengths: np.ndarray) -> np.ndarray:
    """(N, K) lengths about their medians, cut off where a jump was left."""
    deviation = lengths - np.median(lengths, axis=0)
    limit = _CLIP * np.maximum(robust_sigma(lengths), 1e-9)
    return np.clip(deviation, -limit, limit)


def _spectrum(lengths: np.ndarray) -> np.ndarray:
    """(N,) mean squared DCT coefficients of (N, K) lengths about their medians, averaged over bands; mean: variance."""
    power = np.mean(np.square(dct(_deviation(lengths), axis=0, norm="ortho")), axis=1)
    edges = [0]
    while edges[-1] + max(_LEAST_LINES, round(_BAND_SHARE * edges[-1])) < len(power):
        edges.append(edges[-1] + max(_LEAST_LINES, round(_BAND_SHARE * edges[-1])))
    edges = np.array([*edges, len(power)])
    counts = np.diff(edges)
    return np.repeat(np.add.reduceat(power, edges[:-1]) / counts, counts)
