"""What contact does to bodies, as wrenches, as a Drake system."""

from collections.abc import Sequence

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.multibody.plant import ContactResults
from pydrake.systems.framework import LeafSystem

from drake_blfdmp.robot.contact_wrenches import ContactPair, bodies_of_geometries, contact_forces, wrench_on


class ContactWrenches(LeafSystem):
    """Forces and torques of contact on bodies, in W about its origin (`robot.contact_wrenches`).

    .. pydrake_system::

        name: ContactWrenches
        input_ports:
        - contact_results
        output_ports:
        - wrenches

    No state. `contact_results` is the plant's abstract port. `wrenches` (6 K), of each of K pairs in their order:
    torque (N m), then force (N), as in Drake's SpatialForce, expressed in W, the force applied at W's origin.
    `robot.contact_wrenches.wrench_in_body` gives each in its body's frame.
    """

    def __init__(self, *, pairs: Sequence[ContactPair]):
        """Of each pair, what the other bodies do to the body; all of one plant."""
        super().__init__()
        self._results = self.DeclareAbstractInputPort("contact_results", AbstractValue.Make(ContactResults()))
        self._bodies = bodies_of_geometries(pairs)
        self._pairs = [
            (int(pair.body.index()), frozenset(int(other.index()) for other in pair.others)) for pair in pairs
        ]
        self.DeclareVectorOutputPort("wrenches", 6 * len(pairs), self._calc)

    def _calc(self, context, output):
        forces = contact_forces(self._results.Eval(context), self._bodies)
        output.SetFromVector(np.concatenate([wrench_on(forces, body, others) for body, others in self._pairs]))
