"""Whether what the planner refuses cannot be done: looked at once more, by other means than the planner's."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from drake_blfdmp.errors import BlfDmpError
from drake_blfdmp.evaluation.robustness.joined_postures import JoinedPostures
from drake_blfdmp.evaluation.robustness.reach_search import ReachSearch, Way
from drake_blfdmp.evaluation.robustness.trial import Trial
from drake_blfdmp.evaluation.simulation import Judge
from drake_blfdmp.evaluation.studies.intervals import Proportion, proportion
from drake_blfdmp.evaluation.study import Table
from drake_blfdmp.planning.moved_carry import ShiftWindow
from drake_blfdmp.planning.plan import MakePlan
from drake_blfdmp.planning.planned import IndexAt
from drake_blfdmp.planning.scenario import Scenario
from drake_blfdmp.planning.sources import LoadSource, Source
from drake_blfdmp.planning.supports import LEVEL_WITHIN, MakeSupports
from drake_blfdmp.planning.task import BoxHands, MakeMotion, MakeTask, RollOutTask
from drake_blfdmp.robot.box import BoxParameters, TableParameters
from drake_blfdmp.skill.profiles import smooth_step

PLACES_TRIED = 4
"""How many of the places that the search finds for a yaw are given to the planner."""

SAMPLES = 25
"""Of the carry, that the arms must get along; every other one is searched for postures first."""

SQUEEZES = (0.7, 0.8, 0.6, 0.9, 0.5, 0.4)
"""Of the force limit, what a box is squeezed with, likely ones first."""

YAW_SHARES = (1.0, 0.5, 0.0)
LARGEST_YAW = np.deg2rad(45.0)
"""Shares of the yaw of the person's hands, and the largest, rad."""


@dataclass(frozen=True)
class RefusalCheck:
    """A trial that was refused, to be looked at again.

    Attributes:
        reason: why, one of `CHECKS`.
    """

    trial: Trial
    reason: str

    @property
    def key(self) -> str:
        """What its row is known by."""
        return f"{self.trial.key}-{self.reason}-refusal"

    def run(self) -> dict:
        """Its row: `right`, whether the refusal was shown to be, and `evidence`, a sentence."""
        right, evidence = CHECKS[self.reason](self.trial.scenario)
        return self._row(right, evidence)

    def crashed(self, error: str) -> dict:
        """The row of a check that came to no end: nothing was shown."""
        return self._row(False, f"not shown: {error}")

    def _row(self, right: bool, evidence: str) -> dict:
        name = self.trial.scenario.name
        return {"key": self.key, "task": name, "reason": self.reason, "right": right, "evidence": evidence}


def check_reach(scenario: Scenario) -> tuple[bool, str]:
    """Right where no place and no scale lets both palms carry the box along its way; see `reach_search`.

    What the search finds is given to the planner, place and scale fixed: a plan there that succeeds shows that the
    refusal was wrong. Where none does, nothing is shown.
    """
    source = LoadSource(scenario)
    fine, middle = wanted_way(scenario, source)
    apart = np.array([distances[0] for distances in fine.apart])
    search, joined, looked_at, had, found = ReachSearch(), JoinedPostures(), 0, 0, []
    for share in YAW_SHARES:  # As the planner may limit it.
        yaw = share * np.clip(fine.yaw, -LARGEST_YAW, LARGEST_YAW)

        def gets_along(place: np.ndarray, scale: float, yaw: np.ndarray = yaw) -> bool:
            middles = fine.middles(place, scale)
            return joined.get_along(
                middles, yaw, apart, tables_of(scenario, source, middles, yaw) if fine.level else ()
            )

        places, *counts = search.search(every_other(replace(fine, yaw=yaw)), most=PLACES_TRIED, joined=gets_along)
        looked_at, had = looked_at + counts[0], had + counts[1]
        found += [one for one in places if not any(_same(one, other) for other in found)]
    if not found:
        there = f"postures at {had} of {looked_at} pairs of a place and a scale" if had else "no postures along the way"
        but = (
            ", but the arms overlap or jump on the way"
            if had
            else f" at any of {looked_at} pairs of a place and a scale"
        )
        return True, there + but
    told = ""
    for place, scale in found:
        # What counts is where the one end is, seen from the other: the place is free.
        task = replace(scenario.task, take_offset=[0.0, 0.0, 0.0], place_offset=[float(v) for v in fine.shift])
        world = [float(v) for v in place - scale * middle]
        there = replace(scenario, task=task, retarget=replace(scenario.retarget, scale=scale, world=world))
        carried, told, _ = run_anyway(there)
        if carried:
            return False, f"succeeds with retarget.scale={scale:g}, retarget.world={np.round(world, 3).tolist()}"
    return False, f"not shown: postures all along the way at {len(found)} places, yet no plan there succeeds: {told}"


def _same(one: tuple[np.ndarray, float], other: tuple[np.ndarray, float]) -> bool:
    return one[1] == other[1] and np.array_equal(one[0], other[0])


def every_other(way: Way) -> Way:
    """The way by half of its samples, the ends among them."""
    return replace(way, apart=way.apart[::2], yaw=way.yaw[::2], way=way.way[::2], share=way.share[::2])


def check_force(scenario: Scenario) -> tuple[bool, str]:
    """Right where no squeeze carries the box without a palm that presses harder than allowed.

    The very plan that was refused is carried out with one squeeze after the other, whatever is thought of it, and with
    a box that is what the planner was told.
    """
    limit, told = scenario.task.force_limit, []
    reality = replace(scenario.reality, mass_scale=1.0, friction_scale=1.0)
    for share in SQUEEZES:
        task = replace(scenario.task, squeeze=None, squeeze_force=share * limit)
        carried, what, refused = run_anyway(replace(scenario, task=task, reality=reality), limit, heed_force=False)
        if refused:
            return False, f"not shown: {what}"
        told.append(f"squeezed with {share * limit:.0f} N: {what}")
        if carried:
            return False, told[-1]
    return True, "; ".join(told)


def check_clearance(scenario: Scenario) -> tuple[bool, str]:
    """Wrong where the task, planned as if there were room at the tables, succeeds; else looked at as by `check_reach`.

    That the box is dropped on the way that was refused does not show that there is no other: two tasks of which this
    was all that was asked were carried by a later planner.
    """
    carried, told, refused = run_anyway(scenario, heed_clearance=False)
    if carried:
        return False, told
    right, evidence = check_reach(scenario)
    return right, evidence if refused else f"without heed of the tables: {told} And with it: {evidence}"


CHECKS: Mapping[str, Callable[[Scenario], tuple[bool, str]]] = {
    "reach": check_reach,
    "force": check_force,
    "clearance": check_clearance,
}


def run_anyway(
    scenario: Scenario, force_limit: float = np.inf, *, heed_clearance: bool = True, heed_force: bool = True
) -> tuple[bool, str, str]:
    """Whether a changed scenario succeeds, with no palm pressing harder than `force_limit`, N; what happened; and why
    it was refused again, if it was.
    """
    try:
        summary = Judge(MakePlan(scenario, heed_clearance=heed_clearance, heed_force=heed_force))
    except BlfDmpError as error:
        return False, str(error), error.reason
    greatest = summary["box"]["squeeze_force_n"][1]
    if summary["success"] and greatest > force_limit:
        return False, f"carried, but with up to {greatest:.0f} N", ""
    return summary["success"], " ".join(summary["failures"]) or f"carried with up to {greatest:.0f} N", ""


def tables_of(scenario: Scenario, source: Source, middles: np.ndarray, yaw: np.ndarray) -> list[TableParameters]:
    """The table under both ends of a carry of which the hands' middle goes through (K, 3), m in W, turned by (K,)."""
    shape = scenario.box
    box = BoxParameters(source.dimensions.box_width or 0.0, shape.depth, shape.height, shape.mass, shape.friction)
    ends = [np.append(middles[k] - [0.0, 0.0, scenario.task.grasp_above], yaw[k]) for k in (0, -1)]
    return MakeSupports(*ends, box, same_level=True)


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


def sample(trials: Sequence[Trial], rows: Sequence[Mapping], most: int) -> list[RefusalCheck]:
    """The first `most` refusals of a reason that can be looked at."""
    checks = [
        RefusalCheck(trial, row["classes"][0])
        for trial, row in zip(trials, rows, strict=True)
        if row["verdict"] == "refused" and row["classes"][0] in CHECKS
    ]
    return checks[:most]


def refusals_right(rows: Sequence[Mapping]) -> Proportion | None:
    """The share of refusals shown to be right; None of none."""
    return proportion(sum(row["right"] for row in rows), len(rows)) if rows else None


def refusal_table(rows: Sequence[Mapping]) -> Table:
    """A row a refusal that was looked at."""
    names = ("task", "reason", "right", "evidence")
    return Table({name: [row[name] for row in rows] for name in names})
