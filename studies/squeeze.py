"""How far pads deform under a squeeze, and the least squeeze that holds a box beside what friction predicts."""

from collections.abc import Mapping, Sequence

import numpy as np

from drake_blfdmp.evaluation.studies.squeeze_cells import (
    LIMITS,
    below,
    combined,
    deformation_table,
    find,
    mesh_factor,
    press,
    the_box,
)
from drake_blfdmp.evaluation.studies.squeeze_metrics import Cell, Patch, as_columns, as_grid, pad_deformation
from drake_blfdmp.evaluation.studies.squeeze_rig import SAMPLE_S, SETTLE_S, Hold, Lift, Pad, SqueezeRig
from drake_blfdmp.evaluation.study import Claim, Study, StudyContext, Table
from drake_blfdmp.planning.scenario import Scenario
from drake_blfdmp.planning.squeeze import LARGEST_FORCE, AskedForce
from drake_blfdmp.robot.contact import palm_stiffness
from drake_blfdmp.robot.grasp_force import ARMS_FACTOR, PADS_FACTOR, least_squeeze, turning_factor
from drake_blfdmp.robot.plant import ARMS, DEFAULT_STIFFNESS, HOME, MakeKinematicPlant
from drake_blfdmp.viewing.drawing import Drawing
from drake_blfdmp.viewing.study_figures import squeeze as drawing

MASSES = (0.2, 0.5, 1.0, 2.0, 3.5, 5.0)
FRICTIONS = (0.3, 0.45, 0.6, 0.8, 1.0)
"""Of box and pad together."""
OFFSETS = (0.0, 0.005, 0.01, 0.015, 0.02, 0.03, 0.04)
"""M, horizontally."""
ASIDE = 0.02
"""M: the offset that is judged; as far aside as the main job takes a box above its centre."""
SOFTER = (1e5, 3e4)
"""Pa: moduli that are tried besides the model's."""
FORCES = tuple(float(force) for force in range(10, 101, 10))
HOLD_S = 2.2
"""Each trial's length, the settling included, s."""
QUICK_MASSES, QUICK_FRICTIONS, QUICK_OFFSETS, QUICK_FORCES = (1.0,), (0.8,), (0.02,), (10.0, 100.0)
QUICK_HOLD_S = 1.4

LIFT = Lift()

CLOSE = 0.05
"""Measured and estimated least force agree where they differ by less than this share."""
PAD_CLOSE = 0.02
"""The same of deformation."""


def study(context: StudyContext) -> Study:
    """Press, hold, lift, and hold aside of the centre."""
    scenario, quick, progress = context.scenario, context.quick, context.progress
    forces = QUICK_FORCES if quick else FORCES
    masses, frictions = (QUICK_MASSES, QUICK_FRICTIONS) if quick else (MASSES, FRICTIONS)
    offsets = QUICK_OFFSETS if quick else OFFSETS
    seconds = QUICK_HOLD_S if quick else HOLD_S

    progress("pressing", 0.0)
    own = SqueezeRig(the_box(scenario), below(scenario), time_step=scenario.simulation.time_step)
    pad, chosen = own.pad, own.hold(AskedForce(scenario.task), seconds)
    pressed = {modulus: press(scenario, forces, modulus) for modulus in (pad.modulus, *(() if quick else SOFTER))}
    boxes = [(mass, friction, 0.0) for mass in masses for friction in frictions]
    aside = [(scenario.box.mass, combined(scenario, pad), offset) for offset in offsets]
    still = find(scenario, pad, boxes, None, seconds, lambda share: progress("holding", share))
    lifted = find(scenario, pad, boxes, LIFT, seconds, lambda share: progress("lifting", share))
    turned = find(scenario, pad, aside, None, seconds, lambda share: progress("holding aside", share))
    mesh = [mesh_factor(scenario, offset) for offset in offsets]

    progress("drawing", 1.0)
    fine, between = np.linspace(0.0, max(OFFSETS), 60), np.geomspace(forces[0], forces[-1], 100)
    curves = {
        "disc": turning_factor(fine, pad.radius),
        "its mesh": np.interp(fine, *zip(*{0.0: 1.0, **dict(zip(offsets, mesh, strict=True))}.items(), strict=True)),
        "disc, by the ellipse": np.hypot(1.0, 1.5 * fine / pad.radius),
    }
    return Study(
        claims=[
            *pads(scenario, pad, forces, pressed),
            agreement("m g/(2 mu)", "at rest", still),
            agreement("m (g + a)/(2 mu)", f"in a lift with accelerations of up to {LIFT.acceleration:g} m/s^2", lifted),
            hangs(scenario, still),
            *turns(turned, mesh, pad),
            default_force(scenario, pad, chosen),
            whole_range(),
        ],
        figures={
            "deformation": Drawing(
                drawing.deformation,
                np.array(forces),
                {modulus: depths.mean(axis=1) for modulus, (depths, _) in pressed.items()},
                between,
                {modulus: pad_deformation(between, modulus, pad.depth, pad.area) for modulus in pressed},
                AskedForce(scenario.task),
            ),
            "least": Drawing(
                drawing.least_forces,
                {
                    title: (*as_grid(cells, lambda cell: cell.least), as_grid(cells, lambda cell: cell.ratio)[2])
                    for title, cells in (("at rest", still), (f"lifted, up to {LIFT.acceleration:g} m/s²", lifted))
                },
                LARGEST_FORCE,
            ),
            "aside": Drawing(
                drawing.aside,
                np.array(offsets),
                np.array([cell.least for cell in turned]),
                fine,
                curves,
                float(least_squeeze(scenario.box.mass, combined(scenario, pad), factor=1.0)),
            ),
        },
        captions={
            "deformation": "How far each pad yields to a squeeze: simulated (markers) and as an elastic foundation "
            "(lines), with the model's modulus and with softer ones.",
            "least": "The least force of each palm that holds a box, over the box's mass and the friction of box and "
            "pad; small: measured over estimated. Framed: more than the arms plan with.",
            "aside": "How many times harder the palms must press when the box's centre of mass lies aside of their "
            "axis: simulated (markers) and predicted for the disc that the pad is and for the mesh that stands for it.",
        },
        tables={
            "deformation": deformation_table(pad, forces, pressed),
            "still": Table(as_columns(still)),
            "lifted": Table(as_columns(lifted)),
            "aside": Table(as_columns(turned)),
        },
        notes=[
            "The palms are those of the arm's model (shape, modulus, dissipation, friction), on rails, pressed with a "
            "set force; contact is configured as in every simulation. In a carry by the arms the squeeze itself "
            "varies, see docs/contact.md.",
            f"Held: for {seconds:g} s the box nowhere slips faster than {1e3 * LIMITS.slip:g} mm/s nor pivots faster "
            f"than {np.degrees(LIMITS.pivot):.2g} deg/s over {SAMPLE_S:g} s, the first {SETTLE_S:g} s not counted. The "
            "least force is found to 0.25 %, from above.",
            "Friction is that of box and pad together; the box's own coefficient is chosen to give it.",
        ],
        shown=["aside"],
    )


def pads(
    scenario: Scenario, pad: Pad, forces: Sequence[float], pressed: Mapping[float, tuple[np.ndarray, list[Patch]]]
) -> list[Claim]:
    """Do pads deform as they should, and enough for what the paper wants of them?"""
    depths, patches = pressed[pad.modulus]
    ratio = depths.mean(axis=1) / pad_deformation(np.array(forces), pad.modulus, pad.depth, pad.area)
    close = bool(np.max(np.abs(ratio - 1.0)) <= PAD_CLOSE)
    force, mass, friction = AskedForce(scenario.task), scenario.box.mass, combined(scenario, pad)
    least = float(least_squeeze(mass, friction, LIFT.acceleration, factor=1.0))
    # Two palms in a row: the force falls to the least once they are this much farther apart.
    pads_only = 2.0 * (force - least) * pad.depth / (pad.modulus * pad.area)
    arms = 2.0 * (force - ARMS_FACTOR * least) / arm_stiffness()
    half = scenario.bands.hands_half_width
    paper = (
        "object and end effectors have a certain degree of deformation to counteract errors of the relative distance"
    )
    return [
        Claim(
            f"target: pads yield as an elastic foundation, x = F H/(E A), to {100 * PAD_CLOSE:g} %",
            f"{1e3 * depths[0].mean():.4f} mm at {forces[0]:g} N to {1e3 * depths[-1].mean():.4f} mm at "
            f"{forces[-1]:g} N, {ratio.min():.3f} to {ratio.max():.3f} times that; patch as large as a disc of "
            f"{1e3 * patches[-1].radius:.1f} mm, up to {1e-3 * patches[-1].pressure:.1f} kPa",
            close,
            "" if close else "the pressure falls off near the rim",
        ),
        Claim(
            f"{paper} (the pads alone)",
            f"at {force:g} N the pads make up for {1e3 * pads_only:.3f} mm before the box slips; the half width of the "
            f"hands' band is {1e3 * half:g} mm",
            pads_only >= half,
            ""
            if pads_only >= half
            else f"they would have to be of {1e-3 * pad.modulus * pads_only / half:.0f} kPa, as soft as foam",
        ),
        Claim(
            f"{paper} (with what gives way in the arms' joint PD)",
            f"at {force:g} N and {arm_stiffness() / 1e3:.1f} N/mm a palm (arms in front of the chest) they make up for "
            f"{1e3 * arms:.1f} mm; the half width of the hands' band is {1e3 * half:g} mm",
            arms >= half,
            "" if arms >= half else "press harder or narrow the band",
        ),
    ]


def arm_stiffness() -> float:
    """How stiffly joint PD holds a palm along its normal, N/m, the arm in front of the chest."""
    plant = MakeKinematicPlant()
    context, arm = plant.CreateDefaultContext(), plant.GetModelInstanceByName(ARMS[0])
    plant.SetPositions(context, arm, np.array(HOME))
    return palm_stiffness(plant, context, arm, DEFAULT_STIFFNESS)


def agreement(formula: str, when: str, cells: Sequence[Cell]) -> Claim:
    """Is the least force what friction says?"""
    ratio = np.array([cell.ratio for cell in cells])
    least = [cell.least for cell in cells]
    close = bool(np.max(np.abs(ratio - 1.0)) <= CLOSE)
    return Claim(
        f"target: {when} the least squeeze is {formula} to {100 * CLOSE:g} %",
        f"{len(cells)} boxes, {min(least):.2f} to {max(least):.1f} N; measured over estimated {ratio.min():.3f} to "
        f"{ratio.max():.3f}",
        close,
        "" if close else "friction is regularized, so that a box near the cone's edge creeps",
    )


def hangs(scenario: Scenario, cells: Sequence[Cell]) -> Claim:
    """Does a box that is taken above its centre pivot?"""
    worst = float(np.degrees(max(cell.pivot for cell in cells)))
    kept = worst <= np.degrees(LIMITS.pivot)
    return Claim(
        f"target: taken {1e3 * scenario.task.grasp_above:g} mm above its centre a box does not pivot, not even at the "
        "least squeeze",
        f"at most {worst:.1g} deg/s",
        kept,
        "" if kept else "the patches do not bear the moment",
    )


def turns(cells: Sequence[Cell], mesh: Sequence[float], pad: Pad) -> list[Claim]:
    """Is torsional friction what it should be when the centre lies aside? `mesh` has each cell's `mesh_factor`."""
    cell, factor = next(pair for pair in zip(cells, mesh, strict=True) if pair[0].offset == ASIDE)
    to_mesh = cell.ratio * float(turning_factor(cell.offset, pad.radius)) / factor
    worst = max(cell.ratio for cell in cells)
    close, covered = abs(to_mesh - 1.0) <= CLOSE, worst <= PADS_FACTOR
    return [
        Claim(
            f"target: {1e3 * cell.offset:g} mm aside of the centre the least squeeze is that of sliding and torsional "
            f"friction together, to {100 * CLOSE:g} %",
            f"{cell.least:.2f} N, {to_mesh:.3f} times that of the meshed pad, {cell.ratio:.3f} times that of a disc",
            close,
            "" if close else "see the figure",
        ),
        Claim(
            f"target: {PADS_FACTOR:g} times the estimate is enough for pads that face the box, up to "
            f"{1e3 * cells[-1].offset:g} mm aside",
            f"measured over estimated at most {worst:.3f}",
            covered,
            "" if covered else "the mesh bears less torsion than the disc; raise the factor or refine the mesh",
        ),
    ]


def default_force(scenario: Scenario, pad: Pad, hold: Hold) -> Claim:
    """How far is what the main job presses with above the least?"""
    force, mass, friction = AskedForce(scenario.task), scenario.box.mass, combined(scenario, pad)
    least = float(least_squeeze(mass, friction, LIFT.acceleration))
    slip, pivot = hold.creep()
    enough = hold.held and force >= least
    return Claim(
        f"target: the main job's squeeze of {force:g} N holds its box ({mass:g} kg, friction {friction:.2g})",
        f"{force / least:.1f} times the least for {LIFT.acceleration:g} m/s^2, {least:.1f} N with the arms' factor of "
        f"{ARMS_FACTOR:g}, {ARMS_FACTOR * force / least:.1f} times the friction cone's; slips by {1e6 * slip:.1f} "
        f"micrometres/s, pivots by {np.degrees(pivot):.1g} deg/s",
        enough,
        "" if enough else f"press with {least:.0f} N or more (task.squeeze_force)",
    )


def whole_range() -> Claim:
    """Could the arms hold every box of the grid?"""
    mass, friction = (part.ravel() for part in np.meshgrid(MASSES, FRICTIONS, indexing="ij"))
    least = least_squeeze(mass, friction, LIFT.acceleration)
    beyond = least > LARGEST_FORCE
    told = ", ".join(
        f"{m:g} kg at {f:g} ({n:.0f} N)" for m, f, n in zip(mass, friction, least, strict=True) if n > LARGEST_FORCE
    )
    return Claim(
        f"target: the largest planned squeeze, {LARGEST_FORCE:g} N, carries every box of {min(MASSES):g} to "
        f"{max(MASSES):g} kg with a friction of {min(FRICTIONS):g} to {max(FRICTIONS):g}, with the arms' factor",
        f"{np.count_nonzero(~beyond)} of {len(least)} boxes" + (f"; not {told}" if told else ""),
        not told,
        "they need more than LARGEST_FORCE" if told else "",
    )
