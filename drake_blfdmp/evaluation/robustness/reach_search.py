"""Whether any place and scale lets two arms carry a box along its way: a search that has nothing of the planner's.

Drake's InverseKinematics from many starts, over a grid of places and over scales. Only what every plan must do is
asked: both palms flat on the box's sides at samples of the way, and at both ends as far apart as they open. The palms'
rolls are free at every sample, no margin from limits is asked, elbows are where they like, bodies may overlap, and no
posture need lead to the next. So where this search finds nothing, no plan follows the way. Where it finds something,
`joined_postures` tells whether the arms get from one posture to the next.
"""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import product

import numpy as np
from pydrake.multibody.inverse_kinematics import InverseKinematics
from pydrake.solvers import SnoptSolver

from drake_blfdmp.robot.plant import ARMS, HOME, JOINTS_PER_ARM, MakeKinematicPlant, ReadJointLimits

REGION = (np.array([-0.36, 0.12, 0.12]), np.array([0.36, 0.90, 1.50]))
"""Corners of where the hands' middle is looked for at the grasp, m in W."""
MIDDLE = np.array([0.0, 0.47, 0.72])
"""Where the search begins, m in W."""
SPACING = 0.06
SCALES = tuple(float(scale) for scale in np.round(np.arange(0.3, 1.01, 0.1), 2))
"""Those of the planner's range."""
STARTS = 10
POSITION_TOLERANCE, ANGLE_TOLERANCE = 2e-3, 0.02
"""M and rad; as far as that a palm may be off."""


@dataclass(frozen=True)
class Way:
    """What is asked at K samples, from the grasp to the release.

    Attributes:
        apart: K tuples of the palms' distances, m: closed, and at the ends open as well.
        yaw: (K,) of the line between the palms, left to right, rad.
        way: (K, 3) the middle of the hands, seen from the grasp, of the person's size, m.
        share: (K,) of the shift that is done there, from 0 to 1.
        shift: (3,) what the release is moved by in W, in addition, and the grasp is not, m.
        level: both ends are at one height.
    """

    apart: tuple[tuple[float, ...], ...]
    yaw: np.ndarray
    way: np.ndarray
    share: np.ndarray
    shift: np.ndarray
    level: bool

    def middles(self, grasp, scale: float) -> np.ndarray:
        """The hands' middle (K, 3), of that at the grasp, m in W."""
        shift = np.array(self.shift, dtype=float)
        if self.level:
            shift[2] = -scale * self.way[-1, 2]
        return np.asarray(grasp) + scale * self.way + self.share[:, None] * shift


class ReachSearch:
    """Inverse kinematics of two palms that face each other."""

    def __init__(self, seed: int = 0, starts: int = STARTS):
        """Starts are drawn from a seed."""
        self._plant = MakeKinematicPlant()
        self._arms = [self._plant.GetModelInstanceByName(name) for name in ARMS]
        limits = ReadJointLimits(self._plant, self._arms)
        self._lower, self._upper = limits.lower, limits.upper
        self._solver = SnoptSolver()
        rng = np.random.default_rng(seed)
        random = rng.uniform(limits.lower, limits.upper, (starts - 1, 2 * JOINTS_PER_ARM))
        self._starts = np.vstack([np.tile(HOME, 2), random])
        self._shoulders, self._reach = self._extent()

    def _extent(self) -> tuple[np.ndarray, float]:
        """The shoulders' positions (2, 3), m, and a distance from one that no palm can pass, m."""
        plant, context = self._plant, self._plant.CreateDefaultContext()
        shoulders = [plant.GetFrameByName("shoulder", arm).CalcPoseInWorld(context).translation() for arm in self._arms]
        straight = np.zeros(14)
        straight[[3, 10]] = self._upper[[3, 10]]
        plant.SetPositions(context, straight)
        wrist, palm = (
            np.asarray(plant.GetFrameByName(name, self._arms[0]).CalcPoseInWorld(context).translation())
            for name in ("wrist", "palm")
        )
        reach = np.linalg.norm(wrist - shoulders[0]) + np.linalg.norm(palm - wrist)
        return np.array(shoulders), float(reach)

    def facing(self, middle, apart: float, yaw: float) -> np.ndarray | None:
        """A posture (14,) whose palms face each other about a point, m in W, or None where none was found."""
        normal = np.array([np.cos(yaw), np.sin(yaw), 0.0])
        palms = [np.asarray(middle) + sign * 0.5 * apart * normal for sign in (-1.0, 1.0)]
        if any(np.linalg.norm(p - s) > self._reach for p, s in zip(palms, self._shoulders, strict=True)):
            return None
        q = np.tile(HOME, 2).astype(float)
        for arm, (palm, outward) in enumerate(zip(palms, (normal, -normal), strict=True)):
            found = self._one_arm(arm, palm, outward)
            if found is None:
                return None
            q[arm * JOINTS_PER_ARM : (arm + 1) * JOINTS_PER_ARM] = found
        return q

    def _one_arm(self, arm: int, palm: np.ndarray, normal: np.ndarray) -> np.ndarray | None:
        ik = InverseKinematics(self._plant, True)
        world, frame = self._plant.world_frame(), self._plant.GetFrameByName("palm", self._arms[arm])
        ik.AddPositionConstraint(
            frameB=frame,
            p_BQ=np.zeros(3),
            frameA=world,
            p_AQ_lower=palm - POSITION_TOLERANCE,
            p_AQ_upper=palm + POSITION_TOLERANCE,
        )
        ik.AddAngleBetweenVectorsConstraint(world, normal, frame, np.array([0.0, 0.0, 1.0]), 0.0, ANGLE_TOLERANCE)
        own = slice(arm * JOINTS_PER_ARM, (arm + 1) * JOINTS_PER_ARM)
        program = ik.get_mutable_prog()
        other = np.delete(ik.q(), np.r_[own])
        program.AddBoundingBoxConstraint(np.array(HOME), np.array(HOME), other)
        for start in self._starts:
            guess = np.tile(HOME, 2).astype(float)
            guess[own] = start[own]
            result = self._solver.Solve(program, guess, None)
            if result.is_success():
                return np.asarray(result.GetSolution(ik.q()))[own]
        return None

    def search(
        self,
        way: Way,
        spacing: float = SPACING,
        most: int = 1,
        joined: Callable[[np.ndarray, float], bool] = lambda place, scale: True,
    ) -> tuple[list[tuple[np.ndarray, float]], int, int]:
        """Places of the hands' middle at the grasp, m in W, with scales, at which every sample has its postures.

        Args:
            way: what is asked.
            spacing: of the grid of places, m.
            most: how many are enough.
            joined: whether the arms get from posture to posture at a place and a scale; asked where there are some.

        Returns:
            Those found; how many pairs of a place and a scale were looked at; and how many had postures.
        """
        found, tried, had = [], 0, 0
        axes = [np.arange(low, high + 1e-9, spacing) for low, high in zip(*REGION, strict=True)]
        # From the middle outwards: what is easy is found soon.
        places = sorted((np.array(place) for place in product(*axes)), key=lambda p: np.linalg.norm(p - MIDDLE))
        order = [0, *range(len(way.share) - 1, 0, -1)]  # What failed last is asked first, after the grasp.
        for place in places:
            tried += len(SCALES)
            if not self._sample(way, 0, place):
                continue
            for scale in reversed(SCALES):
                middles = way.middles(place, scale)
                failed = next((k for k in order[1:] if not self._sample(way, k, middles[k])), None)
                if failed is not None:
                    order.remove(failed)
                    order.insert(1, failed)
                    continue
                had += 1
                if joined(place, scale):
                    found.append((place, scale))
                    break
            if len(found) >= most:
                break
        return found, tried, had

    def _sample(self, way: Way, k: int, middle: np.ndarray) -> bool:
        return all(self.facing(middle, apart, float(way.yaw[k])) is not None for apart in way.apart[k])
