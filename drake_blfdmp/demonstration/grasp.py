"""The moments of grasp and release inside a held interval.

While a box stands on its support the hands that hold it cannot be lower. A held interval that was found from the hands'
distance may begin before they have come down to the box and end after they have left it; the grasp is the lowest
point on the way to the top, the release the lowest point after it.
"""

from dataclasses import replace

import numpy as np

from drake_blfdmp.demonstration.demonstration import Demonstration
from drake_blfdmp.demonstration.holding import Holding
from drake_blfdmp.demonstration.smoothing import smooth

SHORTEST_S = 0.5


def grasp_and_release(demonstration: Demonstration, holding: Holding, cutoff_hz: float = 1.2) -> Holding:
    """The held interval from the grasp to the release.

    Args:
        demonstration: z up, in the frame that the task is planned in.
        holding: what `find_holding` found.
        cutoff_hz: of the smoothing.

    Returns:
        An interval inside `holding`; `holding` itself where the result would be shorter than 0.5 s.
    """
    inside = np.flatnonzero((demonstration.t >= holding.start_s) & (demonstration.t <= holding.end_s))
    if len(inside) < 3:
        return holding
    x = smooth(demonstration.t, demonstration.x, cutoff_hz)[inside]
    t, z = demonstration.t[inside], 0.5 * (x[:, 2, 2] + x[:, 5, 2])
    top = int(np.argmax(z))
    start, end = float(t[np.argmin(z[: top + 1])]), float(t[top + np.argmin(z[top:])])
    return holding if end - start < SHORTEST_S else replace(holding, start_s=start, end_s=end)
