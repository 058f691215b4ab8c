"""Random tasks: how often each law carries the box, what fails and why, and whether what is refused cannot be done."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from drake_blfdmp.evaluation.robustness import claims
from drake_blfdmp.evaluation.robustness.campaign import Job, run_jobs
from drake_blfdmp.evaluation.robustness.claims import share_claim
from drake_blfdmp.evaluation.robustness.quick import quick_base
from drake_blfdmp.evaluation.robustness.rates import LawRates, by_group, feasible_tasks, law_rates, values
from drake_blfdmp.evaluation.robustness.refusals import refusal_table, refusals_right, sample
from drake_blfdmp.evaluation.robustness.tables import class_table, group_table, law_table, task_table
from drake_blfdmp.evaluation.robustness.trial import make_harder_trials, make_trials, write_failures
from drake_blfdmp.evaluation.study import Study, StudyContext
from drake_blfdmp.viewing.drawing import Drawing
from drake_blfdmp.viewing.study_figures import robustness as drawing

QUICK_TASKS = {"default": 1, "none": 1}


def study(context: StudyContext) -> Study:
    """Run what the file of results does not have yet, and judge."""
    with TemporaryDirectory() as nowhere:
        return carry_out(context, context.folder or Path(nowhere))


def carry_out(context: StudyContext, folder: Path) -> Study:
    """The study, its files in `folder`."""
    scenario, settings = context.scenario, context.scenario.robustness
    base = quick_base(scenario) if context.quick else scenario
    asked = QUICK_TASKS if context.quick else {law: count for law, count in settings.tasks.items() if count}
    laws = sorted(asked, key=lambda law: law != "default")
    trials = [trial for law in laws for trial in make_trials(base, law, asked[law])]
    path = folder / "results.jsonl" if settings.results is None else Path(settings.results)

    def run(jobs: Sequence[Job], what: str) -> list[dict]:
        return run_jobs(
            jobs,
            path,
            workers=context.workers,
            timeout_s=settings.timeout_s,
            progress=lambda done, of: context.progress(f"{of} {what}", done / max(of, 1)),
        )

    rows = run(trials, "trials")
    write_failures(folder / "failures", trials, rows)
    own = asked["default"]  # The default law's trials stand first.
    harder = [] if context.quick else make_harder_trials(base, settings.harder)
    planned = run(harder, "harder tasks planned")
    write_failures(folder / "refused", harder, planned)
    asked_again = sample([*trials[:own], *harder], [*rows[:own], *planned], settings.refusals)
    checked = run(asked_again, "refusals looked at once more")

    context.progress("drawing", 1.0)
    of_law = {law: [row for row in rows if row["law"] == law] for law in laws}
    feasible = feasible_tasks(of_law["default"])
    rates = {law: law_rates(law, found, feasible) for law, found in of_law.items()}
    tables = {
        "laws": law_table(rates),
        "failures": class_table(rates),
        "sensors": group_table("sensor", by_group(of_law["default"], "sensor")),
        "tasks": task_table(rows),
    } | ({"refusals": refusal_table(checked)} if checked else {})
    refused = share_claim(
        f"target: at least {100 * claims.RIGHT:g} % of refusals for reach, force or clearance are right",
        refusals_right(checked),
        claims.RIGHT,
        "the table of refusals says which are not, or could not be shown",
    )
    shown = {law: one for law, one in rates.items() if one.success is not None}
    return Study(
        claims=[*claims.default_claims(of_law["default"], rates["default"]), refused, claims.law_claim(rates)],
        figures={
            "success": Drawing(drawing.success, {law: shares(one) for law, one in shown.items()}, claims.SHARE),
            "classes": Drawing(
                drawing.failures,
                {law: one.classes for law, one in shown.items()},
                {law: one.feasible for law, one in shown.items()},
            ),
            "where": Drawing(drawing.where, *places(of_law["default"])),
            "accuracy": Drawing(
                drawing.accuracy,
                {law: values(found, "placement_error_m") for law, found in of_law.items()},
                {law: values(found, "max_tilt_deg") for law, found in of_law.items()},
                {
                    "placement_m": ((0.5, claims.PLACEMENT_MEDIAN_M), (0.95, claims.PLACEMENT_95_M)),
                    "tilt_deg": claims.TILT_DEG,
                },
            ),
        },
        captions={
            "success": "Share of the feasible tasks that succeed, and in which the box is carried and placed within "
            "every limit, whatever the links do; dashed: the target.",
            "classes": "What fails, by the first class of each failure.",
            "where": "Every task of the default law, over what was drawn; below, where the box stands and goes, of "
            "those that were planned.",
            "accuracy": "Share of runs that place the box at least so closely, and tilt it at most so far.",
        },
        tables=tables,
        notes=[
            "A task is feasible when the planner with the default law does not refuse it; the other laws are judged "
            "by the same tasks.",
            "Duration is that of the person's motion between its rests (timing.speed); where the arms need longer, the "
            "planner slows the motion down further.",
            "Each trial that is no success stands as a scenario in the folder `failures`: python run.py --scenario "
            "FILE.",
            "An interrupted study goes on with --set robustness.results=<its results.jsonl>.",
        ],
        shown=["laws", "failures", "sensors", *(["refusals"] if checked else [])],
    )


def places(rows: Sequence[Mapping]) -> tuple[dict[str, np.ndarray], list[str], dict[str, np.ndarray]]:
    """What the figure needs of the default law's rows."""
    nowhere = [np.nan] * 3
    ends = {
        name: np.array([row["measured"][name] if row["measured"] else nowhere for row in rows]).reshape(-1, 3)
        for name in ("start_m", "goal_m")
    }
    tasks = {name: np.array([row["task"][name] for row in rows], dtype=float) for name in drawing.DRAWN}
    return tasks, [row["verdict"] for row in rows], ends


def shares(rates: LawRates) -> tuple[drawing.Interval, drawing.Interval, int]:
    """What the figure needs of a law's rates."""
    if rates.success is None or rates.physical is None:
        raise ValueError(f"law {rates.law}: no feasible task")
    found = [(one.share, one.lower, one.upper) for one in (rates.success, rates.physical)]
    return found[0], found[1], rates.feasible
