"""The skill's own clock beside its phase, as a Drake system."""

import numpy as np
from pydrake.systems.framework import LeafSystem

from drake_blfdmp.skill.canonical import DEFAULT_GAMMA, time_at


class SkillClock(LeafSystem):
    """The time that the phase tells: the simulation's where nothing slows the skill, behind it else.

    .. pydrake_system::

        name: SkillClock
        input_ports:
        - phase
        output_ports:
        - clock

    No state. `phase` (1) as from CanonicalSystem; `clock` (1), s.
    """

    def __init__(self, *, tau: float, gamma: float = DEFAULT_GAMMA):
        """Of a canonical system's tau (s) and gamma."""
        super().__init__()
        self._tau, self._gamma = tau, gamma
        self._phase = self.DeclareVectorInputPort("phase", 1)
        self.DeclareVectorOutputPort("clock", 1, self._calc)

    def _calc(self, context, output):
        output.SetFromVector(time_at(np.asarray(self._phase.Eval(context)), self._tau, self._gamma))
