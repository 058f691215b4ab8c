"""The swivel angles that both arms have, as a Drake system."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import Frame, ModelInstanceIndex
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
        context = plant.CreateDefaultContext()
        # The first two axes meet there whatever the joints' angles.
        self._shoulders = np.array(
            [plant.GetFrameByName("shoulder", arm).CalcPoseInWorld(context).translation() for arm in arms]
        )
        frames = [plant.GetFrameByName(name, arm) for name in ("elbow", "wrist") for arm in arms]
        self._frames = [(int(frame.body().index()), _place(frame)) for frame in frames]
        self._poses = self.DeclareAbstractInputPort("body_poses", AbstractValue.Make([RigidTransform()]))
        self.DeclareVectorOutputPort("swivel", len(arms), self._calc)

    def _calc(self, context, output):
        poses: Any = self._poses.Eval(context)
        points = np.array(
            [
                poses[body].translation() if place is None else poses[body].multiply(place)
                for body, place in self._frames
            ]
        )
        arms = len(self._shoulders)
        output.SetFromVector(swivel_angle(self._shoulders, points[:arms], points[arms:]))


def _place(frame: Frame) -> np.ndarray | None:
    """Where a frame's origin stands on its body, m; None at the body's own."""
    place = np.asarray(frame.GetFixedPoseInBodyFrame().translation())
    return place if place.any() else None
