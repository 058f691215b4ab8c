"""Figs. 8 and 9: bone lengths of both arms before and after the coupling."""

import numpy as np

from drake_blfdmp.demonstration.bones import BONES, link_lengths
from drake_blfdmp.evaluation.metrics import RECORDING_RATE, link_metrics
from drake_blfdmp.evaluation.studies.noise_metrics import seen_points
from drake_blfdmp.evaluation.study import Claim, Study, StudyContext, Table
from drake_blfdmp.planning.sources import LoadSource
from drake_blfdmp.planning.task import MakeMotion, MakeTask, RollOutTask
from drake_blfdmp.skeleton import LINKS
from drake_blfdmp.skill.bands import LOWER, UPPER
from drake_blfdmp.viewing import study_figures
from drake_blfdmp.viewing.drawing import Drawing

SAMPLES = 15
"""What the paper needs to come inside its bands."""


def study(context: StudyContext) -> Study:
    """Both rollouts, at the scenario's own step: they take less than a second, so `quick` changes nothing."""
    scenario = context.scenario
    context.progress("learning", 0.1)
    source = LoadSource(scenario)
    task = MakeTask(scenario, source, MakeMotion(scenario, source))
    context.progress("rolling out", 0.3)
    original, modified = RollOutTask(scenario, task, coupled=False), RollOutTask(scenario, task)
    t, bands = original.t, task.bands
    demonstration, motion = source.demonstration, task.motion
    samples = link_lengths(demonstration.x)
    shown_at = np.interp(t, motion.t, motion.recorded)
    recorded = np.stack([np.interp(shown_at, demonstration.t, column) for column in samples.T], axis=-1)
    raw = link_lengths(seen_points(source.recording))[:, BONES]

    before, after = (
        {link: entry for link, entry in link_metrics(rollout, bands, task.held[0]).items() if link != "hands"}
        for rollout in (original, modified)
    )
    ranges = [
        (min(entry["min_m"] for entry in entries.values()), max(entry["max_m"] for entry in entries.values()))
        for entries in (before, after)
    ]
    violations = {
        name: sum(entry["violations"] for entry in entries.values())
        for name, entries in (("original", before), ("modified", after))
    }
    counts = [entry["samples_until_inside"] for entry in after.values()]
    soon = None not in counts and max(counts) <= SAMPLES
    settled = t >= SAMPLES / RECORDING_RATE
    bones = list(BONES)
    rest = float(np.abs(modified.lengths - bands.desired(t)[0])[settled][:, bones].max())
    least = min(entry["min_margin"] for entry in after.values())
    funnel, paper = bands.evaluate(t), bands.paper().evaluate(t)

    drawn = funnel[:, [LOWER, UPPER]], paper[:, [LOWER, UPPER]]

    context.progress("drawing", 0.8)
    rows = {"link": list(after), "desired_m": [entry["desired_m"] for entry in after.values()]}
    for name, entries in (("original", before), ("modified", after)):
        for key in ("min_m", "max_m", "violations"):
            rows[f"{name}_{key}"] = [entry[key] for entry in entries.values()]
        until = [entry["samples_until_inside"] for entry in entries.values()]
        rows[f"{name}_samples_until_inside"] = ["never" if n is None else str(n) for n in until]
    series = {"time_s": t}
    for i in bones:
        link = LINKS[i].name
        series |= {f"{link}_recorded_m": recorded[:, i], f"{link}_original_m": original.lengths[:, i]}
        series |= {f"{link}_modified_m": modified.lengths[:, i]}
        series |= {f"{link}_funnel_lower_m": funnel[:, LOWER, i], f"{link}_funnel_upper_m": funnel[:, UPPER, i]}
    stand_in = (
        "a modelled person filmed by the virtual Kinect (synthetic)"
        if source.recording.synthetic
        else source.recording.source
    )
    desired = bands.bones
    total = len(t) * len(bones)
    return Study(
        claims=[
            Claim(
                "original: both distances of both arms vary from 0.13 to 0.32 m",
                f"{ranges[0][0]:.3f} to {ranges[0][1]:.3f} m; raw samples of the recording {np.nanmin(raw):.3f} to "
                f"{np.nanmax(raw):.3f} m; outside the funnels at {violations['original']} of {total} steps and links",
                None,
                "another recording and another person: orientation only",
            ),
            Claim(
                "modified: no bone ever leaves its funnel (target of the project)",
                f"{violations['modified']} violations at {len(t)} steps of {t[1] - t[0]:g} s and {len(bones)} bones; "
                f"least margin {least:.2f} of the half width",
                violations["modified"] == 0,
                "" if violations["modified"] == 0 else "a bone left its funnel; the table says which",
            ),
            Claim(
                f"modified: within ±{bands.final[bones[0]]:g} m of d_s = {desired[bones[0]]:.3g} m and d_e = "
                f"{desired[bones[1]]:.3g} m after about {SAMPLES} samples",
                f"inside for good after {max(counts) if None not in counts else 'never'} samples at the latest; from "
                f"sample {SAMPLES} on at most {1e3 * rest:.2f} mm off",
                soon,
                "" if soon else "a bone stays outside or comes back; the table says which",
            ),
        ],
        figures={
            "original": Drawing(study_figures.arm_lengths, t, original.lengths, *drawn, recorded=recorded),
            "modified": Drawing(study_figures.arm_lengths, t, modified.lengths, *drawn),
            "modified_start": Drawing(
                study_figures.arm_lengths, t, modified.lengths, *drawn, start=(RECORDING_RATE, SAMPLES)
            ),
        },
        captions={
            "original": "Distances of the joints with the original movement primitives, and as recorded (Fig. 8).",
            "modified": "Distances of the joints with the modified movement primitives, in their bands (Fig. 9).",
            "modified_start": "The first samples of Fig. 9: from the recorded error into the paper's band; "
            "the dotted line stands at 15 samples.",
        },
        tables={"links": Table(rows), "lengths": Table(series)},
        notes=[
            f"The paper's recording was never published; what stands in: {stand_in}.",
            "Violations are counted against the funnel that is opened to the error at t = 0, at every step; samples "
            "until inside against the paper's own band (13), at the recording's 30 a second.",
            "Recorded lengths are of the cleaned, unsmoothed samples on the task's clock, which rests at the start, at "
            "grasp and release, and at the end.",
        ],
        shown=["links"],
    )
