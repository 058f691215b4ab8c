"""The document `summary.json`; docs/summary.md says what each entry means."""

import json
from importlib.metadata import PackageNotFoundError, version

import numpy as np

from drake_blfdmp import __version__
from drake_blfdmp.evaluation.metrics import (
    box_metrics,
    feedback_metrics,
    largest_barrier_derivative,
    link_metrics,
    rms_distance,
    robot_metrics,
)
from drake_blfdmp.evaluation.success import find_failures
from drake_blfdmp.planning.plan import Plan
from drake_blfdmp.recording.run_log import RunLog
from drake_blfdmp.skeleton import POINTS
from drake_blfdmp.skill.sampled import Gains


def fit_rms(plan: Plan) -> float:
    """The uncoupled skill against the smooth motion it was learned from, m, over time and the six points."""
    rollout, motion = plan.uncoupled, plan.task.motion
    keep = rollout.t <= plan.task.skill.tau
    t = rollout.t[keep]
    columns = motion.x.reshape(len(motion.t), 18).T
    expected = np.stack([np.interp(t, motion.t * plan.stretch, column) for column in columns], axis=-1)
    return rms_distance(rollout.x[keep], expected.reshape(-1, 6, 3))


def planned_lift(plan: Plan) -> float:
    """How far the planned middle of the hands rises while the box is held, above where it is grasped, m."""
    held = plan.task.held
    middle = 0.5 * (plan.coupled.x[:, 2, 2] + plan.coupled.x[:, 5, 2])
    inside = (plan.coupled.t >= held[0]) & (plan.coupled.t <= held[1])
    z = middle[inside] * plan.retarget.scale
    return float(z.max() - z[0])


def by_point(values: np.ndarray) -> dict[str, float]:
    """Six values by the points' names."""
    return {point: float(value) for point, value in zip(POINTS, values, strict=True)}


def together(plan: Plan) -> dict | None:
    """How several recordings became one demonstration; None for one recording."""
    found, spread = plan.source.together, plan.task.skill.spread
    if found is None or spread is None:
        return None
    rms = np.sqrt(np.mean(np.sum(spread**2, axis=-1), axis=0))
    return {
        "recordings": [
            {
                "source": source.recording.source,
                "weight": float(weight),
                "held_s": [source.holding.start_s, source.holding.end_s],
                "agreement": float(agreement),
            }
            for source, weight, agreement in zip(found.sources, found.weights, found.alignment.agreement, strict=True)
        ],
        "spread_rms_m": by_point(rms),
    }


def versions() -> dict[str, str]:
    """The versions a result depends on."""
    found = {"drake_blfdmp": __version__}
    for name in ("drake", "numpy", "scipy", "mcap"):
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "unknown"
    return found


def MakeSummary(plan: Plan, log: RunLog, margins: np.ndarray, simulated_s: float, wall_s: float) -> dict:
    """All of `summary.json`.

    Args:
        log: of the simulation.
        margins: (M, 5) the links' margins at every step of the simulated skill.
        simulated_s, wall_s: how long the simulation ran, in both clocks.
    """
    scenario, source = plan.scenario, plan.source
    uncertainty, mobility = source.demonstration.uncertainty, plan.task.skill.mobility
    held_at = None if plan.box is None else plan.task.held[0]
    coupled = link_metrics(plan.coupled, plan.task.bands, held_at)
    # The simulated skill is the rollout's twin; were it not, its own margins would tell.
    for entry, margin in zip(coupled.values(), margins.T, strict=True):
        entry["violations"] = max(entry["violations"], int(np.sum(margin <= 0)))
        entry["min_margin"] = min(entry["min_margin"], float(margin.min()))
    summary = {
        "success": False,
        "failures": [],
        "scenario": scenario.name,
        "law": scenario.law,
        "recording": {
            "source": source.demonstration.source,
            "synthetic": bool(source.demonstration.synthetic),
            "frames": len(source.recording.t)
            if source.together is None
            else sum(len(one.recording.t) for one in source.together.sources),
            "rate_hz": source.demonstration.rate_hz,
            "duration_s": source.demonstration.duration_s,
            "repairs": {name: int(count) for name, count in source.demonstration.repairs.items()},
            "held_s": None if plan.box is None else [source.holding.start_s, source.holding.end_s],
            "played_s": [float(t) for t in plan.task.motion.recorded[[0, -1]]],
            "estimated": list(source.estimated),
            "uncertainty_m": None if uncertainty is None else by_point(uncertainty),
            "notes": [*source.recording.evidence, *source.demonstration.notes],
            "together": together(plan),
        },
        "fit": {"rms_m": fit_rms(plan)},
        "links": coupled,
        "links_uncoupled": link_metrics(plan.uncoupled, plan.task.bands, held_at),
        "barrier": {
            "max_derivative": largest_barrier_derivative(plan.coupled, Gains(scenario.gains.k_1, scenario.gains.k_2))
            if scenario.law == "default"
            else None
        },
        "plan": {
            "notes": list(plan.notes),
            "scale": plan.retarget.scale,
            "world_m": [float(value) for value in plan.retarget.world],
            "palm_rolls_rad": [float(value) for value in plan.retarget.rolls],
            "stretch": plan.stretch,
            "hands_scale": plan.retarget.hands_scale,
            "lift_m": None if plan.box is None else planned_lift(plan),
            "box_width_m": None if plan.box is None else plan.box.width,
            "mobility": None if mobility is None else by_point(mobility),
        },
        "events": {
            "planned": {name: t for name, t in log.events},
            "recognised": [[name, t] for name, t in log.recognised],
        },
        "robot": robot_metrics(log, plan.settle_s),
        "feedback": feedback_metrics(log, plan.settle_s, plan.duration_s),
        "box": None
        if plan.box is None or plan.start is None
        else box_metrics(
            log,
            plan.task.held,
            plan.goal,
            float(plan.start[6]),
            plan.box.width,
            plan.squeeze_force,
            scenario.task.force_limit,
        ),
        "timing": {
            "simulated_s": simulated_s,
            "wall_s": wall_s,
            "realtime_rate": simulated_s / wall_s,
        },
        "versions": versions(),
        "seed": scenario.seed,
    }
    summary["failures"] = find_failures(summary)
    summary["success"] = not summary["failures"]
    return summary


def dump(summary: dict) -> str:
    """The summary as JSON text."""
    return json.dumps(summary, indent=2) + "\n"
