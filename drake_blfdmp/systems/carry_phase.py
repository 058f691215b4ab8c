"""Recognises the phase of a carry while it happens, as a Drake system."""

from collections.abc import Sequence

import numpy as np
from pydrake.systems.framework import LeafSystem

from drake_blfdmp.robot.box import TableParameters
from drake_blfdmp.robot.carry_phases import DEFAULT_THRESHOLDS, PhaseThresholds, height_above, next_state


class CarryPhase(LeafSystem):
    """The phase of a carry by what is measured, not by the plan (`robot.carry_phases`).

    .. pydrake_system::

        name: CarryPhase
        input_ports:
        - palm_force
        - box_state
        output_ports:
        - carry_phase

    Discrete state: phase, the phase in question, since when (s), largest squeeze (N): (4). `palm_force` (2), N, from
    PalmForces; `box_state` (13) the plant's state of the box: quaternion, position, angular and translational velocity.
    `carry_phase` (1) is an index of `carry_phases.PHASES`; it is not direct-feedthrough.
    """

    def __init__(
        self,
        *,
        tables: Sequence[TableParameters],
        box_height: float,
        time_step: float = 0.02,
        thresholds: PhaseThresholds = DEFAULT_THRESHOLDS,
    ):
        """Build the system.

        Args:
            tables: what the box can stand on.
            box_height: m.
            time_step: period of the update, s, > 0.
            thresholds: of the recognition.
        """
        super().__init__()
        self._tables, self._half_height, self._thresholds = tuple(tables), 0.5 * box_height, thresholds
        self._force = self.DeclareVectorInputPort("palm_force", 2)
        self._box = self.DeclareVectorInputPort("box_state", 13)
        self.DeclareDiscreteState(np.zeros(4))
        self.DeclareVectorOutputPort("carry_phase", 1, self._calc_phase, {self.xd_ticket()})
        self.DeclarePeriodicDiscreteUpdateEvent(time_step, 0.0, self._update)

    def _calc_phase(self, context, output):
        output.SetFromVector(context.get_discrete_state(0).value()[:1])

    def _update(self, context, discrete_state):
        box = np.asarray(self._box.Eval(context))
        state = next_state(
            context.get_discrete_state(0).value(),
            context.get_time(),
            self._force.Eval(context),
            height_above(self._tables, box[4:7], self._half_height),
            box[10:13],
            self._thresholds,
        )
        discrete_state.get_mutable_vector(0).SetFromVector(state)
