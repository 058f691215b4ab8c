"""Systems and skills that work until they give something that is not a number."""

import numpy as np
from pydrake.systems.framework import LeafSystem

from drake_blfdmp.skill.canonical import phase_at
from drake_blfdmp.skill.skill import Skill


class Breaking(LeafSystem):
    """Gives `value` (size,) until `at` s, from then on `broken` in its last element."""

    def __init__(self, size, at=0.1, value=0.0, broken=np.nan):
        super().__init__()
        self._value, self._at, self._broken = np.full(size, float(value)), at, broken
        self.DeclareVectorOutputPort("value", size, self._calc, {self.time_ticket()})

    def _calc(self, context, output):
        value = self._value.copy()
        if context.get_time() > self._at - 1e-9:
            value[-1] = self._broken
        output.SetFromVector(value)


class Growing(LeafSystem):
    """A discrete state that is multiplied by itself: infinite in the end, with nothing wrong before."""

    def __init__(self, period=0.01):
        super().__init__()
        state = self.DeclareDiscreteState([10.0])
        self.DeclareStateOutputPort("state", state)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def _update(self, context, discrete_state):
        with np.errstate(over="ignore"):
            discrete_state.get_mutable_vector().SetFromVector(context.get_discrete_state_vector().value() ** 2)


class BreakingSkill(Skill):
    """A skill whose forcing is not a number from 0.1 s on."""

    def forcing(self, s, weights=None):
        f = super().forcing(s, weights)
        if np.asarray(s).dtype == object:  # Drake tries the symbolic form.
            return f
        return np.where(np.asarray(s) > phase_at(0.1, self.tau, self.gamma) + 1e-9, f, np.nan)

    @staticmethod
    def of(skill):
        """A breaking copy."""
        return BreakingSkill(**vars(skill))
