"""Learning of the forcing term: minimise (3) with the target (4)."""

import numpy as np
from scipy.linalg import lstsq

from drake_blfdmp.skill.basis import activations


def locally_weighted(s, target, centers, widths):
    """Locally weighted regression, the paper's choice: each basis function fitted on its own.

    w_k = sum phi_k s f / sum phi_k s^2.

    Args:
        s: (N,) phase.
        target: (N, d).

    Returns:
        weights (n, d).
    """
    phi = np.exp(-widths * (s[:, None] - centers) ** 2)
    return ((phi * s[:, None]).T @ target) / ((phi * s[:, None] ** 2).sum(axis=0)[:, None] + np.finfo(float).tiny)


def ridge(s, target, centers, widths, relative_penalty: float = 1e-7):
    """Ridge regression on all basis functions at once.

    The columns of the design matrix are scaled to unit length first: the factor s makes late functions a hundred times
    smaller than early ones, and an unscaled penalty would silence them.

    Args:
        s: (N,) phase.
        target: (N, d).
        relative_penalty: ridge parameter relative to the unit columns.

    Returns:
        weights (n, d).
    """
    design = activations(s, centers, widths)
    scale = np.linalg.norm(design, axis=0)
    n = len(centers)
    augmented = np.vstack([design / scale, np.sqrt(relative_penalty) * np.eye(n)])
    padded = np.vstack([target, np.zeros((n, target.shape[1]))])
    solution, *_ = lstsq(augmented, padded)  # pyright: ignore[reportGeneralTypeIssues]  SciPy's types are guessed
    return solution / scale[:, None]


METHODS = {"ridge": ridge, "lwr": locally_weighted}
