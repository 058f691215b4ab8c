"""What a run prints at its end, with a box and without one."""

import copy

import pytest

from drake_blfdmp.evaluation.console import report

LINK = {"desired_m": 0.22, "min_m": 0.219, "max_m": 0.231, "violations": 0, "samples_until_inside": 4}
SUMMARY = {
    "success": True,
    "failures": [],
    "law": "default",
    "recording": {
        "source": "carry.csv",
        "synthetic": False,
        "repairs": {"jumps_removed": 3, "swaps_undone": 0},
        "held_s": [1.5, 4.25],
        "played_s": [0.8, 4.95],
    },
    "links": {"left_upper_arm": LINK, "hands": {**LINK, "desired_m": 0.276}},
    "links_uncoupled": {"left_upper_arm": LINK, "hands": LINK},
    "plan": {"notes": ["slowed down"], "scale": 0.8, "world_m": [0.0, 0.3, 1.0], "box_width_m": 0.3},
    "robot": {
        "palm_tracking_rms_m": 0.0004,
        "min_joint_margin_rad": 0.4,
        "max_effort_ratio": 0.2,
        "max_velocity_ratio": 0.5,
        "min_clearance_m": 0.05,
    },
    "box": {
        "lifted_m": 0.26,
        "placement_error_m": 0.002,
        "max_tilt_deg": 0.3,
        "squeeze_force_n": [49.0, 75.0],
        "max_slip_m": 0.0002,
    },
    "timing": {"simulated_s": 10.0, "wall_s": 5.0, "realtime_rate": 2.0},
}


@pytest.fixture
def motion():
    summary = copy.deepcopy(SUMMARY)
    summary["box"] = summary["recording"]["held_s"] = summary["plan"]["box_width_m"] = None
    summary["links"]["hands"]["desired_m"] = None
    return summary


def test_a_hold_tells_of_its_box():
    text = report(SUMMARY)
    assert "held from 1.50 to 4.25 s, box 0.300 m wide; repairs: 3 jumps removed\n" in text
    assert "box    lifted 0.260 m" in text
    assert "0.276 m" in text
    assert text.endswith("\nsuccess")


def test_a_motion_tells_what_was_played_and_nothing_of_a_box(motion):
    text = report(motion)
    assert "played from 0.80 to 4.95 s, without a box; repairs: 3 jumps removed\n" in text
    assert "\nbox " not in text and "lifted" not in text and "None" not in text
    assert "palms follow within 0.4 mm" in text


def test_the_columns_stand_below_each_other_whether_the_hands_distance_moves_or_not(motion):
    for summary in (SUMMARY, motion):
        rows = [line for line in report(summary).splitlines() if line.startswith(("link ", "left_", "hands"))]
        assert len({len(row) for row in rows}) == 1
    assert next(row for row in rows if row.startswith("hands")).split()[1] == "moving"
