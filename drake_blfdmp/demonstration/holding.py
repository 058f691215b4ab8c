"""When both hands hold one box: from the moment they have closed on it to the moment they begin to open.

One generalised least-squares fit finds both ends. The hands' distance is modelled as a level while the box is held, and
wider levels before and after it, joined by minimum-jerk movements of a person's usual duration. What the sensor adds
is drift, not white noise: its covariance is a Matern 3/2 process whose size the wobble of the bones tells. A box is
taken and released at rest, so an end costs what the hands' midpoint's speed there (vertical, and horizontal against
the shoulders) is worth in drift. Every pair of ends is tried. An end may also be that of the recording: nothing opens
there, and nobody has to rest.

Sources: Aitken, Proc. R. Soc. Edinburgh 55, 1935 (the estimator); Flash and Hogan, J. Neurosci. 5, 1985 (the shape).
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.interpolate import make_interp_spline
from scipy.linalg import cholesky, solve_triangular

from drake_blfdmp.demonstration.bones import BONES, link_lengths, robust_sigma
from drake_blfdmp.demonstration.demonstration import Demonstration
from drake_blfdmp.demonstration.modelled_person import minimum_jerk
from drake_blfdmp.demonstration.torso_frame import low_pass
from drake_blfdmp.errors import RecordingError
from drake_blfdmp.skeleton import HANDS

_SHOULDERS, _WRISTS = [0, 3], [2, 5]  # Left, right.
_CUTOFF_HZ = 3.0  # Of the distance; what is above is no movement of a person.
_REST_CUTOFF_HZ = 1.0  # Of speeds and heights: a rest, not a turning point of the noise.
_STEP_S = 1.0 / 15.0
_MOST_SAMPLES = 900  # All pairs are tried; a longer recording gets a coarser clock.
_BODY_WOBBLE = 0.01  # m; bones between markers on skin vary so much for a perfect sensor.
_CLOSING_S = 0.7  # Hands close on a box, and open, within 0.5 to 1 s.
_DRIFT = 0.01  # m, standard deviation of the distance without noise: hands slide and squeeze,
_NOISY_DRIFT = 2.3  # and more for each metre of noise: the ends of two chains of bones.
_DRIFT_TIME_S = 0.8  # Integral time scale.
_WHITE_SHARE = 0.3  # White noise for each metre of drift.
_DRIFT_RATE = 1.2  # 1/s: the speed at an end that is worth one standard deviation, for each metre of drift.
_END_COST = 3.0  # What an end inside the recording has to explain, in squared standard deviations.
_LEAST_DURATION_S = 0.8
_LEAST_OPENING, _MOST_OPENING = 0.03, 1.0  # m, at an end inside the recording; the least grows with the noise.
_NOISY_LIFT, _SURE_LIFT = 25.0, 0.18  # Lift that confirms an end, for each metre of noise; and the most asked, m.
_LEAST_PATH = 0.15  # m, of each hand.
_LEAST_SHARE = 0.25  # Of one hand's path to the other's.
_TOGETHER = 0.85  # Correlation of the hands' velocities; real holds measure 0.9 and more without noise.
_NOISE_PARTS = 180.0  # Correlation lost for each metre of noise.
_TOLERANCE = 0.03  # m, median deviation of the distance in a hold without noise,
_NOISY_TOLERANCE = 9.0  # and more for each metre of noise.


@dataclass(frozen=True)
class Holding:
    """When the hands hold, s on the demonstration's clock, and the box's width: the median hand distance then, m."""

    start_s: float
    end_s: float
    hand_distance: float


class DistanceFits(NamedTuple):
    """One fit of the hands' distance for each of K pairs of samples at which the hold starts and ends.

    Attributes:
        first, last: (K,) the pair.
        opening: (K, 2) how much wider the hands are before and after, m; 0 at an end of the recording.
        misfit: (K,) squared standard deviations that the fit leaves.
    """

    first: np.ndarray
    last: np.ndarray
    opening: np.ndarray
    misfit: np.ndarray


def find_holding(demonstration: Demonstration) -> Holding:
    """The interval in which both hands hold the box.

    An end lies inside the recording only where the hands are wider apart beyond it. A noisy sensor's distance alone is
    no proof of that: the box must be lifted or lowered too, else it is held from the first sample to the last.

    Args:
        demonstration: cleaned, unsmoothed, in the world or the torso frame.

    Raises:
        RecordingError: there is none: one hand carries, the hands never keep a distance, or they do not move.
    """
    x = demonstration.x
    noise = wobble(x) if demonstration.wobble is None else demonstration.wobble
    count = min(_MOST_SAMPLES, round(demonstration.duration_s / _STEP_S) + 1)
    t = np.linspace(demonstration.t[0], demonstration.t[-1], count)

    def sampled(points, cutoff_hz):
        return make_interp_spline(demonstration.t, low_pass(points, demonstration.rate_hz, cutoff_hz), k=1)(t)

    hands = sampled(x[:, _WRISTS], _CUTOFF_HZ)
    middle = sampled(x[:, _WRISTS].mean(axis=1), _REST_CUTOFF_HZ)
    shoulders = sampled(x[:, _SHOULDERS].mean(axis=1), _REST_CUTOFF_HZ)
    distance = np.linalg.norm(hands[:, 1] - hands[:, 0], axis=-1)
    drift = _DRIFT + _NOISY_DRIFT * noise
    fits = fit_distance(t, distance, drift)
    speed = np.linalg.norm(np.gradient(middle - shoulders * [1.0, 1.0, 0.0], t, axis=0), axis=-1)  # Who walks can rest.
    end_cost = (speed / (_DRIFT_RATE * drift)) ** 2 + _END_COST
    end_cost[[0, -1]] = 0.0
    cost = fits.misfit + end_cost[fits.first] + end_cost[fits.last]
    wider = (fits.opening >= _LEAST_OPENING + noise) & (fits.opening <= _MOST_OPENING)
    opens = (wider[:, 0] | (fits.first == 0)) & (wider[:, 1] | (fits.last == count - 1))
    lifts = _lifts(fits, middle[:, 2], shoulders[:, 2], noise)
    cost[~(opens & lifts & _carries(fits, hands, noise))] = np.inf
    if np.isfinite(np.min(cost, initial=np.inf)):
        best = int(np.argmin(cost))
        start, end = float(t[fits.first[best]]), float(t[fits.last[best]])
        held = (demonstration.t >= start) & (demonstration.t <= end)
        width = float(np.median(widths := link_lengths(x[held])[:, HANDS]))
        if np.median(np.abs(widths - width)) <= _TOLERANCE + _NOISY_TOLERANCE * noise:
            return Holding(start, end, width)
    raise RecordingError(f"{demonstration.source}: {_why_not(demonstration, hands, distance)}")


def wobble(x: np.ndarray) -> float:
    """The sensor's noise, m: robust standard deviation of the four bones' lengths beyond what bodies do themselves.

    Args:
        x: (N, 6, 3) m.
    """
    return max(0.0, float(np.mean(robust_sigma(link_lengths(x)[:, BONES]))) - _BODY_WOBBLE)


def fit_distance(t: np.ndarray, distance: np.ndarray, drift: float) -> DistanceFits:
    """Fits level, opening before and opening after for every pair of samples `_LEAST_DURATION_S` or more apart.

    Args:
        t: (N,) increasing, s.
        distance: (N,) between the hands, m.
        drift: standard deviation of the sensor's slow error of the distance, m.
    """
    lag = 2.0 / _DRIFT_TIME_S * np.abs(t[:, None] - t)
    covariance = drift**2 * ((1.0 + lag) * np.exp(-lag) + _WHITE_SHARE**2 * np.eye(len(t)))
    since = (t[:, None] - t) / _CLOSING_S  # Row: sample; column: end of the hold.
    before, after = 1.0 - minimum_jerk(since + 1.0), minimum_jerk(since)
    before[:, 0], after[:, -1] = 0.0, 0.0
    columns = np.column_stack([np.ones_like(t), distance, before, after])
    white = solve_triangular(cholesky(covariance, lower=True), columns, lower=True)
    level, observed, before, after = white[:, 0], white[:, 1], white[:, 2 : 2 + len(t)], white[:, 2 + len(t) :]
    first, last = np.nonzero(t - t[:, None] >= _LEAST_DURATION_S - 1e-9)
    normal = np.full((len(first), 3, 3), level @ level)
    normal[:, 0, 1] = normal[:, 1, 0] = (level @ before)[first]
    normal[:, 0, 2] = normal[:, 2, 0] = (level @ after)[last]
    normal[:, 1, 2] = normal[:, 2, 1] = (before.T @ after)[first, last]
    normal[:, 1, 1], normal[:, 2, 2] = np.sum(before**2, axis=0)[first], np.sum(after**2, axis=0)[last]
    normal += 1e-6 * np.eye(3)  # At the recording's ends nothing opens and a column is zero.
    right = np.stack([np.full(len(first), level @ observed), (observed @ before)[first], (observed @ after)[last]], -1)
    solution = np.linalg.solve(normal, right[..., None])[..., 0]
    return DistanceFits(first, last, solution[:, 1:], observed @ observed - np.sum(solution * right, axis=-1))


def _lifts(fits: DistanceFits, hands_z: np.ndarray, shoulders_z: np.ndarray, noise: float) -> np.ndarray:
    """(K,) bool: the box is lifted or lowered as far as the noise asks, or the hold is the whole recording.

    By the arms; half of the hands' own travel counts too, for lifts by the legs. All of it would count a walk towards
    a tilted camera.
    """
    lift = np.maximum(_range(hands_z - shoulders_z), _range(hands_z) / 2.0)[fits.first, fits.last]
    whole = (fits.first == 0) & (fits.last == len(hands_z) - 1)
    return whole | (lift >= min(_SURE_LIFT, _NOISY_LIFT * noise))


def _range(values: np.ndarray) -> np.ndarray:
    """(N, N) largest minus smallest value from one sample to a later one."""
    later = np.triu(values - values[:, None])  # From the sample itself on; 0 before it.
    return np.maximum.accumulate(later, axis=1) - np.minimum.accumulate(later, axis=1)


def _carries(fits: DistanceFits, hands: np.ndarray, noise: float) -> np.ndarray:
    """(K,) bool: both hands move, far enough, and together."""

    def total(per_step):
        run = np.concatenate([[0.0], np.cumsum(per_step)])
        return run[fits.last] - run[fits.first]

    left, right = np.moveaxis(np.diff(hands, axis=0), 1, 0)
    paths = [total(np.linalg.norm(step, axis=-1)) for step in (left, right)]
    less, more = np.minimum(*paths), np.maximum(*paths)
    power = np.sqrt(total(np.sum(left**2, axis=-1)) * total(np.sum(right**2, axis=-1)))
    together = total(np.sum(left * right, axis=-1)) >= (_TOGETHER - _NOISE_PARTS * noise) * power
    return (less >= _LEAST_PATH) & (less >= _LEAST_SHARE * more) & together


def _why_not(demonstration: Demonstration, hands: np.ndarray, distance: np.ndarray) -> str:
    left, right = np.sum(np.linalg.norm(np.diff(hands, axis=0), axis=-1), axis=0)
    if max(left, right) < _LEAST_PATH:
        return f"the hands move by only {max(left, right):.2f} m, nothing is carried; record a whole carry"
    low, high = np.percentile(distance, [2.0, 98.0])
    jumps = demonstration.repairs.get("jumps_removed", 0)
    jumped = f" and {jumps} samples of the arms jumped" if jumps else ""
    return (
        "one hand carries, or none: the hands do not move together at one distance (paths of "
        f"{left:.1f} m left and {right:.1f} m right, distance {low:.2f} to {high:.2f} m, it varies by "
        f"{high - low:.2f} m){jumped}; record one box held in both hands"
    )
