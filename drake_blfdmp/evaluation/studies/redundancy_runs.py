"""One plan carried out with several redundancy resolutions, and what the arms made of each."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from drake_blfdmp.errors import TaskError
from drake_blfdmp.evaluation.simulation import Simulate
from drake_blfdmp.evaluation.studies.swivel_metrics import elbow_distance, swivel_error, swivel_rms
from drake_blfdmp.evaluation.study import Table
from drake_blfdmp.evaluation.summary import MakeSummary
from drake_blfdmp.planning.plan import Plan
from drake_blfdmp.recording.run_log import RunLog
from drake_blfdmp.robot.plant import ARMS, MakeKinematicPlant
from drake_blfdmp.robot.redundancy import ElbowKinematics
from drake_blfdmp.skill.geometry import link_lengths
from drake_blfdmp.viewing.planned_scene import PlannedScene
from drake_blfdmp.viewing.study_figures.frankas import Instants


@dataclass(frozen=True)
class RedundancyRun:
    """A plan, carried out.

    Attributes:
        plan: as it was given, with the scenario's own redundancy resolution.
        summary: as in `summary.json`.
        swivel_error: (N, 2) robot minus person, rad, as in `swivel_metrics`.
        elbow_off: (N, 2) how far each elbow is from where the person's angle wants it, m.
    """

    plan: Plan
    log: RunLog
    summary: dict
    swivel_error: np.ndarray
    elbow_off: np.ndarray


def SimulatePlan(plan: Plan, redundancy: str, progress: Callable[[float], None] = lambda share: None) -> RedundancyRun:
    """One simulation of the plan, with another redundancy resolution in the running arms; nothing is written.

    Args:
        redundancy: one of `robot.redundancy.REDUNDANCIES`.
        progress: called with the share done, 0 to 1.
    """
    retarget = replace(plan.scenario.retarget, redundancy=redundancy)
    changed = replace(plan, scenario=replace(plan.scenario, retarget=retarget))
    done = Simulate(changed, progress=lambda what, share: progress(share) if what == "simulating" else None)
    log = done.log
    summary = MakeSummary(changed, log, done.margins, done.simulated_s, done.wall_s)
    error, elbows = swivel_error(log.swivel, log.swivel_desired), ElbowKinematics()
    return RedundancyRun(plan, log, summary, error, elbow_distance(np.array([elbows.points(q) for q in log.q]), error))


def phase_times(plan: Plan, log: RunLog) -> dict[str, float]:
    """The seven phases of Figs. 5 and 11, s.

    Raises:
        TaskError: nothing is carried.
    """
    if log.box_desired is None:
        raise TaskError("two_frankas: a motion without a box has none of the phases of a carry; use task.kind=hold")
    events, height = dict(log.events), log.box_desired[:, 6]
    top = int(np.argmax(height))
    rising = (log.t <= log.t[top]) & (height >= 0.5 * (height[0] + height[top]))
    return {
        "start": plan.settle_s,
        "approach": events["close"],
        "grasp": events["hold"],
        "lift": float(log.t[np.argmax(rising)]),
        "carry": float(log.t[top]),
        "place": events["open"],
        "release": events["released"],
    }


def instants(plan: Plan, log: RunLog, times: Mapping[str, float]) -> Instants:
    """Person, skill and robots of a run at some times, s, by their names."""
    scene, at = PlannedScene(plan), np.minimum(np.searchsorted(log.t, list(times.values())), len(log.t) - 1)

    def inside(points: np.ndarray) -> np.ndarray:
        return (log.lower[at] < link_lengths(points)) & (link_lengths(points) < log.upper[at])

    poses = [scene.at(log.q[k], None if log.box is None else log.box[k]) for k in at]
    person, skill = log.demonstrated[at], log.position[at]
    return Instants(
        names=list(times),
        person=plan.retarget.point(person),
        skill=plan.retarget.point(skill),
        person_inside=inside(person),
        skill_inside=inside(skill),
        solids=scene.solids,
        poses=np.array(poses),
    )


def posture_row(run: RedundancyRun) -> dict:
    """One line of numbers: swivel angle, elbows, palms, box and joints, from the time at which the arms join in."""
    log, robot, box = run.log, run.summary["robot"], run.summary["box"]
    after = log.t >= run.plan.settle_s
    rms = np.rad2deg(swivel_rms(log.swivel[after], log.swivel_desired[after]))
    return {
        "swivel_rms_left_deg": rms[0],
        "swivel_rms_right_deg": rms[1],
        "swivel_elbow_off_m": float(np.nanmax(run.elbow_off[after])),
        "palm_tracking_rms_m": robot["palm_tracking_rms_m"],
        "box_tilt_max_deg": box["max_tilt_deg"],
        "placement_error_m": box["placement_error_m"],
        "joint_margin_min_rad": robot["min_joint_margin_rad"],
        "effort_ratio_max": robot["max_effort_ratio"],
        "success": "yes" if run.summary["success"] else "no: " + " ".join(run.summary["failures"]),
    }


def swivel_series(runs: Mapping[str, RedundancyRun]) -> Table:
    """Swivel angles over time, the robot's and what was asked of it, of every run."""
    series = {"time_s": next(iter(runs.values())).log.t}
    for setting, run in runs.items():
        for i, arm in enumerate(("left", "right")):
            series[f"{setting}_{arm}_rad"] = run.log.swivel[:, i]
            series[f"{setting}_{arm}_asked_rad"] = run.log.swivel_desired[:, i]
    return Table(series)


def held_means(run: RedundancyRun) -> tuple[float, float, float]:
    """While the box is held, on average: force of a palm, N; distance of the palms, m; the same as commanded."""
    log, (start, end) = run.log, run.plan.task.held
    held = (log.t >= start) & (log.t <= end)
    apart, asked = (np.linalg.norm(x[held, 1, 4:] - x[held, 0, 4:], axis=-1) for x in (log.palm, log.palm_desired))
    return float(log.palm_force[held].mean()), float(apart.mean()), float(asked.mean())


def BasePlaces() -> np.ndarray:
    """Where the bases of the right and the left arm stand in W, (2, 3) m."""
    plant = MakeKinematicPlant()
    context = plant.CreateDefaultContext()
    frames = [plant.GetFrameByName("panda_link0", plant.GetModelInstanceByName(arm)) for arm in reversed(ARMS)]
    return np.array([frame.CalcPoseInWorld(context).translation() for frame in frames])
