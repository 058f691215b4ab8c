"""How well both arms follow a retargeted motion: exactly or not, with how much margin, and how fast."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from drake_blfdmp.robot.clearance import ClearanceChecker
from drake_blfdmp.robot.following import Following, follow_all
from drake_blfdmp.robot.kinematics import DualArmKinematics
from drake_blfdmp.robot.plant import JointLimits
from drake_blfdmp.robot.posture import palm_rolls, starting_postures
from drake_blfdmp.robot.retargeting import Retarget, retarget_motion
from drake_blfdmp.robot.swings import Swings
from drake_blfdmp.robot.tracking import bent_limits

SAMPLES = 60
"""Of a motion, that are followed."""

POSE_TOLERANCE = 2e-3
"""A palm that is off by more, m or rad, does not follow."""

JOINT_MARGIN = 0.09
CLEARANCE = 0.02
"""Least distances from the joints' limits, rad, and of the arms among themselves, m, in a sound reach."""

COMFORT = 0.2
"""The margins, rad, of a comfortable one; of its clearance, m, a quarter."""

VELOCITY_SHARE = 0.5
ACCELERATION_SHARE = 0.4
"""Shares of the joints' limits that a motion may need."""


@dataclass(frozen=True)
class Reach:
    """A retargeting that the arms can follow, and how well.

    Attributes:
        retarget: the map.
        start: (14,) the posture at the motion's first sample, rad.
        following: on the samples that were tried.
        samples: (M,) their indices in the motion.
        clearance: least distance of arms and pedestals among themselves on these samples, m.
        stretch: how much the motion must be slowed down to keep the joints' speed and acceleration (>= 1).
        swings: taught in place of the elbows' own (`led_reach`); None: none.
    """

    retarget: Retarget
    start: np.ndarray
    following: Following
    samples: np.ndarray
    clearance: float
    stretch: float
    swings: Swings | None = None

    @property
    def sound(self) -> bool:
        """Followed exactly, with margin from every limit and clearance among the arms."""
        f = self.following
        return f.pose_error <= POSE_TOLERANCE and f.joint_margin >= JOINT_MARGIN and self.clearance >= CLEARANCE

    @property
    def comfortable(self) -> bool:
        """Sound, with margins to spare from limits, from other bodies and from the shoulders' singularity."""
        following = self.following
        spare = min(following.joint_margin, following.shoulder_lean, 4.0 * self.clearance)
        return self.sound and spare >= COMFORT


def kept_limits(limits: JointLimits, kinematics: DualArmKinematics) -> JointLimits:
    """The limits (14,) within which a sound reach stays: a margin inside of the joints' own, and no elbow straight."""
    bent = bent_limits(limits, kinematics.straight_elbow)
    return replace(bent, lower=bent.lower + JOINT_MARGIN, upper=bent.upper - JOINT_MARGIN)


def needed_stretch(t, q, limits: JointLimits) -> float:
    """How much a path q (M, 14) at times t (M,) must be slowed down to stay within the shares of the joints' limits."""
    velocity = np.gradient(q, t, axis=0)
    acceleration = np.gradient(velocity, t, axis=0)
    return max(
        1.0,
        float((np.abs(velocity) / limits.velocity).max() / VELOCITY_SHARE),
        float(np.sqrt((np.abs(acceleration) / limits.acceleration).max() / ACCELERATION_SHARE)),
    )


def evaluate(
    kinematics: DualArmKinematics,
    limits: JointLimits,
    checker: ClearanceChecker,
    t,
    x,
    retarget: Retarget,
    anchor: int,
    samples: int = SAMPLES,
    turn=None,
) -> Reach | None:
    """`evaluate_all` of one retargeting."""
    return evaluate_all(kinematics, limits, checker, t, x, [retarget], anchor, samples, turn)[0]


def evaluate_all(
    kinematics: DualArmKinematics,
    limits: JointLimits,
    checker: ClearanceChecker,
    t,
    x,
    retargets: Sequence[Retarget],
    anchor: int,
    samples: int = SAMPLES,
    turn=None,
    grasps: Sequence[np.ndarray] | None = None,
) -> list[Reach | None]:
    """Try retargetings on points x (N, 6, 3) at times t (N,); the rolls are chosen at sample `anchor`, the grasp.

    Args:
        samples: how many of the N, evenly, are followed beside the anchor.
        turn: (N, 4) how what is held turns, as in `retarget_motion`; None where nothing tells.
        grasps: for each retargeting the posture (14,) in which the grasp is taken, joint 7 at 0, rad; None: the best.

    Returns:
        For each retargeting: None where the arms cannot take the grasp at all; a clearance of 0 and an infinite stretch
        where they cannot follow.
    """
    tried = samples_of(len(x), samples, anchor)
    middle = int(np.searchsorted(tried, anchor))
    x, turn = x[tried], None if turn is None else turn[tried]
    grasp = slice(middle, middle + 1)
    poses, swivels = palms_of(x[grasp], retargets, None if turn is None else turn[grasp])
    postures = starting_postures(kinematics, limits, poses[:, 0], swivels[:, 0]) if grasps is None else grasps
    taken = [i for i, q in enumerate(postures) if q is not None]
    reaches: list[Reach | None] = [None] * len(retargets)
    if not taken:
        return reaches
    starts = np.array([postures[i] for i in taken])
    rolled = [
        replace(retargets[i], rolls=retargets[i].rolls + palm_rolls(kinematics, q, poses[i, 0]))
        for i, q in zip(taken, starts, strict=True)
    ]
    poses, swivels = palms_of(x, rolled, turn)
    give_up = 5.0 * POSE_TOLERANCE  # On the way back to the start; what misses more on the way on is out.
    back = follow_all(kinematics, limits, starts, poses[:, middle::-1], swivels[:, middle::-1], give_up=give_up)
    for i, retarget, following in zip(taken, rolled, back, strict=True):
        reaches[i] = Reach(retarget, following.q[-1], following, tried, 0.0, np.inf)
    led = [k for k, following in enumerate(back) if following.pose_error <= give_up]
    if not led:
        return reaches
    starts = np.array([back[k].q[-1] for k in led])
    ahead = follow_all(kinematics, limits, starts, poses[led], swivels[led], give_up=POSE_TOLERANCE)
    for k, start, following in zip(led, starts, ahead, strict=True):
        clearance, stretch = 0.0, np.inf
        if following.pose_error <= POSE_TOLERANCE and following.joint_margin >= JOINT_MARGIN:
            clearance = least_clearance(checker, following)
            stretch = needed_stretch(np.asarray(t)[tried], following.q, limits)
        reaches[taken[k]] = Reach(rolled[k], start, following, tried, clearance, stretch)
    return reaches


def samples_of(count: int, samples: int, anchor: int) -> np.ndarray:
    """Indices of so many samples, evenly, of `count`, and the anchor among them."""
    return np.unique(np.append(np.linspace(0, count - 1, samples).round().astype(int), anchor))


def palms_of(x, retargets: Sequence[Retarget], turn) -> tuple[np.ndarray, np.ndarray]:
    """Palm poses (M, N, 2, 7) and swivel angles (M, N, 2) of M retargetings of points x (N, 6, 3)."""
    found = [retarget_motion(x, np.zeros_like(x), retarget, turn=turn) for retarget in retargets]
    return np.array([pose for pose, *_ in found]), np.array([swivel for _, _, swivel, _ in found])


def least_clearance(checker: ClearanceChecker, following: Following) -> float:
    """The least distance, m, over every second sample."""
    return min(checker.min_clearance(posture)[0] for posture in following.q[::2])
