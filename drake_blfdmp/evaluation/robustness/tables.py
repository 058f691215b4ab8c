"""The study's tables: laws, classes of failure, sensors, and every task."""

from collections.abc import Mapping, Sequence

from drake_blfdmp.evaluation.robustness.classes import physically_done
from drake_blfdmp.evaluation.robustness.rates import LawRates
from drake_blfdmp.evaluation.studies.intervals import Proportion
from drake_blfdmp.evaluation.study import Table

MEASURED = (
    "placement_error_m",
    "max_tilt_deg",
    "lifted_m",
    "dropped",
    "max_slip_m",
    "least_force_n",
    "greatest_force_n",
    "violations",
    "largest_excess_m",
    "min_joint_margin_rad",
    "max_velocity_ratio",
    "max_effort_ratio",
    "min_clearance_m",
    "palm_tracking_rms_m",
    "scale",
    "stretch",
    "duration_s",
)

TIMED = ("plan_s", "run_s")
"""Wall time of a trial's planning and simulation."""


def law_table(rates: Mapping[str, LawRates]) -> Table:
    """A row a law, shares in per cent with their intervals."""
    rows = rates.values()
    return Table(
        {
            "law": [one.law for one in rows],
            "tasks": [one.tasks for one in rows],
            "feasible": [one.feasible for one in rows],
            "refused": [one.refused for one in rows],
            "succeed": [_told(one.success) for one in rows],
            "carry_the_box": [_told(one.physical) for one in rows],
        }
    )


def class_table(rates: Mapping[str, LawRates]) -> Table:
    """A row for each first class of a failure: in how many feasible tasks, law beside law."""
    names = list(dict.fromkeys(name for one in rates.values() for name in one.classes)) or ["none"]
    return Table({"class": names} | {law: [one.classes.get(name, 0) for name in names] for law, one in rates.items()})


def group_table(name: str, groups: Mapping[str, Proportion]) -> Table:
    """A row a group: success of the default law among its feasible tasks."""
    return Table(
        {
            name: list(groups),
            "feasible": [found.trials for found in groups.values()],
            "succeed": [_told(found) for found in groups.values()],
        }
    )


def task_table(rows: Sequence[Mapping]) -> Table:
    """Every row: what was drawn and what was measured; NaN where nothing was."""
    columns: dict[str, list] = {
        "law": [row["law"] for row in rows],
        "verdict": [row["verdict"] for row in rows],
        "classes": [" ".join(name.replace(" ", "_") for name in row["classes"]) for row in rows],
        "box_carried": [physically_done(row["verdict"], row["classes"]) for row in rows],
    }
    for name in rows[0]["task"]:
        drawn = [row["task"][name] for row in rows]
        if isinstance(drawn[0], str | int | float):
            columns[name] = drawn
        else:
            stem = name.removesuffix("_m")
            columns |= {f"{stem}_{axis}_m": [value[i] for value in drawn] for i, axis in enumerate("xyz")}
    for name in MEASURED:
        columns[name] = [_number(row, name) for row in rows]
    for end in ("start", "goal"):
        columns |= {f"{end}_{axis}_m": [_number(row, f"{end}_m", i) for row in rows] for i, axis in enumerate("xyz")}
    for name in TIMED:
        columns[name] = [float("nan") if row[name] is None else row[name] for row in rows]
    columns |= {"message": [row["message"] for row in rows], "notes": ["; ".join(row["notes"]) for row in rows]}
    return Table(columns, timed=TIMED)


def _number(row: Mapping, name: str, index: int | None = None) -> float:
    if row["measured"] is None:
        return float("nan")
    value = row["measured"][name]
    return float(value if index is None else value[index])


def _told(found: Proportion | None) -> str:
    return "-" if found is None else found.percent()
