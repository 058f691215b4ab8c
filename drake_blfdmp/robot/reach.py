"""The choice of scale, place and palm rolls that lets both arms carry out a whole motion with margin."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from pydrake.math import RigidTransform
from pydrake.common.eigen_geometry import Quaternion

from drake_blfdmp.errors import TaskError
from drake_blfdmp.robot.clearance import ClearanceChecker
from drake_blfdmp.robot.kinematics import DualArmKinematics
from drake_blfdmp.robot.plant import JointLimits
from drake_blfdmp.robot.posture import Following, follow, palm_rolls, starting_posture
from drake_blfdmp.robot.retargeting import Retarget, retarget_motion

CENTRE = np.array([0.0, 0.47, 0.72])
"""Middle of the space in front of both arms where palms facing each other are reachable, m in W."""

SPAN = np.array([0.5, 0.30, 0.80])
"""Its size along x, y, z, m."""

SCALES = (1.0, 0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3)
SHIFTS = tuple(np.array([0.0, y, z]) for y in (0.0, 0.06, -0.06) for z in (0.0, 0.1, -0.1))
SAMPLES = 60
POSE_TOLERANCE = 2e-3
JOINT_MARGIN = 0.09
CLEARANCE = 0.02
COMFORT = 0.2


@dataclass(frozen=True)
class Reach:
    """A retargeting that the arms can follow, and how well.

    Attributes:
        retarget: the map.
        start: (14,) the posture at the motion's first sample, rad.
        following: on the samples that were tried.
        samples: (M,) their indices in the motion.
        clearance: least distance of arms and pedestals among themselves on these samples, m.
    """

    retarget: Retarget
    start: np.ndarray
    following: Following
    samples: np.ndarray
    clearance: float

    @property
    def sound(self) -> bool:
        """Followed exactly, with margin from every limit and clearance among the arms."""
        f = self.following
        return f.pose_error <= POSE_TOLERANCE and f.joint_margin >= JOINT_MARGIN and self.clearance >= CLEARANCE

    @property
    def quality(self) -> float:
        """Larger is better: the smaller of the joint margin (rad) and four times the clearance (m)."""
        return min(self.following.joint_margin, 4.0 * self.clearance)


def rigid(pose) -> RigidTransform:
    """A pose qw qx qy qz x y z as Drake's."""
    q = np.asarray(pose[:4])
    return RigidTransform(Quaternion(q / np.linalg.norm(q)), pose[4:])


def evaluate(
    kinematics: DualArmKinematics,
    limits: JointLimits,
    checker: ClearanceChecker,
    x,
    retarget: Retarget,
    anchor: int,
) -> Reach | None:
    """Try one retargeting on points x (N, 6, 3); the rolls are chosen at sample `anchor`, the grasp.

    Returns:
        None where the arms cannot take the grasp at all.
    """
    pose, _, swivel, _ = retarget_motion(x, np.zeros_like(x), retarget)
    q = starting_posture(kinematics, limits, pose[anchor], swivel[anchor])
    if q is None:
        return None
    rolls = retarget.rolls + palm_rolls(kinematics, q, pose[anchor])
    retarget = replace(retarget, rolls=rolls)
    pose, _, swivel, _ = retarget_motion(x, np.zeros_like(x), retarget)
    samples = np.unique(np.append(np.linspace(0, len(x) - 1, SAMPLES).round().astype(int), anchor))
    middle = int(np.searchsorted(samples, anchor))
    give_up = 5.0 * POSE_TOLERANCE
    back = follow(kinematics, limits, q, pose[samples[middle::-1]], swivel[samples[middle::-1]], give_up=give_up)
    start = back.q[-1]
    if back.pose_error > give_up:
        return Reach(retarget, start, back, samples, 0.0)
    following = follow(kinematics, limits, start, pose[samples], swivel[samples], give_up=give_up)
    clearance = min(checker.min_clearance(posture)[0] for posture in following.q[::2])
    return Reach(retarget, start, following, samples, clearance)


def find_reach(
    x,
    anchor: int,
    *,
    kinematics: DualArmKinematics,
    limits: JointLimits,
    scale: float | None = None,
    world: np.ndarray | None = None,
    level: bool = True,
    elbow_up: bool = True,
    progress: Callable[[float], None] = lambda share: None,
) -> Reach:
    """The largest scale, and for it the place with the best margins, at which the whole motion is reachable.

    Args:
        x: (N, 6, 3) motion in the torso frame, m.
        anchor: index of the grasp.
        scale, world: fixed by the user; searched where None.

    Raises:
        TaskError: nothing fits.
    """
    person = 0.5 * (x[:, 0] + x[:, 3]).mean(axis=0)
    middle = 0.5 * (x[:, 2] + x[:, 5])
    low, high = middle.min(axis=0), middle.max(axis=0)
    largest = float(np.min(SPAN / np.maximum(high - low, 1e-3)))
    checker = ClearanceChecker(max_distance=0.1)
    scales = [scale] if scale is not None else [s for s in SCALES if s <= max(largest, SCALES[-1])]
    best, nearest = None, None
    for i, s in enumerate(scales):
        middle_now = 0.5 * (low + high) - person
        places = [CENTRE + shift - s * middle_now for shift in SHIFTS] if world is None else [np.asarray(world, float)]
        for j, place in enumerate(places):
            retarget = Retarget(s, person, place, np.zeros(2), level, elbow_up)
            reach = evaluate(kinematics, limits, checker, x, retarget, anchor)
            progress((i + (j + 1) / len(places)) / len(scales))
            if reach is None:
                continue
            nearest = max(nearest or reach, reach, key=lambda r: -r.following.pose_error)
            if reach.sound and (best is None or reach.quality > best.quality):
                best = reach
        # The largest comfortable scale; a tight one only where no smaller scale is comfortable.
        if best is not None and best.quality >= COMFORT:
            break
    progress(1.0)
    if best is not None:
        return best
    if nearest is None:
        distance = float(np.linalg.norm(x[anchor, 5] - x[anchor, 2]))
        raise TaskError(
            f"reach: the arms cannot take a box {distance:.2f} m wide anywhere in front of them; use a narrower box"
        )
    raise TaskError(
        f"reach: no scale from {scales[0]:g} to {scales[-1]:g} makes the whole motion reachable (best: palms "
        f"{1000 * nearest.following.pose_error:.0f} mm off, joint margin {nearest.following.joint_margin:.2f} rad, clearance "
        f"{nearest.clearance:.3f} m); shorten timing.approach_s and timing.retreat_s, or use a smaller box"
    )
