"""Which phase of a carry the arms are in, from what is measured: palm forces, the box's height and speed."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from drake_blfdmp.robot.box import TableParameters

PHASES = ("free_space", "contact", "lift", "carry", "lower", "release", "placed", "dropped")
FREE_SPACE, CONTACT, LIFT, CARRY, LOWER, RELEASE, PLACED, DROPPED = range(len(PHASES))


@dataclass(frozen=True)
class PhaseThresholds:
    """When a phase begins and ends; each pair is a hysteresis.

    Attributes:
        touch_n, free_n: a palm touches above the first, and no longer below the second, N.
        lifted_m, down_m: the box is in the air above the first, on its support below the second, m.
        moving_m_s, level_m_s: it rises or sinks above the first, and no longer below the second, m/s.
        still_m_s: a placed box is slower, m/s.
        open_share: the palms open when the squeeze falls below this share of the largest so far.
        dwell_s: what is measured must say so for this long, s.
    """

    touch_n: float = 2.0
    free_n: float = 0.5
    lifted_m: float = 0.005
    down_m: float = 0.002
    moving_m_s: float = 0.03
    level_m_s: float = 0.015
    still_m_s: float = 0.01
    open_share: float = 0.5
    dwell_s: float = 0.04


DEFAULT_THRESHOLDS = PhaseThresholds()


def height_above(tables: Sequence[TableParameters], position, half_height: float) -> float:
    """How far an upright box stands above the table beneath its centre, m; inf where there is none.

    Args:
        position: (3,) of its centre in W, m; half_height: of the box, m.
    """
    x, y, z = position
    beneath = [
        table.top_center[2]
        for table in tables
        if abs(x - table.top_center[0]) <= table.size[0] / 2 and abs(y - table.top_center[1]) <= table.size[1] / 2
    ]
    return float(z) - half_height - max(beneath) if beneath else np.inf


def phase_now(
    phase: int, force, height: float, vertical: float, speed: float, largest: float, limits: PhaseThresholds
) -> int:
    """The phase that the present measurements, taken alone, lead to from `phase`.

    Args:
        force: (2,) of the palms on the box, N.
        height: above its support, m.
        vertical, speed: of the box, upwards and in all, m/s.
        largest: squeeze (the lesser palm's force) since the box was touched, N.
    """
    least, most = min(force), max(force)
    up, down = height > limits.lifted_m, height < limits.down_m
    held, touched, free = least > limits.touch_n, most > limits.touch_n, most < limits.free_n
    if up and least < limits.free_n and phase in (CONTACT, LIFT, CARRY, LOWER, RELEASE):
        return DROPPED
    if phase in (FREE_SPACE, PLACED):
        return CONTACT if touched else phase
    if phase == CONTACT:
        return LIFT if held and up else FREE_SPACE if free else phase
    if phase == DROPPED:
        return LIFT if held and up else CONTACT if held and down else phase
    if phase == RELEASE:
        return LIFT if held and up else PLACED if free and down and speed < limits.still_m_s else phase
    # In the air, or set down and still squeezed.
    if down and phase == LOWER and least < limits.open_share * largest:
        return RELEASE
    if down or vertical < -limits.moving_m_s:
        return LOWER
    if vertical > limits.moving_m_s:
        return LIFT
    return CARRY if phase == LIFT and vertical < limits.level_m_s else phase


def next_state(state, t: float, force, height: float, velocity, limits: PhaseThresholds = DEFAULT_THRESHOLDS):
    """One update of the recogniser.

    Args:
        state: (4,) phase, the phase in question, since when, s, and the largest squeeze, N.
        t: now, s.
        force: (2,) of the palms on the box, N.
        height: of the box above its support, m.
        velocity: (3,) of the box in W, m/s.

    Returns:
        (4,) the next state.
    """
    phase, asked, since, largest = int(state[0]), int(state[1]), float(state[2]), float(state[3])
    largest = 0.0 if phase in (FREE_SPACE, PLACED) else max(largest, float(min(force)))
    found = phase_now(phase, force, height, float(velocity[2]), float(np.linalg.norm(velocity)), largest, limits)
    if found != asked:
        asked, since = found, t
    if asked != phase and t - since > limits.dwell_s - 1e-9:
        phase = asked
    return np.array([phase, asked, since, largest])


def transitions(t, phase) -> tuple[tuple[str, float], ...]:
    """(name, time in s) of every phase entered after the first sample; t, phase: (N,)."""
    phase = np.asarray(phase).astype(int)
    return tuple((PHASES[phase[k]], float(t[k])) for k in 1 + np.flatnonzero(np.diff(phase)))
