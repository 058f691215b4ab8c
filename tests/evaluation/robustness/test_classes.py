"""Classes of failure agree with what a run counts as a success."""

from copy import deepcopy

import pytest

from drake_blfdmp.errors import RecordingError, SkillError, TaskError
from drake_blfdmp.evaluation.robustness.classes import (
    CLASSES,
    count_first,
    failure_classes,
    physically_done,
    planning_verdict,
)
from drake_blfdmp.evaluation.success import find_failures

GOOD = {
    "success": True,
    "plan": {"lift_m": 0.3},
    "links": {name: {"violations": 0, "largest_excess_m": 0.0} for name in ("hands", "left_forearm")},
    "box": {
        "dropped": False,
        "lifted_m": 0.25,
        "placement_error_m": 0.002,
        "max_tilt_deg": 0.5,
        "max_slip_m": 0.0,
        "squeeze_force_n": [45.0, 75.0],
        "squeeze_limit_n": 120.0,
    },
    "robot": {
        "min_joint_margin_rad": 0.2,
        "max_velocity_ratio": 0.5,
        "max_effort_ratio": 0.6,
        "min_clearance_m": 0.02,
        "palm_tracking_rms_m": 0.009,
    },
    "feedback": {"finished": True, "min_tempo": 1.0},
}
BAD = {
    "dropped": ("box", "dropped", True),
    "collision": ("robot", "min_clearance_m", 0.0),
    "joint limit": ("robot", "min_joint_margin_rad", -0.01),
    "speed limit": ("robot", "max_velocity_ratio", 1.01),
    "effort": ("robot", "max_effort_ratio", 1.0),
    "squeeze": ("box", "squeeze_force_n", [45.0, 121.0]),
    "unfinished": ("feedback", "finished", False),
    "tilt": ("box", "max_tilt_deg", 5.1),
    "placement": ("box", "placement_error_m", 0.0101),
    "lift": ("box", "lifted_m", 0.09),
}


def judged(*classes):
    summary = deepcopy(GOOD)
    for name in classes:
        if name == "violation":
            summary["links"]["hands"]["violations"] = 3
        else:
            part, entry, value = BAD[name]
            summary[part][entry] = value
    summary["failures"] = find_failures(summary)
    summary["success"] = not summary["failures"]
    return summary


@pytest.mark.parametrize("name", [*BAD, "violation"])
def test_each_missed_threshold_is_a_class_of_its_own(name):
    summary = judged(name)
    assert len(summary["failures"]) == 1
    assert failure_classes(summary) == [name]


def test_a_success_has_none():
    assert judged()["success"] and failure_classes(judged()) == []


def test_the_likeliest_cause_stands_first():
    assert failure_classes(judged("placement", "tilt", "dropped", "violation")) == [
        "dropped",
        "violation",
        "tilt",
        "placement",
    ]
    everything = failure_classes(judged(*BAD, "violation"))
    assert everything == [name for name in CLASSES if name in everything] and len(everything) == len(BAD) + 1


def test_a_threshold_that_has_no_class_yet_is_a_failure_all_the_same():
    assert failure_classes({**GOOD, "success": False, "failures": ["Something new."]}) == ["other"]


def test_a_box_may_be_carried_though_a_link_leaves_its_band():
    assert physically_done("success", [])
    assert physically_done("failure", ["violation"])
    assert not physically_done("failure", ["violation", "tilt"])
    assert not physically_done("refused", ["reach"]) and not physically_done("crash", ["crash"])


def test_a_planner_that_refuses_says_why_and_a_law_that_diverges_is_to_blame_itself():
    assert planning_verdict(TaskError("too far", reason="reach"), "default") == ("refused", "reach")
    assert planning_verdict(TaskError("too heavy", reason="force"), "none") == ("refused", "force")
    assert planning_verdict(RecordingError("no holding"), "default") == ("refused", "input")
    assert planning_verdict(SkillError("grows without bound"), "published_lagged") == ("failure", "diverged")
    assert planning_verdict(SkillError("too few samples"), "default") == ("refused", "input")


def test_classes_are_counted_by_their_first():
    found = [["dropped", "tilt"], [], ["tilt"], ["dropped"], ["reach"]]
    assert count_first(found) == {"dropped": 2, "tilt": 1, "reach": 1}
    assert list(count_first([["tilt"], ["crash"]])) == ["crash", "tilt"]
