"""When both hands hold one box: from the first to the last instant at which they move as one body.

A box between the hands fixes their distance. The interval sought has a nearly constant distance (within a tolerance
that grows with the sensor's wobble, which the bones tell), much motion of both hands, and, of two such intervals, the
smaller distance: walking with hanging arms keeps the hands apart too. At its ends the hands close in on the box
and open again.
"""

from dataclasses import dataclass

import numpy as np

from drake_blfdmp.demonstration.bones import BONES, link_lengths, robust_sigma
from drake_blfdmp.demonstration.demonstration import Demonstration
from drake_blfdmp.demonstration.torso_frame import low_pass
from drake_blfdmp.errors import RecordingError

_LEFT_WRIST, _RIGHT_WRIST = 2, 5
_CUTOFF_HZ = 3.0  # Lifts have their power below 1 Hz.
_TOLERANCE = 0.03  # m, of the distance for a sensor without noise: hands slide and squeeze.
_BODY_WOBBLE = 0.01  # m; bones between markers on skin vary so much for a perfect sensor.
_WOBBLES = 9.0  # Tolerance added for each metre of the sensor's noise.
_CLOSING_SPEED = 0.12  # m/s at which the distance changes while the hands come to the box or leave it.
_BRIDGE_S = 0.25  # Excursions shorter than this do not end a hold.
_NOISY_BRIDGE_S = 60.0  # Bridge added for each metre of noise: occlusions by the box last a second and more.
_LEAST_DURATION_S = 0.8
_LEAST_PATH = 0.15  # m, of each hand.
_LEAST_SHARE = 0.25  # Of one hand's path to the other's.
_LEAST_OF_ALL = 0.1  # Of the hands' whole path.
_TOGETHER = 0.6  # Correlation of the hands' velocities; real holds measure 0.9 and more without noise.
_NOISE_PARTS = 100.0  # Correlation lost for each metre of noise.
_PREFERENCE = 0.07  # m above the closest hands that make an interval e times less likely,
_NOISY_PREFERENCE = 4.0  # and more of it for each metre of noise.
_LIFT_WEIGHT = 3.0  # A metre of lifting says as much as three metres of walking.


@dataclass(frozen=True)
class Holding:
    """When the hands hold, s on the demonstration's clock, and the box's width: the median hand distance then, m."""

    start_s: float
    end_s: float
    hand_distance: float


def find_holding(demonstration: Demonstration) -> Holding:
    """The interval in which both hands hold the box.

    Args:
        demonstration: cleaned, unsmoothed, in the world or the torso frame.

    Raises:
        RecordingError: there is none: one hand carries, the hands never keep a distance, or they do not move.
    """
    rate = demonstration.rate_hz
    hands = low_pass(demonstration.x[:, [_LEFT_WRIST, _RIGHT_WRIST]], rate, _CUTOFF_HZ)
    raw_distance = np.linalg.norm(demonstration.x[:, _RIGHT_WRIST] - demonstration.x[:, _LEFT_WRIST], axis=-1)
    distance = np.linalg.norm(hands[:, 1] - hands[:, 0], axis=-1)
    noise = wobble(demonstration.x)
    first, last = holding_interval(hands, distance, rate, noise)
    if last < first:
        raise RecordingError(f"{demonstration.source}: {_why_not(demonstration, hands, distance)}")
    width = float(np.median(raw_distance[first : last + 1]))
    return Holding(float(demonstration.t[first]), float(demonstration.t[last]), width)


def wobble(x: np.ndarray) -> float:
    """The sensor's noise, m: robust standard deviation of the four bones' lengths beyond what bodies do themselves.

    Args:
        x: (N, 6, 3) m.
    """
    return max(0.0, float(np.mean(robust_sigma(link_lengths(x)[:, BONES]))) - _BODY_WOBBLE)


def holding_interval(hands: np.ndarray, distance: np.ndarray, rate_hz: float, noise: float) -> tuple[int, int]:
    """First and last sample of the best interval; (0, -1) where there is none.

    Args:
        hands: (N, 2, 3) both wrists, smoothed, m.
        distance: (N,) between them, m.
        rate_hz: samples a second.
        noise: of the sensor, m, see `wobble`.
    """
    tolerance = _TOLERANCE + _WOBBLES * noise
    bridge = round((_BRIDGE_S + _NOISY_BRIDGE_S * noise) * rate_hz)
    closing_limit = _CLOSING_SPEED + 2.0 * np.pi * _CUTOFF_HZ * noise
    closing = np.gradient(distance) * rate_hz
    closest = float(np.percentile(distance, 5.0))
    preference = _PREFERENCE + _NOISY_PREFERENCE * noise
    whole_path = _path(hands.mean(axis=1))
    best, best_score = (0, -1), 0.0
    for level in np.unique(np.percentile(distance, np.linspace(1.0, 99.0, 50))):
        for first, last in _runs(np.abs(distance - level) <= tolerance, bridge):
            first, last = _trimmed(closing, first, last, closing_limit)
            held = hands[first : last + 1]
            if last - first + 1 < _LEAST_DURATION_S * rate_hz or not _both_move(held):
                continue
            middle = held.mean(axis=1)
            path = _path(middle)
            if path < _LEAST_OF_ALL * whole_path or _togetherness(held) < _TOGETHER - _NOISE_PARTS * noise:
                continue
            lift = float(np.ptp(middle[:, 2]))
            width = float(np.median(distance[first : last + 1]))
            score = (path + _LIFT_WEIGHT * lift) * np.exp(-max(0.0, width - closest) / preference)
            if score > best_score:
                best, best_score = (first, last), score
    return best


def _runs(mask: np.ndarray, bridge: int) -> list[tuple[int, int]]:
    """Inclusive runs of True, joined across interior gaps of at most `bridge` samples."""
    inside = np.flatnonzero(mask)
    if len(inside) == 0:
        return []
    return [(int(run[0]), int(run[-1])) for run in np.split(inside, np.flatnonzero(np.diff(inside) > bridge + 1) + 1)]


def _trimmed(closing: np.ndarray, first: int, last: int, limit: float) -> tuple[int, int]:
    """Without the approach at the start (still closing) and the release at the end (already opening)."""
    while first < last and closing[first] < -limit:
        first += 1
    while last > first and closing[last] > limit:
        last -= 1
    return first, last


def _path(p: np.ndarray) -> float:
    """Length of the path through p (N, 3), m."""
    return float(np.linalg.norm(np.diff(p, axis=0), axis=-1).sum())


def _togetherness(hands: np.ndarray) -> float:
    """Correlation of both hands' velocities, in [-1, 1]."""
    left, right = np.moveaxis(np.diff(hands, axis=0), 1, 0)
    power = np.sqrt(np.sum(left**2) * np.sum(right**2))
    return float(np.sum(left * right) / power) if power > 0.0 else 0.0


def _both_move(hands: np.ndarray) -> bool:
    paths = _path(hands[:, 0]), _path(hands[:, 1])
    return min(paths) >= _LEAST_PATH and min(paths) >= _LEAST_SHARE * max(paths)


def _why_not(demonstration: Demonstration, hands: np.ndarray, distance: np.ndarray) -> str:
    paths = _path(hands[:, 0]), _path(hands[:, 1])
    if max(paths) < _LEAST_PATH:
        return f"the hands move by only {max(paths):.2f} m, nothing is carried; record a whole carry"
    low, high = np.percentile(distance, [2.0, 98.0])
    jumps = demonstration.repairs.get("jumps_removed", 0)
    jumped = f" and {jumps} samples of the arms jumped" if jumps else ""
    return (
        "one hand carries, or none: the hands do not move together at one distance (paths of "
        f"{paths[0]:.1f} m left and {paths[1]:.1f} m right, distance {low:.2f} to {high:.2f} m, it varies by "
        f"{high - low:.2f} m){jumped}; record one box held in both hands"
    )
