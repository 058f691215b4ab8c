"""How hard two palms must press on a box to hold it, and how hard an arm can press.

A squeeze is feasible where `least_squeeze` <= force <= `largest_squeeze`.

Derivation of the first. Each palm presses with N on a disc of radius r, the pressure the same all over it (the pad is
an elastic foundation and the box's face is flat), and bears half of the box's weight and inertia, P = m (g + a)/2.
Where the box's centre of mass lies on the palms' axis, or above or below it, friction bears this force alone:
P <= mu N. Where it lies aside by e, friction must bear the moment P e as well. The box then begins to slide about some
point at a distance c on the far side of the axis, and the power of the load against that of friction gives, for each
palm,

    P (c + e) <= mu N D(c),   D(c): mean distance of the disc's points from that point,

so that P <= mu N min over c of D(c)/(c + e). Every c gives an upper bound, and the least of them is the truth, because
Coulomb friction under a known pressure obeys the principle of greatest dissipation (Goyal, Ruina, Papadopoulos, "Planar
sliding with dry friction. Part 1", Wear 143, 1991). Limits: P = mu N for e = 0, P e = 2/3 mu N r for e >> r.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import JacobianWrtVariable, ModelInstanceIndex
from pydrake.systems.framework import Context
from scipy.special import ellipe, ellipk

from drake_blfdmp.errors import TaskError
from drake_blfdmp.robot.plant import ArmActuators

PALM_RADIUS = 0.045
"""Of the pad of `panda_palm.urdf`, m."""

PALM_FRICTION = 0.8
"""Of the pad: its dynamic coefficient, the only one that Drake's discrete contact uses."""

GRAVITY = 9.81  # m/s^2, Drake's.

PADS_FACTOR = 1.2
"""On the estimate, what the simulated pads need that face the box squarely: 1.01, and 1.18 for a centre 40 mm aside,
where the mesh of the pad bears less torsion than the disc (the study `squeeze`)."""

ARMS_FACTOR = 2.5
"""On the estimate, what the simulated arms need: 2.2. A squeeze turns their palms by 1 to 2 degrees, so that they touch
the box with a quarter to a half of their pads, and it varies on the way (docs/contact.md)."""


def combined_friction(first, second):
    """Drake's coefficient of a pair of surfaces, 2 m n/(m + n); broadcasts."""
    first, second = np.asarray(first, dtype=float), np.asarray(second, dtype=float)
    return 2.0 * first * second / (first + second)


def turning_factor(offset, radius=PALM_RADIUS):
    """How many times harder a palm must press when its load acts `offset` aside of its centre: >= 1, broadcasts.

    1 / min over c of D(c)/(c + offset), see above; lengths in m. 1.28 for 20 mm on the pad's 45 mm. The ellipse of Howe
    and Cutkosky, sqrt(1 + (3 offset/(2 radius))^2), which is often used instead, gives 1.20 there: too little.
    """
    share = np.asarray(offset, dtype=float) / np.asarray(radius, dtype=float)
    # At c -> infinity, pure sliding, the ratio is 1; it has one least value, flat around it, so a fine grid finds it.
    c = np.geomspace(1e-4, 1e4, 2000)
    return 1.0 / np.minimum(1.0, np.min(mean_distance(c) / (c + share[..., None]), axis=-1))


def mean_distance(c):
    """Mean distance of the unit disc's points from a point at the distance c >= 0 of its centre; broadcasts.

    Complete elliptic integrals E, K of the parameter k = c^2 inside: 4/(9 pi) ((7 + c^2) E - 4 (1 - c^2) K); outside,
    with k = 1/c^2: 4/(9 pi) (c (7 + c^2) E - (c^2 + 3)(c^2 - 1)/c K).
    """
    c = np.asarray(c, dtype=float)
    square = c**2
    inside = np.minimum(square, 1.0 - 1e-15)  # K is infinite at 1, where its factor is zero.
    within = (7.0 + square) * ellipe(inside) - 4.0 * (1.0 - inside) * ellipk(inside)
    far = np.maximum(c, 1.0 + 1e-15)
    k = 1.0 / far**2
    beyond = far * (far**2 + 7.0) * ellipe(k) - (far**2 + 3.0) * (far**2 - 1.0) / far * ellipk(k)
    # Far away both terms grow as c^3 and cancel; the mean distance is c + 1/(8 c) there.
    beyond = np.where(far > 100.0, 9.0 * np.pi / 4.0 * (far + 0.125 / far), beyond)
    return 4.0 / (9.0 * np.pi) * np.where(c < 1.0, within, beyond)


def least_squeeze(mass, friction, acceleration=0.0, offset=0.0, *, radius=PALM_RADIUS, factor=ARMS_FACTOR):
    """The least force, N, with which each of two palms must press to hold a box without sliding or turning; broadcasts.

    factor * m (g + a)/(2 mu) * turning_factor(offset).

    Args:
        mass: of the box, kg.
        friction: of palm and box together (`combined_friction`).
        acceleration: magnitude of the greatest one in the carry, m/s^2, as if it were upward: a bound for any other
            direction in the palms' plane.
        offset: horizontal distance of the box's centre of mass from the palms' axis, m. A centre below the axis turns
            nothing while the box is upright.
        radius: of the palms' pads, m.
        factor: on the estimate: ARMS_FACTOR for a carry, PADS_FACTOR for pads that face the box, 1 for the estimate.

    Raises:
        TaskError: a mass, coefficient, radius or factor that is not positive, or a negative acceleration or offset.
    """
    for name, value, least in (
        ("mass", mass, "> 0"),
        ("friction", friction, "> 0"),
        ("radius", radius, "> 0"),
        ("factor", factor, "> 0"),
        ("acceleration", acceleration, ">= 0"),
        ("offset", offset, ">= 0"),
    ):
        array = np.asarray(value, dtype=float)
        if not np.all(np.isfinite(array)) or np.any(array <= 0.0 if least == "> 0" else array < 0.0):
            raise TaskError(f"least squeeze: {name} {value} must be finite and {least}")
    weight = np.asarray(mass, dtype=float) * (GRAVITY + np.asarray(acceleration, dtype=float))
    return factor * weight / (2.0 * np.asarray(friction, dtype=float)) * turning_factor(offset, radius)


def gravity_torque(plant: MultibodyPlant, context: Context, arm: ModelInstanceIndex) -> np.ndarray:
    """What gravity does to an arm's joints, (7,) N m: sum over its bodies of J^T m g.

    Found from the bodies, as the simulated arms have gravity switched off in place of the compensation that a Panda
    runs; its motors bear it all the same.

    Raises:
        TaskError: the plant is not finalized.
    """
    columns = _columns(plant, arm)
    torque = np.zeros(len(columns))
    world, gravity = plant.world_frame(), np.asarray(plant.gravity_field().gravity_vector())
    for index in plant.GetBodyIndices(arm):
        body = plant.get_body(index)
        jacobian = plant.CalcJacobianTranslationalVelocity(
            context,
            JacobianWrtVariable.kV,
            body.body_frame(),
            body.CalcCenterOfMassInBodyFrame(context),
            world,
            world,
        )
        torque += body.get_mass(context) * np.asarray(jacobian)[:, columns].T @ gravity
    return torque


def largest_squeeze(
    plant: MultibodyPlant,
    context: Context,
    arm: ModelInstanceIndex,
    load: Sequence[float] | np.ndarray = (0.0, 0.0, 0.0),
    gravity: bool = True,
) -> float:
    """The largest force, N, with which an arm at rest can press along its palm's normal within its joints' efforts.

    At rest tau = J^T (F n - load) - tau_gravity, n the palm's z axis; the largest F >= 0 with |tau| <= effort limit for
    every joint.

    Args:
        plant: finalized.
        context: its context, with the arm's positions.
        arm: the model instance.
        load: (3,) force on the palm besides the squeeze's own reaction, in W, N: half a box's weight is
            (0, 0, -m g/2).
        gravity: count the arm's own weight, which a real arm's motors bear; False is what the simulated arm can do.

    Returns:
        N; 0 where the joints cannot even bear the load; infinite where no joint resists the squeeze.

    Raises:
        TaskError: the plant is not finalized, or the load is not three finite numbers.
    """
    force = np.asarray(load, dtype=float)
    if force.shape != (3,) or not np.all(np.isfinite(force)):
        raise TaskError(f"largest squeeze: load {load} must be three finite numbers")
    columns = _columns(plant, arm)
    palm, world = plant.GetFrameByName("palm", arm), plant.world_frame()
    origin: Any = np.zeros(3)  # Any: the stubs of Drake 1.51 name an array type that NumPy's own never match.
    jacobian = np.asarray(
        plant.CalcJacobianTranslationalVelocity(context, JacobianWrtVariable.kV, palm, origin, world, world)
    )[:, columns]
    normal = palm.CalcPoseInWorld(context).rotation().matrix()[:, 2]
    effort = np.array([actuator.effort_limit() for actuator in ArmActuators(plant, arm)])
    held = -jacobian.T @ force
    if gravity:
        held = held - gravity_torque(plant, context, arm)
    if np.any(np.abs(held) > effort):
        return 0.0
    slope = jacobian.T @ normal
    with np.errstate(divide="ignore"):
        room = np.where(slope == 0.0, np.inf, (effort - np.sign(slope) * held) / np.abs(slope))
    return float(room.min())


def _columns(plant: MultibodyPlant, arm: ModelInstanceIndex) -> list[int]:
    """Indices of an arm's joints among the plant's velocities."""
    return [actuator.joint().velocity_start() for actuator in ArmActuators(plant, arm)]
