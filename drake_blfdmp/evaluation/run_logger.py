"""What is logged while the diagram runs, and the `RunLog` made of it afterwards."""

from dataclasses import dataclass

import numpy as np
from pydrake.math import RotationMatrix
from pydrake.systems.framework import Context, DiagramBuilder
from pydrake.systems.primitives import LogVectorOutput, VectorLogSink

from drake_blfdmp.diagrams.hold_and_place import HoldAndPlace
from drake_blfdmp.evaluation.planned_signals import MakePlannedSignals, PlannedEvents
from drake_blfdmp.planning.plan import Plan
from drake_blfdmp.recording.run_log import RunLog
from drake_blfdmp.robot.carry_phases import transitions
from drake_blfdmp.robot.clearance import ClearanceChecker
from drake_blfdmp.robot.kinematics import DualArmKinematics
from drake_blfdmp.robot.plant import JointLimits
from drake_blfdmp.robot.rigid import rigid
from drake_blfdmp.skill.canonical import time_at


@dataclass(frozen=True)
class RunLogger:
    """The log sinks of one diagram, by signal."""

    sinks: dict[str, VectorLogSink]
    every_step: VectorLogSink

    def log(self, name: str, context: Context) -> np.ndarray:
        """The samples (N, size) of a signal; those of the box are not logged where there is none."""
        return np.array(self.sinks[name].FindLog(context).data().T)

    def times(self, context: Context) -> np.ndarray:
        """The sample times (N,), s."""
        return np.array(self.sinks["phase"].FindLog(context).sample_times())

    def margins(self, context: Context) -> np.ndarray:
        """1 - |xi| of every link at every step of the simulated skill: (M, 5)."""
        return np.array(self.every_step.FindLog(context).data().T)


def AddRunLogger(builder: DiagramBuilder, parts: HoldAndPlace) -> RunLogger:
    """Log at the scenario's recording rate, and the links' margins at every step of the skill."""
    simulation = parts.plan.scenario.simulation
    period = 1.0 / simulation.record_rate_hz
    left, right = parts.arms
    plant, skill = parts.plant, parts.skill
    ports = {
        "phase": skill.canonical.GetOutputPort("phase"),
        "position": skill.transformation.GetOutputPort("position"),
        "bands": skill.bands.GetOutputPort("bands"),
        "barrier": skill.coupler.GetOutputPort("barrier"),
        "palm_poses": parts.retargeting.GetOutputPort("palm_poses"),
        "swivel": parts.retargeting.GetOutputPort("swivel"),
        "q_desired": parts.ik.GetOutputPort("position"),
        "task_scale": parts.ik.GetOutputPort("task_scale"),
        "hands": parts.observer.GetOutputPort("effective_distance"),
        "left_state": plant.get_state_output_port(left),
        "right_state": plant.get_state_output_port(right),
        "left_effort": plant.get_net_actuation_output_port(left),
        "right_effort": plant.get_net_actuation_output_port(right),
    }
    if parts.box is not None:
        ports["box_state"] = plant.get_state_output_port(parts.box.model_instance())
    if parts.palm_forces is not None:
        ports["palm_force"] = parts.palm_forces.get_output_port()
    if parts.carry_phase is not None:
        ports["carry_phase"] = parts.carry_phase.get_output_port()
    if parts.tempo is not None:
        ports["tempo"] = parts.tempo
    sinks = {name: LogVectorOutput(port, builder, period) for name, port in ports.items()}
    every_step = LogVectorOutput(skill.coupler.GetOutputPort("margin"), builder, simulation.skill_time_step)
    return RunLogger(sinks, every_step)


def MakeRunLog(plan: Plan, limits: JointLimits, logger: RunLogger, context: Context) -> RunLog:
    """Everything that metrics and figures need, from the sinks of a finished (or interrupted) run."""
    t = logger.times(context)
    n = len(t)
    bands = logger.log("bands", context).reshape(n, 6, 5)
    left, right = logger.log("left_state", context), logger.log("right_state", context)
    q, v = np.hstack([left[:, :7], right[:, :7]]), np.hstack([left[:, 7:], right[:, 7:]])
    # A motion without a box has neither.
    box = logger.log("box_state", context)[:, :7] if "box_state" in logger.sinks else None
    force = logger.log("palm_force", context) if "palm_force" in logger.sinks else np.zeros((n, 2))
    phase = logger.log("phase", context)[:, 0]
    clock = time_at(phase, plan.task.skill.tau, plan.task.skill.gamma)
    palm, swivel = _kinematics(q)
    planned = MakePlannedSignals(plan, limits)
    return RunLog(
        t=t,
        clock=clock,
        phase=phase,
        tempo=logger.log("tempo", context)[:, 0] if "tempo" in logger.sinks else np.ones(n),
        position=logger.log("position", context).reshape(n, 6, 3),
        uncoupled=planned.points_at("uncoupled", clock),
        demonstrated=planned.points_at("demonstrated", clock),
        lower=bands[:, 0],
        upper=bands[:, 1],
        desired=0.5 * (bands[:, 0] + bands[:, 1]),
        barrier=logger.log("barrier", context),
        q=q,
        q_desired=logger.log("q_desired", context),
        v=v,
        effort=np.hstack([logger.log("left_effort", context), logger.log("right_effort", context)]),
        q_lower=limits.lower,
        q_upper=limits.upper,
        v_limit=limits.velocity,
        effort_limit=limits.effort,
        palm=palm,
        palm_desired=logger.log("palm_poses", context).reshape(n, 2, 7),
        swivel=swivel,
        swivel_desired=logger.log("swivel", context),
        hands=logger.log("hands", context)[:, 0],
        palm_force=force,
        box=box,
        box_desired=planned.box_at(clock),
        clearance=_clearances(plan, q, box),
        events=tuple((name, float(np.interp(at, clock, t))) for name, at in PlannedEvents(plan)),
        spread=planned.spread_at(clock),
        recognised=transitions(t, logger.log("carry_phase", context)[:, 0]) if "carry_phase" in logger.sinks else (),
    )


def _kinematics(q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    kinematics = DualArmKinematics()
    palm, swivel = np.empty((len(q), 2, 7)), np.empty((len(q), 2))
    for k, posture in enumerate(q):
        for arm, state in enumerate(kinematics.evaluate(posture)):
            palm[k, arm, :4], palm[k, arm, 4:] = RotationMatrix(state.rotation).ToQuaternion().wxyz(), state.position
            swivel[k, arm] = state.swivel
    return palm, swivel


def _clearances(plan: Plan, q: np.ndarray, box: np.ndarray | None) -> np.ndarray:
    checker = ClearanceChecker(plan.tables, plan.real_box)
    poses = [None] * len(q) if box is None else [rigid(pose) for pose in box]
    return np.array([checker.min_clearance(posture, pose)[0] for posture, pose in zip(q, poses, strict=True)])
