"""Hands that close and open about a middle that stands still, so that they neither push the box nor drag it along.

A person's hands, as recorded, may be nearer to each other than the box is wide. The law brings them to the box's width
and beyond; with bones that keep their lengths that swings both arms, and the middle between the hands goes along, by
centimetres with a noisy recording. A motion of all points alike changes no length, and so neither what the law sees nor
what it does: moving the taught motion against that swing takes it out of the middle and out of nothing else.
"""

from dataclasses import replace

import numpy as np
from scipy.integrate import cumulative_trapezoid

from drake_blfdmp.demonstration.timing import TaskMotion
from drake_blfdmp.skill.profiles import smooth_step

RAMP_S = 0.2
"""Within which the middle comes to rest and sets off again, on the clock of the motion, s."""

WORTH = 5e-4
"""A swing, m, that is worth taking out."""


def stillness(t, events: dict[str, float]):
    """How far the middle is to stand still at times t (...): 1 in both dwells, 0 a ramp outside of them, smoothly."""
    t, share = np.asarray(t), 0.0
    for first, last in (("grasp", "grasp_end"), ("release", "release_end")):
        share = share + smooth_step((t - events[first]) / RAMP_S + 1.0)[0] - smooth_step((t - events[last]) / RAMP_S)[0]
    return share


def swing(t, middle, events: dict[str, float]) -> np.ndarray:
    """What the way of the hands' middle does while it should stand still (N, 3), m; 0 while the box is carried.

    Args:
        t: (N,) s on the motion's clock.
        middle: (N, 3) m.
        events: of the motion, s.
    """
    velocity = np.gradient(middle, t, axis=0)
    moved = cumulative_trapezoid(stillness(t, events)[:, None] * velocity, t, axis=0, initial=0.0)
    carry = int(np.searchsorted(t, 0.5 * (events["grasp_end"] + events["release"])))
    return moved - moved[min(carry, len(t) - 1)]


def Steadied(motion: TaskMotion, t, middle) -> tuple[TaskMotion, float]:
    """The motion moved against what its rolled-out way swings in the dwells.

    Args:
        t: (N,) of the way, s on the motion's clock.
        middle: (N, 3) the way of the hands' middle in the person's frame, m.

    Returns:
        The motion, and the largest swing, m; where that is not worth it (`WORTH`), the motion as it was and 0.
    """
    change = swing(np.asarray(t), np.asarray(middle), motion.events)
    largest = float(np.linalg.norm(change, axis=1).max())
    if largest <= WORTH:
        return motion, 0.0
    columns = [np.interp(motion.t, t, column) for column in change.T]
    return replace(motion, x=motion.x - np.stack(columns, axis=-1)[:, None]), largest
