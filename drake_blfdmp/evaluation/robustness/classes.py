"""What a task came to: one of four verdicts, and for every failure its classes, the likeliest cause first."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from typing import Literal

from drake_blfdmp.errors import BlfDmpError, SkillError
from drake_blfdmp.evaluation.success import Thresholds

Verdict = Literal["success", "failure", "refused", "crash"]

REFUSALS = ("reach", "force", "clearance", "input")
"""Why a planner refuses a task, as its errors say."""

CLASSES = (
    "crash",
    "diverged",
    "dropped",
    "collision",
    "joint limit",
    "speed limit",
    "effort",
    "squeeze",
    "violation",
    "unfinished",
    "tilt",
    "placement",
    "lift",
    "other",
)
"""In the order in which one explains the next: a box that is dropped is tilted and misplaced as well."""

LOGICAL = ("violation",)
"""Classes of a run in which the box may have been carried all the same: a link was out of its band."""


def failure_classes(summary: dict, thresholds: Thresholds = Thresholds()) -> list[str]:
    """The classes of a run without success, in the order of `CLASSES`; none of a success.

    Args:
        summary: `summary.json` of a run with a box.
    """
    box, robot = summary["box"], summary["robot"]
    limit = box["squeeze_limit_n"]
    missed: Mapping[str, bool] = {
        "dropped": box["dropped"],
        "collision": robot["min_clearance_m"] <= 0,
        "joint limit": robot["min_joint_margin_rad"] < 0,
        "speed limit": robot["max_velocity_ratio"] > 1,
        "effort": robot["max_effort_ratio"] >= 1,
        "squeeze": limit is not None and box["squeeze_force_n"][1] > limit,
        "violation": any(link["violations"] for link in summary["links"].values()),
        "unfinished": not summary["feedback"]["finished"],
        "tilt": box["max_tilt_deg"] > thresholds.tilt_deg,
        "placement": box["placement_error_m"] > thresholds.placement_m,
        "lift": box["lifted_m"] < thresholds.lifted_m,
    }
    found = [name for name in CLASSES if missed.get(name, False)]
    # Whatever success asks for that is not named above still makes a failure of the run.
    return found if found or summary["success"] else ["other"]


def physically_done(verdict: Verdict, classes: Sequence[str]) -> bool:
    """Whether the box was carried and placed within every limit, whatever the links did."""
    return verdict == "success" or (verdict == "failure" and not set(classes) - set(LOGICAL))


def planning_verdict(error: BlfDmpError, law: str) -> tuple[Verdict, str]:
    """What an error of the planner makes of a task, and its class.

    A motion that grows without bound is the fault of its law, not a task that cannot be done.
    """
    if isinstance(error, SkillError) and law != "default":
        return "failure", "diverged"
    return "refused", error.reason


def count_first(classes: Iterable[Sequence[str]]) -> dict[str, int]:
    """How often each class stands first, in the order of `CLASSES` and then of `REFUSALS`; those that never do not."""
    first = Counter(found[0] for found in classes if found)
    return {name: first[name] for name in (*CLASSES, *REFUSALS) if first[name]}
