"""The transformation system (1), (6) of all six points as a Drake system."""

import numpy as np
from pydrake.symbolic import Expression
from pydrake.systems.framework import BasicVector_, LeafSystem_
from pydrake.systems.scalar_conversion import TemplateSystem

from drake_blfdmp.skill.skill import Skill
from drake_blfdmp.skill.transformation import mean_acceleration, nominal_acceleration, step, step_matrices


@TemplateSystem.define("TransformationSystem_")
def TransformationSystem_(T):
    """Define the system for scalar type T."""

    class Impl(LeafSystem_[T]):
        r"""Springs and dampers that pull the six points to their goals, pushed by forcing and coupling; (1), (6).

        .. pydrake_system::

            name: TransformationSystem
            input_ports:
            - forcing
            - goal
            - coupling_acceleration (optional)
            - tempo (optional)
            output_ports:
            - position
            - velocity
            - nominal_acceleration

        Every port but `tempo` has 18 elements, point by point as in `skeleton.POINTS`, x y z each, in m, m/s and
        m/s^2. The state is (position, velocity), velocity being x' = v / tau. `nominal_acceleration` is x'' without the
        coupling, its mean over the coming step for a discrete state; it does not depend on the coupling input, so a
        coupling computed from the outputs closes no algebraic loop.

        `tempo` (1), >= 0, no unit, is how fast the skill's clock runs: theta' = tempo, 1 when not connected. Every rate
        here, and in all systems of the skill, is one of that clock. So a slower tempo changes when a point is passed
        and not which, and what the law proves of the skill's clock it proves of any tempo; the velocity in the world
        is `tempo` times `velocity`.
        Template parameters: float, AutoDiffXd, Expression.
        """

        def _construct(self, *, skill: Skill, time_step=0.0, converter=None):
            """Build the system; it starts at rest at the skill's start.

            Args:
                skill: gains, time scale and start.
                time_step: 0 for a continuous state, otherwise the period of the discrete one, s; the discrete update
                    is the exact solution for inputs held over the step.
            """
            LeafSystem_[T].__init__(self, converter=converter)
            self._parameters = {"skill": skill, "time_step": time_step}
            self._tau, self._gains, self._time_step = skill.tau, (skill.alpha_z, skill.beta_z), time_step
            self._forcing = self.DeclareVectorInputPort("forcing", 18)
            self._goal = self.DeclareVectorInputPort("goal", 18)
            self._coupling = self.DeclareVectorInputPort("coupling_acceleration", 18)
            self._tempo = self.DeclareVectorInputPort("tempo", 1)
            start = skill.start.reshape(18)
            if time_step > 0:
                self._full_step = step_matrices(time_step, skill.tau, skill.alpha_z, skill.beta_z), time_step
                x = self.DeclareDiscreteState(start)
                v = self.DeclareDiscreteState(np.zeros(18))
                self.DeclarePeriodicDiscreteUpdateEvent(time_step, 0.0, self._update)
                self._position = self.DeclareStateOutputPort("position", x)
                self._velocity = self.DeclareStateOutputPort("velocity", v)
            else:
                state = [T(value) for value in (*start, *np.zeros(18))]
                self.DeclareContinuousState(BasicVector_[T](state), 18, 18, 0)
                ticket = {self.all_state_ticket()}
                self._position = self.DeclareVectorOutputPort("position", 18, self._calc_position, ticket)
                self._velocity = self.DeclareVectorOutputPort("velocity", 18, self._calc_velocity, ticket)
            self._nominal = self.DeclareVectorOutputPort(
                "nominal_acceleration",
                18,
                self._calc_nominal_acceleration,
                {self.all_state_ticket(), self._forcing.ticket(), self._goal.ticket(), self._tempo.ticket()},
            )

        def _construct_copy(self, other, converter=None):
            Impl._construct(self, **other._parameters, converter=converter)

        def _state(self, context):
            if self._time_step > 0:
                return tuple(context.get_discrete_state(i).CopyToVector() for i in range(2))
            state = context.get_continuous_state_vector().CopyToVector()
            return state[:18], state[18:]

        def _coupling_or_zero(self, context):
            return self._coupling.Eval(context) if self._coupling.HasValue(context) else 0.0

        def _step(self, context):
            """The matrices of the coming step and its length on the skill's clock, s."""
            if not self._tempo.HasValue(context):
                return self._full_step
            tempo = self._tempo.Eval(context)[0]
            if T is not Expression and tempo == 1.0:
                return self._full_step
            length = tempo * self._time_step
            return step_matrices(length, self._tau, *self._gains), length

        def _calc_position(self, context, output):
            output.SetFromVector(self._state(context)[0])

        def _calc_velocity(self, context, output):
            output.SetFromVector(self._state(context)[1])

        def _nominal_acceleration(self, context, x, velocity):
            arguments = (x, self._tau * velocity, self._forcing.Eval(context), self._goal.Eval(context), self._tau)
            if self._time_step > 0:
                matrices, length = self._step(context)
                if T is Expression or length > 0.0:
                    return mean_acceleration(*arguments, matrices, length)
            return nominal_acceleration(*arguments, *self._gains)

        def _calc_nominal_acceleration(self, context, output):
            output.SetFromVector(self._nominal_acceleration(context, *self._state(context)))

        def _update(self, context, discrete_state):
            x, velocity = self._state(context)
            matrices, length = self._step(context)
            x, v = step(
                x,
                self._tau * velocity,
                self._forcing.Eval(context),
                self._goal.Eval(context),
                self._coupling_or_zero(context),
                self._tau,
                matrices,
                length,
            )
            discrete_state.get_mutable_vector(0).SetFromVector(x)
            discrete_state.get_mutable_vector(1).SetFromVector(v / self._tau)

        def DoCalcTimeDerivatives(self, context, derivatives):
            if self._time_step > 0:
                return
            x, velocity = self._state(context)
            acceleration = self._nominal_acceleration(context, x, velocity) + self._coupling_or_zero(context)
            tempo = self._tempo.Eval(context)[0] if self._tempo.HasValue(context) else 1.0
            derivatives.get_mutable_vector().SetFromVector(tempo * np.concatenate([velocity, acceleration]))

    return Impl


TransformationSystem = TransformationSystem_[None]
