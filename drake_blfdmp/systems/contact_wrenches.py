"""What contact does to bodies, as wrenches, as a Drake system."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.math import RigidTransform
from pydrake.multibody.plant import ContactResults
from pydrake.systems.framework import LeafSystem, ValueProducer

from drake_blfdmp.robot.contact_wrenches import ContactPair, bodies_of_geometries, point_forces, wrench_on


class ContactWrenches(LeafSystem):
    """Forces and torques of contact on bodies, each in the body's frame at its origin (`robot.contact_wrenches`).

    .. pydrake_system::

        name: ContactWrenches
        input_ports:
        - contact_results
        - body_poses
        output_ports:
        - <name of a pair>

    No state. `contact_results` and `body_poses` are the plant's abstract ports. Each output (6), in the order of
    `pairs`: torque (N m), then force (N), as in Drake's SpatialForce.
    """

    def __init__(self, *, pairs: Mapping[str, ContactPair]):
        """Of each named pair, what the other bodies do to the body; all of one plant."""
        super().__init__()
        self._results = self.DeclareAbstractInputPort("contact_results", AbstractValue.Make(ContactResults()))
        self._poses = self.DeclareAbstractInputPort("body_poses", AbstractValue.Make([RigidTransform()]))
        self._bodies = bodies_of_geometries(list(pairs.values()))
        self._pairs = [
            (int(pair.body.index()), frozenset(int(other.index()) for other in pair.others)) for pair in pairs.values()
        ]
        # One pass over the contacts serves all outputs.
        producer = ValueProducer(allocate=lambda: AbstractValue.Make(np.zeros((len(pairs), 6))), calc=self._calc)
        self._wrenches = self.DeclareCacheEntry(
            description="wrenches", value_producer=producer, prerequisites_of_calc={self.all_input_ports_ticket()}
        )
        for k, name in enumerate(pairs):
            self.DeclareVectorOutputPort(
                name,
                6,
                lambda context, output, k=k: output.SetFromVector(self._evaluated(context)[k]),
                {self._wrenches.ticket()},
            )

    def _evaluated(self, context) -> np.ndarray:
        wrenches: Any = self._wrenches.Eval(context)
        return wrenches

    def _calc(self, context, value):
        forces = point_forces(self._results.Eval(context), self._bodies)
        poses: Any = self._poses.Eval(context)
        value.set_value(np.array([wrench_on(forces, body, others, poses[body]) for body, others in self._pairs]))
