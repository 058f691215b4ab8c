"""A plan simulated and judged: what every run does, whatever else looks on."""

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from drake_blfdmp.diagrams.finite_guard import FiniteGuard
from drake_blfdmp.diagrams.hold_and_place import AddHoldAndPlace, HoldAndPlace, SetInitialState, SkillClock
from drake_blfdmp.evaluation.run_logger import AddRunLogger, MakeRunLog
from drake_blfdmp.evaluation.summary import MakeSummary
from drake_blfdmp.planning.plan import Plan
from drake_blfdmp.recording.run_log import RunLog
from drake_blfdmp.recording.topic_recorder import TopicRecorder

Progress = Callable[[str, float], None]

LONGEST = 3.0
"""A run whose phase is slowed down is given this many times its planned duration."""

SLICE_S = 0.1
"""How much is simulated between two words on the progress, s."""


@dataclass(frozen=True)
class Simulated:
    """What a simulation left behind.

    Attributes:
        log: at the scenario's recording rate.
        margins: (M, 5) the links' margins at every step of the skill.
        simulated_s, wall_s: how long it ran, in both clocks; pauses and the measuring afterwards do not count.
    """

    log: RunLog
    margins: np.ndarray
    simulated_s: float
    wall_s: float


def Simulate(
    plan: Plan,
    add: Callable[[DiagramBuilder, HoldAndPlace], None] = lambda builder, parts: None,
    progress: Progress = lambda what, share: None,
    between: Callable[[Simulator], float] | None = None,
) -> Simulated:
    """Build the plan's diagram, run it to its end and measure.

    Args:
        add: adds what else shall listen, a recorder or a viewer, before the diagram is built.
        progress: called with what is being done and the share of it done.
        between: called before every slice of the simulation, which waits for it; returns for how long it stood still on
            purpose, s of wall time.

    Raises:
        ScenarioError: the gains are not safe at the scenario's time step.
        SimulationError: the simulation cannot go on; a NonFiniteError where a number is not finite.
    """
    builder = DiagramBuilder()
    parts = AddHoldAndPlace(builder, plan)
    logger = AddRunLogger(builder, parts)
    add(builder, parts)
    diagram = builder.Build()
    simulator = Simulator(diagram)
    context = simulator.get_mutable_context()
    SetInitialState(parts, diagram, context)
    guard = FiniteGuard(simulator)
    end = plan.duration_s
    started, stood_still = time.perf_counter(), 0.0
    simulator.Initialize()
    for t in (*np.arange(SLICE_S, end, SLICE_S), end, *np.arange(end + SLICE_S, LONGEST * end, SLICE_S)):
        stood_still += 0.0 if between is None else between(simulator)
        guard.AdvanceTo(float(t))
        clock = SkillClock(parts, context)
        progress("simulating", min(clock / end, 1.0))
        if t >= end and clock >= end - 1e-6:
            break
    wall = time.perf_counter() - started - stood_still
    for system in diagram.GetSystems():
        if isinstance(system, TopicRecorder):
            system.Flush()  # Measuring takes longer than a recorder may hold samples.
    progress("simulating", 1.0)
    progress("measuring", 0.0)
    log = MakeRunLog(plan, parts.limits, logger, context)
    progress("measuring", 1.0)
    return Simulated(log, logger.margins(context), context.get_time(), wall)


def Judge(plan: Plan) -> dict:
    """The `summary.json` of a plan that is simulated with no recorder, viewer or folder; raises as `Simulate`."""
    done = Simulate(plan)
    return MakeSummary(plan, done.log, done.margins, done.simulated_s, done.wall_s)
