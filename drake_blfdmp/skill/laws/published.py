"""The published law (9), z_2' taken along the uncoupled primitive: v' = alpha_2' + k_n z_2.

(12) adds Delta u = k_n z_2 + z_2' / d_z to f(s) / tau, and z_2' holds the v' that Delta u is about to change. Taken
along the uncoupled primitive, z_2' / d_z = alpha_2' - v'_dmp, and in v' = v'_dmp + Delta u the primitive cancels, f(s)
and the goal with it: on every constrained axis the point is a pure follower of its partner.
"""

from drake_blfdmp.skill.laws.follower import PublishedGains
from drake_blfdmp.skill.laws.primitive import Primitive
from drake_blfdmp.skill.laws.rounds import two_rounds


def as_follower(follower, nominal, previous):
    """The reading: v' = alpha_2' + k_n z_2."""
    return follower


def published(
    x,
    velocity,
    nominal_acceleration,
    previous_acceleration,
    bands,
    primitive: Primitive,
    gains: PublishedGains = PublishedGains(),
):
    """The coupling acceleration (..., 6, 3), m/s^2; see `skill.laws` for the arguments."""
    state = x, velocity, nominal_acceleration, previous_acceleration
    return two_rounds(*state, bands, primitive.tau, gains, as_follower) - nominal_acceleration
