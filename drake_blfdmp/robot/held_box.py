"""A box between two palms, carried so slowly that all is in equilibrium: what every palm and every motor bears.

The arms are held by their joints' stiffness at commanded postures; each pad is an elastic foundation (`PadPoints`) on a
rigid, flat face; friction is Coulomb's at every point of the pad. At a posture the displacements u (20) from what is
commanded, of 14 joints and of the box, make

    1/2 dq^T K dq - f^T u + sum_i k_i/2 max(0, depth_i)^2 + sum_i phi(|r_i - s_i|, mu p_i)

least: depth_i(u) how deep point i is in the face, k_i its stiffness, p_i = k_i depth_i its force, r_i(u) how far it has
moved along the face, s_i where it sticks, and phi(r, limit) the potential of friction, h/2 r^2 with a great h up to the
limit, then limit r. They are small, so everything is linear in u about the command, and the sum is convex where the
limits are given, as in Drake's `lagged` contact; they are found by repetition, in which the box creeps against a
viscosity that thins, so that the limits follow the pressure: what comes to rest is held, what does not is lost. Points
whose limit is passed slide, and stick where they come to (return mapping; Wriggers, Computational Contact Mechanics,
2006).

First the palms close, step by step, on a box that its table keeps upright and lets slide; then the box is carried from
posture to posture. What differs from the simulated arms: no speed, no damping, no friction on the table, and a box that
turns far is lost, which then may hang at an angle. It takes a hundredth of the simulation's time.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import JacobianWrtVariable

from drake_blfdmp.robot.grasp_force import GRAVITY, PALM_RADIUS
from drake_blfdmp.robot.plant import ARMS, DEFAULT_STIFFNESS, ArmActuators

FOUNDATION = 1.0e6 / 0.0075
"""Pressure over depth of the pad, N/m^3: its modulus over half its thickness (docs/contact.md)."""

STICKING = 30.0
"""How many times stiffer than a pad's point is along its normal friction holds it; what sticks does not move."""

CLOSING_STEPS = 8
FIRST_GAP = 2e-4  # m, from which the palms close.
TABLE = 1e7
"""How stiffly a table keeps a box upright that is being taken, N/m and N m/rad."""

LOST_M, LOST_RAD = 0.02, np.deg2rad(6.0)
"""A box that moves or turns by more in the palms is lost."""

RELAXED = 0.01
"""The limits of friction are found when they change by no more than this share."""

AT_REST_N, AT_REST_NM = 1e-3, 1e-4
"""What may be missing to the box's equilibrium, N and N m."""

VISCOSITY, THINS, THINNEST = 2e4, 0.7, 2e3
"""What a box that creeps meets, N a metre and repetition; by which factor it thins with each, and to what. What is
found does not depend on them."""

LEVER = 0.1
"""Length, m, that makes viscosity against turning of it."""

REPETITIONS = 80

_BOX, _TURN = slice(14, 17), slice(17, 20)


class PadPoints(NamedTuple):
    """Points (N, 2), m, spread evenly over a pad in its palm's frame, and their share of its area, m^2."""

    at: np.ndarray
    area: float


def MakePadPoints(count: int = 16) -> PadPoints:
    """Of the hexagon with a vertex on x that stands for the pad in Drake's contact, `count` of them across."""
    across = PALM_RADIUS * ((2.0 * np.arange(count) + 1.0) / count - 1.0)
    at = np.stack(np.meshgrid(across, across), axis=-1).reshape(-1, 2)
    towards = np.deg2rad(30.0 + 60.0 * np.arange(6))
    inside = (at @ np.stack([np.cos(towards), np.sin(towards)]) <= PALM_RADIUS * np.cos(np.deg2rad(30.0))).all(axis=1)
    whole = 1.5 * np.sqrt(3.0) * PALM_RADIUS**2
    return PadPoints(at[inside], whole / float(inside.sum()))


@dataclass(frozen=True)
class HeldBox:
    """What is held.

    Attributes:
        width: between its faces, m.
        mass: kg.
        friction: of palm and box together (`combined_friction`).
        centre: (3,) of its mass, from the middle between the palms, along W's axes, m.
    """

    width: float
    mass: float
    friction: float
    centre: np.ndarray


@dataclass(frozen=True)
class Hold:
    """What N postures, or those before a box is lost, lead to; palms are left, right.

    Attributes:
        force: (N, 2) of each palm on the box, along the palm's normal, z, N.
        shear: (N, 2, 2) of each palm's friction on the box, along the palm's x and y, N.
        torsion: (N, 2) the same about the palm's z, N m.
        centre: (N, 2, 2) of the pressure, in each palm's frame, m.
        touching: (N, 2) share of the pad that touches.
        effort: (N, 14) of the motors that holding the box takes, N m.
        moved, turned: (N, 3) of the box, from where the palms are commanded to have it, along W's axes, m and rad.
        lost: whether the box slips out, or turns far, in the posture after the last.
    """

    force: np.ndarray
    shear: np.ndarray
    torsion: np.ndarray
    centre: np.ndarray
    touching: np.ndarray
    effort: np.ndarray
    moved: np.ndarray
    turned: np.ndarray
    lost: bool


def CarryQuasiStatically(
    plant: MultibodyPlant,
    postures: np.ndarray,
    depths: np.ndarray,
    box: HeldBox,
    accelerations: np.ndarray | None = None,
    stiffness: Sequence[float] | np.ndarray = DEFAULT_STIFFNESS,
) -> Hold:
    """Closes on a box in the first of the postures and carries it through all.

    Args:
        plant: both arms, finalized, as from `MakeKinematicPlant`.
        postures: (N, 14) commanded, rad; the palms face each other.
        depths: (N,) by which each palm is commanded into the box, m.
        box: what is held.
        accelerations: (N, 3) of the box in W, m/s^2; none when None.
        stiffness: (7,) of the joints, N m/rad.
    """
    carry = _Carry(plant, box, np.tile(np.asarray(stiffness, dtype=float), 2))
    accelerations = np.zeros((len(postures), 3)) if accelerations is None else accelerations
    found: list[tuple] = []
    lost = False
    first = _Pads.at(plant, postures[0], carry.pad)
    for share in np.arange(1, CLOSING_STEPS + 1) / CLOSING_STEPS:
        carry.step(first, share * depths[0] - (1.0 - share) * FIRST_GAP, np.zeros(3), on_table=True)
    for q, depth, acceleration in zip(postures, depths, accelerations, strict=True):
        lost = not carry.step(_Pads.at(plant, q, carry.pad), depth, acceleration)
        if lost:
            break
        found.append(carry.state())
    shapes = ((2,), (2, 2), (2,), (2, 2), (2,), (14,), (3,), (3,))
    columns = zip(*found, strict=True) if found else [()] * len(shapes)
    return Hold(*(np.reshape(column, (-1, *shape)) for column, shape in zip(columns, shapes, strict=True)), lost=lost)


class _Pads(NamedTuple):
    """How the pads' points move against the box with u: (2, N, 20) into it, (2, N, 2, 20) along its faces."""

    into: np.ndarray
    along: np.ndarray

    @classmethod
    def at(cls, plant: MultibodyPlant, q: np.ndarray, pad: PadPoints) -> "_Pads":
        context, world, origin = plant.CreateDefaultContext(), plant.world_frame(), np.zeros((3, 1))
        plant.SetPositions(context, q)
        palms = [plant.GetFrameByName("palm", plant.GetModelInstanceByName(arm)) for arm in ARMS]
        poses = [palm.CalcPoseInWorld(context) for palm in palms]
        middle = 0.5 * sum(pose.translation() for pose in poses)
        into, along = [], []
        for k, (arm, palm, pose) in enumerate(zip(ARMS, palms, poses, strict=True)):
            columns = [a.joint().velocity_start() for a in ArmActuators(plant, plant.GetModelInstanceByName(arm))]
            J = plant.CalcJacobianSpatialVelocity(context, JacobianWrtVariable.kV, palm, origin, world, world)
            turn, move = np.zeros((3, 20)), np.zeros((3, 20))
            turn[:, 7 * k : 7 * k + 7], move[:, 7 * k : 7 * k + 7] = J[:3, columns], J[3:, columns]
            turn[:, _TURN] = move[:, _BOX] = -np.eye(3)
            place = pose.translation() - middle
            move[:, _TURN] = np.cross(place, np.eye(3)).T  # Times turned: place x turned, less what turning moves.
            axes = pose.rotation().matrix().T
            places = pad.at @ axes[:2]
            x, y, z = (axis @ move + np.cross(places, axis) @ turn for axis in axes)
            into.append(z)
            along.append(np.stack([x, y], axis=1))
        return cls(np.array(into), np.array(along))


class _Carry:
    """The displacements, and where the pads' points stick."""

    def __init__(self, plant: MultibodyPlant, box: HeldBox, stiffness: np.ndarray):
        self.pad, self._box, self._stiffness = MakePadPoints(), box, stiffness
        self._normal = FOUNDATION * self.pad.area
        self._u, self._stuck = np.zeros(20), np.zeros((2, len(self.pad.at), 2))
        self._pressure = np.zeros((2, len(self.pad.at)))
        self._friction = np.zeros_like(self._stuck)

    def step(self, pads: _Pads, depth: float, acceleration: np.ndarray, *, on_table: bool = False) -> bool:
        """Finds the equilibrium with palms that deep; False where there is none, for the box is lost."""
        holding, load = np.zeros((20, 20)), np.zeros(20)
        holding[range(14), range(14)] = self._stiffness
        if on_table:
            holding[range(16, 19), range(16, 19)] = TABLE  # Its height, and two of its turns.
        else:
            load[_BOX] = self._box.mass * (np.array([0.0, 0.0, -GRAVITY]) - acceleration)
            load[_TURN] = np.cross(self._box.centre, load[_BOX])
        u, limit = self._u, self._box.friction * self._pressure
        for trial in range(REPETITIONS):
            before, slow = u, np.zeros(20)
            slow[_BOX] = max(VISCOSITY * THINS**trial, THINNEST)
            slow[_TURN] = LEVER**2 * slow[_BOX]
            u = self._least(before, pads, depth, holding + np.diag(slow), load + slow * before, limit)
            if u is None or np.abs(u[_BOX]).max() > LOST_M or np.abs(u[_TURN]).max() > LOST_RAD:
                return False
            pressure = self._normal * np.maximum(0.0, depth + pads.into @ u)
            new, missing = self._box.friction * pressure, np.abs(slow * (u - before))
            at_rest = missing[_BOX].max() < AT_REST_N and missing[_TURN].max() < AT_REST_NM
            if at_rest and np.abs(new - limit).sum() <= RELAXED * new.sum():
                break
            limit = 0.5 * (limit + new)
        else:
            return False
        self._u, self._pressure = u, pressure
        moved = pads.along @ u
        self._friction = self._held_back(moved - self._stuck, limit)[0]
        stick = STICKING * self._normal
        self._stuck = np.where(pressure[..., None] > 0.0, moved - self._friction / stick, moved)
        return True

    def _held_back(self, slip: np.ndarray, limit: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Friction (..., 2) at slips (..., 2) from where points stick, its ratio to them, and whether they slide."""
        stick, size = STICKING * self._normal, np.linalg.norm(slip, axis=-1)
        slides = stick * size > limit
        ratio = np.where(slides, np.where(slides, limit, 0.0) / np.maximum(size, 1e-15), stick)
        return ratio[..., None] * slip, ratio, slides

    def _least(self, u, pads: _Pads, depth: float, holding, load, limit) -> np.ndarray | None:
        """Newton's method with backtracking from u; None where the box falls out."""
        stick = STICKING * self._normal
        flat = pads.along.reshape(-1, 20)

        def energy(u) -> float:
            slip = np.linalg.norm(pads.along @ u - self._stuck, axis=-1)
            bounded = np.where(np.isfinite(limit), limit, 0.0)
            friction = np.where(stick * slip <= limit, 0.5 * stick * slip**2, bounded * (slip - 0.5 * bounded / stick))
            depths = np.maximum(0.0, depth + pads.into @ u)
            return float(0.5 * u @ holding @ u - load @ u + 0.5 * self._normal * (depths**2).sum() + friction.sum())

        value = energy(u)
        for _ in range(60):
            depths = depth + pads.into @ u
            touching = depths > 0.0
            slip = pads.along @ u - self._stuck
            friction, ratio, slides = self._held_back(slip, limit)
            slope = holding @ u - load + flat.T @ friction.ravel()
            slope += self._normal * np.maximum(0.0, depths).ravel() @ pads.into.reshape(-1, 20)
            if np.linalg.norm(slope) < AT_REST_N:
                return u
            into = pads.into[touching]
            weights = ratio[..., None, None] * np.eye(2)
            away = slip / np.maximum(np.linalg.norm(slip, axis=-1, keepdims=True), 1e-15)
            weights -= np.where(slides, ratio, 0.0)[..., None, None] * away[..., :, None] * away[..., None, :]
            curve = holding + self._normal * into.T @ into + flat.T @ (weights @ pads.along).reshape(-1, 20)
            way = -np.linalg.solve(curve + 1e-9 * np.eye(20), slope)
            share = 1.0
            while share > 1e-4 and energy(u + share * way) > value + 1e-4 * share * float(slope @ way) + 1e-12:
                share *= 0.5
            u = u + share * way
            value = energy(u)
            if np.abs(u[_BOX]).max() > 2.0 * LOST_M or np.abs(u[_TURN]).max() > 2.0 * LOST_RAD:
                return None
        return u

    def state(self) -> tuple:
        """The numbers of `Hold` at the last posture."""
        force = self._pressure.sum(axis=1)
        centre = self._pressure @ self.pad.at / np.maximum(force, 1e-9)[:, None]
        touching = (self._pressure > 0.0).mean(axis=1)
        x, y = self._friction[..., 0], self._friction[..., 1]
        torsion = (self.pad.at[:, 0] * y - self.pad.at[:, 1] * x).sum(axis=1)
        effort = -self._stiffness * self._u[:14]
        return force, self._friction.sum(axis=1), torsion, centre, touching, effort, self._u[_BOX], self._u[_TURN]
