"""A reach whose elbows are led around each other, where no place lets them swing as the person's do."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from scipy.ndimage import gaussian_filter1d

from drake_blfdmp.errors import TaskError
from drake_blfdmp.robot.clearance import ClearanceChecker
from drake_blfdmp.robot.elbow_paths import ElbowPaths, Scene
from drake_blfdmp.robot.kinematics import DualArmKinematics
from drake_blfdmp.robot.plant import JOINTS_PER_ARM, JointLimits
from drake_blfdmp.robot.reach import CALM, CENTRE, SCALES, WIDE, calmed, largest_scale
from drake_blfdmp.robot.reach_evaluation import (
    CLEARANCE,
    SAMPLES,
    Reach,
    evaluate_all,
    kept_limits,
    palms_of,
    samples_of,
)
from drake_blfdmp.robot.retargeting import FADING, Retarget
from drake_blfdmp.robot.swings import Swings
from drake_blfdmp.robot.swivel import wrap

PLACES = CENTRE + np.array(sorted(WIDE, key=lambda shift: float(np.linalg.norm(shift))))
"""Where the middle of the motion is put, m in W; nearest to `CENTRE` first."""

FREE = (FADING, FADING + 0.1)
"""Limits of a swing that is followed as it is, rad."""

SMOOTHED = 1.5
"""Standard deviation of the smoothing of the elbows' ways, samples: they are found on a grid of angles."""

SPARE = 0.015
"""So much more clearance, m, is looked for, as the ways are smoothed afterwards."""

FINER = 4
"""What is found on `SAMPLES` samples has to hold on so many times as many, too."""

SLOWEST = 12.0
"""A motion that must be slowed down more than this is none."""


def find_led_reach(
    t,
    x,
    anchor: int,
    *,
    kinematics: DualArmKinematics,
    limits: JointLimits,
    scale: float | None = None,
    world: np.ndarray | None = None,
    person: np.ndarray | None = None,
    calms: Sequence[float] = CALM,
    level: bool = True,
    turn: np.ndarray | None = None,
    scene: Callable[[Retarget, np.ndarray], Scene] | None = None,
    progress: Callable[[float], None] = lambda share: None,
) -> Reach:
    """The largest scale, and for it the place nearest to the middle, at which arms that keep clear carry the palms.

    Args as of `find_reach`; of `calms` the last one counts, for the hands' yaw and pitch. `scene`, where given, tells
    of a retargeting and indices of the motion's samples what stands around there.

    Returns:
        A sound reach of the motion with `Reach.swings` taught.

    Raises:
        TaskError: there is none.
    """
    t, tried = np.asarray(t), samples_of(len(x), SAMPLES, anchor)
    grasp = int(np.searchsorted(tried, anchor))
    if person is None:
        person = 0.5 * (x[:, 0] + x[:, 3]).mean(axis=0)
    hands = 0.5 * (x[:, 2] + x[:, 5])
    middle = 0.5 * (hands.min(axis=0) + hands.max(axis=0)) - person
    checker = ClearanceChecker(max_distance=0.1)
    paths = ElbowPaths(kinematics, kept_limits(limits, kinematics), checker, CLEARANCE + SPARE)
    scales = [s for s in SCALES if s <= max(largest_scale(hands), SCALES[-1])] if scale is None else [scale]
    for k, s in enumerate(scales):
        places = PLACES - s * middle if world is None else np.asarray(world)[None]
        first = calmed(Retarget(s, person, places[0], np.zeros(2), level), calms[-1])
        # From place to place the palms are shifted, and nothing else changes.
        (pose,), (swivel,) = palms_of(x[tried], [first], None if turn is None else turn[tried])
        poses = np.repeat(pose[None], len(places), axis=0)
        poses[..., 4:] += (places - places[0])[:, None, None]
        possible = np.flatnonzero(paths.may_be(poses))
        for done, i in enumerate(possible):
            progress((k + done / len(possible)) / len(scales))
            retarget = replace(first, world=places[i])
            q = paths.find(poses[i], swivel, scene and partial(scene, retarget, tried))
            if q is None:
                continue
            swings = Swings(t[tried], _smooth_swings(kinematics, q))
            free = replace(retarget, swing_out=FREE, swing_in=FREE)
            reach = reach_of_led(t, swings.of(t, x), anchor, free, q[grasp], kinematics, limits, turn)
            if reach is not None:
                progress(1.0)
                return replace(reach, swings=swings)
    progress(1.0)
    scaled = f"no scale from {scales[0]:g} to {scales[-1]:g}" if len(scales) > 1 else f"no place at scale {scales[0]:g}"
    raise TaskError(
        f"reach: {scaled} lets arms whose elbows are led carry the palms; use a smaller box, or move it less",
        reason="reach",
    )


def reach_of_led(
    t, x, anchor: int, retarget: Retarget, grasp, kinematics: DualArmKinematics, limits: JointLimits, turn
) -> Reach | None:
    """The reach of a motion whose elbows are led already, looked at closely; None where it is not sound.

    Args:
        t: (N,) s.
        x: (N, 6, 3) m.
        anchor: index of the grasp.
        retarget: place and scale, with swings that are `FREE`.
        grasp: (14,) the posture there, joint 7 at 0, rad.
        kinematics: of both arms.
        limits: of their joints.
        turn: (N, 4) as in `retarget_motion`; None where nothing tells.
    """
    checker, reach = ClearanceChecker(max_distance=0.1), None
    for samples in (SAMPLES, FINER * SAMPLES):
        reach = evaluate_all(kinematics, limits, checker, t, x, [retarget], anchor, samples, turn, [grasp])[0]
        if reach is None or not reach.sound or reach.stretch > SLOWEST:
            return None
    return reach


def _smooth_swings(kinematics: DualArmKinematics, q: np.ndarray) -> np.ndarray:
    """The person's swivel angles (N, 2) for which `Retarget.elbow_up` has the arms' of postures (N, 14), smoothed."""
    arms = np.tile([0, 1], len(q))
    psi = kinematics.chains.evaluate(arms, q.reshape(-1, JOINTS_PER_ARM))[3].reshape(-1, 2)
    return gaussian_filter1d(np.unwrap(wrap(np.pi - psi), axis=0), SMOOTHED, axis=0, mode="nearest")
