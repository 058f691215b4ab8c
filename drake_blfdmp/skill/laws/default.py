"""The default law: a barrier on every link, all five met at once by the least change of the points' accelerations."""

from drake_blfdmp.skill.barrier import error_acceleration, length_acceleration, normalised_error
from drake_blfdmp.skill.geometry import link_states
from drake_blfdmp.skill.laws.primitive import Primitive
from drake_blfdmp.skill.reshaper import DEFAULT_MOBILITY, least_change, needs_of
from drake_blfdmp.skill.sampled import Gains


def link_acceleration(states, bands, gains: Gains):
    """Rho'' (..., 5) of the five links by the default law, from their `link_states`."""
    rho, rho_dot, _, _ = states
    xi, xi_dot = normalised_error(rho, rho_dot, bands)
    return length_acceleration(xi, xi_dot, error_acceleration(xi, xi_dot, gains.k_1, gains.k_2), bands)


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
    states = link_states(x, velocity)
    need, n = needs_of(states, nominal_acceleration, link_acceleration(states, bands, gains))
    return least_change(n, need, mobility)
