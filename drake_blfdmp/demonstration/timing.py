"""The task's clock: the recorded motion played with rests where the box is grasped and released.

Hands that close around a box must not carry it along before they hold it. So the clock slows smoothly to a stop at the
grasp and at the release, and the motion starts and ends at rest, which is what a movement primitive expects. A motion
without a box is played in one go, from rest to rest.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.interpolate import make_interp_spline

from drake_blfdmp.demonstration.demonstration import Demonstration
from drake_blfdmp.demonstration.hand_orientation import (
    MOST_DISAGREEMENT,
    disagreement,
    ended_level,
    hand_turns,
    turn_since,
)
from drake_blfdmp.demonstration.holding import Holding
from drake_blfdmp.demonstration.modelled_person import minimum_jerk
from drake_blfdmp.demonstration.smoothing import smooth
from drake_blfdmp.errors import ScenarioError

LONGEST_MOTION_S = 120.0
"""s; of a motion without a box no more is played at once."""


@dataclass
class Timing:
    """How the recording is played.

    Attributes:
        approach_s, retreat_s: how much of the recording before the grasp and after the release is kept, s.
        dwell_s: rest at the grasp and at the release, in which the hands close and open, s.
        rest_s: rest at the start and the end, s; the arms join in after the first.
        ramp_s: time to get up to speed or to stop, s.
        speed: playback speed between the ramps; 1 is the person's.
    """

    approach_s: float = 0.7
    retreat_s: float = 0.7
    dwell_s: float = 0.9
    rest_s: float = 0.5
    ramp_s: float = 0.7
    speed: float = 1.0


@dataclass(frozen=True)
class TaskMotion:
    """A smooth motion on the task's clock.

    Attributes:
        t: (N,) s, uniform from 0.
        x: (N, 6, 3) m.
        recorded: (N,) time in the recording that is shown at t, s.
        events: grasp and release: the beginnings of the two dwells, s; grasp_end and release_end: their ends. Without a
            box start and end of the movement alone.
        turn: (N, 4) how what is held has turned since the grasp, in the frame of the line between the hands
            (`hand_orientation`); None without a box, and where the recording has no orientations.
        disagreeing: how far the two hands turn it differently, rad, root mean square; there is no turn where that is
            more than `MOST_DISAGREEMENT`.
        levelled: rad about that line by which the person put the box down otherwise than they took it; taken out.
    """

    t: np.ndarray
    x: np.ndarray
    recorded: np.ndarray
    events: dict[str, float]
    turn: np.ndarray | None = None
    levelled: float = 0.0
    disagreeing: float = 0.0


def ramp(u):
    """Integral of the quintic step: u^4 (5/2 - 3 u + u^2), from 0 to 1/2 as u goes from 0 to 1."""
    return u**4 * (2.5 + u * (u - 3.0))


def rest_to_rest(t, length: float, ramp_s: float):
    """Distance gone at time t on the way from rest to rest over `length`, at speed 1 between two ramps.

    Where the length is shorter than the ramps, the top speed is lower.

    Returns:
        The distance (...), and the time the whole takes: length + ramp_s, or 2 ramp_s for a short way.
    """
    top = min(1.0, length / ramp_s)
    duration = length / top + ramp_s if top > 0 else 0.0
    t = np.clip(t, 0.0, duration)
    if top == 0:
        return 0.0 * t, 0.0
    up, down = np.clip(t / ramp_s, 0.0, 1.0), np.clip((duration - t) / ramp_s, 0.0, 1.0)
    cruise = np.clip(t - ramp_s, 0.0, duration - 2 * ramp_s)
    return top * (ramp_s * ramp(up) + cruise + ramp_s * (0.5 - ramp(down))), duration


def task_motion(
    demonstration: Demonstration, holding: Holding, timing: Timing, cutoff_hz: float = 1.2, rate_hz: float = 100.0
) -> TaskMotion:
    """Smooth the demonstration and play it on the task's clock.

    Raises:
        ScenarioError: a duration or the speed is not positive, or the box is held too briefly.
    """
    _check(timing)
    start, end = holding.start_s, holding.end_s
    if end - start < 0.3:
        raise ScenarioError(f"the box is held for {end - start:.2f} s only; give a longer held interval")
    stops = [
        max(demonstration.t[0], start - timing.approach_s),
        start,
        end,
        min(demonstration.t[-1], end + timing.retreat_s),
    ]
    rests = [timing.rest_s, timing.dwell_s, timing.dwell_s, timing.rest_s]
    t, x, recorded, durations = _play(demonstration, stops, rests, timing, cutoff_hz, rate_hz)
    grasp = rests[0] + durations[0]
    release = grasp + timing.dwell_s + durations[1]
    held = np.clip(recorded, start, end)
    disagreeing = disagreement(hand_turns(demonstration, held, start, cutoff_hz))
    turn, levelled = turn_since(demonstration, held, start, cutoff_hz), 0.0
    if disagreeing > MOST_DISAGREEMENT:
        turn = None
    if turn is not None:
        turn, levelled = ended_level(turn, minimum_jerk((recorded - start) / (end - start)))
    return TaskMotion(
        t=t,
        x=x,
        recorded=recorded,
        events={
            "grasp": grasp,
            "grasp_end": grasp + timing.dwell_s,
            "release": release,
            "release_end": release + timing.dwell_s,
        },
        turn=turn,
        levelled=levelled,
        disagreeing=disagreeing,
    )


def free_motion(
    demonstration: Demonstration,
    start_s: float,
    end_s: float,
    timing: Timing,
    cutoff_hz: float = 1.2,
    rate_hz: float = 100.0,
) -> TaskMotion:
    """Smooth the demonstration and play it from `start_s` to `end_s`, s, in one go, from rest to rest: no box.

    Raises:
        ScenarioError: a duration or the speed is not positive, or the interval is too short or too long.
    """
    _check(timing)
    if not 0.3 <= end_s - start_s <= LONGEST_MOTION_S:
        raise ScenarioError(
            f"motion: {end_s - start_s:.1f} s would be played, but it must be 0.3 to {LONGEST_MOTION_S:.0f} s; choose "
            "an interval of the recording with task.held=[begin, end]"
        )
    rests = [timing.rest_s, timing.rest_s]
    t, x, recorded, durations = _play(demonstration, [start_s, end_s], rests, timing, cutoff_hz, rate_hz)
    events = {"start": rests[0], "end": rests[0] + durations[0]}
    return TaskMotion(t=t, x=x, recorded=recorded, events=events)  # Free hands turn each on its own: nothing to follow.


def _check(timing: Timing) -> None:
    for name in ("dwell_s", "ramp_s", "speed"):
        if not getattr(timing, name) > 0:
            raise ScenarioError(f"timing.{name} must be positive, not {getattr(timing, name)}")
    for name in ("approach_s", "retreat_s", "rest_s"):
        if getattr(timing, name) < 0:
            raise ScenarioError(f"timing.{name} must not be negative, not {getattr(timing, name)}")


def _play(
    demonstration: Demonstration,
    stops: list[float],
    rests: list[float],
    timing: Timing,
    cutoff_hz: float,
    rate_hz: float,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[float]]:
    """The smoothed recording from one stop to the next, with a rest at each stop.

    Args:
        stops: n recorded times, s; rests: n durations, s.

    Returns:
        t (N,), x (N, 6, 3) and recorded (N,) of the motion, and how long each of the n - 1 pieces takes, s.
    """
    pieces = [b - a for a, b in pairwise(stops)]
    durations = [rest_to_rest(0.0, piece / timing.speed, timing.ramp_s)[1] for piece in pieces]
    total = sum(rests) + sum(durations)
    t = np.arange(round(total * rate_hz) + 1) / rate_hz
    recorded = np.full_like(t, stops[0])
    clock = rests[0]
    for piece, duration, rest in zip(pieces, durations, rests[1:], strict=True):
        recorded += timing.speed * rest_to_rest(t - clock, piece / timing.speed, timing.ramp_s)[0]
        clock += duration + rest
    smoothed = smooth(demonstration.t, demonstration.x, cutoff_hz)
    spline = make_interp_spline(demonstration.t, smoothed.reshape(len(smoothed), 18), k=5)
    x = spline(np.clip(recorded, demonstration.t[0], demonstration.t[-1])).reshape(len(t), 6, 3)
    return t, x, recorded, durations
