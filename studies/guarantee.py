"""Beyond the paper: how often each law leaves its bands on random starts, goals, durations, bands and gains."""

from dataclasses import replace

from drake_blfdmp.evaluation.studies.guarantee_metrics import by_link, by_problem, by_run, outside_axes, violations
from drake_blfdmp.evaluation.studies.intervals import proportion
from drake_blfdmp.evaluation.studies.law_comparison import told
from drake_blfdmp.evaluation.studies.random_gain_search import search_on_problems
from drake_blfdmp.evaluation.studies.random_problems import Job, Spread, draw_problems, run_jobs
from drake_blfdmp.evaluation.study import Claim, Study, StudyContext
from drake_blfdmp.planning.sources import LoadSource
from drake_blfdmp.planning.task import LawGains, MakeMotion, MakeTask
from drake_blfdmp.skeleton import HANDS
from drake_blfdmp.skill.laws import LAWS
from drake_blfdmp.viewing.drawing import Drawing
from drake_blfdmp.viewing.study_figures import random_problems as drawing

COUNT, COMPARED, SEARCHED = 10_000, 1000, 40
QUICK_COUNT, QUICK_COMPARED, QUICK_SEARCHED, QUICK_STEPS, QUICK_TAU = 60, 20, 3, 5.0, (0.5, 0.6)

ANY_GAINS, ITS_GAINS, OPENED = "default", "default, one pair of gains", "published, wider funnel"
AXIS_FILLING = 0.5
"""Below 1 / sqrt(3): the published law's axes, too, all start inside their bounds."""


def study(context: StudyContext) -> Study:
    """All problems with the default law, the first of them with every other one."""
    scenario, quick = context.scenario, context.quick
    context.progress("drawing problems", 0.0)
    source = LoadSource(scenario)
    task = MakeTask(scenario, source, MakeMotion(scenario, source))
    step = scenario.simulation.skill_time_step * (QUICK_STEPS if quick else 1.0)
    spread = Spread(tau=QUICK_TAU) if quick else Spread()
    problems = draw_problems(task.skill, QUICK_COUNT if quick else COUNT, scenario.seed, step, spread)
    few = problems[: QUICK_COMPARED if quick else COMPARED]
    base = Job(task.skill, task.bands.bones, task.bands.rate, problems, "default", step)
    gains = scenario.gains
    workers = 1 if quick else context.workers
    others = draw_problems(task.skill, QUICK_SEARCHED if quick else SEARCHED, scenario.seed + 1, step, spread)
    best, search = search_on_problems(
        base, others, workers=workers, progress=lambda share: context.progress("searching gains", share)
    )
    jobs = {ANY_GAINS: base, ITS_GAINS: replace(base, problems=few.with_gains(gains.k_1, gains.k_2))}
    for law in LAWS:
        if law != "default":
            own = best.get(law, LawGains(replace(scenario, law=law)))
            jobs[law] = replace(base, problems=few, law=law, gains=own)
            if law == "published":
                jobs[OPENED] = replace(jobs[law], filling=AXIS_FILLING)
    found = run_jobs(list(jobs.values()), workers, lambda share: context.progress("running", share))
    outcomes = dict(zip(jobs, found, strict=True))

    context.progress("drawing", 0.0)
    left = {name: violations(outcome) for name, outcome in outcomes.items()}
    relative = {name: outcome.left_s.min(axis=1) / jobs[name].problems.tau for name, outcome in outcomes.items()}
    steps = sum(float((job.problems.tau / step).sum()) for job in jobs.values())
    outside = int(outside_axes(few.start, few.bands(task.bands.bones, task.bands.rate)).sum())
    hands_only = proportion(int(outcomes["gams"].left[:, HANDS].sum()), len(few))

    def kept(name: str, says: str, why: str) -> Claim:
        measured = f"bands left in {left[name].percent()}; least margin {outcomes[name].least.min():.3g}"
        return Claim(says, measured, left[name].count == 0, "" if left[name].count == 0 else why)

    return Study(
        claims=[
            kept(
                ANY_GAINS,
                f"target: the default law leaves no band, at {1 / step:g} Hz with any gains that are allowed there",
                "the table of problems says with which gains, durations and bands",
            ),
            kept(ITS_GAINS, "target: nor with the scenario's gains", "the table says on which links"),
            kept(
                "published",
                "Theorem 1: the published law keeps every distance within its bounds",
                f"the theorem holds for constant bounds and a start inside; these bounds move, and {outside} of "
                f"{len(few)} problems start outside the bound of an axis",
            ),
            kept(
                OPENED,
                "the same with the funnels opened until every axis starts inside",
                "moving bounds and partners that do not wait for those who follow are not in the theorem",
            ),
            kept(
                "published_loop", "the same, the loop of (12) solved", "half of the motion is the uncoupled primitive"
            ),
            kept("published_lagged", "the same, (12) with the previous sample", "it diverges with any gains"),
            Claim(
                "[17] keeps the hands within their bounds",
                f"hands' band left in {hands_only.percent()}; any band in {left['gams'].percent()}",
                hands_only.count == 0,
                "" if hands_only.count == 0 else "a spring has no barrier; the bones are not coupled at all",
            ),
            Claim(
                "these problems are no easy ones: without coupling, bands are left",
                f"in {left['none'].percent()}",
                left["none"].share > 0.9,
                "" if left["none"].share > 0.9 else "the problems are too easy to tell laws apart",
            ),
        ],
        figures={
            "violations": Drawing(drawing.shares, left),
            "least_margins": Drawing(drawing.least_margins, outcomes[ANY_GAINS].least),
            "first_times": Drawing(drawing.first_times, relative),
        },
        captions={
            "violations": "Problems in which a link leaves its band, with exact 95 % confidence intervals; an arrow: "
            "none was seen, and the true share is below its end.",
            "least_margins": f"Least margins of {len(problems)} problems with the default law; 0.2 is where a funnel "
            "that is opened to the start begins, 1 the middle of the band.",
            "first_times": "Share of the problems in which some band has been left, over time.",
        },
        tables={
            "violations": by_run(outcomes),
            "links": by_link(outcomes),
            "problems": by_problem(problems, outcomes[ANY_GAINS]),
            "search": search,
        },
        notes=[
            f"Every problem has its own start (every coordinate moved by {spread.start_m:g} m rms, the hands' "
            f"distance off by up to {spread.hands_error_m:g} m), goal (every coordinate {spread.goal_m:g} m rms, so "
            f"at odds with the bones), duration ({spread.tau[0]:g} to {spread.tau[1]:g} times the skill's "
            f"{task.skill.tau:.2f} s, run to its end), box, closing and opening, half width "
            f"({1e3 * spread.half_width_m[0]:g} to {1e3 * spread.half_width_m[1]:g} mm), funnel and, for the default "
            f"law, gains; {steps:.3g} problem-steps in all.",
            "Every funnel is opened so that a link fills 0.8 of its own at the start. Judged by the distance, that is "
            f"where every law starts inside. The published law's axes have 1/sqrt(3) of it each: in {outside} of "
            f"{len(few)} problems it starts outside on one, so a second run opens its funnels to {AXIS_FILLING:g}.",
            f"The competitors' gains are the best on {len(others)} other problems of the same kind (table search): "
            + "; ".join(f"{law} {told(gains)}" for law, gains in best.items())
            + ". Those of the default law are drawn at random.",
            "Intervals are those of Clopper and Pearson, for each law on its own.",
        ],
        shown=["violations", "links"],
    )
