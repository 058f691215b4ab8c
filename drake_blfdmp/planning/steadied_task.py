"""A task whose hands close and open about a middle that stands still, as far as its carry stays as it should be."""

from collections.abc import Callable, Sequence

from drake_blfdmp.demonstration.timing import TaskMotion
from drake_blfdmp.planning.moved_carry import HandsMiddle
from drake_blfdmp.planning.scenario import Scenario
from drake_blfdmp.planning.sources import Source
from drake_blfdmp.planning.steady import Dwells, Steadied
from drake_blfdmp.planning.task import MakeTask, RollOutTask, Task
from drake_blfdmp.skill.rollout import Rollout


def MakeSteadiedTask(
    scenario: Scenario,
    source: Source,
    motion: TaskMotion,
    stretch: float,
    kept: Sequence[Callable[[Task, Rollout], bool]],
) -> tuple[Task, Rollout]:
    """The task of a motion at its planned speed, and its rollout, steadied (`steady`).

    A carry that is soon over is fast right beside the dwells. Steadied in all of them it may be led astray, into a
    table, or begin where it had risen already; then only what happens while the hands move is taken out.

    Args:
        stretch: the task takes this much longer than the motion.
        kept: what the carry is to be, each told of a task and its rollout. What takes any of it away is not done.

    Raises:
        SkillError, ScenarioError: as `MakeTask` and `RollOutTask`.
    """
    task = MakeTask(scenario, source, motion, stretch)
    coupled = RollOutTask(scenario, task)
    held = task.held[0] / stretch, task.held[1] / stretch
    whole, moving = Dwells.of(motion.events), Dwells.while_moving(motion.events, held)
    for dwells in (whole, moving, moving):  # The skill follows what it is taught not quite.
        steadied, swung = Steadied(motion, coupled.t / stretch, HandsMiddle(coupled), dwells)
        if not swung:
            break
        steady_task = MakeTask(scenario, source, steadied, stretch)
        steady = RollOutTask(scenario, steady_task)
        if all(one(steady_task, steady) or not one(task, coupled) for one in kept):
            motion, task, coupled = steadied, steady_task, steady
            if dwells is whole:
                break
        elif dwells is moving:
            break
    return task, coupled
