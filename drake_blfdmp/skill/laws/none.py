"""No coupling: every point follows its own movement primitive."""

import numpy as np

from drake_blfdmp.skill.laws.primitive import Primitive


def none(x, velocity, nominal_acceleration, previous_acceleration, bands, primitive: Primitive, gains=None):
    """Zero (..., 6, 3); see `skill.laws` for the arguments."""
    return np.zeros_like(x)
