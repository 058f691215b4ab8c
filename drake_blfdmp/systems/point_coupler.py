"""The laws that give every point its acceleration directly, as a Drake system; `skill.laws` but the default."""

from collections.abc import Callable
from typing import Any

import numpy as np
from pydrake.systems.framework import LeafSystem

from drake_blfdmp.errors import ScenarioError
from drake_blfdmp.skill.laws import published_lagged
from drake_blfdmp.skill.laws.primitive import Primitive


class PointCoupler(LeafSystem):
    """One law of `skill.laws` from bands to coupling acceleration; the default one has BlfCoupler and DistanceReshaper.

    .. pydrake_system::

        name: PointCoupler
        input_ports:
        - position
        - velocity
        - nominal_acceleration
        - bands
        output_ports:
        - coupling_acceleration

    `position`, `velocity`, `nominal_acceleration`, `coupling_acceleration` (18), `bands` (30) as from DistanceBands.
    Discrete state with a time step: the acceleration (18) taken at the previous sample, m/s^2, zero at first.
    """

    def __init__(self, *, law: Callable, primitive: Primitive, gains: Any = None, time_step: float = 0.0):
        """Build the system.

        Args:
            law: one of `skill.laws`; gains: of that law, its defaults if None.
            primitive: tau and alpha_z of the skill.
            time_step: of the system that integrates the result, s.

        Raises:
            ScenarioError: the law needs a previous sample and the time is continuous.
        """
        super().__init__()
        if law is published_lagged and time_step == 0.0:
            raise ScenarioError("law: published_lagged lives on samples; give the skill a time step above 0")
        self._law, self._primitive = law, primitive
        self._options = {} if gains is None else {"gains": gains}
        self._inputs = [
            self.DeclareVectorInputPort(name, 18) for name in ("position", "velocity", "nominal_acceleration")
        ]
        self._bands = self.DeclareVectorInputPort("bands", 30)
        self._sampled = time_step > 0
        self._coupling = self.DeclareVectorOutputPort("coupling_acceleration", 18, self._calc_coupling)
        if self._sampled:
            self.DeclareDiscreteState(np.zeros(18))
            self.DeclarePeriodicDiscreteUpdateEvent(time_step, 0.0, self._update)

    def _calc_coupling(self, context, output):
        x, velocity, nominal = (port.Eval(context).reshape(6, 3) for port in self._inputs)
        previous = context.get_discrete_state(0).value().reshape(6, 3) if self._sampled else np.zeros((6, 3))
        bands = self._bands.Eval(context).reshape(6, 5)
        coupling = self._law(x, velocity, nominal, previous, bands, self._primitive, **self._options)
        output.SetFromVector(coupling.reshape(18))

    def _update(self, context, discrete_state):
        nominal, coupling = (np.asarray(port.Eval(context)) for port in (self._inputs[2], self._coupling))
        discrete_state.get_mutable_vector(0).SetFromVector(nominal + coupling)
