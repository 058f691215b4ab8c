"""Fig. 7: errors per axis, both arms, of the original and the modified movement primitives."""

import numpy as np

from drake_blfdmp.evaluation.metrics import link_metrics, rms_distance, samples_until_inside
from drake_blfdmp.evaluation.study import Claim, Study, StudyContext, Table
from drake_blfdmp.planning.sources import LoadSource
from drake_blfdmp.planning.task import MakeMotion, MakeTask, RollOutTask
from drake_blfdmp.skeleton import HANDS, LINKS, POINTS
from drake_blfdmp.skill.projection import nearest_skeleton
from drake_blfdmp.viewing import study_figures
from drake_blfdmp.viewing.drawing import Drawing

HALF_WIDTH = 0.01
SAMPLES = 15
"""What the paper prints: errors inside +-0.01 m after about 15 samples."""


def count(value: int | None) -> str:
    """A number of samples, or that there is none."""
    return "never" if value is None else str(value)


def study(context: StudyContext) -> Study:
    """Both rollouts, at the scenario's own step: they take less than a second, so `quick` changes nothing."""
    scenario = context.scenario
    context.progress("learning", 0.1)
    source = LoadSource(scenario)
    task = MakeTask(scenario, source, MakeMotion(scenario, source))
    context.progress("rolling out", 0.3)
    rollouts = {
        "original": RollOutTask(scenario, task, coupled=False),
        "modified": RollOutTask(scenario, task),
    }
    t = rollouts["original"].t
    desired = task.bands.desired(t)[0]
    context.progress("nearest skeletons", 0.5)
    reference = {name: nearest_skeleton(rollout.x, desired) for name, rollout in rollouts.items()}
    errors = {name: rollout.x - reference[name] for name, rollout in rollouts.items()}

    limit = np.full(len(t), HALF_WIDTH)
    until = {
        name: [[samples_until_inside(t, e[:, p, axis], -limit, limit) for axis in range(3)] for p in range(6)]
        for name, e in errors.items()
    }
    joints = [p for p, point in enumerate(POINTS) if not point.endswith("shoulder")]
    counts = [n for p in joints for n in until["modified"][p]]
    inside = None not in counts and max(counts) <= SAMPLES
    wrong = sum(n is None for p in joints for n in until["original"][p])
    links = {name: link_metrics(rollout, task.bands, task.held[0]) for name, rollout in rollouts.items()}
    hands = links["modified"][LINKS[HANDS].name]
    hands_inside = hands["samples_until_inside"] is not None and hands["samples_until_inside"] <= SAMPLES
    ranges = {
        side: (links["original"][f"{side}_forearm"]["min_m"], links["original"][f"{side}_forearm"]["max_m"])
        for side in ("left", "right")
    }
    low, high = (float(f(errors["original"][:, joints])) for f in (np.min, np.max))
    another = "another recording and another person: orientation only"

    context.progress("drawing", 0.8)
    events = [(name, task.skill.events[name]) for name in ("grasp", "release")]
    figures, captions = {}, {}
    for letter, side in (("a", "left"), ("b", "right")):
        shown = {
            name: {joint: e[:, POINTS.index(f"{side}_{joint}")] for joint in ("elbow", "wrist")}
            for name, e in errors.items()
        }
        figures[f"errors_{side}_arm"] = Drawing(
            study_figures.axis_errors, t, shown["original"], shown["modified"], HALF_WIDTH, events
        )
        captions[f"errors_{side}_arm"] = (
            f"Errors of the {side} arm to the nearest skeleton with the desired lengths, original and modified "
            f"movement primitives (Fig. 7{letter})."
        )
    rows = [(p, axis) for p in range(6) for axis in range(3)]
    table: dict[str, list] = {"point": [POINTS[p] for p, _ in rows], "axis": ["xyz"[axis] for _, axis in rows]}
    for name, e in errors.items():
        table[f"{name}_min_m"] = [float(e[:, p, axis].min()) for p, axis in rows]
        table[f"{name}_max_m"] = [float(e[:, p, axis].max()) for p, axis in rows]
        table[f"{name}_samples_until_inside"] = [count(until[name][p][axis]) for p, axis in rows]
    apart = rms_distance(rollouts["modified"].x, reference["original"])
    stand_in = (
        "a modelled person filmed by the virtual Kinect (synthetic)"
        if source.recording.synthetic
        else source.recording.source
    )
    return Study(
        claims=[
            Claim(
                f"modified: errors within ±{HALF_WIDTH:g} m after about {SAMPLES} samples, elbow and wrist, both arms, "
                "every axis",
                f"inside for good after {count(None if None in counts else max(counts))} samples at the latest "
                f"({sum(n == 0 for n in counts)} of {len(counts)} from the start on)",
                inside,
                "" if inside else "an error stays outside or comes back; the table says which",
            ),
            Claim(
                f"the hands' distance comes into its band (20) after about {SAMPLES} samples",
                f"inside for good after {count(hands['samples_until_inside'])} samples, from {hands['max_m']:.2f} m",
                hands_inside,
                "" if hands_inside else "the funnel (20) closes faster than the hands do",
            ),
            Claim(
                f"original: does not stay within ±{HALF_WIDTH:g} m",
                f"{wrong} of {len(counts)} errors (elbows and wrists, three axes) never come inside for good",
                wrong > 0,
                "" if wrong else "this recording keeps the lengths by itself",
            ),
            Claim("original: errors from -0.1 to about 0.05 m", f"{low:.3f} to {high:.3f} m", None, another),
            Claim(
                "original: elbow-wrist distance from 0.12 to 0.25 m",
                ", ".join(f"{side} {least:.3f} to {most:.3f} m" for side, (least, most) in ranges.items()),
                None,
                another,
            ),
        ],
        figures=figures,
        captions=captions,
        tables={
            "errors": Table(table),
            "errors_over_time": Table(
                {"time_s": t}
                | {
                    f"{name}_{POINTS[p]}_{'xyz'[axis]}_m": e[:, p, axis]
                    for name, e in errors.items()
                    for p, axis in rows
                    if p in joints
                }
            ),
        },
        notes=[
            f"The paper's recording was never published; what stands in: {stand_in}.",
            "The error of a sample is its distance from the nearest skeleton whose five links have exactly the desired "
            "lengths, points weighted by the coupling's mobility. It says how far a motion is from keeping (14)-(17), "
            "not how far from the demonstration; the modified and the original motion are each measured from their own "
            "nearest skeleton. Measured from the original's nearest skeletons, the modified motion is "
            f"{1e3 * apart:.1f} mm off (RMS over all six points).",
            "Samples are counted at the recording's 30 a second.",
        ],
        shown=["errors"],
    )
