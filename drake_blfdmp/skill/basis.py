"""The radial basis of the forcing term f(s) = theta^T Psi(s), below (1)."""

import numpy as np

from drake_blfdmp.skill.canonical import phase_at


def centers_and_widths(n: int, gamma: float) -> tuple[np.ndarray, np.ndarray]:
    """Centres c_k equally spaced in time (so exponentially in phase) and widths h_k, both (n,).

    phi_k has the spacing of the centres as its standard deviation, so neighbours cross at about exp(-1/8) = 0.88: wide
    enough for a smooth sum, and the regression's condition stays below 100 (`docs/learning.md`).
    """
    if n < 2:
        raise ValueError(f"a basis needs at least 2 functions, not {n}")
    c = phase_at(np.linspace(0.0, 1.0, n), 1.0, gamma)
    spacing = np.abs(np.gradient(c))
    return c, 0.5 / spacing**2


def activations(s, centers, widths):
    """Normalised activations psi_k = phi_k(s) s / sum(phi), phi_k = exp(-h_k (s - c_k)^2).

    Args:
        s: (...) phase.
        centers, widths: (n,).

    Returns:
        (..., n).
    """
    s = np.asarray(s)[..., None]
    phi = np.exp(-widths * (s - centers) ** 2)
    return phi * (s / np.sum(phi, axis=-1, keepdims=True))


def forcing(s, weights, centers, widths):
    """The forcing f(s) = theta^T Psi(s).

    Args:
        s: (...) phase.
        weights: (n, d) one column a dimension.

    Returns:
        (..., d), in the unit of the weights.
    """
    return activations(s, centers, widths) @ weights
