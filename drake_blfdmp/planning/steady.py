"""Hands that close and open about a middle that stands still, so that they neither push the box nor drag it along.

A person's hands, as recorded, may be nearer to each other than the box is wide. The law brings them to the box's width
and beyond; with bones that keep their lengths that swings both arms, and the middle between the hands goes along, by
centimetres with a noisy recording. A motion of all points alike changes no length, and so neither what the law sees nor
what it does: moving the taught motion against that swing takes it out of the middle and out of nothing else.

A carry that is fast right beside a dwell is not yet at rest where the dwell begins. There all that can be taken out is
what the middle does while the hands close and open (`Dwells.while_moving`).
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.integrate import cumulative_trapezoid

from drake_blfdmp.demonstration.timing import TaskMotion
from drake_blfdmp.skill.profiles import smooth_step

RAMP_S = 0.2
"""Within which the middle comes to rest and sets off again, on the clock of the motion, s."""

SHORT_RAMP_S = 0.05
"""The same where the dwells' ends are still, or already, part of the carry, s."""

WORTH = 5e-4
"""A swing, m, that is worth taking out."""


@dataclass(frozen=True)
class Dwells:
    """When the middle is to stand still, s on the motion's clock: (first, last) at the grasp and at the release."""

    grasp: tuple[float, float]
    release: tuple[float, float]
    ramp: float = RAMP_S

    @classmethod
    def of(cls, events: dict[str, float]) -> "Dwells":
        """All of both dwells."""
        return cls((events["grasp"], events["grasp_end"]), (events["release"], events["release_end"]))

    @classmethod
    def while_moving(cls, events: dict[str, float], held: tuple[float, float]) -> "Dwells":
        """Until the hands have closed, and from when they open: `held` is what lies between."""
        return cls((events["grasp"], held[0]), (held[1], events["release_end"]), SHORT_RAMP_S)

    def stillness(self, t):
        """How far the middle is to stand still at times t (...): 1 within, 0 a ramp outside, smoothly."""
        t, share = np.asarray(t), 0.0
        for first, last in (self.grasp, self.release):
            share = share + smooth_step((t - first) / self.ramp + 1.0)[0] - smooth_step((t - last) / self.ramp)[0]
        return share


def swing(t, middle, dwells: Dwells) -> np.ndarray:
    """What the way of the hands' middle does while it should stand still (N, 3), m; 0 while the box is carried.

    Args:
        t: (N,) s on the motion's clock.
        middle: (N, 3) m.
        dwells: when it should.
    """
    velocity = np.gradient(middle, t, axis=0)
    moved = cumulative_trapezoid(dwells.stillness(t)[:, None] * velocity, t, axis=0, initial=0.0)
    carry = int(np.searchsorted(t, 0.5 * (dwells.grasp[1] + dwells.release[0])))
    return moved - moved[min(carry, len(t) - 1)]


def Steadied(motion: TaskMotion, t, middle, dwells: Dwells | None = None) -> tuple[TaskMotion, float]:
    """The motion moved against what its rolled-out way swings in the dwells.

    Args:
        t: (N,) of the way, s on the motion's clock.
        middle: (N, 3) the way of the hands' middle in the person's frame, m.
        dwells: when it is to stand still; None: in all of both dwells.

    Returns:
        The motion, and the largest swing, m; where that is not worth it (`WORTH`), the motion as it was and 0.
    """
    change = swing(np.asarray(t), np.asarray(middle), dwells or Dwells.of(motion.events))
    largest = float(np.linalg.norm(change, axis=1).max())
    if largest <= WORTH:
        return motion, 0.0
    columns = [np.interp(motion.t, t, column) for column in change.T]
    return replace(motion, x=motion.x - np.stack(columns, axis=-1)[:, None]), largest
