r"""The published barrier law (7)-(12) on one axis: an own point that follows its partner.

As printed, with its misprints repaired. z_1 = k_z (x_partner - x_own): with own minus partner, which the definition
before (5) can be read as, alpha_2 pushes away from the middle of the band. z_1' = k_z (x_partner' - v_own / tau): the
tau printed in (8) belongs to the whole of V', not to z_1'. With v = tau x', mid = (kappa_hi + kappa_lo) / 2,
D = (kappa_hi - z_1)(z_1 - kappa_lo) and z_2 = d_z (alpha_2 - v_own):

    alpha_2 = tau x_partner' + (z_1 - mid) / d_z                                     (9)
    v_own'  = alpha_2' + k_n z_2,   k_n = k_z / (4 tau d_z^2 D)                       (9)
    tau V'  = -(k_z / (d_z D)) (z_1 - mid - z_2 / 2)^2   <=  0                        (8)

The 1/2 is lost in the paper's last line of the proof. V' is zero on z_1 - mid = z_2 / 2: semi-definite. A further
damping k_2 z_2 in v_own' takes d_z k_2 z_2^2 from V' and makes it definite. Everything holds for constant bounds.
Arrays broadcast; every function but `follower_acceleration` takes Expression entries.
"""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class PublishedGains:
    """Gains of the published law; the paper prints none. `docs/laws.md` documents the search for these.

    Attributes:
        k_z: scale of z_1, 1/m.
        d_z: scale of z_2, 1/m.
        k_2: further damping, m/s; the paper has none.
        largest_rate: d_z k_n, the rate at which z_2 decays, is held at this value, 1/s, where the barrier asks for
            more, and takes it outside the band, where the theorem says nothing. A sampled system cannot carry a rate
            above one over its step.
    """

    k_z: float | np.ndarray = 300.0
    d_z: float | np.ndarray = 0.2
    k_2: float | np.ndarray = 0.0
    largest_rate: float | np.ndarray = 150.0


def barrier_function(z_1, z_2, kappa_lo, kappa_hi):
    """V^c of (7)."""
    span = kappa_hi - kappa_lo
    return 0.5 * np.log(span * span / (4.0 * (kappa_hi - z_1) * (z_1 - kappa_lo))) + 0.5 * z_2 * z_2


def barrier_derivative(z_1, z_2, kappa_lo, kappa_hi, tau, gains: PublishedGains):
    """V^c' along the law for constant bounds, 1/s: (8) with the 1/2 put back."""
    error = z_1 - 0.5 * (kappa_hi + kappa_lo) - 0.5 * z_2
    room = (kappa_hi - z_1) * (z_1 - kappa_lo)
    return -gains.k_z / (tau * gains.d_z * room) * error * error - gains.d_z * gains.k_2 * z_2 * z_2


def virtual_control(z_1, kappa_lo, kappa_hi, partner_velocity, tau, gains: PublishedGains):
    """Alpha_2 of (9), m: what v_own = tau x_own' should be."""
    return tau * partner_velocity + (z_1 - 0.5 * (kappa_hi + kappa_lo)) / gains.d_z


def barrier_gain(z_1, kappa_lo, kappa_hi, tau, gains: PublishedGains):
    """K_n of (9); infinite at the band's edges, negative outside."""
    return gains.k_z / (4.0 * tau * gains.d_z**2 * (kappa_hi - z_1) * (z_1 - kappa_lo))


def limited_barrier_gain(z_1, kappa_lo, kappa_hi, tau, gains: PublishedGains):
    """K_n of (9) with d_z k_n at most `largest_rate`, and just that outside the band."""
    with np.errstate(divide="ignore"):
        k_n = barrier_gain(z_1, kappa_lo, kappa_hi, tau, gains)
    largest = gains.largest_rate / gains.d_z
    return np.where(k_n > 0.0, np.minimum(k_n, largest), largest)


def follower_acceleration(
    x_own, velocity, lower, upper, partner_velocity, partner_acceleration, tau, gains: PublishedGains
):
    """X_own'' by (9), m/s^2, for an own coordinate that must stay between `lower` and `upper`.

    The bounds move with the partner and only so: alpha_2' is taken with constant kappa, as in the theorem. To feed a
    band forward that moves by itself, give the middle's velocity and acceleration as the partner's.

    Args:
        x_own, velocity: coordinate and its rate, m, m/s.
        lower, upper: bounds on x_own, m: x_partner - kappa_hi / k_z and x_partner - kappa_lo / k_z.
        partner_velocity, partner_acceleration: m/s, m/s^2.
        tau: s.
    """
    # Only differences to the middle count, so the middle serves as the partner's place: mid = 0.
    half = 0.5 * (upper - lower)
    z_1 = gains.k_z * (0.5 * (upper + lower) - x_own)
    kappa_hi = gains.k_z * half
    z_1_dot = gains.k_z * (partner_velocity - velocity)
    z_2 = gains.d_z * (virtual_control(z_1, -kappa_hi, kappa_hi, partner_velocity, tau, gains) - tau * velocity)
    k_n = limited_barrier_gain(z_1, -kappa_hi, kappa_hi, tau, gains)
    return partner_acceleration + (z_1_dot / gains.d_z + (k_n + gains.k_2) * z_2) / tau
