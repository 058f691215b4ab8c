r"""The movement primitive of an orientation: (1) for the rotation that is left to the goal.

With unit quaternions q, goal g and the rotation vector of what is left, e = 2 log(g conj(q)), by the shortest way,

    tau z' = alpha (beta (0 - e) - z) + f(s),   tau e' = z,   omega = -J_r(e) e',

omega being the angular velocity in the frame in which q stands and J_r the right Jacobian of the rotation vector. It is
(1) for e with the goal 0, so its exact step, its learning and its convergence are those of the positions.
Ude, Nemec, Petric, Morimoto, "Orientation in Cartesian space dynamic movement primitives", ICRA 2014, write
tau eta' = alpha (beta 2 log(g conj(q)) - eta) + f, tau q' = eta q / 2, as if e' were -omega. That is so for rotations
about one axis only; Koutras and Doulgeri, "A correct formulation for the orientation dynamic movement primitives for
robot control in the Cartesian space", CoRL 2019, put e' in its place, which is what stands here.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import make_interp_spline

from drake_blfdmp.errors import SkillError
from drake_blfdmp.quaternions import conjugate, continuous, from_rotation_vector, multiply, normalised, rotation_vector
from drake_blfdmp.skill.basis import forcing
from drake_blfdmp.skill.canonical import phase_at
from drake_blfdmp.skill.regression import METHODS
from drake_blfdmp.skill.transformation import nominal_acceleration, step_matrices, target_forcing, uncoupled_step
from drake_blfdmp.vectors import cross, dot

FARTHEST = np.deg2rad(170.0)
"""A demonstration that is farther than this from its own end has no shortest way to it that noise would not change."""

_SERIES = 0.05  # rad; below it the Jacobians' quotients come from their series: either way to about 1e-10.


@dataclass(frozen=True)
class OrientationSkill:
    """The orientation's share of a skill, with whose phase, basis and gains it moves.

    Attributes:
        weights: (n, 3) of the rotation vector's three axes.
        start, goal: (4,) unit quaternions, w x y z.
    """

    weights: np.ndarray
    start: np.ndarray
    goal: np.ndarray

    def __post_init__(self):
        for name, shape in (("weights", (len(self.weights), 3)), ("start", (4,)), ("goal", (4,))):
            value = np.asarray(getattr(self, name))
            if value.shape != shape or not np.all(np.isfinite(value)):
                raise SkillError(f"skill: orientation {name} of shape {value.shape} must be finite numbers {shape}")
        for name in ("start", "goal"):
            norm = float(np.linalg.norm(getattr(self, name)))
            if abs(norm - 1.0) > 1e-6:
                raise SkillError(f"skill: orientation {name} is no unit quaternion, its length is {norm:g}")

    def with_goal(self, goal) -> "OrientationSkill":
        """The same skill to another orientation (4,), of any length but zero."""
        return replace(self, goal=normalised(goal))

    def forcing(self, s, centers, widths):
        """f(s) (..., 3) for a phase of shape (...)."""
        return forcing(s, self.weights, centers, widths)


def error(q, goal):
    """The rotation vector e (..., 3) that is left from q to the goal (..., 4), rad, by the shortest way."""
    return rotation_vector(multiply(goal, conjugate(q)))


def _quotients(angle):
    """(1 - cos)/angle^2, (angle - sin)/angle^3, and 1/angle times their derivatives, even functions of the angle."""
    small = angle < _SERIES
    x = np.where(small, 1.0, angle)
    sin, cos, y = np.sin(x), np.cos(x), angle**2
    a = np.where(small, 1 / 2 - y / 24 + y**2 / 720 - y**3 / 40320, (1 - cos) / x**2)
    b = np.where(small, 1 / 6 - y / 120 + y**2 / 5040 - y**3 / 362880, (x - sin) / x**3)
    da = np.where(small, -1 / 12 + y / 180 - y**2 / 6720, (x * sin - 2 * (1 - cos)) / x**4)
    db = np.where(small, -1 / 60 + y / 1260 - y**2 / 60480, (3 * sin - 2 * x - x * cos) / x**5)
    return a, b, da, db


def angular_velocity(e, e_dot):
    """Omega = -J_r(e) e' (..., 3), rad/s, of a q that is e away from a goal at rest."""
    a, b, _, _ = (value[..., None] for value in _quotients(np.linalg.norm(e, axis=-1)))
    across = cross(e, e_dot)
    return -(e_dot - a * across + b * cross(e, across))


def error_rate(e, omega):
    """E' = -J_r(e)^-1 omega (..., 3), rad/s: the inverse of `angular_velocity`."""
    angle = np.linalg.norm(e, axis=-1)
    small = angle < _SERIES
    half = 0.5 * np.where(small, 1.0, angle)
    exact = (1.0 - half / np.tan(half)) / (4.0 * half**2)
    c = np.where(small, 1 / 12 + angle**2 / 720 + angle**4 / 30240, exact)[..., None]
    across = cross(e, omega)
    return -(omega + 0.5 * across + c * cross(e, across))


def angular_acceleration(q, omega, f, goal, tau, alpha_z, beta_z):
    """Omega' (..., 3), rad/s^2, of the primitive at q, omega, for a goal at rest: -(J_r e'' + J_r' e')."""
    e = error(q, goal)
    e_dot = error_rate(e, omega)
    e_ddot = nominal_acceleration(e, tau * e_dot, f, 0.0, tau, alpha_z, beta_z)
    _, b, da, db = (value[..., None] for value in _quotients(np.linalg.norm(e, axis=-1)))
    along = dot(e, e_dot)[..., None]
    across = cross(e, e_dot)
    twice = cross(e, across)
    turning = -da * along * across + db * along * twice + b * cross(e_dot, across)
    return angular_velocity(e, e_ddot) - turning


def orientation_step(q, omega, f, goal, tau, matrices):
    """Q and omega one step later, exactly for inputs held over it; q keeps its unit length whatever the step.

    Args:
        q, goal: (..., 4); omega, f: (..., 3).
        matrices: of `transformation.step_matrices`.
    """
    e = error(q, goal)
    e, z = uncoupled_step(e, tau * error_rate(e, omega), f, 0.0, matrices)
    after = multiply(conjugate(from_rotation_vector(e)), goal)
    after = normalised(np.where(np.sum(after * q, axis=-1, keepdims=True) < 0.0, -after, after))
    return after, angular_velocity(e, z / tau)


def learn_orientation(t, q, *, centers, widths, tau, gamma, alpha_z, method="ridge") -> OrientationSkill:
    """Fit the forcing to a demonstrated orientation: (3) with the target (4), for e.

    Args:
        t: (N,) increasing time from 0, s; q: (N, 4) smooth orientations, signs of any kind.
        centers, widths: (n,) of the basis; tau, s, gamma, alpha_z (beta_z is a quarter of it): the skill's.
        method: a name of `regression.METHODS`.

    Raises:
        SkillError: another shape, numbers that are not finite, or an orientation more than 170 degrees from the last.
    """
    t, q = np.asarray(t, dtype=float), np.asarray(q, dtype=float)
    if len(t) < 8 or q.shape != (len(t), 4):
        raise SkillError(f"learning: needs at least 8 orientations, got {len(t)} samples of shape {q.shape}")
    if not np.all(np.isfinite(normalised(q))):
        raise SkillError("learning: every orientation must be a quaternion of finite numbers, not all of them zero")
    q = continuous(normalised(q))
    e = error(q, q[-1])
    farthest = float(np.linalg.norm(e, axis=-1).max())
    if farthest > FARTHEST:
        raise SkillError(
            f"learning: the orientation is up to {np.rad2deg(farthest):.0f} degrees from the last one, and has no "
            f"clear shortest way beyond {np.rad2deg(FARTHEST):.0f}; cut the recording, or leave its orientations out "
            "with retarget.pitch=false"
        )
    spline = make_interp_spline(t, e, k=5)
    u = np.linspace(0.0, tau, max(len(t), 10 * len(centers) + 1))
    e_u, e_dot, e_ddot = (spline(t[0] + u, order) for order in range(3))
    target = target_forcing(e_u, e_dot, e_ddot, np.zeros(3), tau, alpha_z, alpha_z / 4)
    weights = METHODS[method](phase_at(u, tau, gamma), target, centers, widths)
    return OrientationSkill(weights, q[0].copy(), q[-1].copy())


def roll_out_orientation(skill, *, time_step: float, samples: int, goal=None) -> tuple[np.ndarray, np.ndarray]:
    """Run the orientation of a skill that has one as the discrete system does: forcing taken mid-step.

    Args:
        skill: a `skill.Skill`.
        time_step: s; samples: their number N, the first at t = 0.
        goal: (..., 4), the skill's own by default; leading axes make a batch.

    Returns:
        q (N, ..., 4) and omega (N, ..., 3), rad/s.
    """
    own = skill.orientation
    goal = own.goal if goal is None else normalised(goal)
    q = np.array(np.broadcast_to(own.start, np.shape(goal)))
    omega = np.zeros((*q.shape[:-1], 3))
    matrices = step_matrices(time_step, skill.tau, skill.alpha_z, skill.beta_z)
    phases = phase_at((np.arange(samples) + 0.5) * time_step, skill.tau, skill.gamma)
    f = own.forcing(phases, skill.centers, skill.widths)
    qs, omegas = np.empty((samples, *q.shape)), np.empty((samples, *omega.shape))
    for k in range(samples):
        qs[k], omegas[k] = q, omega
        q, omega = orientation_step(q, omega, f[k], goal, skill.tau, matrices)
    return qs, omegas
