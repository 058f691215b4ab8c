"""Whether what the planner refuses cannot be done: looked at once more, by other means than the planner's."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from drake_blfdmp.errors import BlfDmpError
from drake_blfdmp.evaluation.robustness.joined_postures import JoinedPostures
from drake_blfdmp.evaluation.robustness.reach_search import ReachSearch, Way
from drake_blfdmp.evaluation.robustness.trial import Trial
from drake_blfdmp.evaluation.robustness.wanted_way import clear_of, every_other, wanted_way
from drake_blfdmp.evaluation.simulation import Judge
from drake_blfdmp.evaluation.studies.intervals import Proportion, proportion
from drake_blfdmp.evaluation.study import Table
from drake_blfdmp.planning.plan import MakePlan
from drake_blfdmp.planning.scenario import Scenario
from drake_blfdmp.planning.sources import LoadSource
from drake_blfdmp.robot.kinematics import DualArmKinematics
from drake_blfdmp.robot.plant import ARMS, MakeKinematicPlant, ReadJointLimits
from drake_blfdmp.robot.reach_evaluation import kept_limits

PLACES_TRIED = 4
"""How many of the places that the search finds for a yaw are given to the planner."""

SQUEEZES = (0.7, 0.8, 0.6, 0.9, 0.5, 0.4)
"""Of the force limit, what a box is squeezed with, likely ones first."""

YAW_SHARES = (1.0, 0.5, 0.0)
LARGEST_YAW = np.deg2rad(45.0)
"""Shares of the yaw of the person's hands, and the largest, rad."""

OVER = (None, 0.15)
"""Ways that are looked at: as the person leads the box, and straight up, over so high over the higher end, and down, m.
"""


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
    """Right where at no place and scale the palms carry the box along one of the ways `OVER`, clear of all that stands.

    That is `kept_limits` and `retarget.clearance`, which the arms keep by construction, whatever the plan. What the
    search finds is given to the planner, place and scale fixed: a plan there that succeeds shows that the refusal was
    wrong. Where none does, nothing is shown.
    """
    source = LoadSource(scenario)
    fine, middle = wanted_way(scenario, source)
    apart = np.array([distances[0] for distances in fine.apart])
    plant = MakeKinematicPlant()
    own = ReadJointLimits(plant, [plant.GetModelInstanceByName(arm) for arm in ARMS])
    limits = kept_limits(own, DualArmKinematics(plant))
    search, joined = ReachSearch(limits=limits), JoinedPostures(limits, scenario.retarget.clearance or 0.0)
    looked_at, had, found = 0, 0, []
    for share, over in product(YAW_SHARES, OVER):  # As the planner may limit and lead it.
        way = replace(fine, yaw=share * np.clip(fine.yaw, -LARGEST_YAW, LARGEST_YAW), over=over)

        def gets_along(place: np.ndarray, scale: float, way: Way = way) -> bool:
            middles = way.middles(place, scale)
            clear = clear_of(scenario, source, way.level, middles, way.yaw)
            return clear is not None and joined.get_along(middles, way.yaw, apart, clear)

        places, *counts = search.search(every_other(way), most=PLACES_TRIED, joined=gets_along)
        looked_at, had = looked_at + counts[0], had + counts[1]
        found += [one for one in places if not any(_same(one, other) for other in found)]
    if not found:
        if not had:
            return True, f"no postures along the way at any of {looked_at} pairs of a place and a scale"
        there = f"postures at {had} of {looked_at} pairs of a place and a scale"
        return True, f"{there}, but the arms jump, or get into each other, the box or a table, or it into one"
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
