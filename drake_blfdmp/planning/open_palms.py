"""Open palms beside a box that stands: a plan keeps them off it, where they would push it along.

A person's hands wander after they have let go, by centimetres with a noisy recording. The arms' own check of clearance
leaves palms and box out, as these are to touch.
"""

import numpy as np

from drake_blfdmp.errors import TaskError
from drake_blfdmp.planning.planned import Plan
from drake_blfdmp.planning.task import BoxHands
from drake_blfdmp.quaternions import conjugate, rotated
from drake_blfdmp.robot.box import BoxParameters
from drake_blfdmp.robot.grasp_force import PALM_RADIUS
from drake_blfdmp.robot.retargeting import palm_offsets, retarget_motion

ROOM = 0.01
"""Least distance, m, between an open palm and a box beside it; the palms follow their plan within some millimetres."""


def PalmGaps(palms, poses, box: BoxParameters) -> np.ndarray:
    """How far the palms' middles are outside the box's two sides (..., 2), m; negative inside; infinite elsewhere.

    Args:
        palms: (..., 2, 7) X_WP as qw qx qy qz x y z.
        poses: (..., 7) X_WB.
        box: the box; the palms take it by the sides that its x axis goes through.

    A palm is elsewhere where no part of its pad is over or under, in front of or behind any of the box's side.
    """
    palms, poses = np.asarray(palms, dtype=float), np.asarray(poses, dtype=float)[..., None, :]
    place = np.abs(rotated(conjugate(poses[..., :4]), palms[..., 4:] - poses[..., 4:]))
    reach = 0.5 * np.array([box.depth, box.height]) + PALM_RADIUS
    return np.where(np.all(place[..., 1:] < reach, axis=-1), place[..., 0] - 0.5 * box.width, np.inf)


def CheckOpenPalms(plan: Plan, least: float = ROOM) -> None:
    """Refuse a plan whose open palms would push the box before they take it or after they let it go.

    Args:
        plan: with a box.
        least: distance, m, that is asked for.

    Raises:
        TaskError: of reason clearance.
    """
    box, coupled, retarget = plan.box, plan.coupled, plan.reach.retarget
    if box is None:
        return
    hands = BoxHands(plan.scenario, plan.task.skill, box.width)
    palms, *_ = retarget_motion(coupled.x, coupled.velocity, retarget, palm_offsets(retarget.rolls))
    gaps = PalmGaps(palms, plan.planned_box(), box).min(axis=-1)
    moving = coupled.t >= plan.scenario.timing.rest_s
    let_go = hands.open_s + hands.duration_s
    gaps[~moving | ((coupled.t > hands.close_s) & (coupled.t < let_go))] = np.inf
    k = int(np.argmin(gaps))
    if gaps[k] < least:
        when, key = ("after", "retreat_s") if coupled.t[k] >= let_go else ("before", "approach_s")
        raise TaskError(
            f"clearance: {when} the hands hold the box one comes {1000 * (least - gaps[k]):.0f} mm too near to it and "
            f"may push it, at {coupled.t[k]:.1f} s; shorten timing.{key}, or raise task.clearance",
            reason="clearance",
        )
