"""Runs with other redundancy resolutions: phases, rows and means of series made by hand, and one short simulation."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from drake_blfdmp.evaluation.studies.redundancy_runs import (
    BasePlaces,
    RedundancyRun,
    SimulatePlan,
    held_means,
    phase_times,
    posture_row,
    swivel_series,
)
from drake_blfdmp.planning.plan import MakePlan
from drake_blfdmp.robot.redundancy import ElbowKinematics

T = np.linspace(0.0, 10.0, 101)


def made_by_hand():
    """The box rises from 0.5 to 0.9 m between 3 and 5 s; palms 0.30 m apart, asked for 0.28 m, 20 N from 2 to 8 s."""
    palm, asked = np.zeros((len(T), 2, 7)), np.zeros((len(T), 2, 7))
    palm[:, 1, 4], asked[:, 1, 4] = 0.30, 0.28
    box = np.zeros((len(T), 7))
    box[:, 6] = np.interp(T, [3.0, 5.0, 6.0, 8.0], [0.5, 0.9, 0.9, 0.5])
    held = (T >= 2.0) & (T <= 8.0)
    log = SimpleNamespace(
        t=T,
        box_desired=box,
        palm=palm,
        palm_desired=asked,
        palm_force=np.where(held[:, None], [18.0, 22.0], 0.0),
        swivel=np.full((len(T), 2), 0.3) + np.where(T < 1.0, 1.0, 0.01)[:, None],
        swivel_desired=np.full((len(T), 2), 0.3),
        events=(("close", 1.5), ("hold", 2.0), ("open", 8.0), ("released", 8.5)),
    )
    plan = SimpleNamespace(settle_s=1.0, task=SimpleNamespace(held=(2.0, 8.0)))
    summary = {
        "robot": {"palm_tracking_rms_m": 0.01, "min_joint_margin_rad": 0.4, "max_effort_ratio": 0.5},
        "box": {"max_tilt_deg": 1.0, "placement_error_m": 0.002},
        "success": False,
        "failures": ["The box was dropped.", "It tilted."],
    }
    off = np.where(T < 1.0, 0.1, 0.003)[:, None] * [1.0, 2.0]
    return RedundancyRun(plan, log, summary, log.swivel - log.swivel_desired, off)


def test_phases_follow_the_events_and_the_boxs_way_up():
    run = made_by_hand()
    times = phase_times(run.plan, run.log)
    assert list(times) == ["start", "approach", "grasp", "lift", "carry", "place", "release"]
    assert list(times.values()) == pytest.approx([1.0, 1.5, 2.0, 4.0, 5.0, 8.0, 8.5])


def test_means_are_those_of_the_held_box():
    assert held_means(made_by_hand()) == pytest.approx((20.0, 0.30, 0.28))


def test_a_row_counts_from_when_the_arms_join_in():
    row = posture_row(made_by_hand())
    assert row["swivel_rms_left_deg"] == pytest.approx(np.rad2deg(0.01))
    assert row["swivel_elbow_off_m"] == pytest.approx(0.006)
    assert row["success"] == "no: The box was dropped. It tilted."


def test_the_bases_stand_on_either_side():
    np.testing.assert_allclose(BasePlaces(), [[0.2, 0.0, 0.4], [-0.2, 0.0, 0.4]], atol=1e-12)


def test_a_plan_is_simulated_with_the_resolution_asked_for(default_scenario):
    """With coarse steps; the plan's own resolution, the swivel, would keep every elbow within 2 degrees."""
    simulation = replace(default_scenario.simulation, time_step=0.006, skill_time_step=0.006, record_rate_hz=25.0)
    task = replace(default_scenario.task, duration_scale=1.0)
    plan = MakePlan(replace(default_scenario, simulation=simulation, task=task))
    told = []
    run = SimulatePlan(plan, "none", told.append)
    assert run.plan is plan and plan.scenario.retarget.redundancy == "swivel"
    assert told[-1] == 1.0 and told == sorted(told)
    assert run.log.t[-1] == pytest.approx(plan.duration_s, abs=0.05)
    assert run.elbow_off.shape == run.swivel_error.shape == (len(run.log.t), 2)
    after = run.log.t >= plan.settle_s
    assert np.rad2deg(np.nanmax(np.abs(run.swivel_error[after]))) > 10.0
    k = int(np.nanargmax(run.elbow_off[:, 0]))
    shoulder, elbow, _ = ElbowKinematics().points(run.log.q[k])[0]
    assert 0.0 < run.elbow_off[k, 0] <= 2.0 * np.linalg.norm(elbow - shoulder)
    table = swivel_series({"none": run}).columns
    assert list(table) == ["time_s", "none_left_rad", "none_left_asked_rad", "none_right_rad", "none_right_asked_rad"]
    np.testing.assert_array_equal(table["none_right_rad"], run.log.swivel[:, 1])
