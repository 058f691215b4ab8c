"""The study of rates and gains, quickly, and its claims on cells made by hand."""

import numpy as np
import pytest

from drake_blfdmp.evaluation.study import StudyContext
from drake_blfdmp.evaluation.study_runner import FindStudies, LoadStudy
from drake_blfdmp.planning.scenario import LoadScenario
from drake_blfdmp.skill.sampled import Gains


@pytest.fixture(scope="module")
def script(command_line):
    return FindStudies(command_line.ROOT / "studies")["sampling"]


@pytest.fixture(scope="module")
def parts(script):
    """What the script defines."""
    return LoadStudy(script).__globals__


@pytest.fixture(scope="module")
def study(script):
    context = StudyContext(LoadScenario(script.scenario), True, lambda what, share: None, None, 1)
    return LoadStudy(script)(context)


def test_the_grid_is_whole(study, parts):
    cells = study.tables["cells"].columns
    assert len(cells["step_s"]) == len(parts["QUICK_RATES"]) * len(parts["QUICK_TOTALS"]) * len(parts["RATIOS"])
    assert len(set(zip(cells["family"], cells["k_1_per_s"], cells["step_s"], strict=True))) == len(cells["step_s"])
    total = np.array(cells["k_1_per_s"]) + np.array(cells["k_2_per_s"])
    np.testing.assert_allclose(sorted(set(total.round(9))), parts["QUICK_TOTALS"])
    for family, k_1, k_2 in zip(cells["family"], cells["k_1_per_s"], cells["k_2_per_s"], strict=True):
        assert k_2 / k_1 == pytest.approx(parts["RATIOS"][family])


def test_bands_are_kept_where_it_is_allowed_and_left_far_outside(study):
    cells = study.tables["cells"].columns
    over, left = np.array(cells["over_largest_step"]), np.array(cells["left"])
    assert np.any(over <= 1.0) and np.all(left[over <= 1.0] == 0)
    assert left[over > 30.0].sum() > 0
    edge = study.tables["edge"].columns
    np.testing.assert_allclose(edge["over_largest_step"], 1.0)
    assert not any(edge["left"])
    margin = np.array(cells["least_margin"])
    np.testing.assert_array_equal(left > 0, ~(margin > 0.0))


def test_the_figure_is_drawn_from_its_file(study, redrawn):
    assert set(redrawn(study)) == {"regions"}


def test_claims_follow_from_the_cells(parts):
    cell, make_claims = parts["Cell"], parts["make_claims"]
    gains = Gains(8.0, 20.0)
    kept = cell("f", gains, 0.004, 100, 0, 0.18)
    lost = cell("f", gains, 0.004, 100, 2, -0.3)
    slow = cell("f", gains, 1.0 / 30.0, 100, 40, -9.0)
    assert kept.allowed and not slow.allowed
    assert [claim.holds for claim in make_claims([kept, slow], [kept])] == [True, True, True, False]
    claims = make_claims([lost, cell("f", gains, 1.0 / 30.0, 100, 0, 0.1)], [lost])
    assert [claim.holds for claim in claims] == [False, False, False, True]
    assert "k_1 8, k_2 20 1/s, 4 ms" in claims[0].why
    assert make_claims([slow], [kept])[0].holds is None
