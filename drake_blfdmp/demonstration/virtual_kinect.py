"""A virtual Kinect: films an exact motion with errors of the size and kind measured on real Kinect v1 recordings.

Most of a skeleton tracker's error is not white: the fitted skeleton slides slowly along the body, and further for the
hands than for the elbows and shoulders. A filter therefore cannot remove it, which is why bone lengths have to be
restored by the coupling. Around the slow part stand white noise, hands that a held box hides from the camera, short
jumps while the tracker infers a hand, and frames that are lost or delivered twice.
"""

from dataclasses import dataclass, fields

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.special import erf

from drake_blfdmp.demonstration.demonstration import KnownDimensions, Recording
from drake_blfdmp.demonstration.modelled_person import ModelledPerson, hold_and_place
from drake_blfdmp.errors import RecordingError

WRISTS = (2, 5)


@dataclass(frozen=True)
class VirtualKinect:
    """What the sensor does to the truth; standard deviations are per axis, in metres.

    The defaults give the bones' standard deviations of Kinect v1 recordings of people who carry something (0.027 m for
    the upper arm, 0.035 m for the forearm, UTKinect-Action3D) and wrists whose distance wobbles by some centimetres
    while the box is held.

    Attributes:
        rate_hz: frames a second.
        shoulder_drift_m: standard deviation of the shoulders' slow error, present from the first frame on.
        elbow_drift_m: what an elbow adds to its shoulder's.
        wrist_drift_m: what a wrist adds to its elbow's.
        correlation_s: integral time scale of the slow errors.
        shortening: fraction by which the fitted bones come out short.
        white_m: standard deviation of the frame-to-frame noise.
        occlusion_drift_m: standard deviation of both wrists' common further slow error while the box hides them.
        occlusion_pull_m: how far a hidden wrist is pulled towards the box's middle.
        jump_rate_hz: how often a wrist is inferred instead of seen (Poisson), each wrist.
        jump_m: standard deviation of the offset while it is inferred.
        jump_duration_s: mean length of such a spell (exponential).
        drop_probability: of a frame to be missing from the file (never the first).
        repeat_probability: of a frame to stand in the file twice, with the same time stamp.

    Raises:
        RecordingError: a number is out of its range.
    """

    rate_hz: float = 30.0
    shoulder_drift_m: float = 0.010
    elbow_drift_m: float = 0.025
    wrist_drift_m: float = 0.025
    correlation_s: float = 0.8
    shortening: float = 0.09
    white_m: float = 0.005
    occlusion_drift_m: float = 0.022
    occlusion_pull_m: float = 0.015
    jump_rate_hz: float = 0.15
    jump_m: float = 0.04
    jump_duration_s: float = 0.10
    drop_probability: float = 0.03
    repeat_probability: float = 0.02

    def __post_init__(self):
        positive = ("rate_hz", "correlation_s")
        for field in fields(self):
            name, value = field.name, getattr(self, field.name)
            if not np.isfinite(value) or value < 0 or (name in positive and value == 0):
                wanted = "a positive number" if name in positive else "zero or a positive number"
                raise RecordingError(f"VirtualKinect.{name} is {value}; give {wanted}")
            if (name.endswith("probability") or name == "shortening") and value >= 1:
                raise RecordingError(f"VirtualKinect.{name} is {value}; give a number below 1")


def film(
    sensor: VirtualKinect, t: np.ndarray, x_truth: np.ndarray, seed: int, known: KnownDimensions | None = None
) -> Recording:
    """What the sensor makes of an exact motion; the same seed gives identical arrays.

    Frame number i is taken at t[0] + i / rate_hz; a missing frame's number is skipped, a repeated frame's stands twice.

    Args:
        sensor: the sensor.
        t: (N,) increasing times of the truth, s.
        x_truth: (N, 6, 3) positions in the order of `skeleton.POINTS`, m, z up; interpolated to the sensor's clock.
        seed: of all random numbers.
        known: dimensions known beforehand. `box_width` tells when the box is held and hides the hands; without it they
            are never hidden.

    Returns:
        The recording, in the truth's frame, marked synthetic.

    Raises:
        RecordingError: the truth is not finite, of another shape, too short or not in order; or the seed is negative.
    """
    t, x_truth = np.asarray(t, dtype=float), np.asarray(x_truth, dtype=float)
    if t.ndim != 1 or len(t) < 2 or x_truth.shape != (len(t), 6, 3):
        raise RecordingError(
            f"virtual Kinect: the truth needs t (N,) and x (N, 6, 3) with N of 2 or more; got {t.shape} "
            f"and {x_truth.shape}"
        )
    if not (np.isfinite(t).all() and np.isfinite(x_truth).all()):
        raise RecordingError("virtual Kinect: the truth holds numbers that are not finite; fill or cut them first")
    if (np.diff(t) <= 0).any():
        i = int(np.argmax(np.diff(t) <= 0)) + 1
        raise RecordingError(f"virtual Kinect: the truth's time does not increase at sample {i}; sort or cut it first")
    if seed < 0:
        raise RecordingError(f"virtual Kinect: the seed is {seed}; give zero or a positive whole number")
    known = known or KnownDimensions()
    # A stream for each effect: changing one leaves the others' errors as they are.
    drift, occlusion, jumps, white, delivery = np.random.default_rng(seed).spawn(5)

    clock = t[0] + np.arange(int(np.floor((t[-1] - t[0]) * sensor.rate_hz + 1e-6)) + 1) / sensor.rate_hz
    x = CubicSpline(t, x_truth)(clock)
    hidden = _hidden(x, known.box_width)
    x = _shortened(x, sensor.shortening) + _joint_drift(sensor, drift, len(clock))
    x[:, WRISTS] += _occlusion(sensor, occlusion, x[:, WRISTS], hidden) + _jumps(sensor, jumps, len(clock))
    x += sensor.white_m * white.standard_normal(x.shape)

    frames = _delivered(sensor, delivery, len(clock))
    return Recording(
        t=clock[frames],
        x=x[frames],
        source=f"virtual Kinect (synthetic), seed {seed}",
        format="virtual_kinect",
        frames=frames,
        synthetic=True,
        known=known,
    )


def record_hold_and_place(
    person: ModelledPerson | None = None, sensor: VirtualKinect | None = None, seed: int = 0
) -> tuple[Recording, np.ndarray]:
    """A modelled person takes a box and places it, filmed by a virtual Kinect.

    Args:
        person: the default person if None.
        sensor: the default sensor if None.
        seed: of all random numbers.

    Returns:
        The recording of N rows, with the person's bones and box as known dimensions, and the truth (N, 6, 3) at the
        time stamps of its rows, m.

    Raises:
        RecordingError: the person cannot reach, or the seed is negative.
    """
    person = person or ModelledPerson()
    sensor = sensor or VirtualKinect()
    t, x = hold_and_place(person, rate_hz=sensor.rate_hz)
    known = KnownDimensions(person.upper_arm, person.forearm, person.box_width)
    recording = film(sensor, t, x, seed, known)
    return recording, x[recording.frames]


def slow_noise(
    rng: np.random.Generator, n: int, shape: tuple[int, ...], time_step: float, correlation_s: float
) -> np.ndarray:
    """Stationary Gaussian noise of unit variance with covariance (1 + a |dt|) exp(-a |dt|), a = 2 / correlation_s.

    The second-order Gauss-Markov process (Matern 3/2): unlike an Ornstein-Uhlenbeck process it has a velocity, as a
    skeleton that slides has. Exact at the samples for any time step.

    Args:
        rng: source of the random numbers.
        n: number of samples.
        shape: of one sample; its entries are independent.
        time_step: s.
        correlation_s: the covariance's integral from 0, s.

    Returns:
        (n, *shape).
    """
    a = 2.0 / correlation_s
    h = a * time_step
    step = np.exp(-h) * np.array([[1 + h, h], [-h, 1 - h]])  # State: the value, and its rate divided by a.
    values, vectors = np.linalg.eigh(np.eye(2) - step @ step.T)
    kick = vectors * np.sqrt(np.maximum(values, 0.0))  # A square root that also stands a vanishing time step.
    state = rng.standard_normal((2, int(np.prod(shape))))
    out = np.empty((n, state.shape[1]))
    for i in range(n):
        out[i] = state[0]
        state = step @ state + kick @ rng.standard_normal(state.shape)
    return out.reshape(n, *shape)


def _joint_drift(sensor: VirtualKinect, rng: np.random.Generator, n: int) -> np.ndarray:
    """Slow errors (n, 6, 3), m; they add up along each arm, so a bone's own error is smaller than its far end's."""
    own = np.array([sensor.shoulder_drift_m, sensor.elbow_drift_m, sensor.wrist_drift_m])
    noise = slow_noise(rng, n, (2, 3, 3), 1 / sensor.rate_hz, sensor.correlation_s)
    return np.cumsum(own[:, None] * _bounded(noise), axis=2).reshape(n, 6, 3)


def _bounded(noise: np.ndarray) -> np.ndarray:
    """Standard normal to uniform of unit variance: a tracker's skeleton slides only so far."""
    return np.sqrt(3.0) * erf(noise / np.sqrt(2.0))


def _shortened(x: np.ndarray, fraction: float) -> np.ndarray:
    out = x.copy()
    for near, far in ((0, 1), (1, 2), (3, 4), (4, 5)):
        out[:, far] = out[:, near] + (1 - fraction) * (x[:, far] - x[:, near])
    return out


def _hidden(x: np.ndarray, box_width: float | None) -> np.ndarray:
    """(n,) from 0, hands free, to 1, hands on the box: from 8 to 1 cm more than the box between them."""
    if box_width is None:
        return np.zeros(len(x))
    gap = np.linalg.norm(x[:, WRISTS[1]] - x[:, WRISTS[0]], axis=-1) - box_width
    u = np.clip((0.08 - gap) / 0.07, 0.0, 1.0)
    return u * u * (3 - 2 * u)


def _occlusion(sensor: VirtualKinect, rng: np.random.Generator, wrists: np.ndarray, hidden: np.ndarray) -> np.ndarray:
    """Error of the hidden wrists (n, 2, 3), m, from where they are seen, (n, 2, 3).

    Both slide together: what the tracker takes for the hands is the box.
    """
    inward = wrists.mean(axis=1, keepdims=True) - wrists
    inward /= np.maximum(np.linalg.norm(inward, axis=-1, keepdims=True), 1e-9)
    noise = slow_noise(rng, len(wrists), (1, 3), 1 / sensor.rate_hz, sensor.correlation_s)
    slide = sensor.occlusion_drift_m * _bounded(noise)
    return hidden[:, None, None] * (sensor.occlusion_pull_m * inward + slide)


def _jumps(sensor: VirtualKinect, rng: np.random.Generator, n: int) -> np.ndarray:
    """Offsets of the inferred wrists (n, 2, 3), m: constant within a spell."""
    offset = np.zeros((n, 2, 3))
    for hand in range(2):
        for start in np.flatnonzero(rng.random(n) < -np.expm1(-sensor.jump_rate_hz / sensor.rate_hz)):
            length = 1 + int(rng.exponential(sensor.jump_duration_s) * sensor.rate_hz)
            offset[start : start + length, hand] = sensor.jump_m * rng.standard_normal(3)
    return offset


def _delivered(sensor: VirtualKinect, rng: np.random.Generator, n: int) -> np.ndarray:
    """The frame number of each row of the file, int, from 0."""
    copies = 1 + (rng.random(n) < sensor.repeat_probability)
    dropped = rng.random(n) < sensor.drop_probability
    dropped[0] = False
    return np.repeat(np.arange(n), np.where(dropped, 0, copies))
