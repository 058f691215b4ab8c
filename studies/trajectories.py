"""Fig. 6: paths and skeletons of the original and the modified movement primitives."""

import numpy as np

from drake_blfdmp.demonstration.bones import BONES
from drake_blfdmp.evaluation.metrics import link_metrics, rms_distance
from drake_blfdmp.evaluation.studies.noise_metrics import KINDS
from drake_blfdmp.evaluation.studies.truth import against_truth, by_kind, on_task_clock
from drake_blfdmp.evaluation.study import Claim, Study, StudyContext, Table
from drake_blfdmp.planning.sources import LoadSource
from drake_blfdmp.planning.task import MakeMotion, MakeTask, RollOutTask
from drake_blfdmp.skeleton import LINKS, POINTS
from drake_blfdmp.viewing.drawing import Drawing
from drake_blfdmp.viewing.study_figures import trajectories as drawing

SEEDS, QUICK_SEEDS = 20, 2


def told(values: dict[str, float]) -> str:
    """The values in mm, in words."""
    return ", ".join(f"{kind} {1e3 * value:.1f}" for kind, value in values.items()) + " mm"


def truth_claim(table: Table | None) -> Claim:
    """Whether the coupling brings the motion nearer to what the person did."""
    paper = "(not in the paper) the modification brings every kind of point nearer to what the person really did"
    if table is None:
        return Claim(paper, "not measured", None, "a real recording has no truth beside it")
    mean = {name: float(np.mean(values)) for name, values in table.columns.items() if name != "seed"}
    before = {kind: mean[f"original_{kind}_rms_m"] for kind in KINDS}
    after = {kind: mean[f"modified_{kind}_rms_m"] for kind in KINDS}
    worse = [kind for kind in KINDS if after[kind] >= before[kind]]
    return Claim(
        paper,
        f"mean RMS from the truth over {len(table.columns['seed'])} seeds: original {told(before)}; modified "
        f"{told(after)}",
        not worse,
        f"{' and '.join(worse)} end up farther: right lengths do not tell where the chain as a whole is, and the "
        "hands' distance is the task's, not the person's"
        if worse
        else "",
    )


def study(context: StudyContext) -> Study:
    """Figures of one recording, and how near to the truth several seeds of the virtual Kinect come."""
    scenario = context.scenario
    context.progress("learning", 0.05)
    source = LoadSource(scenario)
    task = MakeTask(scenario, source, MakeMotion(scenario, source))
    original, modified = RollOutTask(scenario, task, coupled=False), RollOutTask(scenario, task)
    t = original.t
    recorded = on_task_clock(source.demonstration.x, scenario, source, task, t)
    count = QUICK_SEEDS if context.quick else SEEDS
    seeds = range(scenario.seed, scenario.seed + count)
    truth = None
    if source.recording.synthetic:
        truth = against_truth(scenario, seeds, lambda what, share: context.progress(what, 0.2 + 0.6 * share))

    paper = task.bands.paper().evaluate(t)
    bone = np.isin(np.arange(len(LINKS)), BONES)
    outside = ((original.lengths <= paper[:, 0]) | (original.lengths >= paper[:, 1])) & bone
    share = float(outside.any(axis=1).mean())
    off = np.abs(original.lengths - task.bands.desired(t)[0])[:, bone].max()
    after = link_metrics(modified, task.bands, task.held[0]).values()
    violations = sum(entry["violations"] for entry in after)
    counts = [entry["samples_until_inside"] for entry in after]
    kept = violations == 0 and None not in counts and share > 0
    change = by_kind(original.x, modified.x)
    ordered = change["shoulders"] < change["elbows"] < change["hands"]

    context.progress("drawing", 0.85)
    events = task.skill.events
    carried = 0.5 * (events["grasp_end"] + events["release"])
    shown = [("start", 0.0), ("grasp", events["grasp"]), ("carried", carried), ("release", events["release"])]
    shown.append(("end", float(t[-1])))
    at = [int(np.clip(np.searchsorted(t, time), 0, len(t) - 1)) for _, time in shown]
    distances = {
        "point": list(POINTS),
        "original_to_modified_rms_m": [rms_distance(original.x[:, [p]], modified.x[:, [p]]) for p in range(6)],
        "original_to_modified_max_m": np.linalg.norm(original.x - modified.x, axis=-1).max(axis=0),
        "original_to_recorded_rms_m": [rms_distance(original.x[:, [p]], recorded[:, [p]]) for p in range(6)],
        "modified_to_recorded_rms_m": [rms_distance(modified.x[:, [p]], recorded[:, [p]]) for p in range(6)],
    }
    every = slice(None, None, max(1, round(1 / 30 / (t[1] - t[0]))))
    paths = {"time_s": t[every]}
    for name, points in (("recorded", recorded), ("original", original.x), ("modified", modified.x)):
        for p, point in enumerate(POINTS):
            paths |= {f"{name}_{point}_{'xyz'[axis]}_m": points[every, p, axis] for axis in range(3)}
    stand_in = (
        "a modelled person filmed by the virtual Kinect (synthetic)"
        if source.recording.synthetic
        else source.recording.source
    )
    return Study(
        claims=[
            Claim(
                "the original movement primitives violate (14)-(17), the modified ones keep them",
                f"original: a bone is outside its band in {100 * share:.0f} % of the steps and up to {off:.3f} m from "
                f"its desired length; modified (law {scenario.law}): {violations} violations of the five funnels, "
                f"inside the paper's own bands after {'never' if None in counts else max(counts)} samples",
                kept,
                ""
                if kept
                else "a link leaves its funnel or does not reach its band, or this recording keeps the bones",
            ),
            Claim(
                "hands are measured worst, so they are moved most, and shoulders least",
                f"RMS between original and modified: {told(change)}; from the unsmoothed recording: original "
                f"{told(by_kind(original.x, recorded))}, modified {told(by_kind(modified.x, recorded))}",
                ordered,
                "" if ordered else "the least change that keeps the links moved another kind of point more",
            ),
            truth_claim(truth),
        ],
        figures={
            "paths": Drawing(drawing.paths, recorded, original.x, modified.x),
            "skeletons": Drawing(drawing.skeletons, shown, original.x[at], modified.x[at], outside[at]),
        },
        captions={
            "paths": "Paths of shoulders, elbows and wrists: recorded, original and modified movement primitives (Fig. "
            "6a).",
            "skeletons": "Skeletons of the original and the modified movement primitives at five instants; thick bones "
            "of the original are outside their bands (Fig. 6b).",
        },
        tables={"distances": Table(distances), "paths_30_hz": Table(paths)} | ({"truth": truth} if truth else {}),
        notes=[
            f"The paper's recording was never published; what stands in: {stand_in}.",
            "Recorded means cleaned and put on the task's clock, with its rests at grasp and release, but not "
            "smoothed.",
        ],
        shown=["distances"],
    )
