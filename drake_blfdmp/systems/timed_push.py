"""A push: a force on a body for a while, for trying what a motion endures."""

from collections.abc import Sequence

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.multibody.math import SpatialForce
from pydrake.multibody.plant import ExternallyAppliedSpatialForce
from pydrake.multibody.tree import RigidBody
from pydrake.systems.framework import LeafSystem


def ForceAtOrigin(body: RigidBody, force: Sequence[float] | np.ndarray) -> ExternallyAppliedSpatialForce:
    """A force (3,) in W, N, that acts at a body's origin, for the plant's `applied_spatial_force`."""
    push = ExternallyAppliedSpatialForce()
    push.body_index = body.index()
    push.p_BoBq_B = np.zeros(3)
    push.F_Bq_W = SpatialForce(tau=np.zeros(3), f=np.array(force, dtype=float))
    return push


class TimedPush(LeafSystem):
    """A constant force at a body's origin from one time to another, nothing before and after.

    .. pydrake_system::

        name: TimedPush
        input_ports:
        output_ports:
        - spatial_forces

    No state. `spatial_forces` is abstract, a list of one or no `ExternallyAppliedSpatialForce`, for the plant's
    `applied_spatial_force`.
    """

    def __init__(self, *, body: RigidBody, force: Sequence[float] | np.ndarray, start_s: float, duration_s: float):
        """Build the system.

        Args:
            body: of the plant that receives the force.
            force: (3,) in W, N.
            start_s: when it begins, s.
            duration_s: how long it lasts, s.
        """
        super().__init__()
        self._push, self._start, self._end = ForceAtOrigin(body, force), start_s, start_s + duration_s
        self.DeclareAbstractOutputPort(
            "spatial_forces",
            lambda: AbstractValue.Make([ExternallyAppliedSpatialForce()]),
            self._calc_spatial_forces,
            {self.time_ticket()},
        )

    def _calc_spatial_forces(self, context, output):
        output.set_value([self._push] if self._start <= context.get_time() < self._end else [])
