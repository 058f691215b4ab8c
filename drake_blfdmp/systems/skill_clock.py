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

    No state. `phase` (1) as from CanonicalSystem; `clock` (2): that phase, no unit, and its time, s.
    """

    def __init__(self, *, tau: float, gamma: float = DEFAULT_GAMMA):
        """Of a canonical system's tau (s) and gamma."""
        super().__init__()
        self._tau, self._gamma = tau, gamma
        self._phase = self.DeclareVectorInputPort("phase", 1)
        self.DeclareVectorOutputPort("clock", 2, self._calc)

    def _calc(self, context, output):
        phase = np.asarray(self._phase.Eval(context))[0]
        output.SetFromVector([phase, time_at(phase, self._tau, self._gamma)])
