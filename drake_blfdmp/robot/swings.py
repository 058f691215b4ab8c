"""How the person's elbows swing about the lines from shoulder to wrist, where they are led another way."""

from dataclasses import dataclass

import numpy as np

from drake_blfdmp.robot.swivel import swivel_angle, wrap
from drake_blfdmp.skeleton import ELBOWS, SHOULDERS, WRISTS
from drake_blfdmp.vectors import cross, dot


@dataclass(frozen=True)
class Swings:
    """The swivel angles that both elbows of the person are to have.

    Attributes:
        t: (N,) s.
        angle: (N, 2) rad, continuous; held before the first time and after the last.
    """

    t: np.ndarray
    angle: np.ndarray

    def of(self, t, x) -> np.ndarray:
        """Points x (M, 6, 3), m, at times t (M,), s, with the elbows so turned; all lengths stay as they are."""
        s, e, w = (x[:, arms] for arms in (SHOULDERS, ELBOWS, WRISTS))
        turn = wrap(self._at(t) - swivel_angle(s, e, w))[..., None]
        axis = w - s
        axis = axis / np.sqrt(dot(axis, axis))[..., None]
        along = dot(e - s, axis)[..., None] * axis
        aside = e - s - along
        swung = x.copy()
        swung[:, ELBOWS] = s + along + np.cos(turn) * aside + np.sin(turn) * cross(axis, aside)
        return swung

    def farthest(self, t, x) -> float:
        """By how much they turn an elbow of points x (M, 6, 3) at times t (M,) at most, rad."""
        s, e, w = (x[:, arms] for arms in (SHOULDERS, ELBOWS, WRISTS))
        return float(np.abs(wrap(self._at(t) - swivel_angle(s, e, w))).max())

    def corrected(self, wanted: "Swings", t, x) -> "Swings":
        """These with what points x (M, 6, 3) at times t (M,), learned from them, lack of the wanted ones added."""
        s, e, w = (x[:, arms] for arms in (SHOULDERS, ELBOWS, WRISTS))
        lacking = wrap(wanted._at(t) - swivel_angle(s, e, w))
        return Swings(self.t, self.angle + np.stack([np.interp(self.t, t, arm) for arm in lacking.T], axis=-1))

    def _at(self, t) -> np.ndarray:
        return np.stack([np.interp(t, self.t, angle) for angle in self.angle.T], axis=-1)
