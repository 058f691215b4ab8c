"""How fast something may go so that a bounded acceleration still stops it in time, in sampled form.

A speed v, held for one step h, is followed by v - a h at the least, then v - 2 a h, ... With room r to the limit,

    V(r) = k r                                           up to V = a c,   c = 1/k - h/2
    V(r) = sqrt((a h / 2)^2 + 2 a (r - a c^2 / 2)) - a h / 2      beyond

is such a speed: the linear approach of gain k while that brakes by less than a, and beyond it the parabola that
continues it with equal value and slope. It is a feasible speed for ever, given k h <= 1 (so that c >= h / 2):

    Claim. 0 <= v <= V(r) implies max(v - a h, 0) <= V(r - h v), and r - h v >= 0.

    On the parabola the speed s(r) solves r - a c^2 / 2 = s^2 / (2 a) + s h / 2; put in s - a h: the room that is left
    after a step at s belongs to s - a h exactly, s(r - h s) = s(r) - a h. V is the tangent's continuation below the
    knee of a concave function, so V >= s there: V(r - h V) >= V - a h. On the line V(r - h V) = V - k h V, and
    k V <= k a c = a (1 - k h / 2) <= a. V rises with r, so a smaller v leaves more. V <= k r, hence r - h v >= 0.

Thus a joint whose last velocity was admissible has an admissible one now: braking at a. For both limits of a joint and
its velocity limit together, `velocity_bounds` and `within_reach` of `differential_ik` use it; docs/redundancy.md.
"""

import numpy as np

ENDLESS = 1e9
"""Accelerations above this count as this: the approach is then linear for every room."""


def braking_speed(room, gain: float, acceleration, time_step: float):
    """The largest speed (...) with which a limit `room` away can be approached.

    Args:
        room: (...) distance to the limit, m or rad; negative counts as 0.
        gain: k, 1/s, of the linear approach; `gain * time_step` <= 1.
        acceleration: (...) a with which to brake, per s^2; inf: the linear approach alone.
        time_step: h, s.
    """
    room, a = np.maximum(room, 0.0), np.minimum(acceleration, ENDLESS)
    c, lost = 1.0 / gain - 0.5 * time_step, 0.5 * a * time_step
    line, knee = gain * room, a * c
    if np.all(line <= knee):
        return line
    parabola = np.sqrt(lost * lost + 2.0 * a * np.maximum(room - 0.5 * a * c * c, 0.0)) - lost
    return np.where(line <= knee, line, parabola)


def braking_share(demand, gain: float, time_step: float):
    """The share (...) in (0, 1] of a correction gain * error that can still be braked.

    Args:
        demand: (...) gain^2 error / acceleration: the deceleration of the linear approach over the one there is.
        gain: 1/s; `gain * time_step` <= 1.
        time_step: s.
    """
    demand = np.maximum(demand, 1e-12)
    return braking_speed(demand / gain**2, gain, 1.0, time_step) * gain / demand
