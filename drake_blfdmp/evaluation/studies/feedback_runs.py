"""One plan carried out in worlds that are not as it believes, with the loop around the palms open and closed."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from drake_blfdmp.evaluation.simulation import Simulate
from drake_blfdmp.evaluation.summary import MakeSummary
from drake_blfdmp.planning.plan import Plan
from drake_blfdmp.planning.scenario_sections import FeedbackConfig, RealityConfig
from drake_blfdmp.recording.run_log import RunLog
from drake_blfdmp.skeleton import HANDS

WORLDS: dict[str, RealityConfig] = {
    "as believed": RealityConfig(),
    "arms 0.4 x as stiff": RealityConfig(stiffness_scale=0.4),
    "box 10 mm wider": RealityConfig(width_error=0.01),
    "box 10 mm narrower": RealityConfig(width_error=-0.01),
    "pushed out, 20 N": RealityConfig(push_force=[-20.0, 0.0, 0.0]),
    "pushed out, 40 N": RealityConfig(push_force=[-40.0, 0.0, 0.0]),
    "pushed out, 60 N": RealityConfig(push_force=[-60.0, 0.0, 0.0]),
    "pushed back, 60 N": RealityConfig(push_force=[0.0, -60.0, 0.0]),
    "pushed up, 60 N": RealityConfig(push_force=[0.0, 0.0, 60.0]),
}
"""What each differs in; pushes act on the left palm for 0.2 s, halfway through the hold."""

LOOPS: dict[str, FeedbackConfig] = {
    "open": FeedbackConfig(hands=False, phase_stopping=False),
    "closed": FeedbackConfig(),
}

SETTLED_S = 0.5
"""So long after the palms have closed the hold is judged: the first touch, an impact of some 30 ms, is told apart."""


@dataclass(frozen=True)
class FeedbackRun:
    """One world, one loop.

    Attributes:
        held: (N,) samples of the log at which the box is held, the first SETTLED_S left out.
        offset: (N,) how far the palms' effective distance is from the middle of the hands' band, m.
        half_width: (N,) of that band, m.
        summary: as in `summary.json`.
    """

    log: RunLog
    held: np.ndarray
    offset: np.ndarray
    half_width: np.ndarray
    summary: dict


def CarryOutIn(
    plan: Plan, reality: RealityConfig, feedback: FeedbackConfig, progress: Callable[[float], None] = lambda share: None
) -> FeedbackRun:
    """Simulate the plan in that world with that feedback; nothing is written."""
    changed = replace(plan, scenario=replace(plan.scenario, reality=reality, feedback=feedback))
    done = Simulate(changed, progress=lambda what, share: progress(share) if what == "simulating" else None)
    log = done.log
    start, end = plan.task.held
    return FeedbackRun(
        log,
        (log.clock >= start + SETTLED_S) & (log.clock <= end),
        log.hands - 0.5 * (log.lower + log.upper)[:, HANDS],
        0.5 * (log.upper - log.lower)[:, HANDS],
        MakeSummary(changed, log, done.margins, done.simulated_s, done.wall_s),
    )


def feedback_row(run: FeedbackRun) -> dict[str, float | bool]:
    """One line of numbers on a run."""
    step = float(np.median(np.diff(run.log.t)))
    force = run.log.palm_force[run.held]
    box, feedback = run.summary["box"], run.summary["feedback"]
    outside = np.abs(run.offset) >= run.half_width
    return {
        "force_least_n": float(force.min()),
        "force_mean_n": float(force.mean()),
        "force_most_n": float(force.max()),
        "outside_held_s": step * int(np.sum(outside & run.held)),
        "worst_offset_held_m": float(np.abs(run.offset[run.held]).max()),
        "mean_offset_held_m": float(np.abs(run.offset[run.held]).mean()),
        "min_tempo": feedback["min_tempo"],
        "delay_s": feedback["delay_s"],
        "placement_error_m": box["placement_error_m"],
        "tilt_deg": box["max_tilt_deg"],
        "dropped": box["dropped"],
        "success": run.summary["success"],
    }


def as_table(runs: Mapping[tuple[str, str], FeedbackRun]) -> dict[str, list]:
    """The rows of all runs as columns, world and loop first."""
    rows = {key: feedback_row(run) for key, run in runs.items()}
    columns = {"world": [world for world, _ in rows], "loop": [loop for _, loop in rows]}
    return columns | {name: [row[name] for row in rows.values()] for name in next(iter(rows.values()))}
