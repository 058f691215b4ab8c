"""Stops a simulation at the first number that is not finite, and says which system made it."""

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, Diagram

from drake_blfdmp import interruption
from drake_blfdmp.diagrams.non_finite import described, find_origin, set_state, state_of, states_by_system
from drake_blfdmp.errors import NonFiniteError, SimulationError

_STUCK_STEPS, _STUCK_S = 100, 1e-6
"""An integrator that takes so many steps in so little time goes on for ever, in front of what it cannot integrate."""


class FiniteGuard:
    """Watches all continuous and discrete state of a simulation, after every step.

    A number that is not finite anywhere in the data's way reaches a state within a step, where this monitor sees it.
    The search for its origin goes back to the last finite state and looks at every vector port there. What is infinite
    in the first state (a distance of nothing near, say) may be so again. An integrator with error control never steps
    on to such a number, but makes its steps ever smaller before it; that is seen too.

    It becomes the simulator's monitor. Advance through `AdvanceTo`, so that what NumPy or Drake raise over such a
    number (a singular value decomposition, the contact solver) ends in the same one line.
    """

    def __init__(self, simulator: Simulator):
        """Watch a simulator of a Diagram from its initialization on."""
        self._simulator = simulator
        self._diagram: Diagram = simulator.get_system()
        self._continuous = simulator.get_context().num_continuous_states() > 0
        self._first: np.ndarray | None = None
        self._infinite = np.zeros(0, dtype=bool)
        self._last: tuple[float, np.ndarray] = (0.0, np.zeros(0))
        self._steps, self._mark = 0, -np.inf
        simulator.set_monitor(self._watch)

    def AdvanceTo(self, time: float) -> None:
        """Advance the simulation to a time, s.

        Raises:
            NonFiniteError: a number is not finite; the line names system, port and time.
            SimulationError: Drake cannot go on for another reason.
        """
        try:
            with np.errstate(invalid="ignore", over="ignore", divide="ignore"):  # Said here, once.
                self._simulator.AdvanceTo(time)
        except SimulationError:
            raise
        except Exception as error:
            interruption.check()
            self._explain(self._simulator.get_context(), error)
            if type(error) is not RuntimeError:  # Drake's own; anything else has a name and a place already.
                raise
            t = self._simulator.get_context().get_time()
            reason = " ".join(str(error).split())
            raise SimulationError(
                f"the simulation cannot go on at t = {t:.6g} s: {reason}; try a shorter simulation.time_step"
            ) from error

    def _watch(self, context: Context) -> None:
        state = state_of(context)
        if self._first is None:
            if np.isnan(state).any():
                raise NonFiniteError("the simulation starts from a state that is not a number; check the initial state")
            self._first, self._infinite = state, np.isinf(state)
        finite = np.isfinite(state)
        if not finite.all() and not (finite | self._infinite & (state == self._first)).all():
            self._explain(context, None)
            raise NonFiniteError(f"a state is not finite after t = {self._last[0]:.6g} s", time=self._last[0])
        self._last = context.get_time(), state
        if self._continuous:
            self._refuse_to_crawl(context)

    def _refuse_to_crawl(self, context: Context) -> None:
        self._steps += 1
        if self._steps % _STUCK_STEPS:
            return
        t = context.get_time()
        if t - self._mark < _STUCK_S:
            # The next step must find what the integrator shrinks from.
            ahead = context.Clone()
            rates = np.asarray(self._diagram.EvalTimeDerivatives(context).CopyToVector())
            ahead.SetTime(t + _STUCK_S)
            ahead.SetContinuousState(
                np.asarray(context.get_continuous_state_vector().CopyToVector()) + _STUCK_S * rates
            )
            self._last = t + _STUCK_S, state_of(ahead)
            self._explain(context, None)
            raise SimulationError(
                f"the integrator cannot get past t = {t:.9g} s: its steps become ever smaller; look for a jump there"
            )
        self._mark = t

    def _explain(self, after: Context, cause: Exception | None) -> None:
        """Raise where a number is found that is not finite: before the last step, or else after it."""
        if self._first is None:
            return
        time, state = self._last
        before, start = after.Clone(), after.Clone()
        for context, t, values in ((before, time, state), (start, 0.0, self._first)):
            context.SetTime(t)
            set_state(context, values)
        origin = find_origin(self._diagram, before, after, start)
        if origin is not None:
            raise NonFiniteError(
                f"{described(origin)} at t = {time:.6g} s; check what that system is given",
                system=origin.system,
                port=origin.port,
                time=time,
                states=states_by_system(self._diagram, before),
            ) from cause
