"""The boxes and squeezes that the study `squeeze` tries on the rig, for a scenario's box."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from drake_blfdmp.evaluation.studies.squeeze_metrics import (
    Cell,
    Limits,
    Patch,
    bearing_factor,
    box_friction,
    pad_deformation,
)
from drake_blfdmp.evaluation.studies.squeeze_rig import Lift, Pad, SqueezeRig
from drake_blfdmp.evaluation.study import Table
from drake_blfdmp.planning.scenario import Scenario
from drake_blfdmp.planning.squeeze import AskedForce
from drake_blfdmp.robot.box import BoxParameters
from drake_blfdmp.robot.grasp_force import combined_friction, least_squeeze

LIMITS = Limits()


def combined(scenario: Scenario, pad: Pad) -> float:
    """Friction of the scenario's box and the pad together."""
    return float(combined_friction(scenario.box.friction, pad.friction))


def the_box(scenario: Scenario) -> BoxParameters:
    """The scenario's box; one without a width is as wide as the modelled person's."""
    box = scenario.box
    width = scenario.synthetic.box_width if box.width is None else box.width
    return BoxParameters(width, box.depth, box.height, box.mass, box.friction)


def below(scenario: Scenario) -> tuple[float, float]:
    """Where the box's centre is from the palms' axis in the main job, (y, z) in m."""
    return 0.0, -scenario.task.grasp_above


def press(scenario: Scenario, forces: Sequence[float], modulus: float) -> tuple[np.ndarray, list[Patch]]:
    """Depths (forces, 2), m, and the left palm's patches with pads of this modulus, Pa."""
    rig = SqueezeRig(the_box(scenario), below(scenario), None, modulus, scenario.simulation.time_step)
    depths, patches = zip(*(rig.press(force) for force in forces), strict=True)
    return np.array(depths), list(patches)


def find(
    scenario: Scenario,
    pad: Pad,
    boxes: Sequence[tuple[float, float, float]],
    lift: Lift | None,
    seconds: float,
    progress: Callable[[float], None],
) -> list[Cell]:
    """The least force of every box: mass in kg, friction of box and pad together, offset in m.

    Aside of its centre a box is held level with it, so that the offset is all that turns it.
    """
    cells = []
    for i, (mass, friction, offset) in enumerate(boxes):
        progress(i / len(boxes))
        box = replace(the_box(scenario), mass=mass, friction=float(box_friction(friction, pad.friction)))
        centre = (offset, 0.0) if offset > 0.0 else below(scenario)
        rig = SqueezeRig(box, centre, lift, time_step=scenario.simulation.time_step)
        acceleration = 0.0 if lift is None else lift.acceleration
        estimate = float(least_squeeze(mass, friction, acceleration, offset, radius=pad.radius, factor=1.0))
        least, hold = rig.least(estimate, seconds, LIMITS)
        cells.append(Cell(mass, friction, offset, estimate, least, *hold.creep()))
    return cells


def mesh_factor(scenario: Scenario, offset: float) -> float:
    """`bearing_factor` of the faces that pad and box have in common when the box is held aside."""
    rig = SqueezeRig(the_box(scenario), (offset, 0.0), time_step=scenario.simulation.time_step)
    return bearing_factor(rig.press(AskedForce(scenario.task))[1], offset)


def deformation_table(
    pad: Pad, forces: Sequence[float], pressed: Mapping[float, tuple[np.ndarray, list[Patch]]]
) -> Table:
    """A row a modulus and force."""
    rows = [
        (modulus, force, depth.mean(), pad_deformation(force, modulus, pad.depth, pad.area), patch)
        for modulus, (depths, patches) in pressed.items()
        for force, depth, patch in zip(forces, depths, patches, strict=True)
    ]
    return Table(
        {
            "modulus_pa": [row[0] for row in rows],
            "force_n": [row[1] for row in rows],
            "deformation_m": [row[2] for row in rows],
            "estimate_m": [row[3] for row in rows],
            "patch_radius_m": [row[4].radius for row in rows],
            "torsion_radius_m": [row[4].torsion_radius for row in rows],
            "mean_pressure_pa": [row[4].force / row[4].area.sum() for row in rows],
            "greatest_pressure_pa": [row[4].pressure for row in rows],
        }
    )
