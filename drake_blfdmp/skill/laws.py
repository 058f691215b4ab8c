"""The coupling laws a scenario can choose: the acceleration added to every point, from the state and the bands.

Each law has one signature: positions, velocities and nominal accelerations (..., 6, 3) and bands (..., 6, 5) in, the
coupling acceleration (..., 6, 3), m/s^2, out.
"""

import numpy as np

from drake_blfdmp.errors import ScenarioError
from drake_blfdmp.skill.barrier import error_acceleration, length_acceleration, normalised_error
from drake_blfdmp.skill.geometry import link_states
from drake_blfdmp.skill.reshaper import DEFAULT_MOBILITY, reshape
from drake_blfdmp.skill.sampled import Gains


def default_link_acceleration(x, velocity, bands, gains: Gains):
    """Rho'' of the five links by the default law, xi and xi': each (..., 5)."""
    rho, rho_dot, _, _ = link_states(x, velocity)
    xi, xi_dot = normalised_error(rho, rho_dot, bands)
    xi_ddot = error_acceleration(xi, xi_dot, gains.k_1, gains.k_2)
    return length_acceleration(xi, xi_dot, xi_ddot, bands), xi, xi_dot


def default(x, velocity, nominal_acceleration, bands, gains: Gains = Gains(), mobility=DEFAULT_MOBILITY):
    """A barrier on every link, all links met at once."""
    demanded, _, _ = default_link_acceleration(x, velocity, bands, gains)
    return reshape(x, velocity, nominal_acceleration, demanded, mobility)


def none(x, velocity, nominal_acceleration, bands, gains: Gains = Gains(), mobility=DEFAULT_MOBILITY):
    """No coupling: every point follows its own movement primitive."""
    return np.zeros_like(x)


LAWS = {"default": default, "none": none}


def law(name: str):
    """The law of that name.

    Raises:
        ScenarioError: there is none.
    """
    if name not in LAWS:
        raise ScenarioError(f"law: unknown law '{name}'; there are {', '.join(LAWS)}")
    return LAWS[name]
