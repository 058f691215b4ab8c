"""What is read from a squeeze, on made-up readings."""

import numpy as np
import pytest

from drake_blfdmp.errors import BlfDmpError
from drake_blfdmp.evaluation.studies.squeeze_metrics import (
    Cell,
    Patch,
    as_columns,
    as_grid,
    bearing_factor,
    box_friction,
    creep,
    least_that_holds,
    pad_deformation,
    polygon_area,
    speeds,
)
from drake_blfdmp.evaluation.study import Table
from drake_blfdmp.robot.grasp_force import combined_friction, turning_factor


def disc(radius, rings=16, spokes=24):
    """A patch that is a disc, in equal parts."""
    edges = radius * np.sqrt(np.linspace(0.0, 1.0, rings + 1))
    middle = 2.0 / 3.0 * np.diff(edges**3) / np.diff(edges**2)
    angle = 2.0 * np.pi * (np.arange(spokes) + 0.5) / spokes
    point = middle[:, None, None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    return Patch(np.full(rings * spokes, np.pi * radius**2 / (rings * spokes)), point.reshape(-1, 2), 1e4, 50.0)


def test_a_patch_knows_its_radii():
    patch = disc(0.03)
    assert patch.radius == pytest.approx(0.03)
    assert patch.torsion_radius == pytest.approx(0.02, rel=1e-3)


def test_a_polygon_has_drakes_number_of_edges():
    assert polygon_area(0.045, 0.05) == pytest.approx(1.5 * np.sqrt(3.0) * 0.045**2)  # ceil(5.65): a hexagon.
    assert polygon_area(0.045, 1.0) == pytest.approx(0.75 * np.sqrt(3.0) * 0.045**2)  # No less than a triangle.
    assert polygon_area(0.045, 1e-4) == pytest.approx(np.pi * 0.045**2, rel=1e-5)


def test_deformation_is_force_over_stiffness():
    assert pad_deformation(50.0, 1e6, 0.0075, 0.005) == pytest.approx(50.0 / (1e6 * 0.005 / 0.0075))
    assert pad_deformation(np.ones(3), np.ones((2, 1)), 1.0, 1.0).shape == (2, 3)


@pytest.mark.parametrize("offset", [0.0, 0.005, 0.02, 0.04])
def test_the_bearing_factor_of_a_disc_is_the_turning_factor(offset):
    assert bearing_factor(disc(0.045), offset) == pytest.approx(turning_factor(offset, 0.045), rel=2e-3)


def test_a_ring_bears_more_torsion_than_a_point():
    ring = Patch(np.ones(12), 0.04 * np.array([[np.cos(a), np.sin(a)] for a in np.pi * np.arange(12) / 6]), 1.0, 1.0)
    point = Patch(np.ones(1), np.array([[0.0, 0.0]]), 1.0, 1.0)
    assert 1.0 < bearing_factor(ring, 0.02) < turning_factor(0.02, 0.04)
    assert bearing_factor(point, 0.02) == np.inf


def test_a_boxs_friction_gives_the_wanted_pair():
    wanted = np.array([0.3, 0.8, 1.0, 1.5])
    np.testing.assert_allclose(combined_friction(box_friction(wanted, 0.8), 0.8), wanted)
    for value in (1.6, 2.0, 0.0, -0.1):
        with pytest.raises(BlfDmpError, match="0 and 1.6"):
            box_friction(value, 0.8)


def test_creep_is_the_greatest_speed_after_the_settling():
    t = np.array([0.0, 0.1, 0.2, 0.3, 0.4])
    moved = np.zeros((5, 3))
    moved[1:, 2] = -1.0  # A jump while it settles.
    moved[3:, 1] = 3e-3
    moved[4, 2] -= 4e-3
    turned = np.array([0.0, 0.5, 0.5, 0.4, 0.4])
    np.testing.assert_allclose(speeds(t, turned), [5.0, 0.0, 1.0, 0.0])
    assert creep(t, moved, turned, 0.2) == pytest.approx((0.04, 1.0))
    assert creep(t[:2], moved[:2], turned[:2], 0.2) == (0.0, 0.0)


@pytest.mark.parametrize("guess", [2.0, 9.9, 10.0, 10.1, 60.0])
def test_the_least_force_is_found_from_either_side(guess):
    asked = []

    def holds(force):
        asked.append(force)
        return force >= 10.0

    least = least_that_holds(holds, guess)
    assert 10.0 <= least <= 10.025
    assert least in asked  # It was tried, and held.
    assert len(asked) < 25


def test_what_never_holds_or_always_does_is_said():
    for always in (False, True):
        with pytest.raises(BlfDmpError, match="nothing changes from 5 to"):
            least_that_holds(lambda force, answer=always: answer, 5.0, tries=10)


def test_cells_stand_at_their_mass_and_friction():
    cells = [Cell(m, f, 0.0, 2.0, 2.0 * m * f, 1e-5, np.radians(0.05)) for m, f in ((2.0, 0.3), (1.0, 0.8), (1.0, 0.3))]
    masses, frictions, least = as_grid(cells, lambda cell: cell.least)
    np.testing.assert_array_equal(masses, [1.0, 2.0])
    np.testing.assert_array_equal(frictions, [0.3, 0.8])
    np.testing.assert_allclose(least, [[0.6, 1.6], [1.2, np.nan]])
    columns = Table(as_columns(cells)).columns
    assert columns["measured_to_estimate"][0] == pytest.approx(0.6)
    assert columns["pivot_deg_per_s"][0] == pytest.approx(0.05)
