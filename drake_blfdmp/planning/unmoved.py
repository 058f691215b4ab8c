"""The person's own motion as the arms can take it up, before the places of the box are moved."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from drake_blfdmp.demonstration.timing import TaskMotion
from drake_blfdmp.errors import TaskError
from drake_blfdmp.planning.moved_carry import EndHeights, HandsMiddle, ShiftWindow
from drake_blfdmp.planning.planned import FindReach, IndexAt, Progress
from drake_blfdmp.planning.scenario import Scenario
from drake_blfdmp.planning.sources import Source
from drake_blfdmp.planning.steady import Steadied
from drake_blfdmp.planning.supports import LEVEL_WITHIN
from drake_blfdmp.planning.task import MakeMotion, MakeTask, RollOutTask, Task, Turned
from drake_blfdmp.robot.following import Following
from drake_blfdmp.robot.kinematics import DualArmKinematics
from drake_blfdmp.robot.plant import HOME, JOINTS_PER_ARM, JointLimits
from drake_blfdmp.robot.reach import CENTRE, SCALES
from drake_blfdmp.robot.reach_evaluation import Reach
from drake_blfdmp.robot.retargeting import Retarget
from drake_blfdmp.skill.rollout import Rollout


@dataclass(frozen=True)
class Unmoved:
    """The person's own motion, steadied and turned as asked, before its ends are moved.

    Attributes:
        motion, task, coupled: it.
        not_turned: task and rollout before it was turned.
        anchor: index in the rollout at which the palms' rolls are chosen.
        same_level: both ends share one table.
        reach: at the scale that suits it best.
    """

    motion: TaskMotion
    task: Task
    coupled: Rollout
    not_turned: tuple[Task, Rollout]
    anchor: int
    same_level: bool
    reach: Reach

    def at_scale(
        self,
        scenario: Scenario,
        kinematics: DualArmKinematics,
        limits: JointLimits,
        progress: Progress,
        scale: float,
        *,
        wide: bool = False,
        led: bool = False,
        **options: Any,
    ) -> Reach:
        """The reach at another scale.

        Args:
            wide: look farther around (`find_reach`) where nothing is found near by, which takes seconds.
            led: where nothing is found, the middle of the arms' space all the same: elbows may be led yet.
            options: of `FindReach`.

        Raises:
            TaskError: nothing fits.
        """
        asked = scenario, self.coupled, self.anchor, kinematics, limits, progress, scale
        try:
            return FindReach(*asked, **options)
        except TaskError:
            if not (wide or led):
                raise
        if led:
            return Unreached(scenario, self.coupled, scale)
        return FindReach(*asked, wide=wide, **options)


def Unreached(scenario: Scenario, coupled: Rollout, scale: float) -> Reach:
    """A reach, not sound, that only tells where the motion would be: in the middle of the arms' space, or as asked."""
    moving = coupled.x[IndexAt(coupled, scenario.timing.rest_s) :]
    person, hands = 0.5 * (moving[:, 0] + moving[:, 3]).mean(axis=0), 0.5 * (moving[:, 2] + moving[:, 5])
    config, middle = scenario.retarget, 0.5 * (hands.min(axis=0) + hands.max(axis=0)) - person
    world = CENTRE - scale * middle if config.world is None else np.array(config.world)
    retarget = Retarget(scale, person, world, np.zeros(2), config.level, config.elbow_up)
    nowhere = Following(np.empty((0, 2 * JOINTS_PER_ARM)), np.inf, np.inf, -np.inf)
    return Reach(retarget, np.tile(HOME, 2), nowhere, np.empty(0, dtype=int), -np.inf, np.inf)


def MakeUnmoved(
    scenario: Scenario,
    source: Source,
    kinematics: DualArmKinematics,
    limits: JointLimits,
    progress: Progress,
    *,
    led: bool = False,
    **options: Any,
) -> Unmoved:
    """Learn the person's motion, take what the law swings in the dwells out of it, turn its end, and find its reach.

    Args:
        led: nothing is looked for, as elbows are to be led (`Unreached`).
        options: of `FindReach`.

    Raises:
        SkillError, ScenarioError, TaskError: as the steps do.
    """
    motion = MakeMotion(scenario, source)
    progress("learning the skill", 0.0)
    task = MakeTask(scenario, source, motion)
    progress("learning the skill", 1.0)
    coupled = RollOutTask(scenario, task)
    motion, swung = Steadied(motion, coupled.t, HandsMiddle(coupled))
    if swung:
        task = MakeTask(scenario, source, motion)
        coupled = RollOutTask(scenario, task)
    anchor = IndexAt(coupled, task.held[0])
    same_level = abs(np.subtract(*EndHeights(coupled, task))) < LEVEL_WITHIN
    not_turned = task, coupled
    if yaw := scenario.task.place_rotation[2]:
        motion = Turned(motion, yaw, ShiftWindow(coupled, task, same_level))
        task = MakeTask(scenario, source, motion)
        coupled = RollOutTask(scenario, task)
    if led:
        reach = Unreached(scenario, coupled, SCALES[0])
    else:
        reach = FindReach(scenario, coupled, anchor, kinematics, limits, progress, **options)
    return Unmoved(motion, task, coupled, not_turned, anchor, bool(same_level), reach)
