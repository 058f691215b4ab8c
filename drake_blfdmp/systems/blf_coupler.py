"""The barrier Lyapunov coupler: which acceleration every link's length must have to stay inside its band."""

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.systems.framework import LeafSystem_, ValueProducer
from pydrake.systems.scalar_conversion import TemplateSystem

from drake_blfdmp.skeleton import HANDS
from drake_blfdmp.skill.barrier import barrier_function, error_acceleration, length_acceleration, normalised_error
from drake_blfdmp.skill.geometry import link_states
from drake_blfdmp.skill.sampled import Gains


@TemplateSystem.define("BlfCoupler_")
def BlfCoupler_(T):
    """Define the system for scalar type T."""

    class Impl(LeafSystem_[T]):
        r"""The default law on all five links (`skill.barrier`).

        .. pydrake_system::

            name: BlfCoupler
            input_ports:
            - position
            - velocity
            - bands
            - measured_distance (optional)
            output_ports:
            - link_acceleration
            - barrier
            - margin

        No state. `position`, `velocity` (18); `bands` (30) as from DistanceBands. `measured_distance` (3), when
        connected, is what the law keeps in the hands' band in place of the planned distance: a distance (m), its rate
        (m/s), and that part of its acceleration (m/s^2) which does not come from the plan (HandsObserver).
        `link_acceleration` (5) is the rho'' (m/s^2) demanded of the plan, `barrier` (5) is V, `margin` (5) is 1 - |xi|,
        negative outside the band.
        Template parameters: float, AutoDiffXd, Expression.
        """

        def _construct(self, *, gains: Gains = Gains(), time_step=0.0, converter=None):
            """Build the system.

            Args:
                gains: k_1, k_2.
                time_step: of the system that integrates the result, s.

            Raises:
                ScenarioError: the gains are not safe at this time step.
            """
            LeafSystem_[T].__init__(self, converter=converter)
            gains.check(time_step)
            self._parameters = {"gains": gains, "time_step": time_step}
            self._gains = gains
            self._position = self.DeclareVectorInputPort("position", 18)
            self._velocity = self.DeclareVectorInputPort("velocity", 18)
            self._bands = self.DeclareVectorInputPort("bands", 30)
            self._measured = self.DeclareVectorInputPort("measured_distance", 3)
            # All outputs are made of the same errors.
            producer = ValueProducer(allocate=lambda: AbstractValue.Make(()), calc=self._calc_errors)
            inputs = {self.all_input_ports_ticket()}
            self._errors = self.DeclareCacheEntry("errors", producer, inputs)
            self.DeclareVectorOutputPort("link_acceleration", 5, self._calc_link_acceleration, inputs)
            self.DeclareVectorOutputPort("barrier", 5, self._calc_barrier, {self._errors.ticket()})
            self.DeclareVectorOutputPort("margin", 5, self._calc_margin, {self._errors.ticket()})

        def _construct_copy(self, other, converter=None):
            Impl._construct(self, **other._parameters, converter=converter)

        def _calc_errors(self, context, value):
            bands = self._bands.Eval(context).reshape(6, 5)
            rho, rho_dot, _, _ = link_states(
                self._position.Eval(context).reshape(6, 3), self._velocity.Eval(context).reshape(6, 3)
            )
            if self._measured.HasValue(context):
                rho[HANDS], rho_dot[HANDS] = self._measured.Eval(context)[:2]
            value.set_value((*normalised_error(rho, rho_dot, bands), bands))

        def _calc_link_acceleration(self, context, output):
            xi, xi_dot, bands = self._errors.Eval(context)
            xi_ddot = error_acceleration(xi, xi_dot, self._gains.k_1, self._gains.k_2)
            demanded = length_acceleration(xi, xi_dot, xi_ddot, bands)
            if self._measured.HasValue(context):
                demanded[HANDS] = demanded[HANDS] - self._measured.Eval(context)[2]
            output.SetFromVector(demanded)

        def _calc_barrier(self, context, output):
            xi, xi_dot, _ = self._errors.Eval(context)
            output.SetFromVector(barrier_function(xi, xi_dot, self._gains.k_1))

        def _calc_margin(self, context, output):
            xi, _, _ = self._errors.Eval(context)
            output.SetFromVector(1.0 - np.abs(xi))

    return Impl


BlfCoupler = BlfCoupler_[None]
