"""Where a plan has a body by the skill's clock, as a Drake system."""

import numpy as np
from pydrake.systems.framework import LeafSystem


class PlannedPose(LeafSystem):
    """A pose looked up by a clock.

    .. pydrake_system::

        name: PlannedPose
        input_ports:
        - clock
        output_ports:
        - pose

    No state. `clock` (1) as from SkillClock; `pose` (7) is X_WB as qw qx qy qz x y z, that of the nearest time.
    """

    def __init__(self, *, t: np.ndarray, poses: np.ndarray):
        """Of growing times (N,), s, and the poses (N, 7) then."""
        super().__init__()
        self._poses = poses
        self._middles = (t[1:] + t[:-1]) / 2
        self._clock = self.DeclareVectorInputPort("clock", 1)
        self.DeclareVectorOutputPort("pose", 7, self._calc)

    def _calc(self, context, output):
        nearest = np.searchsorted(self._middles, np.asarray(self._clock.Eval(context))[0])
        output.SetFromVector(self._poses[nearest])
