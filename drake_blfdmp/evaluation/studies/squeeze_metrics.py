"""What is read from a squeeze: the pad's deformation and its estimate, creep, and the least force that holds.

Pure functions; `squeeze_rig` simulates.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from drake_blfdmp.errors import BlfDmpError


@dataclass(frozen=True)
class Limits:
    """How fast a box that counts as held may creep: slip in m/s, pivot in rad/s."""

    slip: float = 1e-4
    pivot: float = float(np.radians(0.1))


@dataclass(frozen=True)
class Patch:
    """A contact patch of F faces in the plane of the palm.

    Attributes:
        area: (F,) m^2.
        point: (F, 2) centroids from the palm's axis, m.
        pressure: the greatest one, Pa.
        force: the normal one, N.
    """

    area: np.ndarray
    point: np.ndarray
    pressure: float
    force: float

    @property
    def radius(self) -> float:
        """Of the disc of the same area, m."""
        return float(np.sqrt(self.area.sum() / np.pi))

    @property
    def torsion_radius(self) -> float:
        """Mean distance of the friction from the axis, m; of a disc 2/3 of its radius."""
        return float(self.area @ np.linalg.norm(self.point, axis=1) / self.area.sum())


def polygon_area(radius: float, hint: float) -> float:
    """Area, m^2, of the regular polygon that Drake makes of a cylinder's face: ceil(2 pi radius / hint) edges, >= 3."""
    edges = max(3, int(np.ceil(2.0 * np.pi * radius / hint)))
    return float(0.5 * edges * radius**2 * np.sin(2.0 * np.pi / edges))


def pad_deformation(force, modulus, depth, area):
    """How far, m, an elastic foundation yields to a flat face: x = F H/(E A); broadcasts.

    A compliant hydroelastic pad has the pressure E x/H at the depth x, H the depth of the field's greatest value
    (Elandt et al., "A pressure field model for fast, robust approximation of net contact force and moment between
    nominally rigid objects", IROS 2019). Within x of the rim the pressure is less, so a deep squeeze goes deeper still.

    Args:
        force: N. modulus: E, Pa. depth: H, m. area: A, m^2.
    """
    return np.asarray(force) * depth / (np.asarray(modulus) * area)


def bearing_factor(patch: Patch, offset: float) -> float:
    """What `robot.grasp_force.turning_factor` is for a disc, for a patch of points with the shares of their areas.

    The point about which the box begins to turn may lie anywhere in the plane; it is looked for along the line of the
    offset, horizontally, on both sides of the patch's centre.
    """
    if offset <= 0.0:
        return 1.0
    share = patch.area / patch.area.sum()
    c = np.concatenate([-np.geomspace(100.0, 1e-5, 3000), np.linspace(0.0, 0.95 * offset, 200)])
    about = np.stack([c, np.zeros_like(c)], axis=-1)
    mean = np.linalg.norm(patch.point - about[:, None], axis=-1) @ share
    bears = np.min(mean / np.abs(offset - c))
    return float(max(1.0, 1.0 / bears)) if bears > 0.0 else np.inf


def box_friction(combined, pad):
    """The coefficient of a box that gives `combined` with a pad, by Drake's rule 2 m n/(m + n); broadcasts.

    Raises:
        BlfDmpError: not below twice the pad's, which no box reaches.
    """
    combined = np.asarray(combined, dtype=float)
    if np.any(combined <= 0.0) or np.any(combined >= 2.0 * pad):
        raise BlfDmpError(f"friction {combined}: with a pad of {pad:g} it must lie between 0 and {2.0 * pad:g}")
    return combined * pad / (2.0 * pad - combined)


def speeds(t, values):
    """Mean speeds between the samples: values (N,) or (N, 3) at t (N,) s -> (N - 1,), per s."""
    change = np.diff(np.asarray(values, dtype=float), axis=0)
    return (np.linalg.norm(change, axis=1) if change.ndim > 1 else np.abs(change)) / np.diff(t)


def creep(t, moved, turned, settle: float) -> tuple[float, float]:
    """Greatest speeds of slip, m/s, and pivot, rad/s, between samples that begin at `settle`, s, or later; 0 if none.

    Args:
        t: (N,) s. moved: (N, 3) m. turned: (N,) rad.
    """
    late = np.asarray(t)[:-1] > settle - 1e-9
    slip, pivot = (float(np.max(speeds(t, part)[late], initial=0.0)) for part in (moved, turned))
    return slip, pivot


def least_that_holds(
    holds: Callable[[float], bool], guess: float, widen: float = 1.01, tolerance: float = 0.0025, tries: int = 10
) -> float:
    """The least force that holds, to a relative `tolerance` from above, where every larger one holds as well.

    From `guess` on it walks by the factor `widen`, squared from step to step, until the answer changes, then bisects in
    the logarithm.

    Raises:
        BlfDmpError: the answer does not change within `tries` steps.
    """
    up = not holds(guess)
    inner, outer, factor = guess, guess, widen
    for _ in range(tries):
        inner, outer, factor = outer, outer * factor if up else outer / factor, factor**2
        if holds(outer) == up:
            break
    else:
        raise BlfDmpError(f"least force: nothing changes from {guess:g} to {outer:g} N; choose another guess")
    lower, upper = sorted((inner, outer))
    while upper > lower * (1.0 + tolerance):
        middle = float(np.sqrt(lower * upper))
        lower, upper = (lower, middle) if holds(middle) else (middle, upper)
    return upper


@dataclass(frozen=True)
class Cell:
    """The least force found for one box, and the hold with it.

    Attributes:
        mass: kg. friction: of box and pad together. offset: m aside of the palms' axis.
        estimate, least: N.
        slip, pivot: creep with `least`, m/s and rad/s.
    """

    mass: float
    friction: float
    offset: float
    estimate: float
    least: float
    slip: float
    pivot: float

    @property
    def ratio(self) -> float:
        """Measured to estimate."""
        return self.least / self.estimate


def as_columns(cells: Sequence[Cell]) -> dict[str, list[float]]:
    """Columns of a `Table`, a row a cell."""
    return {
        "mass_kg": [cell.mass for cell in cells],
        "friction": [cell.friction for cell in cells],
        "offset_m": [cell.offset for cell in cells],
        "estimate_n": [cell.estimate for cell in cells],
        "least_n": [cell.least for cell in cells],
        "measured_to_estimate": [cell.ratio for cell in cells],
        "slip_m_per_s": [cell.slip for cell in cells],
        "pivot_deg_per_s": [float(np.degrees(cell.pivot)) for cell in cells],
    }


def as_grid(cells: Sequence[Cell], what: Callable[[Cell], float]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Masses (M,), coefficients (F,), both rising, and `what` (M, F) of the cell there, NaN where there is none."""
    masses, frictions = (np.array(sorted({getattr(cell, name) for cell in cells})) for name in ("mass", "friction"))
    grid = np.full((len(masses), len(frictions)), np.nan)
    for cell in cells:
        grid[np.searchsorted(masses, cell.mass), np.searchsorted(frictions, cell.friction)] = what(cell)
    return masses, frictions, grid
