"""Where a plan has a body by the skill's clock, as a Drake system."""

import numpy as np
from pydrake.systems.framework import LeafSystem

from drake_blfdmp.quaternions import interpolated_poses


class PlannedPose(LeafSystem):
    """A pose looked up by a clock.

    .. pydrake_system::

        name: PlannedPose
        input_ports:
        - clock
        output_ports:
        - pose

    No state. `clock` (2) as from SkillClock; `pose` (7) is X_WB as qw qx qy qz x y z.
    """

    def __init__(self, *, t: np.ndarray, poses: np.ndarray):
        """Of growing times (N,), s, and the poses (N, 7) then."""
        super().__init__()
        self._t, self._poses = t, poses
        self._clock = self.DeclareVectorInputPort("clock", 2)
        self.DeclareVectorOutputPort("pose", 7, self._calc)

    def _calc(self, context, output):
        clock = np.asarray(self._clock.Eval(context))[1:]
        output.SetFromVector(interpolated_poses(self._t, self._poses, clock)[0])
