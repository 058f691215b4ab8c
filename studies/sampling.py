"""Beyond the paper: at which rates and gains the sampled law still keeps its bands, and what is enforced."""

import numpy as np

from drake_blfdmp.evaluation.studies.intervals import proportion
from drake_blfdmp.evaluation.studies.random_problems import Spread, draw_problems
from drake_blfdmp.evaluation.studies.sampling_cells import Cell, Grid, as_table, gains_of, jury, run_grid, shares
from drake_blfdmp.evaluation.study import Claim, Study, StudyContext
from drake_blfdmp.planning.sources import LoadSource
from drake_blfdmp.planning.task import MakeMotion, MakeTask
from drake_blfdmp.viewing.drawing import Drawing
from drake_blfdmp.viewing.study_figures.sampling import regions

RATES = (10.0, 20.0, 30.0, 50.0, 100.0, 150.0, 200.0, 300.0, 500.0, 1000.0, 2000.0)
"""Hz; the paper's recording has 30."""
TOTALS = tuple(float(total) for total in np.geomspace(4.0, 256.0, 10))
"""K_1 + k_2, 1/s."""
RATIOS = {"k_2 = 2.5 k_1": 2.5, "k_1 = 3 k_2": 1.0 / 3.0}
"""K_2 / k_1: that of the default gains, and one with most of the damping in k_1."""
COUNT, EDGE_COUNT = 100, 250
QUICK_COUNT, QUICK_RATES, QUICK_TOTALS, QUICK_TAU = 4, (10.0, 30.0, 100.0, 200.0), (8.0, 28.0, 64.0), (0.5, 0.6)


def slowest(family: str, total: float) -> tuple[float, float]:
    """The lowest rate that is enforced with gains of this sum, and that of the linear bound, Hz."""
    gains = gains_of(total, RATIOS[family])
    return 1.0 / gains.largest_step(), 1.0 / jury(gains)


def study(context: StudyContext) -> Study:
    """A grid of rates and gains, and the edge of what is enforced on its own."""
    scenario, quick = context.scenario, context.quick
    context.progress("drawing problems", 0.0)
    source = LoadSource(scenario)
    task = MakeTask(scenario, source, MakeMotion(scenario, source))
    rates, totals = (QUICK_RATES, QUICK_TOTALS) if quick else (RATES, TOTALS)
    count, edge_count = (QUICK_COUNT, QUICK_COUNT) if quick else (COUNT, EDGE_COUNT)
    grid = Grid(rates, totals, RATIOS)
    spread = Spread(tau=QUICK_TAU) if quick else Spread()
    problems = draw_problems(task.skill, edge_count, scenario.seed, 1.0 / max(rates), spread)
    inner, at_edge = run_grid(
        grid, task, problems, count, 1 if quick else context.workers, lambda share: context.progress("running", share)
    )
    shown = {family: shares(grid, inner, family) for family in RATIOS}

    fine = np.geomspace(totals[0], totals[-1], 200)
    bounds = {family: np.transpose([slowest(family, total) for total in fine]) for family in RATIOS}

    context.progress("drawing", 1.0)
    return Study(
        claims=make_claims(inner, at_edge),
        figures={"regions": Drawing(regions, shown, totals, rates, fine, bounds)},
        captions={
            "regions": f"Share of {count} random problems a cell in which a link leaves its band (empty: none), the "
            "limit that is enforced, and the linear bound."
        },
        tables={"cells": as_table(inner), "edge": as_table(at_edge)},
        notes=[
            f"Problems are drawn as in the study 'guarantee' (starts, goals, durations of {spread.tau[0]:g} to "
            f"{spread.tau[1]:g} times {task.skill.tau:.2f} s, bands), the same ones in every cell, each run to its "
            "end.",
            "Bands are looked at at the samples; what a robot does between them at 10 Hz is not.",
            "Gains whose longest allowed step is below the finest one here have no cell in the table 'edge'.",
        ],
        shown=["edge"],
    )


def make_claims(grid: list[Cell], at_edge: list[Cell]) -> list[Claim]:
    """What the cells say."""
    inside = [cell for cell in grid if cell.allowed]
    outside = [cell for cell in grid if not cell.allowed]
    claims = []
    for where, found in (("inside the enforced region", inside), ("on its edge, at the longest step allowed", at_edge)):
        left, problems = sum(cell.left for cell in found), sum(cell.problems for cell in found)
        if not problems:
            claims.append(Claim(f"target: no band is left {where}", "no cell there", None, "the grid has none"))
            continue
        bad = ", ".join(
            f"k_1 {cell.gains.k_1:.3g}, k_2 {cell.gains.k_2:.3g} 1/s, {1e3 * cell.step:.3g} ms"
            for cell in found
            if cell.left
        )
        claims.append(
            Claim(
                f"target: no band is left {where}",
                f"bands left in {proportion(left, problems).percent()}, {len(found)} cells; least margin "
                f"{min(cell.least_margin for cell in found):.3f}",
                left == 0,
                f"left with {bad}" if left else "",
            )
        )
    bad = [cell for cell in outside if cell.left]
    nearest = min(bad, key=lambda cell: cell.step / cell.gains.largest_step(), default=None)
    claims.append(
        Claim(
            "the limit is not idle: outside, bands are left",
            "in no cell"
            if nearest is None
            else f"in {len(bad)} of {len(outside)} cells outside; nearest to the region at "
            f"{nearest.step / nearest.gains.largest_step():.2f} times the longest step (k_1 {nearest.gains.k_1:.3g}, "
            f"k_2 {nearest.gains.k_2:.3g} 1/s, {1.0 / nearest.step:g} Hz: {nearest.left} of {nearest.problems})",
            nearest is not None,
            "" if nearest else "the limits could be wider than they are",
        )
    )
    slow = [cell for cell in grid if abs(30.0 * cell.step - 1.0) < 1e-9]
    best = min(slow, key=lambda cell: cell.left / cell.problems)
    claims.append(
        Claim(
            "the law can run at the recording's 30 Hz",
            f"of {len(slow)} pairs of gains the best (k_1 {best.gains.k_1:.3g}, k_2 {best.gains.k_2:.3g} 1/s) leaves "
            f"bands in {best.left} of {best.problems} problems",
            best.left == 0,
            "" if best.left == 0 else "soft gains give way to what changes within a step, stiff ones overshoot",
        )
    )
    return claims
