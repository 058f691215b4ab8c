"""Where a carry begins and ends, when it may be moved, and the reach of one that was."""

from typing import Any

import numpy as np

from drake_blfdmp.errors import TaskError
from drake_blfdmp.planning.planned import FindReach, IndexAt, Progress
from drake_blfdmp.planning.scenario import Scenario
from drake_blfdmp.planning.supports import Ends
from drake_blfdmp.planning.task import Task
from drake_blfdmp.robot.kinematics import DualArmKinematics
from drake_blfdmp.robot.plant import JointLimits
from drake_blfdmp.robot.reach_evaluation import Reach
from drake_blfdmp.robot.retargeting import Retarget, hand_line
from drake_blfdmp.skill.rollout import Rollout


def FindReachAgain(
    scenario: Scenario,
    coupled: Rollout,
    anchor: int,
    kinematics: DualArmKinematics,
    limits: JointLimits,
    progress: Progress,
    before: Retarget,
    *,
    stay: bool,
    **options: Any,
) -> Reach:
    """The reach of a motion that was changed, at the scale it had.

    Args:
        before: of the motion before it was changed.
        options: of `FindReach`.
        stay: the person stays where it was if the arms can do that: what was moved shall be moved in the world.

    Raises:
        TaskError: out of reach.
    """
    given = scenario.retarget.world is not None
    if stay or given:
        try:
            return FindReach(
                scenario,
                coupled,
                anchor,
                kinematics,
                limits,
                progress,
                before.scale,
                before.world,
                person=before.person,
                **options,
            )
        except TaskError:
            if given:
                raise
            # Out of reach there; another place may do.
    return FindReach(scenario, coupled, anchor, kinematics, limits, progress, before.scale, **options)


def HandsMiddle(rollout: Rollout) -> np.ndarray:
    """The middle between the hands (N, 3), m."""
    return 0.5 * (rollout.x[:, 2] + rollout.x[:, 5])


def EndHeights(rollout: Rollout, task: Task) -> tuple[float, float]:
    """Of the hands' middle where the box is taken and where it is put down, m."""
    first, last = HandsMiddle(rollout)[[IndexAt(rollout, t) for t in task.held], 2]
    return float(first), float(last)


def CarryEnds(rollout: Rollout, task: Task, retarget: Retarget) -> Ends:
    """Where the carry begins and ends in W."""
    first, last = (IndexAt(rollout, t) for t in task.held)
    middle = retarget.point(HandsMiddle(rollout)[first : last + 1])
    return Ends(grasp=middle[0], release=middle[-1], top=float(middle[:, 2].max()))


def EndYaws(rollout: Rollout, task: Task, retarget: Retarget) -> tuple[float, float]:
    """Of the line between the palms where the box is taken and where it is put down, rad."""
    x = rollout.x[[IndexAt(rollout, t) for t in task.held]]
    yaw = hand_line(x, np.zeros_like(x), retarget)[4]
    return float(yaw[0]), float(yaw[1])


SHORTEST = 0.5
"""Least time, s, in which a carry is moved."""


def AboveBoth(rollout: Rollout, task: Task) -> tuple[float, float] | None:
    """When the box is above both of its ends, from s to s; None where it never is, or gets there so late that less
    than `SHORTEST` is left.
    """
    first, last = (IndexAt(rollout, t) for t in task.held)
    begin, finish = task.skill.events["grasp_end"], task.skill.events["release"]
    z = HandsMiddle(rollout)[first : last + 1, 2]
    higher = max(z[0], z[-1])
    above = np.flatnonzero(z > higher + 0.5 * (z.max() - higher)) + first
    if len(above) == 0:
        return None
    start, end = (float(rollout.t[k]) for k in above[[0, -1]])
    start = max(start, begin)
    end = min(max(end, start + SHORTEST), finish)
    return (start, end) if end - start >= SHORTEST - 1e-9 else None


def ShiftWindow(rollout: Rollout, task: Task, same_level: bool) -> tuple[float, float]:
    """When the release may be shifted: while the box is above both ends; the whole carry where it is not, or where one
    table serves both.
    """
    above = None if same_level else AboveBoth(rollout, task)
    return above or (task.skill.events["grasp_end"], task.skill.events["release"])
