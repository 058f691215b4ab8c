"""One random task carried out with one law, and the row that says what came of it."""

import hashlib
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from drake_blfdmp.errors import BlfDmpError
from drake_blfdmp.evaluation.robustness.classes import failure_classes, planning_verdict
from drake_blfdmp.evaluation.robustness.tasks import HARDER, RandomTask, draw_task, task_scenario
from drake_blfdmp.evaluation.simulation import Judge
from drake_blfdmp.planning.plan import MakePlan
from drake_blfdmp.planning.planned import Plan
from drake_blfdmp.planning.scenario import DumpScenario, Scenario


@dataclass(frozen=True)
class Trial:
    """A task, a law, and the scenario that carries out both; it may be planned only, to see whether it is refused."""

    task: RandomTask
    law: str
    scenario: Scenario
    planned_only: bool = False

    @property
    def key(self) -> str:
        """What its row is known by: another seed, task, law or setting has another."""
        digest = hashlib.sha256(DumpScenario(self.scenario).encode()).hexdigest()[:12]
        return f"{self.scenario.name}-{digest}{'-planned' if self.planned_only else ''}"

    def run(self) -> dict:
        """Plan, simulate and judge: the trial's row, in plain numbers and text, for JSON.

        Returns:
            `verdict` and `classes` as in `classes`, "planned" where that was all; `message`: why it was refused, or
            each missed threshold's sentence; `notes`: what the planner changed; `measured`: numbers of the summary and
            the plan, None where nothing was simulated; `plan_s`, `run_s`: wall time.
        """
        row = self.crashed("")
        started = time.perf_counter()
        try:
            plan = MakePlan(self.scenario)
        except BlfDmpError as error:
            verdict, kind = planning_verdict(error, self.law)
            told = {"verdict": verdict, "classes": [kind], "message": str(error)}
            return row | told | {"plan_s": time.perf_counter() - started}
        planned = time.perf_counter()
        if self.planned_only:
            return row | {"verdict": "planned", "classes": [], "notes": list(plan.notes), "plan_s": planned - started}
        try:
            summary = Judge(plan)
        except BlfDmpError as error:  # A number that is not finite, say.
            told = {"verdict": "failure", "classes": ["diverged"], "message": str(error)}
            return row | told | {"plan_s": planned - started, "run_s": time.perf_counter() - planned}
        return row | {
            "notes": list(plan.notes),
            "verdict": "success" if summary["success"] else "failure",
            "classes": failure_classes(summary),
            "message": " ".join(summary["failures"]),
            "measured": measured(plan, summary),
            "plan_s": planned - started,
            "run_s": time.perf_counter() - planned,
        }

    def crashed(self, error: str) -> dict:
        """The row of a trial whose process raised what no user can cause, died, or did not end."""
        return {
            "key": self.key,
            "law": self.law,
            "task": self.task.as_dict(),
            "verdict": "crash",
            "classes": ["crash"],
            "message": error,
            "notes": [],
            "measured": None,
            "plan_s": None,
            "run_s": None,
        }


def make_trials(base: Scenario, law: str, count: int) -> list[Trial]:
    """The first `count` tasks of the base's seed, with a law."""
    tasks = [draw_task(base.seed, index) for index in range(count)]
    return [Trial(task, law, task_scenario(base, task, law)) for task in tasks]


def make_harder_trials(base: Scenario, count: int) -> list[Trial]:
    """The first `count` tasks of the base's seed from the ranges `HARDER`, with the default law, to be planned only."""
    trials = []
    for index in range(count):
        task = draw_task(base.seed, index, HARDER)
        scenario = task_scenario(base, task, "default")
        name = f"harder-{task.seed}-{index:04d}"
        trials.append(Trial(task, "default", replace(scenario, name=name), planned_only=True))
    return trials


def write_failures(folder: Path, trials: Sequence[Trial], rows: Sequence[Mapping]) -> list[Path]:
    """Write the scenario of every trial that was refused, failed or crashed: `python run.py --scenario FILE`.

    Args:
        folder: is made where there is something to write.
        rows: of the trials.

    Returns:
        The files.
    """
    written = []
    for trial, row in zip(trials, rows, strict=True):
        if row["verdict"] in ("success", "planned"):
            continue
        folder.mkdir(exist_ok=True)
        written.append(folder / f"{trial.scenario.name}.yaml")
        told = " ".join(f"{row['verdict']} ({', '.join(row['classes'])}): {row['message']}".split())
        written[-1].write_text(f"# {told}\n{DumpScenario(trial.scenario)}", encoding="utf-8")
    return written


def measured(plan: Plan, summary: dict) -> dict:
    """The numbers of a row, by the names that the summary has for them."""
    if plan.start is None or plan.goal is None:
        raise ValueError("a trial is about a box")
    box, robot, links = summary["box"], summary["robot"], summary["links"].values()
    low, high = box["squeeze_force_n"]
    return {
        **{name: robot[name] for name in ("min_joint_margin_rad", "max_velocity_ratio", "max_effort_ratio")},
        **{name: robot[name] for name in ("min_clearance_m", "palm_tracking_rms_m")},
        **{name: box[name] for name in ("lifted_m", "placement_error_m", "max_tilt_deg", "dropped", "max_slip_m")},
        "least_force_n": low,
        "greatest_force_n": high,
        "violations": sum(link["violations"] for link in links),
        "largest_excess_m": max(link["largest_excess_m"] for link in links),
        "scale": plan.retarget.scale,
        "stretch": plan.stretch,
        "duration_s": plan.duration_s,
        "start_m": [float(value) for value in plan.start[4:]],
        "goal_m": [float(value) for value in plan.goal[4:]],
    }
