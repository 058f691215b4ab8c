"""The low-pass filter: what it keeps, what it removes, where the ends stay."""

import numpy as np
import pytest

from drake_blfdmp.demonstration.smoothing import smooth
from drake_blfdmp.errors import RecordingError

RATE = 100.0
T = np.arange(1001) / RATE
INSIDE = slice(200, -200)


def amplitude(frequency, cutoff):
    """How much of a sine of `frequency` comes through, by projection, away from the ends."""
    wave = np.exp(2j * np.pi * frequency * T)
    passed = smooth(T, np.real(wave), cutoff)[INSIDE]
    return np.linalg.lstsq(np.stack([np.real(wave), np.imag(wave)], -1)[INSIDE], passed, rcond=None)[0]


@pytest.mark.parametrize("cutoff", [0.8, 1.5, 3.0])
def test_the_cutoff_halves_the_amplitude_without_lag(cutoff):
    in_phase, quadrature = amplitude(cutoff, cutoff)
    assert in_phase == pytest.approx(0.5, abs=2e-3)
    assert quadrature == pytest.approx(0.0, abs=2e-3)


@pytest.mark.parametrize("ratio", [0.5, 2.0, 4.0])
def test_the_gain_is_that_of_a_fourth_order_butterworth_run_twice(ratio):
    assert amplitude(1.5 * ratio, 1.5)[0] == pytest.approx(1.0 / (1.0 + ratio**8), abs=2e-3)


def test_a_straight_line_keeps_its_very_ends():
    line = np.stack([2.0 + 0.3 * T, -0.1 * T], axis=-1).reshape(-1, 1, 2)
    np.testing.assert_allclose(smooth(T, line), line, atol=1e-4 * np.ptp(line))


def test_columns_do_not_mix():
    x = np.random.default_rng(0).normal(size=(len(T), 6, 3))
    y = smooth(T, x)
    np.testing.assert_allclose(y[:, 4, 1], smooth(T, x[:, 4, 1]), atol=1e-12)


def test_noise_is_mostly_removed():
    noise = np.random.default_rng(1).normal(size=len(T))
    # White noise keeps the share of its band that is passed.
    assert np.std(smooth(T, noise, 1.2)[INSIDE]) < 1.5 * np.sqrt(1.2 / (RATE / 2))


@pytest.mark.parametrize("cutoff", [0.0, -1.0, 50.0, 80.0, np.nan])
def test_a_cutoff_outside_what_the_rate_allows_is_refused(cutoff):
    with pytest.raises(RecordingError, match="smoothing: cut-off .* between 0 and half the rate, 50 Hz"):
        smooth(T, np.zeros((len(T), 6, 3)), cutoff)
