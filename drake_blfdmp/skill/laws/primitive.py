"""What a law may know of the movement primitive that it couples."""

from typing import NamedTuple

import numpy as np


class Primitive(NamedTuple):
    """Two constants of (1).

    Attributes:
        tau: time scale, s; (..., 1, 1) for a batch in which every member has its own.
        alpha_z: gain.
    """

    tau: float | np.ndarray
    alpha_z: float
