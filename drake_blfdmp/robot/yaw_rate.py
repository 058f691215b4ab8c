"""How fast the line between the palms may be turned, and how much of the person's yaw that leaves.

Hands that are near each other have a yaw that a noisy recording throws about: by a radian in a tenth of a second, or
once round where they seem to cross. The arms would have to throw what they hold.
"""

from dataclasses import replace

import numpy as np

from drake_blfdmp.robot.retargeting import Retarget, hand_line

RATE = 0.8
"""Largest rate of the yaw that is asked of the palms, rad/s: random tasks without such throws stay below 0.6."""

TURN = 4.0
"""How fast that rate may change, rad/s^2; the same tasks stay below 2."""

LEAST = 0.02
"""Less of the yaw is none."""


def yaw_rates(t, x, retarget: Retarget) -> tuple[float, float]:
    """The largest rate of the palms' yaw, rad/s, and the largest rate of that, rad/s^2, of x (N, 6, 3) at t (N,)."""
    yaw = hand_line(x, np.zeros_like(x), retarget)[4]
    rate = np.gradient(yaw, t)
    return float(np.abs(rate).max()), float(np.abs(np.gradient(rate, t)).max())


def gentle_yaw_share(t, x, retarget: Retarget, stretch: float) -> float:
    """How much of the yaw can be taken, at most `retarget.yaw_share`, for a motion slowed down by `stretch`.

    Args:
        t: (N,) s.
        x: (N, 6, 3) the motion, m.
        retarget: its other limits of the yaw stay as they are.
        stretch: >= 1.
    """
    share = retarget.yaw_share
    while share > 0.0:
        rate, turn = yaw_rates(t, x, replace(retarget, yaw_share=share))
        over = max(rate / stretch / RATE, turn / stretch**2 / TURN)
        if over <= 1.0:
            break
        # Limits bend what is asked; in small steps nothing is lost by that.
        share = share / min(over, 1.5) if share > LEAST else 0.0
    return share
