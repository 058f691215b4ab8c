"""Where a planned box stands before and after, and how much room it has on its way."""

from dataclasses import dataclass

import numpy as np

from drake_blfdmp.planning.box_path import lacking_room
from drake_blfdmp.planning.carry_height import rise
from drake_blfdmp.planning.moved_carry import EndYaws, HandsMiddle
from drake_blfdmp.planning.planned import BelowPalms, IndexAt
from drake_blfdmp.planning.supports import MakeSupports
from drake_blfdmp.planning.task import Task
from drake_blfdmp.robot.box import BoxParameters, TableParameters
from drake_blfdmp.robot.retargeting import Retarget, box_pose
from drake_blfdmp.skill.rollout import Rollout


@dataclass(frozen=True)
class CarriedBox:
    """A box in the palms of a retargeted task.

    Attributes:
        box, retarget: it, and the map to the arms.
        grasp_above: how far above the box's centre the palms take it, m.
        same_level: it is taken from and put on one table.
    """

    box: BoxParameters
    retarget: Retarget
    grasp_above: float
    same_level: bool

    def standing(self, task: Task, coupled: Rollout) -> tuple[np.ndarray, list[TableParameters]]:
        """Where the box stands at both ends, (2, 7), and on what."""
        held = [IndexAt(coupled, t) for t in task.held]
        # It stands on a table: turned about the line between the palms by no more than the skill's fit errs.
        poses = BelowPalms(box_pose(coupled.x[held], self.retarget), self.grasp_above)
        if self.same_level:
            poses[1, 6] = poses[0, 6]
        yaws = EndYaws(coupled, task, self.retarget)
        ends = [np.append(pose[4:], yaw) for pose, yaw in zip(poses, yaws, strict=True)]
        return poses, MakeSupports(*ends, self.box, self.same_level)

    def lacking_room(self, task: Task, coupled: Rollout) -> np.ndarray:
        """How much room the box lacks to the tables at every step of the carry, m."""
        first, last = (IndexAt(coupled, t) for t in task.held)
        held = slice(first, last + 1)
        turn = None if coupled.turn is None else coupled.turn[held]
        carried = BelowPalms(box_pose(coupled.x[held], self.retarget, turn), self.grasp_above)
        ends, tables = self.standing(task, coupled)
        return lacking_room(carried, self.box, tables, ends)

    def has_room(self, task: Task, coupled: Rollout) -> bool:
        """Whether it lacks none."""
        return bool(self.lacking_room(task, coupled).max() <= 0.0)

    def rise(self, task: Task, coupled: Rollout) -> float:
        """How far it rises above where it is taken, m."""
        first, last = (IndexAt(coupled, t) for t in task.held)
        return self.retarget.scale * rise(HandsMiddle(coupled)[first : last + 1])

    def largest_acceleration(self, task: Task, coupled: Rollout) -> float:
        """Of the box while it is carried, m/s^2, at the speed of the rollout."""
        first, last = (IndexAt(coupled, t) for t in task.held)
        hands = coupled.velocity[first : last + 1, 2] + coupled.velocity[first : last + 1, 5]
        velocity = self.retarget.scale * 0.5 * hands
        return float(np.linalg.norm(np.gradient(velocity, coupled.t[first : last + 1], axis=0), axis=1).max())
