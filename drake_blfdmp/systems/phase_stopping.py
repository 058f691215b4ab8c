"""The tempo of the skill's clock: slower where the arms cannot keep up, and where they are pushed off their way."""

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.math import RigidTransform
from pydrake.systems.framework import LeafSystem

from drake_blfdmp.errors import ScenarioError
from drake_blfdmp.robot.palm_feedback import kept_share, middle_error, palm_positions
from drake_blfdmp.robot.tempo import tempo_towards


class PhaseStopping(LeafSystem):
    """Phase stopping by the palms' tracking error, joined with the tempo that the joints' limits allow.

    .. pydrake_system::

        name: PhaseStopping
        input_ports:
        - body_poses
        - commanded_palms
        - arms_tempo (optional)
        output_ports:
        - tempo
        - tracking_error

    Discrete state: the tempo by the tracking error (1). `body_poses` is the plant's abstract port, `commanded_palms`
    (6) and `arms_tempo` (1) come from SwivelDifferentialIk's outputs `commanded_palms` and `tempo`. `tempo` (1), in
    (0, 1], the smaller of both, is for CanonicalSystem and all that goes by the skill's clock. `tracking_error` (1), m,
    is how far the palms' middle is off the commanded one (`robot.palm_feedback`).
    """

    def __init__(
        self,
        *,
        palms: tuple[int, int],
        time_step: float,
        slack: float,
        scale: float,
        fall: float = 0.02,
        rise: float = 0.3,
        floor: float = 0.1,
    ):
        """Build the system.

        Args:
            palms: indices of the left and the right palm's body in `body_poses`.
            time_step: period of the update, s, > 0.
            slack: tracking error that costs no time, m, >= 0.
            scale: by how much more the tempo is halved, m, > 0.
            fall: time constant of slowing down, s (`robot.tempo`).
            rise: time constant of the way back, s.
            floor: never slower than this, in (0, 1]; > 0, so that an arm that is blocked for good does not hang.

        Raises:
            ScenarioError: one of them is out of its range.
        """
        super().__init__()
        for name, value, fits in (
            ("time_step", time_step, time_step > 0),
            ("slack", slack, slack >= 0),
            ("scale", scale, scale > 0),
            ("fall", fall, fall > 0),
            ("rise", rise, rise > 0),
            ("floor", floor, 0 < floor <= 1),
        ):
            if not (fits and value < np.inf):
                raise ScenarioError(f"phase stopping: {name} is out of range: {value}")
        self._palms, self._time_step = palms, time_step
        self._slack, self._scale, self._constants = slack, scale, (fall, rise, floor)
        self._poses = self.DeclareAbstractInputPort("body_poses", AbstractValue.Make([RigidTransform()]))
        self._commanded = self.DeclareVectorInputPort("commanded_palms", 6)
        self._arms = self.DeclareVectorInputPort("arms_tempo", 1)
        state = self.DeclareDiscreteState(np.ones(1))
        self.DeclareVectorOutputPort(
            "tempo", 1, self._calc_tempo, {self.discrete_state_ticket(state), self._arms.ticket()}
        )
        self._error = self.DeclareVectorOutputPort(
            "tracking_error", 1, self._calc_error, {self._poses.ticket(), self._commanded.ticket()}
        )
        self.DeclarePeriodicDiscreteUpdateEvent(time_step, 0.0, self._update)

    def _calc_error(self, context, output):
        palms = palm_positions(self._poses.Eval(context), self._palms)
        output.SetFromVector([middle_error(palms, self._commanded.Eval(context).reshape(2, 3))])

    def _calc_tempo(self, context, output):
        tempo = context.get_discrete_state(0).value()[0]
        if self._arms.HasValue(context):
            tempo = min(tempo, np.asarray(self._arms.Eval(context))[0])
        output.SetFromVector([tempo])

    def _update(self, context, discrete_state):
        fall, rise, floor = self._constants
        wanted = max(kept_share(np.asarray(self._error.Eval(context))[0], self._slack, self._scale), floor)
        tempo = tempo_towards(context.get_discrete_state(0).value(), wanted, self._time_step, fall, rise)
        discrete_state.get_mutable_vector(0).SetFromVector(tempo)
