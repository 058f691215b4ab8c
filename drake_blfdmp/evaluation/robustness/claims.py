"""What the project promises of its default law under variation, held against what came out."""

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from drake_blfdmp.evaluation.robustness.rates import LawRates, values
from drake_blfdmp.evaluation.studies.intervals import Proportion
from drake_blfdmp.evaluation.study import Claim

SHARE = 0.99
"""Least share of feasible tasks that succeed."""
RIGHT = 0.95
"""Least share of refusals that are right."""
PLACEMENT_MEDIAN_M, PLACEMENT_95_M, TILT_DEG = 0.003, 0.008, 3.0
ENOUGH = 100
"""Tasks from which on a share is judged even where its interval holds the target."""


def share_claim(paper: str, found: Proportion | None, target: float, why: str) -> Claim:
    """A share that shall be at least `target`; open where there are too few to tell.

    Args:
        why: it does not hold.
    """
    if found is None:
        return Claim(paper, "none", None, "there is none")
    if found.trials < ENOUGH and found.lower < target <= found.upper:
        return Claim(paper, found.percent(), None, f"{found.trials} are too few to tell")
    holds = found.share >= target
    return Claim(paper, found.percent(), holds, "" if holds else why)


def default_claims(rows: Sequence[Mapping], rates: LawRates) -> list[Claim]:
    """The claims on the default law.

    Args:
        rows: of the default law.
    """
    told = ", ".join(f"{count} {name}" for name, count in rates.classes.items()) or "none"
    return [
        share_claim(
            f"target: at least {100 * SHARE:g} % of the tasks that the planner calls feasible succeed",
            rates.success,
            SHARE,
            f"failures: {told}",
        ),
        limit(
            f"target: the box is placed within {1e3 * PLACEMENT_MEDIAN_M:g} mm (median) and "
            f"{1e3 * PLACEMENT_95_M:g} mm (95th percentile)",
            values(rows, "placement_error_m"),
            lambda x: f"{1e3 * np.median(x):.2f} mm and {1e3 * np.quantile(x, 0.95):.2f} mm in {len(x)} runs",
            lambda x: bool(np.median(x) <= PLACEMENT_MEDIAN_M and np.quantile(x, 0.95) <= PLACEMENT_95_M),
        ),
        limit(
            f"target: it never tilts by more than {TILT_DEG:g} degrees",
            values(rows, "max_tilt_deg"),
            lambda x: (
                f"median {np.median(x):.2f}, at most {x.max():.2f} degrees; {np.sum(x > TILT_DEG)} of {len(x)} "
                "runs tilt by more"
            ),
            lambda x: bool(x.max() <= TILT_DEG),
        ),
        limit(
            "target: no joint passes its position or speed limit, no actuator its effort",
            np.array(
                [
                    values(rows, "min_joint_margin_rad"),
                    values(rows, "max_velocity_ratio"),
                    values(rows, "max_effort_ratio"),
                ]
            ),
            lambda x: (
                f"{np.sum(x[0] < 0)}, {np.sum(x[1] > 1)} and {np.sum(x[2] >= 1)} of {x.shape[1]} runs; margin at "
                f"least {x[0].min():.3f} rad, speed at most {100 * x[1].max():.0f} %, effort {100 * x[2].max():.0f} %"
            ),
            lambda x: bool(x[0].min() >= 0 and x[1].max() <= 1 and x[2].max() < 1),
        ),
        limit(
            "target: nothing touches that must not",
            values(rows, "min_clearance_m"),
            lambda x: f"{np.sum(x <= 0)} of {len(x)} runs; clearance at least {1e3 * x.min():.1f} mm",
            lambda x: bool(x.min() > 0),
        ),
        limit(
            "target: no link leaves its band",
            values(rows, "violations"),
            lambda x: f"{np.sum(x > 0)} of {len(x)} runs",
            lambda x: not x.any(),
        ),
    ]


def limit(
    paper: str, found: np.ndarray, told: Callable[[np.ndarray], str], kept: Callable[[np.ndarray], bool]
) -> Claim:
    """A claim on measured numbers; open where no run was."""
    if found.size == 0:
        return Claim(paper, "no run", None, "every task was refused or crashed")
    holds = kept(found)
    return Claim(paper, told(found), holds, "" if holds else "the folder `failures` has a scenario for each failed run")


def law_claim(rates: Mapping[str, LawRates]) -> Claim:
    """Does the coupling matter to the box, or to the links alone?"""
    paper = "the coupling is what lets two arms carry the box: the other laws do worse on the same tasks"
    shown = {law: (one.success, one.physical) for law, one in rates.items() if one.success and one.physical}
    if set(shown) <= {"default"} or "default" not in shown:
        return Claim(paper, "only one law was tried", None, "give others a number in robustness.tasks")
    told = "; ".join(
        f"{law}: {success.count} succeed and {carried.count} carry the box of {carried.trials}"
        for law, (success, carried) in shown.items()
    )
    own = shown["default"][1].share
    worse = all(carried.share < own for law, (_, carried) in shown.items() if law != "default")
    return Claim(
        paper, told, worse, "" if worse else "a law carries the box as often, though its links leave their bands"
    )
