"""A palm's pad as points of an elastic foundation."""

from typing import NamedTuple

import numpy as np

from drake_blfdmp.robot.grasp_force import PALM_RADIUS

FOUNDATION = 1.0e6 / 0.0075
"""Pressure over depth of the pad, N/m^3: its modulus over half its thickness (docs/contact.md)."""


class PadPoints(NamedTuple):
    """Points (N, 2), m, spread evenly over a pad in its palm's frame, and their share of its area, m^2."""

    at: np.ndarray
    area: float


def MakePadPoints(count: int = 16) -> PadPoints:
    """Of the hexagon with a vertex on x that stands for the pad in Drake's contact, `count` of them across."""
    across = PALM_RADIUS * ((2.0 * np.arange(count) + 1.0) / count - 1.0)
    at = np.stack(np.meshgrid(across, across), axis=-1).reshape(-1, 2)
    towards = np.deg2rad(30.0 + 60.0 * np.arange(6))
    inside = (at @ np.stack([np.cos(towards), np.sin(towards)]) <= PALM_RADIUS * np.cos(np.deg2rad(30.0))).all(axis=1)
    whole = 1.5 * np.sqrt(3.0) * PALM_RADIUS**2
    return PadPoints(at[inside], whole / float(inside.sum()))
