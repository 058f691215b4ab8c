"""Lengths of the five links and their rates. Points are (..., 6, 3), m; links are (..., 5)."""

import numpy as np

from drake_blfdmp.skeleton import LINKS
from drake_blfdmp.vectors import dot

FIRST = np.array([link.a for link in LINKS])
SECOND = np.array([link.b for link in LINKS])


def link_vectors(x):
    """R = x_b - x_a of every link: (..., 5, 3)."""
    return x[..., SECOND, :] - x[..., FIRST, :]


def link_lengths(x):
    """Rho = |r|: (..., 5)."""
    r = link_vectors(x)
    return np.sqrt(dot(r, r))


def link_states(x, velocity):
    """Lengths, rates, unit vectors and the centripetal part of the length's acceleration.

    rho'' = n . r'' + (|r'|^2 - rho'^2) / rho

    Returns:
        rho (..., 5), rho' (..., 5), n (..., 5, 3), (|r'|^2 - rho'^2) / rho (..., 5).
    """
    r, r_dot = link_vectors(x), link_vectors(velocity)
    rho = np.sqrt(dot(r, r))
    n = r / rho[..., None]
    rho_dot = dot(n, r_dot)
    return rho, rho_dot, n, (dot(r_dot, r_dot) - rho_dot**2) / rho
