"""The study of squeezing: its claims on made-up cells, and a quick run of the whole."""

from dataclasses import replace

import numpy as np
import pytest

from drake_blfdmp.evaluation.studies.squeeze_metrics import Cell, Patch
from drake_blfdmp.evaluation.studies.squeeze_rig import Hold, Pad
from drake_blfdmp.evaluation.study import StudyContext
from drake_blfdmp.evaluation.study_runner import FindStudies, LoadStudy
from drake_blfdmp.planning.scenario import LoadScenario
from drake_blfdmp.planning.squeeze import AskedForce
from drake_blfdmp.robot.grasp_force import PADS_FACTOR, least_squeeze, turning_factor

PAD = Pad(0.045, 0.015, 1e6, 0.05, 0.8)


@pytest.fixture(scope="module")
def script(command_line):
    return FindStudies(command_line.ROOT / "studies")["squeeze"]


@pytest.fixture(scope="module")
def scenario(script):
    return LoadScenario(script.scenario)


@pytest.fixture(scope="module")
def parts(script):
    """What the script defines."""
    return LoadStudy(script).__globals__


@pytest.fixture(scope="module")
def quick(script, scenario):
    return LoadStudy(script)(StudyContext(scenario, True, lambda what, share: None, None, 1))


def cell(ratio, offset=0.0, pivot=0.0):
    return Cell(1.0, 0.8, offset, 10.0, 10.0 * ratio, 1e-5, pivot)


def test_a_quick_run_finds_the_friction_cone_at_rest_and_in_a_lift(quick):
    for table, acceleration in (("still", 0.0), ("lifted", 1.5)):
        columns = quick.tables[table].columns
        estimate = least_squeeze(np.array(columns["mass_kg"]), columns["friction"], acceleration, factor=1.0)
        np.testing.assert_allclose(columns["estimate_n"], estimate)
        np.testing.assert_allclose(columns["least_n"], estimate, rtol=0.05)
        assert max(columns["slip_m_per_s"]) <= 1e-4
    assert quick.tables["lifted"].columns["least_n"][0] > quick.tables["still"].columns["least_n"][0]
    (aside,) = quick.tables["aside"].columns["measured_to_estimate"]
    assert 1.0 < aside < 1.3


def test_a_quick_run_judges_everything_and_draws_three_figures(quick, redrawn):
    assert len(quick.claims) == 10 and all(claim.holds is not None for claim in quick.claims)
    assert set(redrawn(quick)) == set(quick.captions) == {"deformation", "least", "aside"}
    deformation = quick.tables["deformation"].columns
    np.testing.assert_allclose(deformation["deformation_m"], deformation["estimate_m"], rtol=0.02)
    np.testing.assert_allclose(deformation["mean_pressure_pa"], deformation["greatest_pressure_pa"], rtol=0.02)


def test_cells_agree_within_the_stated_share(parts):
    agreement = parts["agreement"]
    assert agreement("f", "now", [cell(0.96), cell(1.04)]).holds is True
    for ratio in (0.94, 1.06):
        claim = agreement("f", "now", [cell(1.0), cell(ratio)])
        assert claim.holds is False and f"{ratio:.3f}" in claim.measured


def test_pads_are_judged_by_the_rim_and_by_the_band(parts, scenario):
    patch = Patch(np.array([PAD.area]), np.zeros((1, 2)), 1e4, 50.0)

    def judge(depth, **changes):
        changed = replace(scenario, **changes)
        return parts["pads"](changed, PAD, [50.0], {1e6: (np.full((1, 2), depth), [patch])})

    exact = 50.0 * PAD.depth / (1e6 * PAD.area)
    assert [claim.holds for claim in judge(exact)] == [True, False, True]
    assert judge(1.05 * exact)[0].holds is False
    narrow = replace(scenario.bands, hands_half_width=1e-4)
    assert judge(exact, bands=narrow)[1].holds is True
    weak = replace(scenario.task, squeeze_force=10.0)
    assert judge(exact, task=weak)[2].holds is False


def test_a_box_that_hangs_must_not_pivot(parts, scenario):
    assert parts["hangs"](scenario, [cell(1.0), cell(1.0, pivot=1e-9)]).holds is True
    assert parts["hangs"](scenario, [cell(1.0), cell(1.0, pivot=0.01)]).holds is False


def test_torsion_is_judged_by_the_mesh_and_the_factor_by_the_worst_offset(parts):
    disc = float(turning_factor(0.02, 0.045))
    mesh = [1.0, 1.1 * disc, 2.0]
    near, enough = parts["turns"]([cell(1.0), cell(1.11, 0.02), cell(PADS_FACTOR, 0.04)], mesh, PAD)
    assert near.holds is True and enough.holds is True
    off, too_much = parts["turns"]([cell(1.0), cell(1.0, 0.02), cell(1.01 * PADS_FACTOR, 0.04)], mesh, PAD)
    assert off.holds is False and too_much.holds is False


def test_the_default_force_must_hold_and_exceed_the_least(parts, scenario):
    t = np.array([0.0, 0.1, 0.2, 0.3])
    hold = Hold(t, np.zeros((4, 3)), np.zeros(4), np.full(2, 55.0), True)
    claim = parts["default_force"](scenario, PAD, hold)
    least = float(least_squeeze(scenario.box.mass, 0.8, 1.5))
    assert claim.holds is True and f"{AskedForce(scenario.task) / least:.1f} times" in claim.measured
    assert parts["default_force"](scenario, PAD, replace(hold, held=False)).holds is False
    weak = replace(scenario, task=replace(scenario.task, squeeze_force=0.9 * least))
    assert parts["default_force"](weak, PAD, hold).holds is False


def test_boxes_beyond_the_largest_squeeze_are_named(parts):
    claim = parts["whole_range"]()
    mass, friction = np.meshgrid(parts["MASSES"], parts["FRICTIONS"], indexing="ij")
    beyond = least_squeeze(mass, friction, 1.5) > parts["LARGEST_FORCE"]
    assert claim.holds is not bool(beyond.any())
    assert claim.measured.count(" kg at ") == beyond.sum()
    assert beyond.any() and "5 kg at 0.3" in claim.measured
