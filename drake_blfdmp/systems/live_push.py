"""A push that someone gives while the simulation runs."""

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.multibody.plant import ExternallyAppliedSpatialForce
from pydrake.multibody.tree import RigidBody
from pydrake.systems.framework import LeafSystem

from drake_blfdmp.systems.timed_push import ForceAtOrigin


class LivePush(LeafSystem):
    """A force at a body's origin until a time, both by an input.

    .. pydrake_system::

        name: LivePush
        input_ports:
        - push (optional)
        output_ports:
        - spatial_forces

    No state. `push` (4): a force in W, N, and the time up to which it acts, s; nothing acts when it is not connected.
    `spatial_forces` is abstract, a list of one or no `ExternallyAppliedSpatialForce`, for the plant's
    `applied_spatial_force`.
    """

    def __init__(self, *, body: RigidBody):
        """Build the system for a body of the plant that receives the force."""
        super().__init__()
        self._body = body
        self._push = self.DeclareVectorInputPort("push", 4)
        self.DeclareAbstractOutputPort(
            "spatial_forces",
            lambda: AbstractValue.Make([ExternallyAppliedSpatialForce()]),
            self._calc_spatial_forces,
            {self.time_ticket(), self._push.ticket()},
        )

    def _calc_spatial_forces(self, context, output):
        push = np.asarray(self._push.Eval(context)) if self._push.HasValue(context) else np.zeros(4)
        acts = context.get_time() < push[3]
        output.set_value([ForceAtOrigin(self._body, push[:3])] if acts else [])
