"""The distance between the robot's palms, as the law on the plan's hands can use it."""

from typing import NamedTuple

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.math import RigidTransform
from pydrake.systems.framework import LeafSystem

from drake_blfdmp.errors import ScenarioError
from drake_blfdmp.robot.palm_feedback import effective_distance, filter_matrices, filtered, palm_positions
from drake_blfdmp.skeleton import HANDS, LINKS

_LEFT, _RIGHT = (slice(3 * point, 3 * point + 3) for point in (LINKS[HANDS].a, LINKS[HANDS].b))


class Squeeze(NamedTuple):
    """What a box between the palms makes of a commanded distance (`robot.palm_feedback`).

    Attributes:
        width: of the box, believed, m.
        compliance: of both arms together, m/N.
        contact_force: from which on the palms count as touching, N.
    """

    width: float
    compliance: float
    contact_force: float


class HandsObserver(LeafSystem):
    """The palms' effective distance, filtered, for BlfCoupler's `measured_distance` (`robot.palm_feedback`).

    .. pydrake_system::

        name: HandsObserver
        input_ports:
        - position
        - velocity
        - body_poses
        - palm_force (optional)
        - tempo (optional)
        output_ports:
        - measured_distance
        - effective_distance

    Discrete state: e_f, e_f' (2), on the skill's clock, m and m/s. `position`, `velocity` (18) of the skill,
    `body_poses` the plant's abstract port, `palm_force` (2), N, `tempo` (1) as for TransformationSystem.
    `measured_distance` (3): rho_c + e_f, its rate, and the mean e_f'' over the coming step, m, m/s, m/s^2.
    `effective_distance` (1): rho_eff, unfiltered, m. Distances are in the skill's measure.
    """

    def __init__(
        self,
        *,
        palms: tuple[int, int],
        time_step: float,
        rate: float,
        largest: float,
        squeeze: Squeeze | None = None,
        hands_scale: float = 1.0,
        active_from: float = 0.0,
    ):
        """Build the system.

        Args:
            palms: indices of the left and the right palm's body in `body_poses`.
            time_step: period of the update, s, > 0.
            rate: a of the filter, 1/s.
            largest: errors beyond it are taken for it, m.
            squeeze: what a box makes of the distance; None: the palms hold nothing.
            hands_scale: the palms' distance for the skill's (`Retarget.hands_scale`).
            active_from: until then, s, the error counts as zero: the arms do not follow the skill yet.

        Raises:
            ScenarioError: `time_step`, `rate` or `largest` is not positive.
        """
        super().__init__()
        for name, value in (("time_step", time_step), ("rate", rate), ("largest", largest)):
            if not 0.0 < value < np.inf:
                raise ScenarioError(f"hands observer: {name} must be positive and finite, not {value}")
        self._palms, self._time_step, self._rate, self._largest = palms, time_step, rate, largest
        self._squeeze, self._scale, self._active_from = squeeze, hands_scale, active_from
        self._full_step = filter_matrices(rate, time_step)
        self._position = self.DeclareVectorInputPort("position", 18)
        self._velocity = self.DeclareVectorInputPort("velocity", 18)
        self._poses = self.DeclareAbstractInputPort("body_poses", AbstractValue.Make([RigidTransform()]))
        self._force = self.DeclareVectorInputPort("palm_force", 2)
        self._tempo = self.DeclareVectorInputPort("tempo", 1)
        self.DeclareDiscreteState(np.zeros(2))
        self.DeclareVectorOutputPort("measured_distance", 3, self._calc_measured)
        self._effective = self.DeclareVectorOutputPort(
            "effective_distance",
            1,
            self._calc_effective,
            {self._poses.ticket(), self._force.ticket()},
        )
        self.DeclarePeriodicDiscreteUpdateEvent(time_step, 0.0, self._update)

    def _calc_effective(self, context, output):
        left, right = palm_positions(self._poses.Eval(context), self._palms)
        distance = np.linalg.norm(right - left)
        if self._squeeze is not None and self._force.HasValue(context):
            distance = effective_distance(distance, self._force.Eval(context).mean(), *self._squeeze)
        output.SetFromVector([distance / self._scale])

    def _lengths(self, context):
        r, r_dot = (
            np.asarray(port.Eval(context))[_RIGHT] - np.asarray(port.Eval(context))[_LEFT]
            for port in (self._position, self._velocity)
        )
        rho = np.sqrt(r @ r)
        return rho, r @ r_dot / rho

    def _step(self, context, rho):
        """e_f, e_f' now and after the coming step, and its length on the skill's clock, s."""
        now = context.get_discrete_state(0).value()
        error = 0.0
        if context.get_time() >= self._active_from - 0.5 * self._time_step:
            error = np.clip(np.asarray(self._effective.Eval(context))[0] - rho, -self._largest, self._largest)
        tempo = np.asarray(self._tempo.Eval(context))[0] if self._tempo.HasValue(context) else 1.0
        length = tempo * self._time_step
        matrices = self._full_step if tempo == 1.0 else filter_matrices(self._rate, length)
        return now, np.array(filtered(*now, error, matrices)), length

    def _calc_measured(self, context, output):
        rho, rho_dot = self._lengths(context)
        now, after, length = self._step(context, rho)
        acceleration = (after[1] - now[1]) / length if length > 0.0 else 0.0
        output.SetFromVector([rho + now[0], rho_dot + now[1], acceleration])

    def _update(self, context, discrete_state):
        discrete_state.get_mutable_vector(0).SetFromVector(self._step(context, self._lengths(context)[0])[1])
