"""The iterative learning of Gams et al. 2014, the paper's [17]: over epochs, the hands learn what feedback leaves over.

C = c e + F_c with e = k (d_d - d_a) and, after every epoch, F_c(j) <- Q (F_c(j) + L c e(j + 1)). As C = c k (d_d + r -
d_a) with r = F_c / (c k), what is learned is a reference beside the desired distance, r(j) <- Q (r(j) + L (d_d -
d_a)(j + 1)): the coupling `skill.laws.gams` stays as it is and is given d_d + r. Read as a derivative in place of a
one-sample shift the update diverges.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import CubicSpline

from drake_blfdmp.errors import SkillError
from drake_blfdmp.skeleton import HANDS
from drake_blfdmp.skill.bands import Bands
from drake_blfdmp.skill.laws import gams
from drake_blfdmp.skill.laws.gams import GamsGains
from drake_blfdmp.skill.profiles import ConstantDistance, HandDistance, RecordedDistance
from drake_blfdmp.skill.rollout import Rollout, roll_out
from drake_blfdmp.skill.skill import Skill


class SampledDistance:
    """A desired distance with a sampled reference beside it, d(t) + r(t); takes the place of `Bands.hands`.

    Between samples r is a cubic spline, so that the coupling's C' has its derivative; after the last it is held.
    """

    def __init__(self, base: HandDistance | ConstantDistance | RecordedDistance, t, reference):
        """Of a reference (N,), m, at increasing times (N,), s.

        Raises:
            SkillError: fewer than two samples, times that do not increase, or numbers that are not finite.
        """
        t, reference = np.asarray(t, dtype=float), np.asarray(reference, dtype=float)
        if t.ndim != 1 or len(t) < 2 or t.shape != reference.shape or not np.all(np.diff(t) > 0):
            raise SkillError(
                "sampled distance: needs two samples or more at increasing times, "
                f"got shapes {t.shape}, {reference.shape}"
            )
        if not np.all(np.isfinite(reference)):
            raise SkillError("sampled distance: the reference holds a number that is not finite; use a smaller Q or L")
        self._base, self._last = base, float(t[-1])
        self._spline = CubicSpline(t, reference, bc_type="natural")

    def evaluate(self, t):
        """D + r and its first two derivatives at time t (...), in m, m/s, m/s^2."""
        inside = np.asarray(t) <= self._last
        r = (
            self._spline(np.minimum(t, self._last)),
            np.where(inside, self._spline(t, 1), 0.0),
            np.where(inside, self._spline(t, 2), 0.0),
        )
        return tuple(d + value for d, value in zip(self._base.evaluate(t), r, strict=True))


@dataclass(frozen=True)
class Epoch:
    """One epoch.

    Attributes:
        reference: (N,) r that was used, m.
        rollout: its bands have d + r in the middle of the hands'; those given to `iterate` are the task's.
        error: (N,) d_d - d_a, m.
        rms: of the error, m, and `settled_rms` of its part from `settled` on.
    """

    reference: np.ndarray
    rollout: Rollout
    error: np.ndarray
    rms: float
    settled_rms: float


def iterate(
    skill: Skill,
    bands: Bands,
    *,
    epochs: int,
    time_step: float,
    duration: float | None = None,
    gains: GamsGains = GamsGains(c_2=0.0),
    q: float = 0.99,
    learning_gain: float = 1.0,
    settled: float = 1.0,
    progress: Callable[[float], None] = lambda share: None,
) -> list[Epoch]:
    """Run the skill `epochs` times; the first has no reference: feedback alone.

    Args:
        bands: `bands.hands` gives d_d.
        time_step: of the rollout and of the learning, s; duration: s, the skill's by default.
        gains: of `skill.laws.gams`; without c_2, with which the error at the start fades slowly and misleads learning.
        q, learning_gain: Q and L, one each.
        settled: what is later than this counts in `settled_rms`, s.

    Raises:
        SkillError: the learning diverges.
    """
    result: list[Epoch] = []
    n = round((skill.tau if duration is None else duration) / time_step) + 1
    t = time_step * np.arange(n)
    desired, late = bands.desired(t)[0][:, HANDS], t >= settled
    reference = np.zeros(n)
    for epoch in range(epochs):
        led = replace(bands, hands=SampledDistance(bands.hands, t, reference))
        rollout = roll_out(skill, time_step=time_step, duration=t[-1], bands=led, law=gams, gains=gains)
        error = desired - rollout.lengths[:, HANDS]
        rms, settled_rms = (float(np.sqrt(np.mean(e**2))) for e in (error, error[late]))
        result.append(Epoch(reference, rollout, error, rms, settled_rms))
        reference = updated(reference, error, q, learning_gain)
        progress((epoch + 1) / epochs)
    return result


def updated(reference, error, q: float = 0.99, learning_gain: float = 1.0):
    """R after an epoch: Q (r(j) + L e(j + 1)), both (N,), m; the last sample takes its own error."""
    return q * (reference + learning_gain * np.append(error[1:], error[-1]))
