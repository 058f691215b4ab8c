"""Fig. 11: two Frankas carry a box; the swivel angle in their null space, not there, and as (18) prints it."""

from dataclasses import replace

import numpy as np

from drake_blfdmp.errors import TaskError
from drake_blfdmp.evaluation.studies.redundancy_runs import (
    BasePlaces,
    RedundancyRun,
    SimulatePlan,
    held_means,
    instants,
    phase_times,
    posture_row,
    swivel_series,
)
from drake_blfdmp.evaluation.study import Claim, Study, StudyContext, Table
from drake_blfdmp.planning.plan import MakePlan
from drake_blfdmp.robot.redundancy import REDUNDANCIES
from drake_blfdmp.viewing import robot_figures
from drake_blfdmp.viewing.drawing import Drawing
from drake_blfdmp.viewing.study_figures import frankas

WIDE = 0.010
"""By how much the hands are commanded too far apart in the last run, m: the half width of the hands' band."""

TARGET_DEG = 2.0
"""The project's own: the swivel angle follows the person's to this, RMS."""


def study(context: StudyContext) -> Study:
    """One plan, simulated with every resolution, and once more with the hands too far apart."""
    scenario, progress = context.scenario, context.progress
    settings = REDUNDANCIES
    if context.quick:
        # Coarser steps and no slowing down: the same code, not the same figures.
        simulation = replace(scenario.simulation, time_step=0.006, skill_time_step=0.006, record_rate_hz=25.0)
        scenario = replace(scenario, simulation=simulation, task=replace(scenario.task, duration_scale=1.0))
        settings = ("swivel",)
    plan = MakePlan(scenario, progress)
    runs = {
        setting: SimulatePlan(plan, setting, lambda share, what=setting: progress(f"simulating {what}", share))
        for setting in settings
    }
    swivel, rows = runs["swivel"], {setting: posture_row(run) for setting, run in runs.items()}
    times = phase_times(plan, swivel.log)
    if context.quick:
        times = {name: times[name] for name in ("grasp", "carry")}
    claims = [carried(swivel.summary), bases(), *postures(rows), compliance(swivel, context)]
    source = plan.source.recording
    stand_in = "a modelled person filmed by the virtual Kinect (synthetic)" if source.synthetic else source.source
    return Study(
        claims=claims,
        figures={
            "stills": Drawing(
                frankas.pictures, instants(plan, swivel.log, times), pixels=150 if context.quick else 300
            ),
            "swivel": Drawing(
                frankas.swivel_angles,
                swivel.log.t,
                {
                    setting: frankas.Swivels(run.log.swivel_desired, run.swivel_error, run.elbow_off)
                    for setting, run in runs.items()
                },
                swivel.log.events,
            ),
            "squeeze": Drawing(robot_figures.palm_forces, swivel.log.t, swivel.log.palm_force, swivel.log.events),
        },
        captions={
            "stills": "The smooth motion that was learned, the skill, and the robots at the same instants, from the "
            "front. While the box is held the hands' band is narrower than the box, by the squeeze.",
            "swivel": "Swivel angle of both arms, and how far the elbow is from where the person's angle wants it.",
            "squeeze": "Normal force of each palm on the box, swivel put right.",
        },
        tables={
            "settings": Table(
                {"setting": list(rows)} | {name: [line[name] for line in rows.values()] for name in rows["swivel"]}
            ),
            "swivel": swivel_series(runs),
        },
        notes=[
            f"Neither the paper's recording nor its simulation was published; what stands in: {stand_in}, and Drake "
            "with this project's model of the Panda in place of Gazebo.",
            "All settings carry out the same plan from the same posture; only the running arms' null space differs. "
            "Errors count from the time at which the arms join in.",
            "The angle asked of the robots is the person's, mirrored to above the arms and softly limited, and so is "
            "the psi that goes into (18). U_psi is the robot's own; docs/redundancy.md measures the other readings.",
        ],
        shown=["settings"],
    )


def carried(summary: dict) -> Claim:
    """Do they hold, move and place it?"""
    box, robot = summary["box"], summary["robot"]
    return Claim(
        "two Frankas hold, move and place an object 0.3 m wide under PD control",
        f"lifted by {box['lifted_m']:.3f} m, put down {1e3 * box['placement_error_m']:.1f} mm from its goal, tilted by "
        f"at most {box['max_tilt_deg']:.2f} degrees; palms follow to {1e3 * robot['palm_tracking_rms_m']:.1f} mm RMS, "
        f"the squeeze included; least joint margin {robot['min_joint_margin_rad']:.2f} rad, at most "
        f"{100 * robot['max_effort_ratio']:.0f} % of the effort",
        summary["success"],
        " ".join(summary["failures"]),
    )


def bases() -> Claim:
    """Where the arms stand."""
    found = BasePlaces()
    there = np.allclose(found, [[0.2, 0.0, 0.4], [-0.2, 0.0, 0.4]], atol=1e-9)
    told = " and ".join(str(place.round(6).tolist()) for place in found)
    why = "" if there else "the model differs"
    return Claim("the bases stand at [0.2, 0, 0.4] and [-0.2, 0, 0.4] m", f"{told} m", there, why)


def postures(rows: dict[str, dict]) -> list[Claim]:
    """Is the posture the person's?"""

    def told(setting: str) -> str:
        left, right, off = (
            rows[setting][f"swivel_{what}"] for what in ("rms_left_deg", "rms_right_deg", "elbow_off_m")
        )
        return f"{left:.2f} (left) and {right:.2f} degrees RMS (right), elbows up to {1e3 * off:.0f} mm off their place"

    def follows(setting: str) -> bool:
        return max(rows[setting][f"swivel_rms_{arm}_deg"] for arm in ("left", "right")) <= TARGET_DEG

    same = follows("swivel")
    claims = [
        Claim(
            f"the swivel angle makes the posture human-like; put right, it follows the person's to {TARGET_DEG:g} "
            "degrees RMS (target of the project)",
            told("swivel") + (f"; with no null motion {told('none')}" if "none" in rows else ""),
            same,
            "" if same else "a limit keeps an elbow from its angle",
        )
    ]
    if "published" not in rows:
        return claims
    same, margins = follows("published"), [rows[name]["joint_margin_min_rad"] for name in ("published", "swivel")]
    why = (
        "psi, an angle, is used as a speed, so the elbows keep moving until a joint's limit stops them; nothing feeds "
        "the robot's own angle back; and the projector outside the pseudo-inverse leaks the elbow task"
    )
    measured = f"{told('published')}; least joint margin {margins[0]:.2f} rad in place of {margins[1]:.2f}"
    paper = f"(18) as printed makes the posture human-like (to the same {TARGET_DEG:g} degrees RMS)"
    return [*claims, Claim(paper, measured, same, "" if same else why)]


def compliance(run: RedundancyRun, context: StudyContext) -> Claim:
    """Does enough give way? Measured with the hands commanded too far apart."""
    paper = "object and end effectors deform a little, which counteracts errors of the relative distance"
    width, (force, apart, asked) = run.plan.source.dimensions.box_width, held_means(run)
    if width is None:
        raise TaskError("two_frankas: a motion without a box presses on nothing; use task.kind=hold")
    told = (
        f"palms commanded {1e3 * (width - asked):.1f} mm closer than the box is wide stay {1e3 * apart:.1f} mm "
        f"apart and press with {force:.0f} N on average"
    )
    if context.quick:
        return Claim(paper, told, None, "a quick run does not try the hands too far apart")
    task = replace(run.plan.scenario.task, squeeze=0.5 * (width - asked - WIDE))
    wider = MakePlan(replace(run.plan.scenario, task=task), context.progress)
    other = SimulatePlan(wider, "swivel", lambda share: context.progress("simulating hands too far apart", share))
    return Claim(
        paper,
        f"{told}; with the hands {1e3 * WIDE:.0f} mm too far apart throughout, the half width of their band, "
        f"{held_means(other)[0]:.0f} N remain and the box is put down "
        f"{1e3 * other.summary['box']['placement_error_m']:.1f} mm from its goal. What gives way is the joints' PD, "
        "hardly the pads; the box is rigid",
        run.summary["success"] and other.summary["success"],
        " ".join([*run.summary["failures"], *other.summary["failures"]]),
    )
