import numpy as np
import pytest

from drake_blfdmp.evaluation.studies import one_axis_facts as facts


def test_v_dot_vanishes_on_the_line_and_damping_makes_it_definite():
    line = facts.on_the_line()
    np.testing.assert_array_equal(line.printed, 0.0)
    off = np.abs(line.share) > 1e-9
    assert np.all(line.damped[off] < 0.0) and np.count_nonzero(off) == len(off) - 1
    # -d_z k_2 z_2^2 with z_2 a share of 2 k_z 0.01 m.
    np.testing.assert_allclose(line.damped, -((0.02 * line.share) ** 2), atol=1e-18)


def test_only_high_rates_hide_that_a_band_moves():
    crossed = facts.crossed_at(1e-3)
    assert crossed[0] < 0.05 and np.isinf(crossed[-1])
    assert np.all(np.diff(np.isinf(crossed).astype(int)) >= 0)  # From one rate on, none crosses.
    moving = facts.in_a_moving_band(1e-3)
    assert moving["as printed"].left_at == pytest.approx(crossed[0]) and np.isinf(moving["fed forward"].left_at)


def test_a_goal_moves_the_loop_alone():
    goals = facts.with_a_goal_elsewhere()
    ends = {name: run.x[-1] for name, run in goals.items()}
    assert abs(ends["published"] - facts.OWN_GOAL) == pytest.approx(0.15, abs=1e-3)
    assert abs(ends["published"] - ends["published, goal 0"]) < 1e-4 < abs(ends["published"] - ends["loop"])


def test_the_lagged_reading_leaves_and_grows_at_every_step():
    assert 0.0 < facts.lagged().left_at < 0.05
    for growth in facts.lagged_growth((2e-3, 1e-3)).values():
        assert growth.measured == pytest.approx(growth.predicted, rel=0.01) and growth.predicted > 1.0


def test_random_roots_are_seeded_and_all_outside():
    roots = facts.largest_lagged_roots(50, 3)
    np.testing.assert_array_equal(roots, facts.largest_lagged_roots(50, 3))
    assert roots.shape == (50,) and roots.min() > 1.0
    assert not np.array_equal(roots, facts.largest_lagged_roots(50, 4))


def test_one_sign_stays_and_the_other_leaves():
    signs = facts.both_signs(5e-4)
    assert np.isinf(signs["partner minus own"].left_at) and signs["own minus partner"].left_at < 0.05
