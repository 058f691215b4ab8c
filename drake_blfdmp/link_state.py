"""How far a link is in its band, as a state and a colour: the same in every drawing of the skeleton."""

import numpy as np
from numpy.typing import ArrayLike

INSIDE, NEAR, OUTSIDE = "inside", "near", "outside"
COLOURS = {INSIDE: "#009E73", NEAR: "#E69F00", OUTSIDE: "#D00000"}
"""State -> CSS colour."""

JOINT_COLOUR = "#5A6470"
"""Of the six points."""

NEAR_MARGIN = 0.2
"""Margins (1 - |xi|) below this are near the band's edge."""


_STATES = (INSIDE, NEAR, OUTSIDE)


def classify(margin: ArrayLike, near: float = NEAR_MARGIN) -> list[str]:
    """State of each link: OUTSIDE where `margin` is negative or NaN, NEAR below `near` (same unit), INSIDE else."""
    return [_STATES[number] for number in _numbers(margin, near)]


def link_colours(margin: ArrayLike, near: float = NEAR_MARGIN) -> np.ndarray:
    """Red, green and blue (..., 3), 0 to 1, of the states that `classify` gives margins (...)."""
    return _RGB[_numbers(margin, near)]


def _numbers(margin: ArrayLike, near: float) -> np.ndarray:
    margin = np.asarray(margin, dtype=float)
    return np.where(margin >= 0.0, np.where(margin < near, 1, 0), 2)


def rgb(colour: str) -> tuple[float, float, float]:
    """Red, green and blue, 0 to 1, of a CSS colour `#RRGGBB`."""
    red, green, blue = (int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5))
    return red, green, blue


_RGB = np.array([rgb(COLOURS[state]) for state in _STATES])
