"""The published law with the previous sample's v' in z_2', which is what the circulation of Fig. 3 does.

v'_k + v'_(k-1) = v'_dmp + alpha_2' + k_n z_2: the sum of two accelerations is what is controlled, so their difference
is free, a mode of period two. It does not even keep its size: with whatever damping c the right side has,
a_k = -a_(k-1) - c x'_k, x'_(k+1) = x'_k + dt a_k has z^2 + c dt z - 1 = 0, whose roots have the product -1 and the sum
-c dt, so one lies below -1 for any c > 0 and dt > 0. Only a sampled system has a previous sample.
"""

from drake_blfdmp.skill.laws.follower import PublishedGains
from drake_blfdmp.skill.laws.primitive import Primitive
from drake_blfdmp.skill.laws.rounds import two_rounds


def as_lagged(follower, nominal, previous):
    """The reading: what is left of the sum after the previous sample's acceleration."""
    return nominal + follower - previous


def published_lagged(
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
    return two_rounds(*state, bands, primitive.tau, gains, as_lagged) - nominal_acceleration
