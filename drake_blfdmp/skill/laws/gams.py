r"""The coupling of Gams, Nemec, Ijspeert, Ude, "Coupling movement primitives", IEEE T-RO 30(4), 2014; the paper's [17].

Per axis, for two points 1 and 2 with d_a = y_1 - y_2:

    tau z_1' = alpha (beta (g_1 - y_1) - z_1) + f_1 + c_2 C_12',   tau y_1' = z_1 + C_12
    C_12 = c F_12 lf_1,   C_21 = -c F_12 lf_2,   F_12 = k (d_d - d_a)

It couples velocity and acceleration. Written for the real velocity y' in place of z = tau y' - C, both together are one
acceleration beside the primitive's own:

    y'' = (alpha (beta (g - y) - tau y') + f) / tau^2 + (alpha C + (c_2 + tau) C') / tau^2

A primitive that starts at rest, y' = 0, starts with z = -C. Here d_d is the vector of length d_j(t) along the hands'
line, which is the same in one dimension; the bones are not coupled, as there. Two primitives with goals dg apart rest
at (2 c k d_d + beta dg) / (beta + 2 c k).
"""

from dataclasses import dataclass

import numpy as np

from drake_blfdmp.skeleton import HANDS, LINKS
from drake_blfdmp.skill.barrier import middles_and_half_widths
from drake_blfdmp.skill.laws.primitive import Primitive
from drake_blfdmp.vectors import dot


@dataclass(frozen=True)
class GamsGains:
    """Gains of the coupling; `docs/laws.md` documents the search.

    Attributes:
        c_k: the product c k.
        c_2: of the acceleration coupling, s.
        lf_1, lf_2: how far the right hand (1) and the left hand (2) give way: 0 makes a leader.
    """

    c_k: float | np.ndarray = 300.0
    c_2: float | np.ndarray = 10.0
    lf_1: float = 1.0
    lf_2: float = 1.0


def resting_distance(desired, goals_apart, beta_z, c_k):
    """Where the feedback alone comes to rest, m, for lf_1 = lf_2 = 1: (2 c k d_d + beta dg) / (beta + 2 c k)."""
    return (2.0 * c_k * desired + beta_z * goals_apart) / (beta_z + 2.0 * c_k)


def characteristic(tau, alpha_z, beta_z, gains: GamsGains):
    """Coefficients (1, a_1, a_0) of the polynomial in s whose roots are the distance's poles, for lf_1 = lf_2 = 1."""
    a_1 = (alpha_z * tau + 2.0 * gains.c_k * (gains.c_2 + tau)) / tau**2
    return 1.0, a_1, alpha_z * (beta_z + 2.0 * gains.c_k) / tau**2


def gams(
    x,
    velocity,
    nominal_acceleration,
    previous_acceleration,
    bands,
    primitive: Primitive,
    gains: GamsGains = GamsGains(),
):
    """The coupling acceleration (..., 6, 3), m/s^2; see `skill.laws` for the arguments. The bands' middle is d_d."""
    (m, m_dot, _), _ = middles_and_half_widths(bands)
    desired, desired_rate = m[..., HANDS, None, None], m_dot[..., HANDS, None, None]
    own, partner = LINKS[HANDS].b, LINKS[HANDS].a
    # One more axis, (..., 1, 3), so that a batch's gains and tau, (..., 1, 1), broadcast.
    r = (x[..., own, :] - x[..., partner, :])[..., None, :]
    r_dot = (velocity[..., own, :] - velocity[..., partner, :])[..., None, :]
    rho = np.sqrt(dot(r, r))[..., None]
    n = r / rho
    rho_dot = dot(n, r_dot)[..., None]
    n_dot = (r_dot - rho_dot * n) / rho
    force = gains.c_k * (desired - rho) * n
    force_rate = gains.c_k * ((desired_rate - rho_dot) * n + (desired - rho) * n_dot)
    tau, alpha_z = primitive
    acceleration = (alpha_z * force + (gains.c_2 + tau) * force_rate) / tau**2
    coupling = np.zeros_like(x)
    coupling[..., own, :] = gains.lf_1 * acceleration[..., 0, :]
    coupling[..., partner, :] = -gains.lf_2 * acceleration[..., 0, :]
    return coupling
