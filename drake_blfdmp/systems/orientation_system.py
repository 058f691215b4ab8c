"""The movement primitive of an orientation (`skill.orientation`) as a Drake system."""

import numpy as np
from pydrake.systems.framework import BasicVector, LeafSystem

from drake_blfdmp.errors import SkillError
from drake_blfdmp.quaternions import multiply, normalised
from drake_blfdmp.skill.canonical import phase_at
from drake_blfdmp.skill.orientation import angular_acceleration, orientation_step
from drake_blfdmp.skill.skill import Skill
from drake_blfdmp.skill.transformation import step_matrices


class OrientationSystem(LeafSystem):
    """How what the hands hold turns, in the frame of the line between the hands; pulled to its goal, pushed by forcing.

    .. pydrake_system::

        name: OrientationSystem
        input_ports:
        - phase
        - goal_orientation
        - tempo (optional)
        output_ports:
        - orientation
        - angular_velocity

    `orientation` and `goal_orientation` (4) are unit quaternions w x y z, of either sign; `angular_velocity` (3) is in
    rad per second of the skill's clock. `tempo` (1, no unit) slows (< 1) or stops (0) that clock; 1 when not connected.
    The state is (orientation, angular velocity); no output is direct-feedthrough. The goal may move: it pulls by the
    shortest way. Float alone: the sign of a quaternion is a choice that neither gradient nor symbol survives.
    """

    def __init__(self, *, skill: Skill, time_step: float = 0.0):
        """Build the system; it starts at rest at the skill's start.

        Args:
            skill: that has an orientation.
            time_step: 0 for a continuous state, otherwise the period of the discrete one, s; the discrete update is the
                exact solution for inputs held over the step, with the forcing of the step's middle.

        Raises:
            SkillError: the skill has no orientation.
        """
        super().__init__()
        if skill.orientation is None:
            raise SkillError("OrientationSystem: the skill has no orientation; learn it from a recording with some")
        self._skill, self._orientation, self._time_step = skill, skill.orientation, time_step
        self._phase = self.DeclareVectorInputPort("phase", 1)
        self._goal = self.DeclareVectorInputPort("goal_orientation", 4)
        self._tempo = self.DeclareVectorInputPort("tempo", 1)
        start = np.asarray(skill.orientation.start, dtype=float)
        if time_step > 0:
            self._matrices = (1.0, step_matrices(time_step, skill.tau, skill.alpha_z, skill.beta_z))
            q = self.DeclareDiscreteState(start)
            omega = self.DeclareDiscreteState(np.zeros(3))
            self.DeclarePeriodicDiscreteUpdateEvent(time_step, 0.0, self._update)
            self.DeclareStateOutputPort("orientation", q)
            self.DeclareStateOutputPort("angular_velocity", omega)
        else:
            self.DeclareContinuousState(BasicVector([*start, 0.0, 0.0, 0.0]))
            ticket = {self.all_state_ticket()}
            self.DeclareVectorOutputPort("orientation", 4, self._calc_orientation, ticket)
            self.DeclareVectorOutputPort("angular_velocity", 3, self._calc_angular_velocity, ticket)

    def _state(self, context):
        state = context.get_continuous_state_vector().CopyToVector()
        # An integrator leaves the unit sphere by its own error; the rotation that is meant does not.
        return normalised(state[:4]), state[4:]

    def _calc_orientation(self, context, output):
        output.SetFromVector(self._state(context)[0])

    def _calc_angular_velocity(self, context, output):
        output.SetFromVector(self._state(context)[1])

    def _inputs(self, context, ahead: float):
        """Forcing at the phase `ahead`, s, of now, the goal, and the tempo."""
        tempo = np.asarray(self._tempo.Eval(context))[0] if self._tempo.HasValue(context) else 1.0
        skill = self._skill
        s = np.asarray(self._phase.Eval(context))[0] * phase_at(tempo * ahead, skill.tau, skill.gamma)
        f = self._orientation.forcing(s, skill.centers, skill.widths)
        return f, normalised(self._goal.Eval(context)), tempo

    def _update(self, context, discrete_state):
        skill = self._skill
        f, goal, tempo = self._inputs(context, 0.5 * self._time_step)
        if tempo != self._matrices[0]:
            dt = tempo * self._time_step
            self._matrices = (tempo, step_matrices(dt, skill.tau, skill.alpha_z, skill.beta_z))
        q, omega = (context.get_discrete_state(i).CopyToVector() for i in range(2))
        q, omega = orientation_step(q, omega, f, goal, skill.tau, self._matrices[1])
        discrete_state.get_mutable_vector(0).SetFromVector(q)
        discrete_state.get_mutable_vector(1).SetFromVector(omega)

    def DoCalcTimeDerivatives(self, context, derivatives):
        if self._time_step > 0:
            return
        skill = self._skill
        q, omega = self._state(context)
        f, goal, tempo = self._inputs(context, 0.0)
        q_dot = 0.5 * multiply(np.append(0.0, omega), q)
        omega_dot = angular_acceleration(q, omega, f, goal, skill.tau, skill.alpha_z, skill.beta_z)
        derivatives.get_mutable_vector().SetFromVector(tempo * np.concatenate([q_dot, omega_dot]))
