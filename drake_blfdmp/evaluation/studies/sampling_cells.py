"""Random problems at many rates and pairs of gains: in how many of them the sampled default law leaves a band.

`Gains.check` enforces a longest step for every pair; a cell is one pair at one step, whether allowed or not.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from drake_blfdmp.evaluation.studies.intervals import proportion
from drake_blfdmp.evaluation.studies.random_problems import Job, Outcome, Problems, run_jobs
from drake_blfdmp.evaluation.study import Table
from drake_blfdmp.planning.task import Task
from drake_blfdmp.skill.sampled import Gains


@dataclass(frozen=True)
class Cell:
    """One rate and one pair of gains, and what came of `problems` there."""

    family: str
    gains: Gains
    step: float
    problems: int
    left: int
    least_margin: float

    @property
    def allowed(self) -> bool:
        """Whether `Gains.check` lets it pass."""
        return self.step <= self.gains.largest_step()


def gains_of(total: float, ratio: float) -> Gains:
    """Gains of a sum k_1 + k_2, 1/s, and a ratio k_2 / k_1."""
    return Gains(total / (1.0 + ratio), total * ratio / (1.0 + ratio))


def repeated(problems: Problems, gains: list[Gains]) -> Problems:
    """The problems once with each pair of gains, pair after pair."""
    n = len(problems)
    return problems[np.tile(np.arange(n), len(gains))].with_gains(
        np.repeat([pair.k_1 for pair in gains], n), np.repeat([pair.k_2 for pair in gains], n)
    )


def cells(families: list[str], gains: list[Gains], step: float, outcome: Outcome) -> list[Cell]:
    """The outcome of `repeated` problems at one step, pair by pair."""
    least = outcome.least.min(axis=1).reshape(len(gains), -1)
    left = outcome.left.any(axis=1).reshape(len(gains), -1)
    return [
        Cell(family, pair, step, left.shape[1], int(left[i].sum()), float(least[i].min()))
        for i, (family, pair) in enumerate(zip(families, gains, strict=True))
    ]


def jury(gains: Gains) -> float:
    """The longest step, s, of a stable loop near the middle of the band (`docs/sampling.md`)."""
    k_1, k_2 = float(gains.k_1), float(gains.k_2)
    total, stiffness = k_1 + k_2, 1.0 + k_1 * k_2
    return min(2.0 / total, 2.0 * total / stiffness)


@dataclass(frozen=True)
class Grid:
    """What is tried: every rate with every pair of gains, and every pair once more at its longest allowed step.

    Attributes:
        rates: (R,) Hz.
        totals: (T,) k_1 + k_2, 1/s.
        ratios: family's name to k_2 / k_1.
    """

    rates: Sequence[float]
    totals: Sequence[float]
    ratios: Mapping[str, float]

    @property
    def pairs(self) -> list[tuple[str, Gains]]:
        """Family and gains of every pair."""
        return [(family, gains_of(total, ratio)) for family, ratio in self.ratios.items() for total in self.totals]


def run_grid(
    grid: Grid,
    task: Task,
    problems: Problems,
    count: int,
    workers: int = 1,
    progress: Callable[[float], None] = lambda share: None,
) -> tuple[list[Cell], list[Cell]]:
    """The cells of the grid, rate by rate, and those at the longest steps.

    Args:
        problems: run at the longest steps, as far as these are no finer than the grid's finest; in the grid the first
            `count` of them are.
        workers, progress: as in `run_jobs`.
    """
    families, gains = (list(column) for column in zip(*grid.pairs, strict=True))
    edge = [i for i, pair in enumerate(gains) if pair.largest_step() >= 1.0 / max(grid.rates)]

    def job(step: float, pairs: list[Gains], many: int) -> Job:
        repeat = repeated(problems[:many], pairs)
        return Job(task.skill, task.bands.bones, float(task.bands.rate), repeat, "default", step)

    jobs = [job(1.0 / rate, gains, count) for rate in grid.rates]
    jobs += [job(gains[i].largest_step(), [gains[i]], len(problems)) for i in edge]
    outcomes = run_jobs(jobs, workers, progress)
    inner = [
        cell
        for rate, outcome in zip(grid.rates, outcomes, strict=False)
        for cell in cells(families, gains, 1.0 / rate, outcome)
    ]
    at_edge = [
        cell
        for i, outcome in zip(edge, outcomes[len(grid.rates) :], strict=True)
        for cell in cells([families[i]], [gains[i]], gains[i].largest_step(), outcome)
    ]
    return inner, at_edge


def shares(grid: Grid, found: Sequence[Cell], family: str) -> np.ndarray:
    """Share of problems in which a band is left, % (R, T), of one family; NaN where there is no cell."""
    share = np.full((len(grid.rates), len(grid.totals)), np.nan)
    for cell in found:
        if cell.family == family:
            row = int(np.argmin(np.abs(np.array(grid.rates) * cell.step - 1.0)))
            column = int(np.argmin(np.abs(np.array(grid.totals) - cell.gains.k_1 - cell.gains.k_2)))
            share[row, column] = 100.0 * cell.left / cell.problems
    return share


def as_table(found: list[Cell]) -> Table:
    """A row a cell."""
    intervals = [proportion(cell.left, cell.problems) for cell in found]
    columns: Mapping[str, list] = {
        "family": [cell.family for cell in found],
        "k_1_per_s": [cell.gains.k_1 for cell in found],
        "k_2_per_s": [cell.gains.k_2 for cell in found],
        "step_s": [cell.step for cell in found],
        "over_largest_step": [cell.step / cell.gains.largest_step() for cell in found],
        "problems": [cell.problems for cell in found],
        "left": [cell.left for cell in found],
        "upper_percent": [100.0 * interval.upper for interval in intervals],
        "least_margin": [cell.least_margin for cell in found],
    }
    return Table(columns)
