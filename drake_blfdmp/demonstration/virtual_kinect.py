"""A virtual Kinect: films an exact motion with errors of the size and kind measured on real recordings.

Most of a skeleton tracker's error is not white: the fitted skeleton slides slowly along the body, and further for the
hands than for the elbows and shoulders. A filter therefore cannot remove it, which is why bone lengths have to be
restored by the coupling. Around the slow part stand white noise, hands that a held box hides from the camera, short
jumps while the tracker infers a hand, arms fitted in a wrong direction, a body that is fitted too large or too small,
and frames that are lost, empty or delivered twice. How much of each a sensor has is in `sensors.py`.
"""

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.signal import lfilter
from scipy.spatial.transform import Rotation
from scipy.special import erf

from drake_blfdmp.demonstration.demonstration import KnownDimensions, Recording
from drake_blfdmp.demonstration.modelled_person import ModelledPerson, hand_orientations, hold_and_place
from drake_blfdmp.demonstration.sensors import VirtualKinect
from drake_blfdmp.errors import RecordingError
from drake_blfdmp.quaternions import from_rotation_vector, interpolated, multiply
from drake_blfdmp.skeleton import WRISTS

_MISFIT = 0.3  # rad; an arm that is turned by more is one that the sensor guesses.


def film(
    sensor: VirtualKinect,
    t: np.ndarray,
    x_truth: np.ndarray,
    seed: int,
    known: KnownDimensions | None = None,
    turns: np.ndarray | None = None,
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
        turns: (N, 2, 4) the hands' orientations, w x y z; None films none.

    Returns:
        The recording, in the truth's frame, marked synthetic, with the sensor's confidence in every point: 1 seen, 0.5
        guessed, 0 (and NaN) while it finds no body.

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
    drift, occlusion, jumps, white, delivery, misfits, size, presence = np.random.default_rng(seed).spawn(8)
    turning = np.random.default_rng(seed).spawn(9)[8]

    clock = t[0] + np.arange(int(np.floor((t[-1] - t[0]) * sensor.rate_hz + 1e-6)) + 1) / sensor.rate_hz
    x = CubicSpline(t, x_truth)(clock)
    hidden = _hidden(x, known.box_width)
    x = _shortened(x, sensor.shortening)
    bones = _bones(x)
    x, misfitted = _misfits(sensor, misfits, x)
    x = x + _joint_drift(sensor, drift, len(clock))
    offset, inferred = _jumps(sensor, jumps, len(clock))
    x[:, WRISTS] += _occlusion(sensor, occlusion, x[:, WRISTS], hidden) + offset
    x += sensor.white_m * np.tile(sensor.white_grading, 2)[:, None] * white.standard_normal(x.shape)
    x = _sized(sensor, size, x, bones)

    confidence = np.where(np.repeat(misfitted, 3, axis=1) & ([False, True, True] * 2), sensor.misfit_confidence, 1.0)
    confidence[:, WRISTS] = np.where(inferred, np.minimum(confidence[:, WRISTS], 0.5), confidence[:, WRISTS])
    absent = _absent(sensor, presence, len(clock))
    x[absent], confidence[absent] = np.nan, 0.0
    frames = _delivered(sensor, delivery, len(clock))
    seen_turns = None if turns is None else _turned(sensor, turning, t, turns, clock)
    return Recording(
        t=clock[frames],
        x=x[frames],
        source=f"virtual Kinect (synthetic), seed {seed}",
        format="virtual_kinect",
        frames=frames,
        synthetic=True,
        known=known,
        confidence=confidence[frames],
        orientations=None if seen_turns is None else np.where(absent[:, None, None], np.nan, seen_turns)[frames],
        up="z",
    )


def record_hold_and_place(
    person: ModelledPerson | None = None, sensor: VirtualKinect | None = None, seed: int = 0
) -> tuple[Recording, np.ndarray]:
    """A modelled person takes a box and places it, filmed by a virtual Kinect.

    Args:
        person: the default person if None.
        sensor: `VirtualKinect()` if None; `sensors.SENSORS` has those measured.
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
    turns = hand_orientations(person, t) if person.box_pitch else None
    recording = film(sensor, t, x, seed, known, turns)
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


def rough_noise(
    rng: np.random.Generator, n: int, shape: tuple[int, ...], time_step: float, correlation_s: float
) -> np.ndarray:
    """Stationary Gaussian noise of unit variance with covariance exp(-|dt| / correlation_s): Ornstein-Uhlenbeck.

    Args and returns as of `slow_noise`.
    """
    kept = np.exp(-time_step / correlation_s)
    kicks = rng.standard_normal((n, *shape))
    kicks[1:] *= np.sqrt(-np.expm1(-2 * time_step / correlation_s))
    return np.asarray(lfilter([1.0], [1.0, -kept], kicks, axis=0))


def _joint_drift(sensor: VirtualKinect, rng: np.random.Generator, n: int) -> np.ndarray:
    """Slow errors (n, 6, 3), m; they add up along each arm, so a bone's own error is smaller than its far end's."""
    own = np.array([sensor.shoulder_drift_m, sensor.elbow_drift_m, sensor.wrist_drift_m])
    if sensor.rough:
        noise = rough_noise(rng, n, (2, 3, 3), 1 / sensor.rate_hz, sensor.correlation_s)
    else:
        noise = _bounded(slow_noise(rng, n, (2, 3, 3), 1 / sensor.rate_hz, sensor.correlation_s))
    return np.cumsum(own[:, None] * noise, axis=2).reshape(n, 6, 3)


def _turned(
    sensor: VirtualKinect, rng: np.random.Generator, t: np.ndarray, turns: np.ndarray, clock: np.ndarray
) -> np.ndarray:
    """The hands' orientations (n, 2, 4) at the clock's times, with slow and white errors; their size is assumed."""
    shown = np.stack([interpolated(t, turns[:, hand], clock) for hand in range(2)], axis=1)
    slow = slow_noise(rng, len(clock), (2, 3), 1 / sensor.rate_hz, sensor.correlation_s)
    error = sensor.hand_turn * slow + 0.3 * sensor.hand_turn * rng.standard_normal(slow.shape)
    return multiply(from_rotation_vector(error), shown)


def _misfits(sensor: VirtualKinect, rng: np.random.Generator, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Arms fitted in a wrong direction for a while: (n, 6, 3), m, and (n, 2) bool, whether each arm is off by a lot.

    The arm turns about its shoulder there and back (sine squared), so its bones stay as long as they are.
    """
    n, longest = len(x), 1.5 * sensor.misfit_duration_s
    turn = np.zeros((n, 2, 3))
    clock = np.arange(n) / sensor.rate_hz
    span = longest + n / sensor.rate_hz  # A spell may have begun before the first frame.
    for arm in range(2):
        for start in rng.uniform(-longest, span - longest, rng.poisson(sensor.misfit_rate_hz * span)):
            duration = sensor.misfit_duration_s * rng.uniform(0.5, 1.5)
            axis = rng.standard_normal(3)
            angle = sensor.misfit_angle * rng.standard_normal() / np.linalg.norm(axis)
            done = np.clip((clock - start) / duration, 0.0, 1.0)
            turn[:, arm] += angle * np.sin(np.pi * done[:, None]) ** 2 * axis
    arms = x.reshape(n, 2, 3, 3).copy()
    off = np.linalg.norm(turn, axis=-1) > 1e-9
    if off.any():
        shoulders = arms[off][:, :1]
        rotation = Rotation.from_rotvec(turn[off]).as_matrix()
        arms[off] = shoulders + np.einsum("aij,apj->api", rotation, arms[off] - shoulders)
    return arms.reshape(n, 6, 3), np.linalg.norm(turn, axis=-1) > _MISFIT


def _bones(x: np.ndarray) -> np.ndarray:
    """(n, 2, 2) lengths of both arms' upper arm and forearm, m."""
    return np.linalg.norm(np.diff(x.reshape(-1, 2, 3, 3), axis=2), axis=-1)


def _sized(sensor: VirtualKinect, rng: np.random.Generator, x: np.ndarray, bones: np.ndarray) -> np.ndarray:
    """The fitted body (n, 6, 3), m: bones (n, 2, 2), m, restored if it is rigid, and all of it larger or smaller."""
    if not sensor.rigid and sensor.body_scale == 0:
        return x
    arms = x.reshape(-1, 2, 3, 3)
    vectors = np.diff(arms, axis=2)
    if sensor.rigid:
        vectors = vectors * (bones / np.maximum(_bones(x), 1e-9))[..., None]
    noise = slow_noise(rng, len(x), (1, 1, 1), 1 / sensor.rate_hz, sensor.correlation_s)
    size = 1 + sensor.body_scale * noise
    middle = arms[:, :, :1].mean(axis=1, keepdims=True)
    shoulders = middle + size * (arms[:, :, :1] - middle)
    return np.concatenate([shoulders, shoulders + np.cumsum(size * vectors, axis=2)], axis=2).reshape(-1, 6, 3)


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


def _jumps(sensor: VirtualKinect, rng: np.random.Generator, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Offsets of inferred wrists (n, 2, 3), m, constant within a spell; and whether each is inferred, (n, 2) bool."""
    offset, inferred = np.zeros((n, 2, 3)), np.zeros((n, 2), dtype=bool)
    for hand in range(2):
        for start in np.flatnonzero(rng.random(n) < -np.expm1(-sensor.jump_rate_hz / sensor.rate_hz)):
            length = 1 + int(rng.exponential(sensor.jump_duration_s) * sensor.rate_hz)
            offset[start : start + length, hand] = sensor.jump_m * rng.standard_normal(3)
            inferred[start : start + length, hand] = True
    return offset, inferred


def _absent(sensor: VirtualKinect, rng: np.random.Generator, n: int) -> np.ndarray:
    """(n,) bool: frames before the person is found and after it is lost; never so many that fewer than two are left."""
    count = max(0, min(round(sensor.absent_share * n), n - 2))
    before = int(rng.integers(count + 1))
    index = np.arange(n)
    return (index < before) | (index >= n - (count - before))


def _delivered(sensor: VirtualKinect, rng: np.random.Generator, n: int) -> np.ndarray:
    """The frame number of each row of the file, int, from 0."""
    copies = 1 + (rng.random(n) < sensor.repeat_probability)
    dropped = rng.random(n) < sensor.drop_probability
    dropped[0] = False
    return np.repeat(np.arange(n), np.where(dropped, 0, copies))
