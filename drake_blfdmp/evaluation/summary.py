"""The document `summary.json`; docs/summary.md says what each entry means."""

import json
from importlib.metadata import PackageNotFoundError, version

import numpy as np

from drake_blfdmp import __version__
from drake_blfdmp.evaluation.metrics import (
    box_metrics,
    largest_barrier_derivative,
    link_metrics,
    rms_distance,
    robot_metrics,
)
from drake_blfdmp.evaluation.success import find_failures
from drake_blfdmp.planning.plan import Plan
from drake_blfdmp.recording.run_log import RunLog
from drake_blfdmp.skill.sampled import Gains


def fit_rms(plan: Plan) -> float:
    """The uncoupled skill against the smooth motion it was learned from, m, over time and the six points."""
    rollout, motion = plan.uncoupled, plan.task.motion
    keep = rollout.t <= plan.task.skill.tau
    t = rollout.t[keep]
    columns = motion.x.reshape(len(motion.t), 18).T
    expected = np.stack([np.interp(t, motion.t * plan.stretch, column) for column in columns], axis=-1)
    return rms_distance(rollout.x[keep], expected.reshape(-1, 6, 3))


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
    held = plan.task.held
    coupled = link_metrics(plan.coupled, plan.task.bands, held[0])
    # The simulated skill is the rollout's twin; were it not, its own margins would tell.
    for entry, margin in zip(coupled.values(), margins.T, strict=True):
        entry["violations"] = max(entry["violations"], int(np.sum(margin <= 0)))
        entry["min_margin"] = min(entry["min_margin"], float(margin.min()))
    middle = 0.5 * (plan.coupled.x[:, 2, 2] + plan.coupled.x[:, 5, 2])
    inside = (plan.coupled.t >= held[0]) & (plan.coupled.t <= held[1])
    z = middle[inside] * plan.retarget.scale
    summary = {
        "success": False,
        "failures": [],
        "scenario": scenario.name,
        "law": scenario.law,
        "recording": {
            "source": source.recording.source,
            "synthetic": bool(source.recording.synthetic),
            "frames": len(source.recording.t),
            "rate_hz": source.demonstration.rate_hz,
            "duration_s": source.demonstration.duration_s,
            "repairs": {name: int(count) for name, count in source.demonstration.repairs.items()},
            "held_s": [source.holding.start_s, source.holding.end_s],
            "estimated": list(source.estimated),
        },
        "fit": {"rms_m": fit_rms(plan)},
        "links": coupled,
        "links_uncoupled": link_metrics(plan.uncoupled, plan.task.bands, held[0]),
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
            "lift_m": float(z.max() - z[0]),
            "box_width_m": plan.box.width,
        },
        "robot": robot_metrics(log, plan.settle_s),
        "box": box_metrics(log, held, plan.goal, float(plan.start[6]), plan.box.width),
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
