"""The distance reshaper: one acceleration for all points that meets all links' demands; (15)-(17) at once."""

import numpy as np
from pydrake.systems.framework import LeafSystem_
from pydrake.systems.scalar_conversion import TemplateSystem

from drake_blfdmp.skill.reshaper import DEFAULT_MOBILITY, reshape, reshape_limited


@TemplateSystem.define("DistanceReshaper_")
def DistanceReshaper_(T):
    """Define the system for scalar type T."""

    class Impl(LeafSystem_[T]):
        r"""The weighted least change of the nominal accelerations (`skill.reshaper`).

        .. pydrake_system::

            name: DistanceReshaper
            input_ports:
            - position
            - velocity
            - nominal_acceleration
            - link_acceleration
            output_ports:
            - coupling_acceleration
            - widening

        No state. `position`, `velocity`, `nominal_acceleration`, `coupling_acceleration` (18), `link_acceleration` (5).
        `widening` (1), m: how much wider the hands' band would have to be for the demand to be met; 0 as long as the
        acceleration limit is not reached (Remark 2: the arm links come first).
        Template parameters: float, AutoDiffXd, Expression; with an acceleration limit float only.
        """

        def _construct(
            self, *, mobility=DEFAULT_MOBILITY, acceleration_limit=np.inf, law_stiffness=161.0, converter=None
        ):
            """Build the system.

            Args:
                mobility: (6,) positive weights of the points.
                acceleration_limit: m/s^2 for each point.
                law_stiffness: 1 + k_1 k_2 of the law, 1/s^2: what turns an acceleration given up into a distance.
            """
            LeafSystem_[T].__init__(self, converter=converter)
            self._parameters = {
                "mobility": mobility,
                "acceleration_limit": acceleration_limit,
                "law_stiffness": law_stiffness,
            }
            self._mobility = np.asarray(mobility, dtype=float)
            self._limit, self._stiffness = acceleration_limit, law_stiffness
            self._inputs = [
                self.DeclareVectorInputPort(name, size)
                for name, size in (
                    ("position", 18),
                    ("velocity", 18),
                    ("nominal_acceleration", 18),
                    ("link_acceleration", 5),
                )
            ]
            self.DeclareVectorOutputPort("coupling_acceleration", 18, self._calc_coupling)
            self.DeclareVectorOutputPort("widening", 1, self._calc_widening)

        def _construct_copy(self, other, converter=None):
            Impl._construct(self, **other._parameters, converter=converter)

        def _evaluate(self, context):
            x, velocity, nominal, demanded = (port.Eval(context) for port in self._inputs)
            arguments = (x.reshape(6, 3), velocity.reshape(6, 3), nominal.reshape(6, 3), demanded)
            if np.isinf(self._limit):
                return reshape(*arguments, self._mobility), 0.0
            return reshape_limited(*arguments, self._limit, self._mobility)

        def _calc_coupling(self, context, output):
            output.SetFromVector(self._evaluate(context)[0].reshape(18))

        def _calc_widening(self, context, output):
            output.SetFromVector([self._evaluate(context)[1] / self._stiffness])

    return Impl


DistanceReshaper = DistanceReshaper_[None]
