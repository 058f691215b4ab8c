"""The canonical system (2) as a Drake system."""

import numpy as np
from pydrake.systems.framework import BasicVector_, LeafSystem_
from pydrake.systems.scalar_conversion import TemplateSystem

from drake_blfdmp.skill.canonical import DEFAULT_GAMMA, phase_rate


@TemplateSystem.define("CanonicalSystem_")
def CanonicalSystem_(T):
    """Define the system for scalar type T."""

    class Impl(LeafSystem_[T]):
        r"""The phase of a movement, tau s' = -gamma s tempo, s(0) = 1; equation (2).

        .. pydrake_system::

            name: CanonicalSystem
            input_ports:
            - tempo (optional)
            output_ports:
            - phase

        The state is s. `tempo` (1, no unit) slows (< 1) or stops (0) the movement; 1 when not connected.
        Template parameters: float, AutoDiffXd, Expression.
        """

        def _construct(self, *, tau, gamma=DEFAULT_GAMMA, time_step=0.0, converter=None):
            """Build the system.

            Args:
                tau: time scale, s.
                gamma: decay; s(tau) = exp(-gamma).
                time_step: 0 for a continuous state, otherwise the period of the discrete one, s; the discrete update
                    is exact for a tempo held over the step.
            """
            LeafSystem_[T].__init__(self, converter=converter)
            self._parameters = {"tau": tau, "gamma": gamma, "time_step": time_step}
            self._tau, self._gamma, self._time_step = tau, gamma, time_step
            self._tempo = self.DeclareVectorInputPort("tempo", 1)
            if time_step > 0:
                state = self.DeclareDiscreteState([1.0])
                self.DeclarePeriodicDiscreteUpdateEvent(time_step, 0.0, self._update)
            else:
                state = self.DeclareContinuousState(BasicVector_[T]([T(1.0)]))
            self._phase = self.DeclareStateOutputPort("phase", state)

        def _construct_copy(self, other, converter=None):
            Impl._construct(self, **other._parameters, converter=converter)

        def _tempo_or_one(self, context):
            return self._tempo.Eval(context)[0] if self._tempo.HasValue(context) else 1.0

        def _update(self, context, discrete_state):
            s = context.get_discrete_state_vector().CopyToVector()
            decay = np.exp(-self._gamma * self._time_step / self._tau * self._tempo_or_one(context))
            discrete_state.get_mutable_vector().SetFromVector(s * decay)

        def DoCalcTimeDerivatives(self, context, derivatives):
            if self._time_step > 0:
                return
            s = context.get_continuous_state_vector().CopyToVector()
            rate = phase_rate(s, self._tau, self._gamma) * self._tempo_or_one(context)
            derivatives.get_mutable_vector().SetFromVector(rate)

    return Impl


CanonicalSystem = CanonicalSystem_[None]
