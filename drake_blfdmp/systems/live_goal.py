"""A goal that someone moves while the skill runs."""

import numpy as np
from pydrake.systems.framework import LeafSystem

from drake_blfdmp.errors import ScenarioError
from drake_blfdmp.skill.canonical import DEFAULT_GAMMA, time_at
from drake_blfdmp.vectors import towards


class LiveGoal(LeafSystem):
    """The planned goal, moved towards where it is wanted, no faster than a rate, and only within a window of times.

    .. pydrake_system::

        name: LiveGoal
        input_ports:
        - planned_goal
        - phase
        - wanted_offset (optional)
        output_ports:
        - goal
        - offset

    Discrete state: the offset (3), m in W. `wanted_offset` (3), m in W, is where it shall go, 0 when not connected.
    `planned_goal` (18) and `goal` (18) are in the person's torso frame, m, whose axes are W's: `goal` is the planned
    one with all six points moved by the offset over the retargeting's scale, so no link's length changes. A changed
    goal moves the points at once and not only at the end (the transformation system is a spring to it), so the window
    is for the times when that does no harm. `phase` (1) is the skill's; the window goes by its clock. Outside of the
    window the offset stays as it is.
    """

    def __init__(
        self,
        *,
        scale: float,
        window: tuple[float, float],
        rate: float,
        tau: float,
        gamma: float = DEFAULT_GAMMA,
        time_step: float,
    ):
        """Build the system.

        Args:
            scale: of the person's motion in W.
            window: when the goal may move, on the skill's clock, s.
            rate: how fast the offset may change, m/s in W.
            tau, gamma: of the canonical system that the phase is of.
            time_step: period of the update, s.

        Raises:
            ScenarioError: one of them is out of its range.
        """
        super().__init__()
        for name, value in (("scale", scale), ("rate", rate), ("tau", tau), ("gamma", gamma), ("time_step", time_step)):
            if not 0 < value < np.inf:
                raise ScenarioError(f"live goal: {name} is out of range: {value}")
        self._scale, self._window, self._largest = scale, window, rate * time_step
        self._tau, self._gamma = tau, gamma
        self._planned = self.DeclareVectorInputPort("planned_goal", 18)
        self._phase = self.DeclareVectorInputPort("phase", 1)
        self._wanted = self.DeclareVectorInputPort("wanted_offset", 3)
        state = self.DeclareDiscreteState(np.zeros(3))
        self.DeclareVectorOutputPort(
            "goal", 18, self._calc_goal, {self.discrete_state_ticket(state), self._planned.ticket()}
        )
        self.DeclareStateOutputPort("offset", state)
        self.DeclarePeriodicDiscreteUpdateEvent(time_step, 0.0, self._update)

    def _calc_goal(self, context, output):
        offset = context.get_discrete_state(0).value() / self._scale
        output.SetFromVector(np.asarray(self._planned.Eval(context)) + np.tile(offset, 6))

    def _update(self, context, discrete_state):
        offset = context.get_discrete_state(0).value()
        clock = time_at(np.asarray(self._phase.Eval(context))[0], self._tau, self._gamma)
        wanted = self._wanted.Eval(context) if self._wanted.HasValue(context) else np.zeros(3)
        if self._window[0] <= clock <= self._window[1]:
            offset = towards(offset, wanted, self._largest)
        discrete_state.get_mutable_vector(0).SetFromVector(offset)
