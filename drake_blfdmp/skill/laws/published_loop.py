"""The published law with the algebraic loop of (12) solved: v' = (v'_dmp + alpha_2' + k_n z_2) / 2.

With the true v' in z_2' / d_z = alpha_2' - v', (12) reads v' = v'_dmp + k_n z_2 + alpha_2' - v': half demonstration,
half follower. The theorem does not cover it.
"""

from drake_blfdmp.skill.laws.follower import PublishedGains
from drake_blfdmp.skill.laws.primitive import Primitive
from drake_blfdmp.skill.laws.rounds import two_rounds


def as_loop(follower, nominal, previous):
    """The reading: the mean of the uncoupled and the follower's acceleration."""
    return 0.5 * (nominal + follower)


def published_loop(
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
    return two_rounds(*state, bands, primitive.tau, gains, as_loop) - nominal_acceleration
