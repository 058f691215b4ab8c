"""What a carry asks for, and what stands around it: what a refusal is looked at again with."""

from dataclasses import replace
from functools import cache

import numpy as np

from drake_blfdmp.evaluation.robustness.joined_postures import Clear
from drake_blfdmp.evaluation.robustness.reach_search import Way
from drake_blfdmp.planning.box_path import table_gaps
from drake_blfdmp.planning.carry import RAISED
from drake_blfdmp.planning.moved_carry import ShiftWindow
from drake_blfdmp.planning.planned import BelowPalms, IndexAt
from drake_blfdmp.planning.scenario import Scenario
from drake_blfdmp.planning.sources import Source
from drake_blfdmp.planning.supports import LEVEL_WITHIN, Ends, MakeSupports, ShiftForSupports
from drake_blfdmp.planning.task import BoxHands, MakeMotion, MakeTask, RollOutTask
from drake_blfdmp.robot.box import BoxParameters, TableParameters
from drake_blfdmp.robot.elbow_paths import Scene
from drake_blfdmp.robot.retargeting import line_frame
from drake_blfdmp.skill.profiles import smooth_step

SAMPLES = 25
"""Of the carry, that the arms must get along; every other one is searched for postures first."""

SUNK = RAISED
"""How deep, m, the box may be led into a table: by so much the planner raises a way at last."""


def wanted_way(scenario: Scenario, source: Source) -> tuple[Way, np.ndarray]:
    """What the carry asks for, and the hands' middle (3,) at the grasp, seen from between the shoulders, m."""
    task = MakeTask(scenario, source, MakeMotion(scenario, source))
    coupled = RollOutTask(scenario, task)
    first, last = (IndexAt(coupled, t) for t in task.held)
    k = np.linspace(first, last, SAMPLES).round().astype(int)
    x = coupled.x[k]
    middle, line = 0.5 * (x[:, 2] + x[:, 5]), x[:, 5] - x[:, 2]
    level = bool(abs(middle[-1, 2] - middle[0, 2]) < LEVEL_WITHIN)
    begin, end = ShiftWindow(coupled, task, level)
    hands = BoxHands(scenario, task.skill, source.dimensions.box_width or 0.0)
    closed, opened = float(np.max(hands.closed_m)), float(np.max(hands.open_m))
    rest = IndexAt(coupled, scenario.timing.rest_s)
    person = 0.5 * (coupled.x[rest:, 0] + coupled.x[rest:, 3]).mean(axis=0)
    way = Way(
        apart=((closed, opened), *((closed,) for _ in k[1:-1]), (closed, opened)),
        yaw=np.arctan2(line[:, 1], line[:, 0]),
        way=middle - middle[0],
        share=smooth_step((coupled.t[k] - begin) / (end - begin))[0],
        shift=np.subtract(scenario.task.place_offset, scenario.task.take_offset),
        level=level,
    )
    return way, middle[0] - person


def every_other(way: Way) -> Way:
    """The way by half of its samples, the ends among them."""
    return replace(way, apart=way.apart[::2], yaw=way.yaw[::2], way=way.way[::2], share=way.share[::2])


def tables_of(
    scenario: Scenario, box: BoxParameters, level: bool, middles: np.ndarray, yaw: np.ndarray
) -> list[TableParameters]:
    """The tables under both ends of a carry of which the hands' middle goes through (K, 3), m in W, turned by (K,).

    Not any where the ends leave two tables no room, as the planner then moves the release.
    """
    ends = [np.append(middles[k] - [0.0, 0.0, scenario.task.grasp_above], yaw[k]) for k in (0, -1)]
    asked = Ends(middles[0], middles[-1], float(middles[:, 2].max()))
    if not level and np.any(ShiftForSupports(asked, box, (yaw[0], yaw[-1]), False).release):
        return []
    return MakeSupports(*ends, box, level)


def clear_of(scenario: Scenario, source: Source, level: bool, middles: np.ndarray, yaw: np.ndarray) -> Clear | None:
    """What stands around a carry, its tables and its box, as `JoinedPostures.reached` asks for it.

    Args as of `tables_of`.

    Returns:
        None where the box itself gets into a table.
    """
    shape = scenario.box
    box = BoxParameters(source.dimensions.box_width or 0.0, shape.depth, shape.height, shape.mass, shape.friction)
    pose = np.concatenate([line_frame(yaw, np.zeros_like(yaw))[0], middles], axis=-1)
    poses, tables = BelowPalms(pose, scenario.task.grasp_above), tables_of(scenario, box, level, middles, yaw)
    if any(table_gaps(poses, box, table).min() < -SUNK for table in tables):
        return None
    scene = cache(lambda: Scene(tables, box, poses, 0.0))  # Made where it matters: it takes longer than to ask it.
    return lambda k, left, right: scene().clear(k, left, right)
