"""How many of a plan's times have passed, as a Drake system."""

from collections.abc import Sequence

import numpy as np
from pydrake.systems.framework import LeafSystem


class PassedTimes(LeafSystem):
    """Counts the times that lie behind the skill's clock, so that each can be told when it comes.

    .. pydrake_system::

        name: PassedTimes
        input_ports:
        - clock
        output_ports:
        - number

    No state. `clock` (1) as from SkillClock; `number` (1) counts the times, s, that it has reached.
    """

    def __init__(self, *, times: Sequence[float]):
        super().__init__()
        self._times = np.sort(np.asarray(times, dtype=float))
        self._clock = self.DeclareVectorInputPort("clock", 1)
        self.DeclareVectorOutputPort("number", 1, self._calc)

    def _calc(self, context, output):
        clock = np.asarray(self._clock.Eval(context))[0]
        # The clock is a logarithm: a time it stands at may come out a little later.
        output.SetFromVector([np.searchsorted(self._times, clock + 1e-9, side="right")])
