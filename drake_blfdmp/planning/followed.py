"""Whether the arms follow a plan all the way, looked at more closely than when its place was chosen.

Where a joint's limit holds an elbow off, there may be two ways on: one leads to where the palm cannot be carried any
further, and the other may be got to between two samples only by an elbow that swings over in no time.
"""

import numpy as np

from drake_blfdmp.planning.planned import IndexAt, Plan
from drake_blfdmp.robot.following import follow
from drake_blfdmp.robot.kinematics import DualArmKinematics
from drake_blfdmp.robot.plant import JointLimits
from drake_blfdmp.robot.reach_evaluation import POSE_TOLERANCE, SAMPLES, needed_stretch
from drake_blfdmp.robot.retargeting import retarget_motion

FINER = 4
"""So many times the samples of the search are followed."""

SWINGS_OVER = 2.0
"""A plan that must be slowed down so many times more, looked at closely, has an elbow that swings over."""


def DoubtOf(plan: Plan, kinematics: DualArmKinematics, limits: JointLimits) -> str:
    """Why the arms may not get along a plan's way, for people; empty where they do.

    It is followed twice: through as many samples as in the search, which are others now that the motion was slowed down
    and steadied, and through `FINER` times as many. The running arms may still get along: their palms wait for an elbow
    (`robot.tempo`). So this is a reason to look for another plan, not to refuse one.
    """
    coupled = plan.coupled
    first = IndexAt(coupled, plan.settle_s)
    # Who asks for a faster motion than the arms can bear gets it.
    bearable = SWINGS_OVER * max(1.0, plan.reach.stretch / plan.stretch)
    t, q = np.empty(0), np.empty((0, 14))
    for samples in (SAMPLES, FINER * SAMPLES):
        k = np.linspace(first, len(coupled.t) - 1, samples).round().astype(int)
        x, turn = coupled.x[k], None if coupled.turn is None else coupled.turn[k]
        pose, _, swivel, _ = retarget_motion(x, np.zeros_like(x), plan.retarget, turn=turn)
        following = follow(kinematics, limits, plan.reach.start, pose, swivel, give_up=POSE_TOLERANCE)
        if following.pose_error > POSE_TOLERANCE:
            return "an arm at its joints' limits may not get along the whole way"
        t, q = coupled.t[k], following.q
    if needed_stretch(t, q, limits) <= bearable:
        return ""
    at = t[np.abs(np.diff(q, axis=0)).max(axis=1).argmax()]
    return f"an elbow that a joint's limit holds off swings over at {at:.1f} s, and may be held up"
