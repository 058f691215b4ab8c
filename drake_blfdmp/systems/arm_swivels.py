"""The swivel angles that both arms have, as a Drake system."""

from collections.abc import Sequence

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import ModelInstanceIndex
from pydrake.systems.framework import LeafSystem

from drake_blfdmp.robot.swivel import swivel_angle


class ArmSwivels(LeafSystem):
    """Swivel angle of each arm as it stands (`robot.swivel`).

    .. pydrake_system::

        name: ArmSwivels
        input_ports:
        - body_poses
        output_ports:
        - swivel

    No state. `body_poses` is the plant's abstract port; `swivel` (2) left, right, rad.
    """

    def __init__(self, *, plant: MultibodyPlant, arms: Sequence[ModelInstanceIndex]):
        """Of two model instances of a finalized plant, left and right."""
        super().__init__()
        names = ("shoulder", "elbow", "wrist")
        frames = [[plant.GetFrameByName(name, arm) for arm in arms] for name in names]
        self._bodies = [[int(frame.body().index()) for frame in row] for row in frames]
        self._places = [[frame.GetFixedPoseInBodyFrame().translation() for frame in row] for row in frames]
        self._poses = self.DeclareAbstractInputPort("body_poses", AbstractValue.Make([RigidTransform()]))
        self.DeclareVectorOutputPort("swivel", len(arms), self._calc)

    def _calc(self, context, output):
        poses = self._poses.Eval(context)
        points = [
            np.array([poses[body].multiply(p_BF) for body, p_BF in zip(bodies, places, strict=True)])
            for bodies, places in zip(self._bodies, self._places, strict=True)
        ]
        output.SetFromVector(swivel_angle(*points))
