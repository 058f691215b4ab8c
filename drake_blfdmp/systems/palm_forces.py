"""How hard each palm presses on the box, as a Drake system."""

from collections.abc import Sequence

from pydrake.common.value import AbstractValue
from pydrake.multibody.plant import ContactResults
from pydrake.multibody.tree import RigidBody
from pydrake.systems.framework import LeafSystem

from drake_blfdmp.robot.contact import palm_forces


class PalmForces(LeafSystem):
    """Normal force of each palm on the box (`robot.contact.palm_forces`).

    .. pydrake_system::

        name: PalmForces
        input_ports:
        - contact_results
        output_ports:
        - palm_force

    No state. `contact_results` is the plant's abstract port; `palm_force` (2) left, right, N.
    """

    def __init__(self, *, palms: Sequence[RigidBody], box: RigidBody):
        super().__init__()
        self._palms, self._box = palms, box
        self._results = self.DeclareAbstractInputPort("contact_results", AbstractValue.Make(ContactResults()))
        self.DeclareVectorOutputPort("palm_force", len(palms), self._calc_force)

    def _calc_force(self, context, output):
        output.SetFromVector(palm_forces(self._results.Eval(context), self._palms, self._box))
