"""A sentence for each threshold that is missed, and none for what is kept."""

import copy

import pytest

from drake_blfdmp.evaluation.success import Thresholds, find_failures

FORCE = {"squeeze_force_n": [49.0, 75.0], "squeeze_limit_n": 120.0}

GOOD = {
    "links": {
        "left_upper_arm": {"violations": 0, "largest_excess_m": 0.0},
        "hands": {"violations": 0, "largest_excess_m": 0.0},
    },
    "plan": {"lift_m": 0.24},
    "box": {"dropped": False, "lifted_m": 0.23, "placement_error_m": 0.002, "max_tilt_deg": 0.3} | FORCE,
    "feedback": {"finished": True, "min_tempo": 1.0},
    "robot": {
        "min_joint_margin_rad": 0.4,
        "max_velocity_ratio": 0.5,
        "max_effort_ratio": 0.5,
        "min_clearance_m": 0.02,
    },
}


def changed(section, key, value):
    summary = copy.deepcopy(GOOD)
    summary[section][key] = value
    return summary


def test_a_good_run_has_no_failures():
    assert find_failures(GOOD) == []


@pytest.mark.parametrize(
    ("section", "key", "kept", "missed", "words"),
    [
        ("box", "dropped", False, True, ["dropped"]),
        ("box", "lifted_m", 0.1, 0.0999, ["0.100 m only", "0.10 m", "0.240 m"]),
        ("box", "placement_error_m", 0.01, 0.0123, ["12.3 mm", "10 mm"]),
        ("box", "max_tilt_deg", 5.0, 5.4, ["5.4 degrees", "more than 5"]),
        ("box", "squeeze_force_n", [49.0, 120.0], [49.0, 131.4], ["131 N", "more than 120 N"]),
        ("feedback", "finished", True, False, ["was not finished"]),
        ("robot", "min_joint_margin_rad", 0.0, -0.012, ["joint passed its limit", "0.012 rad"]),
        ("robot", "max_velocity_ratio", 1.0, 1.07, ["1.07 times its velocity limit"]),
        ("robot", "max_effort_ratio", 0.999, 1.0, ["effort limit"]),
        ("robot", "min_clearance_m", 1e-6, -0.0034, ["3.4 mm"]),
    ],
)
def test_each_threshold_has_its_sentence_and_its_side(section, key, kept, missed, words):
    assert find_failures(changed(section, key, kept)) == []
    (sentence,) = find_failures(changed(section, key, missed))
    for word in words:
        assert word in sentence
    assert sentence.endswith(".")
    assert "\n" not in sentence


def test_touching_bodies_do_not_pass():
    assert len(find_failures(changed("robot", "min_clearance_m", 0.0))) == 1


def test_a_link_that_leaves_its_band_is_named():
    summary = copy.deepcopy(GOOD)
    summary["links"]["hands"] = {"violations": 12, "largest_excess_m": 0.0071}
    (sentence,) = find_failures(summary)
    for word in ("hands", "12 steps", "7.1 mm"):
        assert word in sentence


def test_every_miss_is_told():
    summary = copy.deepcopy(GOOD)
    summary["box"] = {"dropped": True, "lifted_m": 0.01, "placement_error_m": 0.3, "max_tilt_deg": 60.0} | FORCE
    assert len(find_failures(summary)) == 4


def test_other_thresholds_judge_otherwise():
    assert find_failures(GOOD, Thresholds(lifted_m=0.3))
    assert not find_failures(changed("box", "max_tilt_deg", 7.0), Thresholds(tilt_deg=8.0))


MOTION = {
    "links": GOOD["links"],
    "plan": {"lift_m": None},
    "box": None,
    "feedback": GOOD["feedback"],
    "robot": {**GOOD["robot"], "palm_tracking_rms_m": 0.0004},
}


def test_without_a_box_the_palms_have_to_follow():
    assert find_failures(MOTION) == []
    off = {**MOTION, "robot": {**MOTION["robot"], "palm_tracking_rms_m": 0.0123}}
    (sentence,) = find_failures(off)
    assert "12.3 mm off the plan" in sentence and "more than 10 mm" in sentence
    assert find_failures(off, Thresholds(tracking_m=0.02)) == []
    assert find_failures({**off, "box": GOOD["box"], "plan": GOOD["plan"]}) == []  # A squeeze keeps palms off theirs.


def test_without_a_box_links_joints_and_clearance_count_as_ever():
    broken = copy.deepcopy(MOTION)
    broken["links"]["hands"] = {"violations": 1, "largest_excess_m": 0.001}
    broken["robot"] |= {"min_joint_margin_rad": -0.1, "max_velocity_ratio": 1.2, "max_effort_ratio": 1.0}
    broken["robot"]["min_clearance_m"] = -0.001
    assert len(find_failures(broken)) == 5
