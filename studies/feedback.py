"""The barrier around the real palms: soft arms, a box of another width, pushes; with the loop open and closed."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from drake_blfdmp.errors import TaskError
from drake_blfdmp.evaluation.studies.feedback_runs import (
    LOOPS,
    WORLDS,
    CarryOutIn,
    FeedbackRun,
    as_table,
    feedback_row,
)
from drake_blfdmp.evaluation.study import Claim, Study, StudyContext, Table
from drake_blfdmp.planning.plan import MakePlan, Plan
from drake_blfdmp.viewing.drawing import Drawing
from drake_blfdmp.viewing.study_figures import feedback as drawing

QUICK_WORLDS = ("box 10 mm wider",)
SHOWN = ("arms 0.4 x as stiff", "box 10 mm wider", "box 10 mm narrower", "pushed out, 40 N")
SLOWED = ("arms 0.4 x as stiff", "pushed back, 60 N", "pushed out, 60 N")

FORCE_WITHIN = 0.1
"""Of the planned force: how near the mean of the hold has to come with the loop closed."""

BACK_S = 0.1
"""Within which a push that takes the palms out of their band has to be answered, s."""

Runs = Mapping[tuple[str, str], FeedbackRun]


def study(context: StudyContext) -> Study:
    """Every world twice."""
    scenario, progress = context.scenario, context.progress
    worlds = {name: WORLDS[name] for name in QUICK_WORLDS} if context.quick else WORLDS
    if context.quick:
        # Coarser steps and no slowing down: the same code, not the same figures.
        simulation = replace(scenario.simulation, time_step=0.006, skill_time_step=0.006, record_rate_hz=50.0)
        scenario = replace(scenario, simulation=simulation, task=replace(scenario.task, duration_scale=1.0))
    plan = MakePlan(scenario, progress)
    if plan.box is None:
        raise TaskError("feedback: a motion without a box squeezes nothing; use task.kind=hold")
    runs = {}
    for world, reality in worlds.items():
        for loop, feedback in LOOPS.items():
            what = f"{world}, loop {loop}"
            runs[world, loop] = CarryOutIn(plan, reality, feedback, lambda share, what=what: progress(what, share))
    series = {key: _series(run) for key, run in runs.items()}
    wanted = planned_force(plan)
    shown = [world for world in SHOWN if world in worlds] or list(worlds)
    window = (plan.push_at_s - 0.3, plan.push_at_s + 0.9)
    windows = {world: window if world.startswith("pushed") else _hold(plan, runs[world, "closed"]) for world in shown}
    slowed = [world for world in SLOWED if world in worlds] or list(worlds)
    return Study(
        claims=[*widths(runs, wanted), *soft(runs, wanted), *pushes(runs, plan.push_at_s), *phase(runs), carried(runs)],
        figures={
            "bands": Drawing(
                drawing.bands,
                {world: {loop: series[world, loop] for loop in LOOPS} for world in shown},
                windows,
                wanted,
            ),
            "tempo": Drawing(
                drawing.tempos,
                {world: series[world, "closed"] for world in slowed},
                {world: _lag(runs[world, "closed"]) for world in slowed},
                _hold(plan, runs[slowed[0], "closed"]) if context.quick else window,
            ),
        },
        captions={
            "bands": "The palms' effective distance in the hands' band, and the force of the palm that presses less, "
            "with the loop around them open and closed; dashed: the planned force.",
            "tempo": "How far the palms' middle is off its place, and the tempo of the skill's clock that this leaves.",
        },
        tables={"runs": Table(as_table(runs))},
        notes=[
            "One plan, made for the believed box and arms, in every world. Effective distance: what the palms' force "
            "says of how far they are commanded together (docs/feedback.md); without contact their distance itself.",
            "The hold is judged from 0.5 s after the palms have closed. The first touch is an impact of a few samples "
            "of 10 ms, open or closed.",
        ],
        shown=["runs"],
    )


def planned_force(plan: Plan) -> float:
    """What the plan presses with by the arms' mean stiffness, N."""
    squeeze, compliance = plan.scenario.task.squeeze, plan.squeeze_compliance
    if squeeze is None:
        return float(plan.squeeze_force or 0.0)
    if compliance is None:
        raise TaskError("feedback: the plan has no compliance")
    return 2.0 * squeeze / compliance


def _series(run: FeedbackRun) -> drawing.Series:
    return drawing.Series(run.log.t, run.offset, run.half_width, run.log.palm_force, run.log.tempo)


def _lag(run: FeedbackRun) -> np.ndarray:
    return np.linalg.norm((run.log.palm - run.log.palm_desired)[..., 4:].mean(axis=1), axis=-1)


def _hold(plan: Plan, run: FeedbackRun) -> tuple[float, float]:
    t = run.log.t[run.held]
    return float(t[0]) - 1.0, float(t[-1])


def _said(row: dict) -> str:
    return (
        f"{row['force_least_n']:.0f}-{row['force_most_n']:.0f} N, mean {row['force_mean_n']:.0f} N, "
        f"{1e3 * row['outside_held_s']:.0f} ms outside"
    )


def _compared(title: str, runs: Runs, world: str, wanted: float) -> Claim:
    opened, closed = (feedback_row(runs[world, loop]) for loop in LOOPS)
    holds = closed["outside_held_s"] == 0.0 and abs(closed["force_mean_n"] - wanted) <= FORCE_WITHIN * wanted
    return Claim(
        f"Target: {title}, the robot's own hands stay in their band while they hold, and press as planned",
        f"planned {wanted:.0f} N. Closed: {_said(closed)}. Open: {_said(opened)}",
        holds,
        ""
        if holds
        else f"the correction is limited to {1e3 * LOOPS['closed'].largest:.0f} mm, or the band was left on the way",
    )


def widths(runs: Runs, wanted: float) -> list[Claim]:
    """A box of another width than believed."""
    return [
        _compared(f"with a {world}", runs, world, wanted)
        for world in ("box 10 mm wider", "box 10 mm narrower")
        if (world, "closed") in runs
    ]


def soft(runs: Runs, wanted: float) -> list[Claim]:
    """Tracking error: arms that yield more than the plan knows."""
    world = "arms 0.4 x as stiff"
    return [_compared(f"with {world}", runs, world, wanted)] if (world, "closed") in runs else []


def outside_after(run: FeedbackRun, start: float) -> float:
    """How long after `start`, s, the palms are outside of their band for the last time within the next second."""
    near = (run.log.t >= start) & (run.log.t <= start + 1.0)
    outside = near & (np.abs(run.offset) >= run.half_width)
    return float(run.log.t[outside][-1] - start) if outside.any() else 0.0


def pushes(runs: Runs, start: float) -> list[Claim]:
    """Forces on an arm."""
    worlds = [world for world, loop in runs if loop == "closed" and world.startswith("pushed")]
    if not worlds:
        return []
    last = {world: tuple(outside_after(runs[world, loop], start) for loop in LOOPS) for world in worlds}
    told = "; ".join(f"{world}: closed {1e3 * c:.0f} ms, open {1e3 * o:.0f} ms" for world, (o, c) in last.items())
    holds = all(closed <= BACK_S for _, closed in last.values())
    dropped = [world for world in worlds if feedback_row(runs[world, "closed"])["dropped"]]
    return [
        Claim(
            f"Target: pushed with 20-60 N for 0.2 s the palms are back in their band within {1e3 * BACK_S:.0f} ms",
            f"last outside after the push began: {told}",
            holds,
            ""
            if holds
            else "a push changes the force within some 10 ms; the law answers at its own 8 and 20 1/s, and the end of "
            "the push is a second disturbance",
        ),
        Claim(
            "Target: no push of 20-60 N for 0.2 s takes the box from the palms",
            f"dropped in {len(dropped)} of {len(worlds)} worlds with the loop closed",
            not dropped,
            "" if not dropped else f"dropped: {', '.join(dropped)}",
        ),
    ]


def phase(runs: Runs) -> list[Claim]:
    """Does the phase slow down where the arms are off their way, and resume?"""
    worlds = [world for world in SLOWED if (world, "closed") in runs]
    if not worlds:
        return []
    rows = {world: feedback_row(runs[world, "closed"]) for world in worlds}
    told = "; ".join(
        f"{world}: slowest {row['min_tempo']:.2f}, {abs(row['delay_s']):.2f} s later" for world, row in rows.items()
    )
    calm = feedback_row(runs["as believed", "closed"])["min_tempo"] if ("as believed", "closed") in runs else 1.0
    holds = (
        any(row["min_tempo"] < 1.0 for row in rows.values())
        and all(runs[world, "closed"].log.tempo[-1] > 0.99 for world in worlds)
        and calm == 1.0
    )
    return [
        Claim(
            "Target: the phase slows down where the arms are off their way by more than the slack, resumes, and loses "
            "no time otherwise",
            f"{told}; undisturbed: slowest {calm:.2f}",
            holds,
            "" if holds else "no error passed the slack, or the phase did not come back, or undisturbed it slowed down",
        )
    ]


def carried(runs: Runs) -> Claim:
    """Is the box carried in every world?"""
    failed = {key: run.summary["failures"] for key, run in runs.items() if not run.summary["success"]}
    closed = [world for world, loop in failed if loop == "closed"]
    opened = [world for world, loop in failed if loop == "open"]
    return Claim(
        "Target: the box is carried and placed in every world",
        f"no success with the loop closed: {', '.join(closed) or 'none'}; open: {', '.join(opened) or 'none'}",
        not closed,
        " ".join(sentence for key, sentences in failed.items() if key[1] == "closed" for sentence in sentences),
    )
