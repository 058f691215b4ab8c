"""From a smooth demonstration to a `Skill`."""

from collections.abc import Mapping

import numpy as np
from scipy.interpolate import make_interp_spline

from drake_blfdmp.errors import SkillError
from drake_blfdmp.skill.basis import centers_and_widths
from drake_blfdmp.skill.canonical import DEFAULT_GAMMA, phase_at
from drake_blfdmp.skill.orientation import learn_orientation
from drake_blfdmp.skill.regression import METHODS
from drake_blfdmp.skill.skill import Skill
from drake_blfdmp.skill.transformation import target_forcing


def learn_skill(
    t: np.ndarray,
    x: np.ndarray,
    *,
    basis_functions: int | None = None,
    method: str = "ridge",
    alpha_z: float | None = None,
    gamma: float = DEFAULT_GAMMA,
    events: Mapping[str, float] | None = None,
    source: str = "",
    spread: np.ndarray | None = None,
    mobility: np.ndarray | None = None,
    turn: np.ndarray | None = None,
) -> Skill:
    """Fit the forcing terms of all six points to a demonstration: (3) with the target (4).

    Args:
        t: (N,) increasing time from 0, s.
        x: (N, 6, 3) smooth positions, m. Velocity and acceleration are those of the quintic spline through them, so
            noise must be gone before: differentiation multiplies it by 1/dt^2.
        basis_functions: n; by default 5 a second, at least 50: n functions follow frequencies up to n / (2 tau) only.
        method: "ridge" (all basis functions at once) or "lwr" (locally weighted regression, the paper's).
        alpha_z: gain of (1); by default 10 tau, so that the spring's rate alpha_z / (2 tau) is 5 rad/s whatever the
            duration. beta_z = alpha_z / 4: critically damped.
        spread: (N, 6, 3) standard deviation at t over the recordings whose mean x is, m; kept 10 times a second or at
            101 times. The fit of the mean is the weighted least-squares fit of all recordings (`docs/learning.md`).
        events, source, mobility: kept in the skill.
        turn: (N, 4) orientations that the skill learns beside the points (`skill.orientation`); None for none.

    Raises:
        SkillError: too few samples or basis functions, or an unknown method.
    """
    if method not in METHODS:
        raise SkillError(f"learning: unknown method '{method}'; there are {', '.join(METHODS)}")
    t, x = np.asarray(t, dtype=float), np.asarray(x, dtype=float)
    if len(t) < 8 or x.shape != (len(t), 6, 3):
        raise SkillError(f"learning: needs at least 8 samples of 6 points, got {len(t)} samples of shape {x.shape}")
    if not (np.all(np.diff(t) > 0) and np.all(np.isfinite(x))):
        raise SkillError("learning: time must increase and every position be finite; clean the recording first")
    tau = float(t[-1] - t[0])
    n = max(50, int(np.ceil(5.0 * tau))) if basis_functions is None else basis_functions
    if n < 2:
        raise SkillError(f"learning: needs at least 2 basis functions, not {n}")
    alpha_z = 10.0 * tau if alpha_z is None else alpha_z
    spline = make_interp_spline(t, x.reshape(len(t), 18), k=5)
    goal = x[-1].reshape(18)
    # Ten samples a function or more: between sparse samples the fit would be free to swing.
    u = np.linspace(0.0, tau, max(len(t), 10 * n + 1))
    x_u, velocity, acceleration = (spline(t[0] + u, order) for order in range(3))
    target = target_forcing(x_u, velocity, acceleration, goal, tau, alpha_z, alpha_z / 4)
    centers, widths = centers_and_widths(n, gamma)
    weights = METHODS[method](phase_at(u, tau, gamma), target, centers, widths)
    return Skill(
        weights=weights.reshape(n, 6, 3),
        centers=centers,
        widths=widths,
        start=x[0].copy(),
        goal=x[-1].copy(),
        tau=tau,
        alpha_z=alpha_z,
        beta_z=alpha_z / 4,
        gamma=gamma,
        events=dict(events or {}),
        source=source,
        spread=None if spread is None else _evenly(t, np.asarray(spread, dtype=float)),
        mobility=mobility,
        orientation=None
        if turn is None
        else learn_orientation(
            t, turn, centers=centers, widths=widths, tau=tau, gamma=gamma, alpha_z=alpha_z, method=method
        ),
    )


def _evenly(t: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Values (N, 6, 3) at times (N,) sampled as a skill keeps its spread."""
    if values.shape != (len(t), 6, 3):
        raise SkillError(f"learning: the spread has shape {values.shape}, expected {(len(t), 6, 3)}")
    return make_interp_spline(t, values, k=1)(
        np.linspace(t[0], t[-1], max(101, int(np.ceil(10.0 * (t[-1] - t[0]))) + 1))
    )
