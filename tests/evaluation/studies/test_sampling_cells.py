"""Cells of rates and gains: which problem had which gains, where cells lie in the grid, and the linear bound."""

import numpy as np
import pytest

from drake_blfdmp.demonstration.modelled_person import hold_and_place
from drake_blfdmp.evaluation.studies.random_problems import Outcome, draw_problems
from drake_blfdmp.evaluation.studies.sampling_cells import Cell, Grid, as_table, cells, gains_of, jury, repeated, shares
from drake_blfdmp.skill.learning import learn_skill
from drake_blfdmp.skill.sampled import Gains


def test_problems_go_with_their_gains():
    """`repeated` and `cells` agree on which problem had which gains."""
    problems = draw_problems(learn_skill(*hold_and_place()), 3, 0, 0.001)
    pairs = [Gains(8.0, 20.0), Gains(20.0, 40.0)]
    both = repeated(problems, pairs)
    np.testing.assert_array_equal(both.k_1, [8.0, 8.0, 8.0, 20.0, 20.0, 20.0])
    np.testing.assert_array_equal(both.tau, np.tile(problems.tau, 2))
    left_s = np.full((6, 5), np.inf)
    left_s[4, 2] = 0.5
    least = np.full((6, 5), 0.2)
    least[4, 2] = -0.1
    first, second = cells(["a", "b"], pairs, 0.004, Outcome(least, left_s))
    assert (first.left, second.left, first.problems, second.family) == (0, 1, 3, "b")
    assert (first.least_margin, second.least_margin) == (0.2, -0.1)


def test_gains_have_the_sum_and_the_ratio():
    gains = gains_of(28.0, 2.5)
    assert (gains.k_1, gains.k_2) == pytest.approx((8.0, 20.0))


def test_a_cells_share_stands_at_its_rate_and_sum():
    grid = Grid((10.0, 100.0), (14.0, 28.0, 56.0), {"a": 2.5, "b": 1.0})
    assert [family for family, _ in grid.pairs] == ["a"] * 3 + ["b"] * 3
    one = Cell("a", gains_of(56.0, 2.5), 0.01, 8, 2, -0.1)
    other = Cell("b", gains_of(14.0, 1.0), 0.1, 8, 8, -0.1)
    share = shares(grid, [one, other], "a")
    assert share[1, 2] == 25.0
    assert np.isnan(share).sum() == 5
    assert shares(grid, [one, other], "b")[0, 0] == 100.0


def test_the_table_tells_how_far_beyond_the_longest_step_a_cell_is():
    gains = Gains(8.0, 20.0)
    table = as_table([Cell("a", gains, 3.0 * gains.largest_step(), 100, 4, -0.2)]).columns
    assert table["over_largest_step"][0] == pytest.approx(3.0)
    assert 4.0 < table["upper_percent"][0] < 11.0


def test_the_linear_bound_is_jurys():
    """At the bound the loop of `docs/sampling.md` has a root on the unit circle, and none outside."""
    for gains in (Gains(8.0, 20.0), Gains(0.3, 0.4), Gains(30.0, 10.0)):
        step = jury(gains)
        c_1, c_2 = 1.0 + gains.k_1 * gains.k_2, gains.k_1 + gains.k_2
        roots = np.roots([1.0, c_2 * step + 0.5 * c_1 * step**2 - 2.0, 1.0 - c_2 * step + 0.5 * c_1 * step**2])
        assert np.abs(roots).max() == pytest.approx(1.0, abs=1e-9)
