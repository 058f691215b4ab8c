"""From a plan to the signals that a run's recording and log hold of it."""

import numpy as np

from drake_blfdmp.planning.plan import Plan
from drake_blfdmp.quaternions import interpolated_poses
from drake_blfdmp.recording.planned_signals import MOST_SAMPLES, PlannedSignals
from drake_blfdmp.robot.plant import JointLimits
from drake_blfdmp.skill.profiles import HandDistance


def MakePlannedSignals(plan: Plan, limits: JointLimits) -> PlannedSignals:
    """What the plan has at every sample that is recorded where nothing slows the skill.

    Args:
        plan: of the run.
        limits: of the joints.
    """
    step = max(1.0 / plan.scenario.simulation.record_rate_hz, plan.duration_s / (MOST_SAMPLES - 1))
    clock = np.append(np.arange(0.0, plan.duration_s - 1e-6, step), plan.duration_s)
    motion, rollout = plan.task.motion, plan.uncoupled

    def at(t: np.ndarray, x: np.ndarray) -> np.ndarray:
        columns = [np.interp(clock, t, column) for column in x.reshape(len(x), 18).T]
        return np.stack(columns, axis=-1).reshape(-1, 6, 3)

    return PlannedSignals(
        clock=clock,
        uncoupled=at(rollout.t, rollout.x),
        demonstrated=at(motion.t * plan.stretch, motion.x),
        spread=plan.task.skill.spread_at(clock),
        box=None if plan.box is None else interpolated_poses(plan.coupled.t, plan.planned_box(), clock),
        q_lower=limits.lower,
        q_upper=limits.upper,
        v_limit=limits.velocity,
        effort_limit=limits.effort,
    )


def PlannedEvents(plan: Plan) -> tuple[tuple[str, float], ...]:
    """The task's phases by the skill's clock: (name, time in s)."""
    hands, events = plan.task.bands.hands, plan.task.skill.events
    if not isinstance(hands, HandDistance):
        return tuple((name, float(t)) for name, t in events.items())
    grasped, released = plan.task.held
    return (
        ("close", float(hands.close_s)),
        ("hold", float(grasped)),
        ("carry", float(events["grasp_end"])),
        ("set down", float(events["release"])),
        ("open", float(released)),
        ("released", float(released + hands.duration_s)),
    )
