"""Rates on made-up rows, and their intervals against closed forms."""

import math

import numpy as np
import pytest

from drake_blfdmp.evaluation.robustness.claims import ENOUGH, default_claims, law_claim, share_claim
from drake_blfdmp.evaluation.robustness.rates import by_group, feasible_tasks, law_rates, values
from drake_blfdmp.evaluation.robustness.tables import class_table, law_table, task_table
from drake_blfdmp.evaluation.robustness.tasks import draw_task
from drake_blfdmp.evaluation.studies.intervals import proportion

FINE = {
    "placement_error_m": 0.002,
    "max_tilt_deg": 0.5,
    "lifted_m": 0.25,
    "dropped": False,
    "max_slip_m": 1e-4,
    "least_force_n": 45.0,
    "greatest_force_n": 75.0,
    "violations": 0,
    "largest_excess_m": 0.0,
    "min_joint_margin_rad": 0.2,
    "max_velocity_ratio": 0.5,
    "max_effort_ratio": 0.6,
    "min_clearance_m": 0.02,
    "palm_tracking_rms_m": 0.009,
    "scale": 1.0,
    "stretch": 1.2,
    "duration_s": 14.0,
    "start_m": [0.0, 0.4, 0.6],
    "goal_m": [0.1, 0.5, 0.6],
}


def row(index, verdict="success", classes=(), law="default", **measured):
    ran = verdict in ("success", "failure")
    return {
        "law": law,
        "task": draw_task(0, index).as_dict(),
        "verdict": verdict,
        "classes": list(classes),
        "message": "",
        "notes": ["slowed down", "release moved"] if ran else [],
        "measured": FINE | measured if ran else None,
        "plan_s": None if verdict == "crash" else 2.0,
        "run_s": 9.0 if ran else None,
    }


ROWS = [
    row(0),
    row(1, "refused", ["reach"]),
    row(2, "failure", ["violation"], violations=4),
    row(3, "failure", ["dropped", "tilt"], max_tilt_deg=40.0),
    row(4, "crash", ["crash"]),
]


def test_rates_are_of_the_feasible_tasks():
    feasible = feasible_tasks(ROWS)
    assert feasible == {0, 2, 3, 4}
    rates = law_rates("default", ROWS, feasible)
    assert (rates.tasks, rates.feasible, rates.refused) == (5, 4, 1)
    assert rates.success == proportion(1, 4) and rates.physical == proportion(2, 4)
    assert rates.classes == {"crash": 1, "dropped": 1, "violation": 1}


def test_another_law_is_judged_by_the_tasks_that_the_default_planner_accepts():
    other = [row(0, "refused", ["reach"], "gams"), row(1, law="gams"), row(2, law="gams")]
    rates = law_rates("gams", other, feasible_tasks(ROWS))
    assert rates.success == proportion(1, 2)
    assert rates.refused == 1 and rates.classes == {"reach": 1}


def test_no_feasible_task_has_no_rate():
    refused = [row(0, "refused", ["reach"])]
    rates = law_rates("default", refused, feasible_tasks(refused))
    assert rates.success is None and rates.physical is None
    claims = default_claims(refused, rates)
    assert all(claim.holds is None for claim in claims)


def test_intervals_are_those_of_clopper_and_pearson():
    """With no failure, or nothing but failures, the exact interval's end is (alpha/2)^(1/n)."""
    for n in (1, 20, 1000):
        end = 0.025 ** (1.0 / n)
        assert proportion(n, n)[2:] == pytest.approx((end, 1.0))
        assert proportion(0, n)[2:] == pytest.approx((0.0, 1.0 - end))
    found = proportion(990, 1000)
    for bound, tail in ((found.lower, range(990, 1001)), (found.upper, range(991))):
        mass = sum(
            math.exp(
                math.lgamma(1001) - math.lgamma(k + 1) - math.lgamma(1001 - k)
                + k * math.log(bound) + (1000 - k) * math.log1p(-bound)
            )
            for k in tail
        )  # fmt: skip
        assert mass == pytest.approx(0.025, rel=1e-6)


def test_a_share_is_open_while_there_are_too_few_tasks_to_tell():
    assert share_claim("p", proportion(20, 20), 0.99, "w").holds is None
    assert share_claim("p", proportion(15, 20), 0.99, "w").holds is False
    assert share_claim("p", proportion(ENOUGH, ENOUGH), 0.99, "w").holds is True
    assert share_claim("p", proportion(989, 1000), 0.99, "w").holds is False
    assert share_claim("p", None, 0.99, "w").holds is None


@pytest.mark.parametrize(
    ("which", "change"),
    [
        (1, {"placement_error_m": 0.02}),
        (2, {"max_tilt_deg": 3.1}),
        (3, {"min_joint_margin_rad": -0.01}),
        (3, {"max_velocity_ratio": 1.1}),
        (3, {"max_effort_ratio": 1.0}),
        (4, {"min_clearance_m": -0.001}),
        (5, {"violations": 1}),
    ],
)
def test_each_claim_can_fail_and_alone(which, change):
    rows = [row(i) for i in range(3)]
    rates = law_rates("default", rows, feasible_tasks(rows))
    assert [claim.holds for claim in default_claims(rows, rates)][1:] == [True] * 5
    rows.append(row(3, **change))
    verdicts = [claim.holds for claim in default_claims(rows, rates)]
    assert [i for i, holds in enumerate(verdicts) if holds is False] == [which]


def test_laws_are_compared_by_the_box_not_by_the_links():
    rows = {"default": [row(0), row(1)], "none": [row(i, "failure", ["violation"], "none") for i in range(2)]}
    rates = {law: law_rates(law, found, {0, 1}) for law, found in rows.items()}
    assert law_claim(rates).holds is False
    rates["none"] = law_rates("none", [row(0, "failure", ["dropped"], "none"), rows["none"][1]], {0, 1})
    assert law_claim(rates).holds is True
    assert law_claim({"default": rates["default"]}).holds is None


def test_tables_have_a_row_for_each_task_and_law():
    rates = {"default": law_rates("default", ROWS, feasible_tasks(ROWS))}
    assert law_table(rates).rows() == [("default", 5, 4, 1, proportion(1, 4).percent(), proportion(2, 4).percent())]
    assert class_table(rates).rows() == [("crash", 1), ("dropped", 1), ("violation", 1)]
    columns = task_table(ROWS).columns
    assert columns["verdict"] == [one["verdict"] for one in ROWS]
    assert columns["box_carried"] == [True, False, True, False, False]
    np.testing.assert_array_equal(columns["max_tilt_deg"], [0.5, np.nan, 0.5, 40.0, np.nan])
    assert columns["place_offset_x_m"][3] == draw_task(0, 3).place_offset_m[0]
    assert columns["goal_y_m"][0] == 0.5
    assert columns["notes"][:2] == ["slowed down; release moved", ""]


def test_groups_leave_out_what_was_refused():
    groups = by_group(ROWS, "sensor")
    assert sum(found.trials for found in groups.values()) == 4
    assert sum(found.count for found in groups.values()) == 1
    assert list(values(ROWS, "max_tilt_deg")) == [0.5, 0.5, 40.0]
