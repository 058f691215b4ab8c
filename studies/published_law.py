"""Five facts about the published law (7)-(13) that the paper does not say, each as a number."""

from collections.abc import Mapping

import numpy as np

from drake_blfdmp.evaluation.studies import one_axis_facts as trials
from drake_blfdmp.evaluation.studies.law_metrics import measure, roll_out_law, turned
from drake_blfdmp.evaluation.studies.one_axis import OneAxisResult
from drake_blfdmp.evaluation.study import Claim, Study, StudyContext, Table
from drake_blfdmp.planning.sources import LoadSource
from drake_blfdmp.planning.task import MakeMotion, MakeTask
from drake_blfdmp.skeleton import LINKS
from drake_blfdmp.viewing.drawing import Drawing
from drake_blfdmp.viewing.study_figures.one_axis import Trial, facts, growth


def shown(runs: Mapping[str, OneAxisResult]) -> dict[str, Trial]:
    """What the figure shows of trials."""
    return {name: Trial(run.t, run.x, run.error, run.half_width) for name, run in runs.items()}


def study(context: StudyContext) -> Study:
    """The trials take a few seconds; `quick` takes longer steps on one axis."""
    h = 5e-4 if context.quick else 1e-4
    context.progress("one axis", 0.1)
    line = trials.on_the_line()
    moving, crossed = trials.in_a_moving_band(h), trials.crossed_at(h)
    goals, lagged, grows = trials.with_a_goal_elsewhere(), trials.lagged(), trials.lagged_growth()
    roots = trials.largest_lagged_roots(200 if context.quick else 2000, context.scenario.seed)
    signs = trials.both_signs(h)
    ends = {name: float(abs(run.x[-1] - trials.OWN_GOAL)) for name, run in goals.items()}
    apart = float(np.abs(goals["published"].x - goals["published, goal 0"].x).max())
    printed, fed = moving.values()
    rates, never = np.array(trials.RATES), np.isinf(crossed)

    context.progress("the task", 0.6)
    scenario = context.scenario
    source = LoadSource(scenario)
    task = MakeTask(scenario, source, MakeMotion(scenario, source))
    laws = {"demonstrated": "none", "default": "default", "published": "published"}
    runs = {name: roll_out_law(scenario, task, law) for name, law in laws.items()}
    angles = {name: turned(run.x).max(axis=0) for name, run in runs.items()}
    default, published = (measure(runs[name], task, name) for name in ("default", "published"))
    paper, length = task.bands.paper().evaluate(0.0), runs["default"].lengths[0]
    outside = [link.name.replace("_", " ") for i, link in enumerate(LINKS) if not paper[0, i] < length[i] < paper[1, i]]
    off = 1e3 * np.abs(length - task.bands.desired(0.0)[0]).max()
    ratio = angles["published"] / angles["demonstrated"]

    context.progress("drawing", 0.9)
    zero, damped = np.abs(line.printed).max(), np.abs(line.damped).max()
    grows_as_predicted = all(abs(one.measured / one.predicted - 1.0) < 0.01 for one in grows.values())
    return Study(
        claims=[
            Claim(
                "V' < 0 along the law (proof of Theorem 1)",
                f"V' at {len(line.share)} states on z_1 - mid = z_2 / 2 is at most {zero:.1e} 1/s in size, off the "
                f"origin; with a damping k_2 = {trials.DAMPING:g} m/s it reaches -{damped:.1e} 1/s there",
                zero > 0.0,
                "only semi-definite: zero on a line through the origin" if zero == 0.0 else "",
            ),
            Claim(
                "the bounds kappa may vary in time: the output constraint is never violated",
                f"unit gains, half width 0.01 m, d moving by 0.1 sin 3t m: crossed after {printed.left_at:.3f} s; with "
                f"the middle fed forward never, error at most {1e3 * np.abs(fed.error).max():.2f} mm. k_z / (d_z tau) "
                f"of {', '.join(f'{rate:g}' for rate in rates[~never])} 1/s cross, of "
                f"{', '.join(f'{rate:g}' for rate in rates[never]) or 'none'} 1/s do not",
                bool(np.isinf(printed.left_at)),
                "" if np.isinf(printed.left_at) else "alpha_2' in (9) holds no kappa': high gains can only hide it",
            ),
            Claim(
                "the output is determined by f(s) and z_2 together (12)",
                f"published: goal 0.15 m from where the partner leads, it ends {ends['published']:.3f} m from it; "
                f"another goal changes the path by {apart:.1e} m; the loop solved ends {ends['loop']:.3f} m from it. "
                f"On the task the published law ends {published.from_goal_m:.2f} m from its goal, the default "
                f"{default.from_goal_m:.2f} m",
                apart > 1e-3,
                "z_2' / d_z along the uncoupled primitive cancels f(s) and the goal: a pure follower"
                if apart <= 1e-3
                else "",
            ),
            Claim(
                "(12) can be calculated with the previous sample's v', as Fig. 3 circulates it",
                f"leaves a constant band after {lagged.left_at:.3f} s (step 1 ms, 2 mm off the middle); "
                "|a_k - a_(k-1)| grows a sample by "
                + " and ".join(
                    f"{one.measured:.4f} (predicted {one.predicted:.4f}) at {1e3 * step:g} ms"
                    for step, one in grows.items()
                )
                + f"; {np.sum(roots > 1.0)} of {len(roots)} random slopes and steps have a root outside the unit "
                f"circle, the least by {roots.min() - 1.0:.1e}",
                bool(np.isinf(lagged.left_at)) and not grows_as_predicted,
                "a growing mode of period two for every gain and step (proof in docs/laws.md)",
            ),
            Claim(
                "z_1 = k_z (x - x_partner), as the definition before (5) can be read",
                f"own minus partner leaves the band after {signs['own minus partner'].left_at:.3f} s from 1 mm off the "
                "middle; partner minus own never, and ends "
                f"{1e3 * abs(signs['partner minus own'].error[-1]):.4f} mm off",
                bool(np.isinf(signs["own minus partner"].left_at)),
                "with that sign alpha_2 pushes away from the middle; partner minus own is meant",
            ),
            Claim(
                "decomposing (5) to axes constrains the distance only",
                "largest turn of a link over the task, published by demonstrated: "
                + ", ".join(
                    f"{link.name.replace('_', ' ')} {np.degrees(a):.0f}° of {np.degrees(b):.0f}°"
                    for link, a, b in zip(LINKS, angles["published"], angles["demonstrated"], strict=True)
                )
                + "; default "
                + ", ".join(f"{np.degrees(a):.0f}°" for a in angles["default"]),
                bool(np.all(ratio > 0.8)),
                "three degrees of freedom are bound: tangential motion is damped, the links' directions are nearly held"
                if np.any(ratio <= 0.8)
                else "",
            ),
            Claim(
                "the theorem's start, inside the bands, is that of a recording",
                f"at t = 0 outside the paper's bands: {', '.join(outside) or 'none'} (up to {off:.0f} mm off). In "
                f"funnels opened to the start {default.outside} of {default.samples} samples are outside (default, "
                f"least margin {default.least_margin:.2f}; published {published.outside}); the paper's own bands are "
                f"met after {default.until_inside} (default) and {published.until_inside} samples at 30 Hz (published; "
                "the paper: about 15)",
                not outside,
                "recordings start outside; the funnel makes the premise true" if outside else "",
            ),
        ],
        figures={
            "facts": Drawing(
                facts,
                line.share,
                {"$k_2$ = 0": line.printed, f"$k_2$ = {trials.DAMPING:g} m/s": line.damped},
                shown(moving),
                shown(goals),
                trials.OWN_GOAL,
                shown({"lagged": lagged})["lagged"],
                shown(signs),
                angles,
            ),
            "growth": Drawing(
                growth,
                {step: one.change[-40:] for step, one in grows.items()},
                {step: one.predicted for step, one in grows.items()},
            ),
        },
        captions={
            "facts": "What the paper does not say of its law: V' vanishes on a line, a moving band is crossed, the "
            "goal cancels, the lagged reading diverges, the sign of z_1 matters, and links hardly turn.",
            "growth": "The lagged reading: change of the acceleration from sample to sample, and the growth that its "
            "largest root predicts.",
        },
        tables={
            "crossing": Table({"k_z_by_d_z_tau_1_per_s": rates, "crossed_at_s": crossed}),
            "turn": Table(
                {"link": [link.name for link in LINKS]} | {f"{name}_rad": values for name, values in angles.items()}
            ),
        },
        notes=[
            "One-axis trials: tau 1 s, no forcing, start at rest at the middle of the band unless said otherwise. The "
            "goal of fact 3 is chosen 0.15 m off where the partner leads; that the end is as far off is then what a "
            "follower does."
        ],
        shown=["crossing", "turn"],
    )
