"""Whether any place and scale lets two arms carry a box along its way: a search that has nothing of the planner's.

Every posture there is, in closed form, over a grid of places and over scales. Only what every plan must do is asked:
both palms flat on the box's sides at samples of the way, and at both ends as far apart as they open. The palms' rolls
are free at every sample, elbows are where they like, bodies may overlap, and no posture need lead to the next. So where
this search finds nothing, no plan follows the way. Where it finds something, `joined_postures` tells whether the arms
get from one posture to the next.
"""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import product

import numpy as np

from drake_blfdmp.robot.closed_form_ik import ClosedFormIk
from drake_blfdmp.robot.plant import JointLimits, MakeKinematicPlant
from drake_blfdmp.skill.profiles import smooth_step

REGION = (np.array([-0.84, -0.84, 0.0]), np.array([0.84, 1.08, 1.68]))
"""Corners of where the hands' middle is looked for at the grasp, m in W: as far around as arms reach."""
MIDDLE = np.array([0.0, 0.47, 0.72])
"""Where the search begins, m in W."""
SPACING = 0.06
SCALES = tuple(float(scale) for scale in np.round(np.arange(0.3, 1.01, 0.1), 2))
"""Those of the planner's range."""
ANGLES = 72
"""Of a wrist about the palm's normal that are looked at, all around."""
CHUNK = 256
"""So many palms are looked at at once."""
AT_ONCE = 24
"""So many places are: the first may be enough."""


@dataclass(frozen=True)
class Way:
    """What is asked at K samples, from the grasp to the release.

    Attributes:
        apart: K tuples of the palms' distances, m: closed, and at the ends open as well.
        yaw: (K,) of the line between the palms, left to right, rad.
        way: (K, 3) the middle of the hands, seen from the grasp, of the person's size, m.
        share: (K,) of the shift that is done there, from 0 to 1.
        shift: (3,) what the release is moved by in W, in addition, and the grasp is not, m.
        level: both ends are at one height.
        over: how high over the higher end the hands are led, m: straight up, over and straight down, a third of the
            samples each; None as the person leads them.
    """

    apart: tuple[tuple[float, ...], ...]
    yaw: np.ndarray
    way: np.ndarray
    share: np.ndarray
    shift: np.ndarray
    level: bool
    over: float | None = None

    def middles(self, grasp, scale: float) -> np.ndarray:
        """The hands' middle (K, 3), of that at the grasp, m in W."""
        shift = np.array(self.shift, dtype=float)
        if self.level:
            shift[2] = -scale * self.way[-1, 2]
        if self.over is None:
            return np.asarray(grasp) + scale * self.way + self.share[:, None] * shift
        end = scale * self.way[-1] + shift
        top = max(0.0, end[2]) + self.over
        u = 3.0 * np.linspace(0.0, 1.0, len(self.share))
        up, across, down = (smooth_step(u - k)[0][:, None] for k in range(3))
        return np.asarray(grasp) + across * [*end[:2], 0.0] + up * [0.0, 0.0, top] + down * [0.0, 0.0, end[2] - top]


class ReachSearch:
    """Asks where two palms that face each other can be."""

    def __init__(self, angles: int = ANGLES, limits: JointLimits | None = None):
        """Look at so many `angles` of a wrist about its palm's normal, of joints within limits (None: their own)."""
        self._ik = ClosedFormIk(MakeKinematicPlant(), limits)
        self._angles = np.linspace(-np.pi, np.pi, angles, endpoint=False)

    def facing(self, middles, apart: float, yaw: float) -> np.ndarray:
        """Which of the points (n, 3), m in W, palms can face each other about, `apart` m and turned by `yaw`: (n,)."""
        middles = np.asarray(middles, dtype=float)
        normal = np.array([np.cos(yaw), np.sin(yaw), 0.0])
        reached = np.ones(len(middles), dtype=bool)
        for arm, sign in enumerate((-1.0, 1.0)):
            palms, faced = middles + sign * 0.5 * apart * normal, -sign * normal
            reached &= self._ik.may_reach(arm, palms, faced)
            left = np.flatnonzero(reached)
            for rows in np.split(left, range(CHUNK, len(left), CHUNK)):
                q = self._ik.postures(arm, palms[rows], faced, self._angles)
                reached[rows] = self._ik.within_limits(arm, q).any(axis=(1, 2))
        return reached

    def search(
        self,
        way: Way,
        spacing: float = SPACING,
        most: int = 1,
        joined: Callable[[np.ndarray, float], bool] = lambda place, scale: True,
    ) -> tuple[list[tuple[np.ndarray, float]], int, int]:
        """Places of the hands' middle at the grasp, m in W, with scales, at which every sample has its postures.

        Args:
            way: what is asked.
            spacing: of the grid of places, m.
            most: how many are enough.
            joined: whether the arms get from posture to posture at a place and a scale; asked where there are some.

        Returns:
            Those found; how many pairs of a place and a scale were looked at; and how many had postures.
        """
        found, tried, had = [], 0, 0
        axes = [np.arange(low, high + 1e-9, spacing) for low, high in zip(*REGION, strict=True)]
        # From the middle outwards: what is easy is found soon.
        places = np.array(sorted(product(*axes), key=lambda place: np.linalg.norm(np.subtract(place, MIDDLE))))
        for some in np.split(places, range(AT_ONCE, len(places), AT_ONCE)):
            there = self._scales(way, some)
            for place, with_postures in zip(some, there, strict=True):
                tried += len(SCALES)
                for scale in np.array(SCALES)[with_postures][::-1]:
                    had += 1
                    if joined(place, float(scale)):
                        found.append((place, float(scale)))
                        break
                if len(found) >= most:
                    return found, tried, had
        return found, tried, had

    def _scales(self, way: Way, places: np.ndarray) -> np.ndarray:
        """With which of `SCALES` every sample has its postures, at n places: (n, S)."""
        last = len(way.share) - 1
        there = np.repeat(self._sample(way, 0, places)[:, None], len(SCALES), axis=1)
        # The end first, then by halves: what lies between is mostly reached where its neighbours are.
        for k in sorted(range(1, last + 1), key=lambda k: (k != last, -(k & -k))):
            row, column = np.nonzero(there)
            middles = [way.middles(places[i], SCALES[j])[k] for i, j in zip(row, column, strict=True)]
            there[row, column] = self._sample(way, k, np.reshape(middles, (-1, 3)))
        return there

    def _sample(self, way: Way, k: int, middles: np.ndarray) -> np.ndarray:
        """At which of n middles sample k has its postures: (n,)."""
        reached = np.ones(len(middles), dtype=bool)
        for apart in way.apart[k]:
            reached[reached] = self.facing(middles[reached], apart, float(way.yaw[k]))
        return reached
