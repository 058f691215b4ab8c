"""What contact does to bodies, as wrenches, as a Drake system."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.math import RigidTransform
from pydrake.multibody.plant import ContactResults
from pydrake.systems.framework import LeafSystem

from drake_blfdmp.robot.contact_wrenches import ContactPair, bodies_of_geometries, point_forces, wrench_on


class ContactWrenches(LeafSystem):
    """Forces and torques of contact on bodies, each in the body's frame at its origin (`robot.contact_wrenches`).

    .. pydrake_system::

        name: ContactWrenches
        input_ports:
        - contact_results
        - body_poses
        output_ports:
        - wrenches

    No state. `contact_results` and `body_poses` are the plant's abstract ports. `wrenches` (6 K), of each of K pairs in
    their order: torque (N m), then force (N), as in Drake's SpatialForce.
    """

    def __init__(self, *, pairs: Sequence[ContactPair]):
        """Of each pair, what the other bodies do to the body; all of one plant."""
        super().__init__()
        self._results = self.DeclareAbstractInputPort("contact_results", AbstractValue.Make(ContactResults()))
        self._poses = self.DeclareAbstractInputPort("body_poses", AbstractValue.Make([RigidTransform()]))
        self._bodies = bodies_of_geometries(pairs)
        self._pairs = [
            (int(pair.body.index()), frozenset(int(other.index()) for other in pair.others)) for pair in pairs
        ]
        self.DeclareVectorOutputPort("wrenches", 6 * len(pairs), self._calc)

    def _calc(self, context, output):
        forces = point_forces(self._results.Eval(context), self._bodies)
        poses: Any = self._poses.Eval(context)
        wrenches = [wrench_on(forces, body, others, poses[body]) for body, others in self._pairs]
        output.SetFromVector(np.concatenate(wrenches))
