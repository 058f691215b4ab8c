"""From the rows of trials to shares with intervals, quantiles and counts: pure functions."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from drake_blfdmp.evaluation.robustness.classes import count_first, physically_done
from drake_blfdmp.evaluation.studies.intervals import Proportion, proportion


@dataclass(frozen=True)
class LawRates:
    """How one law does on tasks.

    Attributes:
        tasks: how many it was tried on.
        feasible: those of them that the planner with the default law does not refuse.
        refused: those that the planner refuses with this law.
        success: of the feasible, as `summary.json` has it; None where there are none.
        physical: of the feasible, those in which the box is carried and placed within every limit, whatever the links
            did; None where there are none.
        classes: first class of every failure and crash of a feasible task, to its number.
    """

    law: str
    tasks: int
    feasible: int
    refused: int
    success: Proportion | None
    physical: Proportion | None
    classes: Mapping[str, int]


def index_of(row: Mapping) -> int:
    """Which task of its seed a row is about."""
    return int(row["task"]["index"])


def feasible_tasks(default_rows: Sequence[Mapping]) -> set[int]:
    """The indices of tasks that were planned; a planner that crashed has refused nothing."""
    return {index_of(row) for row in default_rows if row["verdict"] != "refused"}


def law_rates(law: str, rows: Sequence[Mapping], feasible: set[int]) -> LawRates:
    """The rates of a law's rows; `feasible` as `feasible_tasks` has it."""
    counted = [row for row in rows if index_of(row) in feasible]
    done = sum(row["verdict"] == "success" for row in counted)
    carried = sum(physically_done(row["verdict"], row["classes"]) for row in counted)
    return LawRates(
        law=law,
        tasks=len(rows),
        feasible=len(counted),
        refused=sum(row["verdict"] == "refused" for row in rows),
        success=proportion(done, len(counted)) if counted else None,
        physical=proportion(carried, len(counted)) if counted else None,
        classes=count_first(row["classes"] for row in counted),
    )


def values(rows: Sequence[Mapping], name: str) -> np.ndarray:
    """A measured number of all rows that have it: (N,)."""
    return np.array([row["measured"][name] for row in rows if row["measured"] is not None], dtype=float)


def by_group(rows: Sequence[Mapping], name: str) -> dict[str, Proportion]:
    """Success of the rows that were not refused, by a task's entry, as `sensor`: group to share."""
    groups: dict[str, list[bool]] = {}
    for row in rows:
        if row["verdict"] != "refused":
            groups.setdefault(str(row["task"][name]), []).append(row["verdict"] == "success")
    return {group: proportion(sum(found), len(found)) for group, found in sorted(groups.items())}
