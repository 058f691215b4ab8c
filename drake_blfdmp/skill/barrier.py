"""The barrier Lyapunov function on one link length and the default law that keeps the length inside a moving band.

For a length rho in the band [lo, hi] with middle m and half width w:

    xi  = (rho - m) / w,   z_2 = xi' + k_1 xi
    V   = 1/2 log(1 / (1 - xi^2)) + 1/2 z_2^2
    xi'' = -xi / (1 - xi^2) - k_2 z_2 - k_1 xi'
    =>  V' = -k_1 xi^2 / (1 - xi^2) - k_2 z_2^2 < 0 off the origin, for any smooth moving band.

The barrier is the paper's (7) with z_1 = rho and the band normalised; moving bounds enter by m', m'', w', w'' as in
Tee, Ren, Ge, "Control of nonlinear systems with time-varying output constraints", Automatica 47, 2011. Arrays
broadcast; bands are (..., 6, 5) as in `bands`. Float, AutoDiffXd or Expression entries.
"""

import numpy as np


def middles_and_half_widths(bands):
    """m, m', m'' and w, w', w'' (each (..., 5)) of bands (..., 6, 5)."""
    lower, upper = bands[..., 0::2, :], bands[..., 1::2, :]
    m, w = 0.5 * (lower + upper), 0.5 * (upper - lower)
    return (m[..., 0, :], m[..., 1, :], m[..., 2, :]), (w[..., 0, :], w[..., 1, :], w[..., 2, :])


def normalised_error(rho, rho_dot, bands):
    """Xi and xi' of lengths rho (..., 5), m, with rates rho' (..., 5), m/s."""
    (m, m1, _), (w, w1, _) = middles_and_half_widths(bands)
    xi = (rho - m) / w
    return xi, (rho_dot - m1 - w1 * xi) / w


def barrier_function(xi, xi_dot, k_1):
    """V: 0 at the middle of the band at rest, infinite at its edges."""
    return -0.5 * np.log(1.0 - xi * xi) + 0.5 * (xi_dot + k_1 * xi) ** 2


def barrier_derivative(xi, xi_dot, k_1, k_2):
    """V' along the default law, 1/s: negative off the origin."""
    return -k_1 * xi * xi / (1.0 - xi * xi) - k_2 * (xi_dot + k_1 * xi) ** 2


def error_acceleration(xi, xi_dot, k_1, k_2):
    """Xi'' of the default law, 1/s^2."""
    return -xi / (1.0 - xi * xi) - k_2 * (xi_dot + k_1 * xi) - k_1 * xi_dot


def length_acceleration(xi, xi_dot, xi_ddot, bands):
    """Rho'' = m'' + w xi'' + 2 w' xi' + w'' xi, m/s^2."""
    (_, _, m2), (w, w1, w2) = middles_and_half_widths(bands)
    return m2 + w * xi_ddot + 2.0 * w1 * xi_dot + w2 * xi
