"""The default law: a barrier on every link, all five met at once by the least change of the points' accelerations."""

from drake_blfdmp.skill.barrier import error_acceleration, length_acceleration, normalised_error
from drake_blfdmp.skill.geometry import link_states
from drake_blfdmp.skill.laws.primitive import Primitive
from drake_blfdmp.skill.reshaper import DEFAULT_MOBILITY, reshape
from drake_blfdmp.skill.sampled import Gains


def link_acceleration(x, velocity, bands, gains: Gains):
    """Rho'' of the five links by the default law, xi and xi': each (..., 5)."""
    rho, rho_dot, _, _ = link_states(x, velocity)
    xi, xi_dot = normalised_error(rho, rho_dot, bands)
    xi_ddot = error_acceleration(xi, xi_dot, gains.k_1, gains.k_2)
    return length_acceleration(xi, xi_dot, xi_ddot, bands), xi, xi_dot


def default(
    x,
    velocity,
    nominal_acceleration,
    previous_acceleration,
    bands,
    primitive: Primitive,
    gains: Gains = Gains(),
    mobility=DEFAULT_MOBILITY,
):
    """The coupling acceleration (..., 6, 3), m/s^2; see `skill.laws` for the arguments.

    `mobility` (6,) positive, this law's alone: how readily each point gives way. It decides who moves, not whether:
    V' < 0 on all links together, for any smooth moving bands (`skill.barrier`, `skill.reshaper`).
    """
    demanded, _, _ = link_acceleration(x, velocity, bands, gains)
    return reshape(x, velocity, nominal_acceleration, demanded, mobility)
