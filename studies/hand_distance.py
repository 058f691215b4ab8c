"""Fig. 10: the hands' distance with every law, the search for their gains, and the learning of Gams et al."""

from dataclasses import replace

import numpy as np

from drake_blfdmp.demonstration.bones import link_lengths
from drake_blfdmp.evaluation.metrics import RECORDING_RATE
from drake_blfdmp.evaluation.studies import law_comparison as compare
from drake_blfdmp.evaluation.studies.gain_search import DURATIONS, GRIDS, best_for_all, search_steps
from drake_blfdmp.evaluation.studies.law_comparison import told
from drake_blfdmp.evaluation.studies.resting import resting_distances
from drake_blfdmp.evaluation.study import Claim, Study, StudyContext
from drake_blfdmp.planning.sources import LoadSource
from drake_blfdmp.planning.task import LawGains, MakeMotion, MakeTask
from drake_blfdmp.skeleton import HANDS
from drake_blfdmp.viewing.drawing import Drawing
from drake_blfdmp.viewing.study_figures.laws import HandsBand, hand_distances, learning

TITLES = {"constant": "$d_j$ = 0.30 m", "moving": "$d_j(t)$ of the task"}
COMPETITORS = ("published", "published_loop", "gams")
START = 1.0
"""s, shown on its own; the opened funnels have closed to within 1 cm of (20) by then."""


def study(context: StudyContext) -> Study:
    """The two cases, the lagged reading, the resting distance; `quick` takes a long step and fewer gains."""
    scenario, quick = context.scenario, context.quick
    source = LoadSource(scenario)
    motion = MakeMotion(scenario, source)
    task = MakeTask(scenario, source, motion)
    durations = () if quick else tuple(MakeTask(scenario, source, motion, share) for share in DURATIONS)
    step = 0.005 if quick else scenario.simulation.skill_time_step

    def case(name: str, one, searched, begin: float, **how) -> compare.Case:
        def progress(what: str, share: float) -> None:
            context.progress(f"{name} d_j, {what}", begin + 0.35 * share)

        return compare.compare_case(scenario, one, searched, time_step=step, quick=quick, progress=progress, **how)

    # The scenario's gains are those for the task; for the constant distance every competitor brings its best.
    constant = case("constant", compare.with_constant_distance(task), COMPETITORS, 0.0, with_best=True)
    moving = case("moving", task, tuple(GRIDS), 0.35, with_best=False, search_on=durations)
    cases = {"constant": constant, "moving": moving}
    context.progress("lagged reading", 0.7)
    steps = (1 / 30, 0.01, 0.004) if quick else (1 / 30, 0.01, 0.004, 0.002, 0.001)
    lagged = search_steps(task, "published_lagged", time_steps=steps, duration=1.0 if quick else 2.0)
    context.progress("resting distance", 0.85)
    steps, accuracy = ((0.016, 0.008), 1e-5) if quick else ((0.002, 0.001), 1e-8)
    resting = resting_distances(task, time_steps=steps, accuracy=accuracy)
    formula, simulated = resting.columns["resting_distance_m"][:2]

    t = moving.runs["default"].t
    shown_at = np.interp(t, task.motion.t, task.motion.recorded)
    recorded = np.interp(shown_at, source.demonstration.t, link_lengths(source.demonstration.x)[:, HANDS])
    used = {name: LawGains(replace(scenario, law=name)) for name in COMPETITORS}
    published = moving.searches["published"]
    together = published.gains_of(best_for_all([published, moving.searches["published_loop"]]))
    followed = moving.outside("gams") == 0
    feedback, first = moving.runs["gams"].hands, moving.epochs[0].rollout.lengths[:, HANDS]
    lags = [moving.lag(hands, START) for hands in (feedback, first, compare.learned(moving))]
    until = {name: one.runs["default"].result.until_inside for name, one in cases.items()}
    kept = all(one.outside("default") == 0 and until[name] is not None for name, one in cases.items())
    agree = abs(simulated - formula) < 1e-5
    survivors, longest = sum(lagged.columns["that_keep_all_bands"]), max(lagged.columns["longest_inside_s"])
    theorem = constant.outside("published") == constant.outside("published_loop") == 0
    in_use = (together, together, moving.best("gams")) == tuple(used.values())
    in_use = in_use and all(moving.outside(name) == 0 for name in COMPETITORS)
    searched = "; ".join(compare.how_searched(constant, name, used[name]) for name in COMPETITORS)

    return Study(
        claims=[
            Claim(
                "the modified distance keeps the bounds (20) (opened to the start's error, target of the project)",
                "; ".join(
                    f"{name} d_j: {one.outside('default')} of {len(t)} samples outside, the paper's own bands met for "
                    f"good after {until[name]} samples at 30 Hz"
                    for name, one in cases.items()
                ),
                kept,
                "" if kept else "table laws says where",
            ),
            Claim(
                "[17] keeps the distance around 0.305 m when 0.300 m is asked for",
                f"goals 0.40 m apart, beta_z 12, c k 100: the continuous diagram comes to rest at {simulated:.9f} m, "
                f"{abs(simulated - formula):.0e} m from the closed form's {formula:.9f} m",
                agree,
                "" if agree else "simulation and closed form differ by more than 1e-5 m",
            ),
            Claim(
                "[17] cannot follow a moving d_j",
                f"given the moving d_d, the feedback alone is off by at most {1e3 * lags[0]:.1f} mm from {START:g} s "
                f"on ({told(used['gams'])}; {1e3 * lags[1]:.1f} mm without c_2), with {moving.outside('gams')} of "
                f"{len(t)} samples outside; without c_2 after {len(moving.epochs)} epochs by {1e3 * lags[2]:.2f} mm",
                not followed,
                "the law couples velocity and acceleration, and C' holds d_d': it follows, without a guarantee and "
                "with the bones uncoupled"
                if followed
                else "",
            ),
            Claim(
                "Theorem 1: the output never leaves its bounds, here those around a constant d_j",
                f"d_j = 0.30 m, the hands start {1e3 * abs(constant.epochs[0].error[0]):.0f} mm off, funnels opened "
                f"to that. With the best gains of a search on this case: {searched}. "
                f"default, with the task's gains: {constant.outside('default')}",
                theorem,
                "" if theorem else "no gains of the grid keep the narrowing funnel from this start",
            ),
            Claim(
                "some gains let the lagged reading of (12), that of Fig. 3, keep its bands",
                f"{survivors} of {sum(lagged.columns['gains_tried'])} combinations of gains and steps do; the longest "
                f"stays inside for {longest:.3f} s",
                survivors > 0,
                ""
                if survivors
                else "a root of the linearised law lies below -1 for any gain and step; see docs/laws.md",
            ),
            Claim(
                "the gains in use are those of the search, and keep the bands (target of the project)",
                f"found: published and loop together {told(together)}; gams {told(moving.best('gams'))}. In use: "
                f"{told(used['published'])}; {told(used['gams'])}. Each for itself: published "
                f"{told(moving.best('published'))}, loop {told(moving.best('published_loop'))}",
                True if in_use else None if quick else False,
                "" if in_use else "the quick search ends after 2 s" if quick else "tables laws and search_ say where",
            ),
        ],
        figures={
            "hand_distance": Drawing(
                hand_distances,
                t,
                recorded,
                {title: HandsBand.of(cases[name].task.bands, t) for name, title in TITLES.items()},
                {title: {law: run.hands for law, run in cases[name].runs.items()} for name, title in TITLES.items()},
                {title: compare.learned(cases[name]) for name, title in TITLES.items()},
                start=START,
                rate=RECORDING_RATE,
            ),
            "learning": Drawing(
                learning,
                {
                    f"{name} $d_j$": (
                        np.array([e.rms for e in one.epochs]),
                        np.array([e.settled_rms for e in one.epochs]),
                    )
                    for name, one in cases.items()
                },
                START,
            ),
        },
        captions={
            "hand_distance": "The hands' distance with every law (Fig. 10), constant and moving d_j: all of it, the "
            "first second, and what is left to d_j. The lagged reading leaves at once.",
            "learning": "Iterative learning of Gams et al. (Q 0.99, L 1): what is left of the hands' error after each "
            "epoch.",
        },
        tables={
            "laws": compare.laws_table(cases),
            "resting": resting,
            "search_lagged_steps": lagged,
            "epochs": compare.epochs_table(cases),
            "curves": compare.curves_table(t, recorded, cases),
        }
        | {
            f"search_{name}_{law}": search.table()
            for name, one in cases.items()
            for law, search in one.searches.items()
        },
        notes=[
            "The paper's recording and gains were never published: the scenario's recording stands in, gains are "
            "searched for by one criterion for all laws (fewest samples outside the bands of the links a law couples, "
            "then least distance to the demonstration): those in use on the task at "
            f"{DURATIONS[0]:g} to {DURATIONS[-1]:g} times its duration, those for the constant d_j on that case.",
            f"The learning leaves {1e3 * constant.epochs[-1].settled_rms:.3f} mm (constant) and "
            f"{1e3 * moving.epochs[-1].settled_rms:.3f} mm (moving) RMS from {START:g} s on; the error at the start "
            "stays, since no reference can undo where the hands begin.",
            "Gams et al. couple the hands alone: their distance to the demonstration is smaller for it, and the bones "
            "go unchecked.",
            "Sampled, the coupling of Gams et al. is held beside spring and damper, which moves its resting distance "
            "in proportion to the step (table resting).",
            "The learning is without c_2: with a large one the error at the start fades slowly, and no reference can "
            "undo it.",
        ],
        shown=["laws", "resting", "search_lagged_steps", "epochs"],
    )
