"""The forcing term f(s) = theta^T Psi(s) as a Drake system."""

import numpy as np
from pydrake.systems.framework import LeafSystem_
from pydrake.systems.scalar_conversion import TemplateSystem

from drake_blfdmp.skill.canonical import phase_at
from drake_blfdmp.skill.skill import Skill


@TemplateSystem.define("ForcingTerm_")
def ForcingTerm_(T):
    """Define the system for scalar type T."""

    class Impl(LeafSystem_[T]):
        r"""The learned forcing of all six points, below (1).

        .. pydrake_system::

            name: ForcingTerm
            input_ports:
            - phase
            output_ports:
            - forcing

        No state. `forcing` (18) is ordered point by point as in `skeleton.POINTS`, x y z each.
        Template parameters: float, AutoDiffXd, Expression.
        """

        def _construct(self, *, skill: Skill, time_step=0.0, converter=None):
            """Build the system.

            Args:
                skill: weights and basis.
                time_step: s. When positive, the output is held over a step by the discrete TransformationSystem, so
                    it is evaluated at the phase of the step's middle, which makes the pair second-order accurate.
            """
            LeafSystem_[T].__init__(self, converter=converter)
            self._parameters = {"skill": skill, "time_step": time_step}
            self._skill = skill
            self._advance = float(phase_at(0.5 * time_step, skill.tau, skill.gamma))
            self._phase = self.DeclareVectorInputPort("phase", 1)
            self._forcing = self.DeclareVectorOutputPort("forcing", 18, self._calc_forcing)

        def _construct_copy(self, other, converter=None):
            Impl._construct(self, **other._parameters, converter=converter)

        def _calc_forcing(self, context, output):
            s = self._phase.Eval(context)[0] * self._advance
            output.SetFromVector(self._skill.forcing(np.asarray(s)))

    return Impl


ForcingTerm = ForcingTerm_[None]
