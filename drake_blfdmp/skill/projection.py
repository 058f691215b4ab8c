"""The nearest skeleton whose links have exactly the desired lengths: the reference "fitting (14)-(17)" of Fig. 7.

Of all six points y with |y_b - y_a| = d_l on every link l, the one that minimises the mobility-weighted change

    sum_p |y_p - x_p|^2 / w_p

from given points x; so a shoulder, which is measured best, moves least. At the minimum y - x = W G(y)^T tension, the
reshaper's least change once more, of positions in place of accelerations. Gauss-Newton iterates it:

    y <- (1 - a) y + a [x + W G^T (G W G^T)^-1 (d - rho(y) + G (y - x))],   G and rho at the last y

With a = 1 the iteration swings from side to side where links have to grow by a third; an a below one lets it settle.
"""

import numpy as np

from drake_blfdmp.errors import SkillError
from drake_blfdmp.skeleton import LINKS
from drake_blfdmp.skill.geometry import link_vectors
from drake_blfdmp.skill.reshaper import DEFAULT_MOBILITY, solve_chain, spread
from drake_blfdmp.vectors import dot

RELAXATION = 0.7
"""The a above; of 2000 random skeletons with 0.05 m of noise on every coordinate all settle, with 1.0 all but 3."""

TOLERANCE = 1e-13
"""m; the last step moves no point farther."""

LARGEST_COUNT = 300


def nearest_skeleton(x, lengths, mobility=DEFAULT_MOBILITY):
    """The points nearest to x whose five links have the given lengths.

    The iteration converges linearly: links within a quarter of their desired length take about thirty steps.

    Args:
        x: (..., 6, 3) m.
        lengths: (..., 5) positive, m; broadcast against the leading axes of x.
        mobility: (6,) positive.

    Returns:
        (..., 6, 3) m.

    Raises:
        SkillError: a number is not finite or a length not positive, a link of x has no direction because its ends
            coincide, or the iteration does not settle because a link is much too long or too short.
    """
    x, lengths, mobility = (np.asarray(value, dtype=float) for value in (x, lengths, mobility))
    shape = np.broadcast_shapes(x.shape[:-2], lengths.shape[:-1])
    x, lengths = np.broadcast_to(x, (*shape, 6, 3)), np.broadcast_to(lengths, (*shape, len(LINKS)))
    if not (np.isfinite(x).all() and np.isfinite(lengths).all()):
        raise SkillError("nearest skeleton: a point or length is not finite; fill the gaps first")
    if not (np.all(lengths > 0) and np.all(mobility > 0)):
        raise SkillError("nearest skeleton: lengths and mobilities must be positive; check the bands' bones")
    _check_directions(x)
    y = np.array(x)
    moved = np.zeros(shape)
    for _ in range(LARGEST_COUNT):
        r = link_vectors(y)
        rho = np.sqrt(dot(r, r))
        n = r / np.maximum(rho, np.finfo(float).tiny)[..., None]
        need = lengths - rho + dot(n, link_vectors(y - x))
        step = RELAXATION * (x - y + spread(n, solve_chain(n, need, mobility), mobility))
        moved = np.abs(step).max(axis=(-2, -1))
        y = y + step
        if moved.size == 0 or moved.max() <= TOLERANCE:
            return y
    worst = np.unravel_index(int(np.argmax(moved)), shape)
    wrong = np.abs(np.linalg.norm(link_vectors(x[worst]), axis=-1) / lengths[worst] - 1.0)
    raise SkillError(
        f"nearest skeleton: {_sample(worst)}not found in {LARGEST_COUNT} iterations; the link "
        f"{LINKS[int(np.argmax(wrong))].name} is {100 * wrong.max():.0f} % off its desired length, check the points"
    )


def _check_directions(x) -> None:
    """Refuse a link whose ends coincide: no direction is nearest."""
    r = link_vectors(x)
    zero = np.argwhere(dot(r, r) == 0.0)
    if len(zero):
        *where, link = zero[0]
        raise SkillError(
            f"nearest skeleton: {_sample(where)}the link {LINKS[link].name} has its ends at one point; "
            "check the recording"
        )


def _sample(index) -> str:
    """How an error names one of the skeletons."""
    return f"at sample {', '.join(str(int(i)) for i in index)} " if len(index) else ""
