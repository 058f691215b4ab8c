"""The links' moving bands (5), (13), (20) as a Drake system."""

import numpy as np
from pydrake.systems.framework import LeafSystem_
from pydrake.systems.scalar_conversion import TemplateSystem

from drake_blfdmp.skill.bands import Bands
from drake_blfdmp.skill.canonical import DEFAULT_GAMMA, time_at


@TemplateSystem.define("DistanceBands_")
def DistanceBands_(T):
    """Define the system for scalar type T."""

    class Impl(LeafSystem_[T]):
        r"""Lower and upper bounds of the five links' lengths, with two derivatives.

        .. pydrake_system::

            name: DistanceBands
            input_ports:
            - phase
            output_ports:
            - bands

        No state. The bands are functions of the skill's clock, which an undisturbed canonical system's phase tells, so
        they slow down with it. `bands` (30): lower (5), upper (5), then their first and second derivatives by that
        clock in the same way (m, m/s, m/s^2), links as in `skeleton.LINKS`.
        Template parameters: float, AutoDiffXd, Expression; the bands of a recorded distance have no symbolic form.
        """

        def _construct(self, *, bands: Bands, tau, gamma=DEFAULT_GAMMA, converter=None):
            """Build the system; tau (s) and gamma are those of the canonical system."""
            LeafSystem_[T].__init__(self, converter=converter)
            self._parameters = {"bands": bands, "tau": tau, "gamma": gamma}
            self._functions, self._tau, self._gamma = bands, tau, gamma
            self._phase = self.DeclareVectorInputPort("phase", 1)
            # Stated, so that Drake need not try the symbolic form to find it: not every profile has one.
            self._bands = self.DeclareVectorOutputPort("bands", 30, self._calc_bands, {self._phase.ticket()})

        def _construct_copy(self, other, converter=None):
            Impl._construct(self, **other._parameters, converter=converter)

        def _calc_bands(self, context, output):
            t = time_at(self._phase.Eval(context)[0], self._tau, self._gamma)
            output.SetFromVector(self._functions.evaluate(np.asarray(t)).reshape(30))

    return Impl


DistanceBands = DistanceBands_[None]
