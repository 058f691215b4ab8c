"""The forcing term f(s) = theta^T Psi(s) as a Drake system."""

import numpy as np
from pydrake.systems.framework import BasicVector_, LeafSystem_
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
            - tempo (optional)
            output_ports:
            - forcing

        No state. `forcing` (18) is ordered point by point as in `skeleton.POINTS`, x y z each. `tempo` (1) as for
        TransformationSystem: how far the phase comes in the coming step. Numeric parameter 0 is the weights (n, 18), by
        row, the skill's by default: a context can carry others, and derivatives with respect to them.
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
            self._half_step = 0.5 * time_step
            self._phase = self.DeclareVectorInputPort("phase", 1)
            self._tempo = self.DeclareVectorInputPort("tempo", 1)
            weights = [T(value) for value in skill.weights.reshape(-1)]
            self._weights = self.DeclareNumericParameter(BasicVector_[T](weights))
            self._forcing = self.DeclareVectorOutputPort(
                "forcing",
                18,
                self._calc_forcing,
                {self._phase.ticket(), self._tempo.ticket(), self.all_parameters_ticket()},
            )

        def _construct_copy(self, other, converter=None):
            Impl._construct(self, **other._parameters, converter=converter)

        def _calc_forcing(self, context, output):
            tempo = self._tempo.Eval(context)[0] if self._tempo.HasValue(context) else 1.0
            s = self._phase.Eval(context)[0] * phase_at(self._half_step * tempo, self._skill.tau, self._skill.gamma)
            weights = context.get_numeric_parameter(self._weights).CopyToVector().reshape(-1, 18)
            output.SetFromVector(self._skill.forcing(np.asarray(s), weights))

    return Impl


ForcingTerm = ForcingTerm_[None]
