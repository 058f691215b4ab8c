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

First the palms close, step by step, on a box that its table keeps upright, and holds in its place or lets slide; then
the box is carried from posture to posture. What differs from the simulated arms: no speed, no damping, a box that
slides on its table a little, or lies there askew, and that one that turns far is lost, where it may hang at an angle.
It takes a hundredth of the simulation's time.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import JacobianWrtVariable

from drake_blfdmp.robot.grasp_force import GRAVITY
from drake_blfdmp.robot.pad_points import FOUNDATION, MakePadPoints, PadPoints
from drake_blfdmp.robot.plant import ARMS, DEFAULT_STIFFNESS, ArmActuators

STICKING = 30.0
"""How many times stiffer than a pad's point is along its normal friction holds it; what sticks does not move."""

CLOSING_STEPS = 8
FIRST_GAP = 2e-4  # m, from which the palms close.
TABLE = 1e7
"""How stiffly a table holds a box that is being taken, N/m and N m/rad."""

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
    *,
    slides: bool = False,
) -> Hold:
    """Closes on a box in the first of the postures and carries it through all.

    Args:
        plant: both arms, finalized, as from `MakeKinematicPlant`.
        postures: (N, 14) commanded, rad; the palms face each other.
        depths: (N,) by which each palm is commanded into the box, m.
        box: what is held.
        accelerations: (N, 3) of the box in W, m/s^2; none when None.
        stiffness: (7,) of the joints, N m/rad.
        slides: the box goes along when the palms close, as far as they yield unlike each other; else its table holds it
            in its place.
    """
    carry = _Carry(box, np.tile(np.asarray(stiffness, dtype=float), 2))
    accelerations = np.zeros((len(postures), 3)) if accelerations is None else accelerations
    found: list[tuple] = []
    lost = False
    first = _Pads.at(plant, postures[0], carry.pad)
    for share in np.arange(1, CLOSING_STEPS + 1) / CLOSING_STEPS:
        carry.close(first, share * depths[0] - (1.0 - share) * FIRST_GAP, slides)
    for q, depth, acceleration in zip(postures, depths, accelerations, strict=True):
        lost = not carry.step(_Pads.at(plant, q, carry.pad), depth, acceleration)
        if lost:
            break
        found.append(carry.state())
    shapes = ((2,), (2, 2), (2,), (2, 2), (2,), (14,), (3,), (3,))
    columns = zip(*found, strict=True) if found else [()] * len(shapes)
    return Hold(*(np.reshape(column, (-1, *shape)) for column, shape in zip(columns, shapes, strict=True)), lost=lost)


class _Pads(NamedTuple):
    """How the 2 N points of both pads move against the box with u: (2 N, 20) into it, (2 N, 2, 20) along its faces."""

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
        return cls(np.concatenate(into), np.concatenate(along))


class _Carry:
    """The displacements, and where the pads' points stick."""

    def __init__(self, box: HeldBox, stiffness: np.ndarray):
        self.pad, self._box, self._stiffness = MakePadPoints(), box, stiffness
        self._normal = FOUNDATION * self.pad.area
        self._stick = STICKING * self._normal
        points = 2 * len(self.pad.at)
        self._u, self._pressure = np.zeros(20), np.zeros(points)
        self._stuck, self._friction = np.zeros((points, 2)), np.zeros((points, 2))

    def close(self, pads: _Pads, depth: float, slides: bool) -> None:
        """Finds the equilibrium with palms that deep in a box on its table, which lets it slide or holds it."""
        holding = np.zeros((20, 20))
        held = range(16, 19) if slides else range(14, 20)  # Its height and two of its turns, or all.
        holding[held, held] = TABLE
        self._settle(pads, depth, holding, np.zeros(20))

    def step(self, pads: _Pads, depth: float, acceleration: np.ndarray) -> bool:
        """Finds the equilibrium of a box that is held; False where there is none, for it is lost."""
        load = np.zeros(20)
        load[_BOX] = self._box.mass * (np.array([0.0, 0.0, -GRAVITY]) - acceleration)
        load[_TURN] = np.cross(self._box.centre, load[_BOX])
        return self._settle(pads, depth, np.zeros((20, 20)), load)

    def _settle(self, pads: _Pads, depth: float, holding: np.ndarray, load: np.ndarray) -> bool:
        """With what holds the box beside the palms (20, 20), and its load (20,)."""
        holding[range(14), range(14)] = self._stiffness
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
        self._stuck = np.where(pressure[:, None] > 0.0, moved - self._friction / self._stick, moved)
        return True

    def _held_back(self, slip: np.ndarray, limit: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Friction (..., 2) at slips (..., 2) from where points stick, its ratio to them, and whether they slide."""
        size = np.linalg.norm(slip, axis=-1)
        slides = self._stick * size > limit
        ratio = np.where(slides, limit / np.maximum(size, 1e-15), self._stick)
        return ratio[..., None] * slip, ratio, slides

    def _least(self, u, pads: _Pads, depth: float, holding, load, limit) -> np.ndarray | None:
        """Newton's method with backtracking from u; None where the box falls out."""
        into, along = pads
        stick, stuck, flat = self._stick, self._stuck, along.reshape(-1, 20)

        def energy(u) -> float:
            slip = np.linalg.norm(along @ u - stuck, axis=-1)
            friction = np.where(stick * slip <= limit, 0.5 * stick * slip**2, limit * (slip - 0.5 * limit / stick))
            depths = np.maximum(0.0, depth + into @ u)
            return float(0.5 * u @ holding @ u - load @ u + 0.5 * self._normal * (depths**2).sum() + friction.sum())

        value = energy(u)
        for _ in range(60):
            depths = np.maximum(0.0, depth + into @ u)
            slip = along @ u - stuck
            friction, ratio, slides = self._held_back(slip, limit)
            slope = holding @ u - load + flat.T @ friction.ravel() + self._normal * depths @ into
            if np.linalg.norm(slope) < AT_REST_N:
                return u
            touching = into[depths > 0.0]
            weights = ratio[..., None, None] * np.eye(2)
            away = slip / np.maximum(np.linalg.norm(slip, axis=-1, keepdims=True), 1e-15)
            weights -= np.where(slides, ratio, 0.0)[..., None, None] * away[..., :, None] * away[..., None, :]
            curve = holding + self._normal * touching.T @ touching + flat.T @ (weights @ along).reshape(-1, 20)
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
        pressure, friction = self._pressure.reshape(2, -1), self._friction.reshape(2, -1, 2)
        force = pressure.sum(axis=1)
        centre = pressure @ self.pad.at / np.maximum(force, 1e-9)[:, None]
        touching = (pressure > 0.0).mean(axis=1)
        torsion = (self.pad.at[:, 0] * friction[..., 1] - self.pad.at[:, 1] * friction[..., 0]).sum(axis=1)
        effort = -self._stiffness * self._u[:14]
        return force, friction.sum(axis=1), torsion, centre, touching, effort, self._u[_BOX], self._u[_TURN]
