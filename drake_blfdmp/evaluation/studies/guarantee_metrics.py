"""What outcomes on random problems say of the promise that no band is left: shares, tables, and where it begins."""

from collections.abc import Mapping

import numpy as np

from drake_blfdmp.evaluation.studies.intervals import Proportion, proportion
from drake_blfdmp.evaluation.studies.random_problems import Outcome, Problems
from drake_blfdmp.evaluation.study import Table
from drake_blfdmp.skeleton import HANDS, LINKS
from drake_blfdmp.skill.bands import Bands
from drake_blfdmp.skill.geometry import link_lengths, link_vectors


def outside_axes(start: np.ndarray, bands: Bands) -> np.ndarray:
    """Whether the published law starts outside its bound on some axis, (P,): |rho - d| |n^i| > sigma / sqrt(3).

    Args:
        start: (P, 6, 3) m.
        bands: of these problems, opened or not.
    """
    r, rho = link_vectors(start), link_lengths(start)
    error = np.abs((rho - bands.desired(0.0)[0]) / rho)[..., None] * np.abs(r)
    return np.any(error > (bands.half_widths(0.0)[0] / np.sqrt(3.0))[..., None], axis=(1, 2))


def violations(outcome: Outcome) -> Proportion:
    """The share of problems in which any link left its band."""
    return proportion(int(outcome.left.any(axis=1).sum()), len(outcome.left))


def by_run(outcomes: Mapping[str, Outcome]) -> Table:
    """Of every run: problems in which a band is left, with the interval of their share, and the least margin."""
    left = [violations(outcome) for outcome in outcomes.values()]
    return Table(
        {
            "law": list(outcomes),
            "problems": [p.trials for p in left],
            "left": [p.count for p in left],
            "share_percent": [100.0 * p.share for p in left],
            "lower_percent": [100.0 * p.lower for p in left],
            "upper_percent": [100.0 * p.upper for p in left],
            "least_margin": [float(outcome.least.min()) for outcome in outcomes.values()],
        }
    )


def by_link(outcomes: Mapping[str, Outcome]) -> Table:
    """Of every run and link: problems in which it left its band, and its least margin."""
    rows = [(name, outcome, i) for name, outcome in outcomes.items() for i in range(len(LINKS))]
    return Table(
        {
            "law": [name for name, _, _ in rows],
            "link": [LINKS[i].name for _, _, i in rows],
            "problems": [len(outcome.left) for _, outcome, _ in rows],
            "left": [int(outcome.left[:, i].sum()) for _, outcome, i in rows],
            "least_margin": [float(outcome.least[:, i].min()) for _, outcome, i in rows],
        }
    )


def by_problem(problems: Problems, outcome: Outcome) -> Table:
    """Every problem's duration, gains and bands, its least margin, and when it first left a band."""
    return Table(
        {
            "tau_s": problems.tau,
            "k_1_per_s": problems.k_1,
            "k_2_per_s": problems.k_2,
            "half_width_m": problems.half_width_m,
            "closing_s": problems.closing_s,
            "hands_at_start_m": link_lengths(problems.start)[:, HANDS],
            "least_margin": outcome.least.min(axis=1),
            "first_left_s": outcome.left_s.min(axis=1),
        }
    )
