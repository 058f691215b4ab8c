"""The squeeze of a box that rules of thumb would refuse, by what palms and motors really bear along the way."""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from pydrake.multibody.plant import MultibodyPlant

from drake_blfdmp.robot.box import BoxParameters
from drake_blfdmp.robot.grasp_force import PALM_FRICTION, combined_friction, gravity_torque, least_squeeze
from drake_blfdmp.robot.held_box import CarryQuasiStatically, HeldBox
from drake_blfdmp.robot.plant import ARMS, ArmActuators

POSTURES = 25
"""So many of the held postures are looked at, evenly along the way."""

CANDIDATES = 25
"""So many forces are, evenly in their logarithm, from the friction cone's estimate to the limit."""

HARDER_TRIED = 9
"""So many are between a squeeze that a worse box may slip in and the most that is wanted."""

EFFORT = 0.9
"""Share of its limit that a motor may need; what comes on top is the motion's."""

HARDER = 2.0 / 3.0
"""How far from the least to the greatest squeeze that holds a box the one is that is taken, in their logarithm."""

DOUBT = 0.05
"""A box so much lighter and rougher is held where the prediction may be wrong about one that slips: the least force
that carries was seen to be 8 % less than predicted (docs/contact.md)."""

DOUBTFUL_EFFORT = 1.0
"""`EFFORT` where the prediction may be wrong about a motor."""

PRESSES_MORE = 1.1
"""A palm that moves may press by this factor more than in equilibrium."""

TURNS = np.deg2rad(2.0)
"""How far the box may tilt in the palms."""


@dataclass(frozen=True)
class Way:
    """How a box is carried.

    Attributes:
        plant: both arms.
        postures: (N, 14) commanded while it is held, rad.
        depth: by which the palms were to be deep in the box when these were found, m; what they are deeper or less deep
            stays with other depths.
        below: how far the box's centre is below the palms' middle, m.
        acceleration: its largest, m/s^2; taken as upward all along.
        compliances: (N,) of both palms together, m/N, where a loop is closed around their force (`HandsObserver`): it
            makes them the deeper the more they yield, and the force even. None where nothing does.
    """

    plant: MultibodyPlant
    postures: np.ndarray
    depth: float
    below: float
    acceleration: float
    compliances: np.ndarray | None = None


class Problem(NamedTuple):
    """What keeps a squeeze from holding a box, in a few words, and whether a harder squeeze may help."""

    what: str
    more_helps: bool


class HeldSqueeze:
    """What becomes of a box on its way when it is squeezed."""

    def __init__(self, way: Way, box: BoxParameters, force_limit: float):
        """With a largest force of a palm, N."""
        few = np.unique(np.linspace(0, len(way.postures) - 1, POSTURES).round().astype(int))
        self._way, self._box, self._limit = way, box, force_limit
        self._postures = way.postures[few]
        self._efforts, self._bears, apart = Motors(way.plant, self._postures)
        self._deeper = 0.5 * (box.width - apart) - way.depth
        self._share = np.ones(len(few))  # Of the depth, in each posture.
        if way.compliances is not None:
            self._share = way.compliances[few] * np.mean(1.0 / way.compliances)

    def problem(
        self, depth: float, *, worse: float = 0.0, effort: float = EFFORT, at_best: bool = False
    ) -> Problem | None:
        """What keeps a squeeze with palms so deep, m, from holding the box; None where nothing does.

        How the box comes to lie between palms that close, and yield unlike each other, depends on its table: one that
        holds it and one that lets it slide are both looked at.

        Args:
            worse: share by which the box is heavier and smoother than believed.
            effort: share of its limit that a motor may need.
            at_best: it is enough where one of the two does not keep it.
        """
        found = None
        for slides in (False, True):
            problem = self._problem(depth, worse, effort, slides)
            if (problem is None) == at_best:
                return problem
            found = found or problem
        return found

    def _problem(self, depth: float, worse: float, effort: float, slides: bool) -> Problem | None:
        box = replace(self._box, mass=(1.0 + worse) * self._box.mass, friction=(1.0 - worse) * self._box.friction)
        friction = float(combined_friction(box.friction, PALM_FRICTION))
        held = HeldBox(box.width, box.mass, friction, np.array([0.0, 0.0, -self._way.below]))
        upward = np.tile([0.0, 0.0, self._way.acceleration], (len(self._postures), 1))
        depths = depth * self._share + self._deeper
        hold = CarryQuasiStatically(self._way.plant, self._postures, depths, held, upward, slides=slides)
        if hold.lost:
            return Problem("it slips", more_helps=True)
        if (turned := float(np.linalg.norm(hold.turned[:, :2], axis=1).max())) > TURNS:
            return Problem(f"it tilts by {np.rad2deg(turned):.0f} degrees", more_helps=True)
        if (force := PRESSES_MORE * float(hold.force.max())) > self._limit:
            return Problem(f"a palm may press with {force:.0f} N", more_helps=False)
        # The simulated arms have no weight; a real one's motors bear it as well.
        needed = np.maximum(np.abs(hold.effort), np.abs(hold.effort + self._bears)) / self._efforts
        if (share := float(needed.max())) > effort:
            return Problem(f"a motor needs {100.0 * share:.0f} % of what it can", more_helps=False)
        return None

    def find(self, force_per_depth: float, worse: float) -> tuple[float | None, str]:
        """The depth, m, that holds the box, and in words what is not sure about it; or None, and why there is none.

        The least that holds a box that is heavier and smoother by the share `worse`, too; else of those that hold this
        one one well away from slipping, and not the greatest (`HARDER`); else one between too little and too much that
        may hold it, if the prediction is a little wrong.

        Args:
            force_per_depth: mean force over the depth, N/m.
        """
        friction = combined_friction(self._box.friction, PALM_FRICTION)
        least = float(least_squeeze(self._box.mass, friction, self._way.acceleration, factor=1.0))
        depths = np.geomspace(min(least, self._limit), self._limit, CANDIDATES) / force_per_depth
        depth, _ = self._halve(depths, worse=worse)
        if depth is not None and self.problem(depth) is None:
            return depth, ""
        depth, told = self._halve(depths, greatest=True)
        why = ", ".join(f"with {depth * force_per_depth:.3g} N {what}" for depth, what in told)
        if depth is not None:
            between = float(depth * ((self._halve(depths)[0] or depth) / depth) ** (1.0 - HARDER))
            depth = between if self.problem(between) is None else depth
            return depth, f"one {worse:.0%} heavier and smoother is not, and much more is too much for palms or motors"
        for depth, _ in reversed(told):  # What is too much for a motor rather than what slips.
            if self.problem(depth, worse=-DOUBT, effort=DOUBTFUL_EFFORT, at_best=True) is None:
                return depth, f"though barely, and it may fail: {why}"
        return None, why

    def harder(self, depth: float, deepest: float, worse: float) -> float:
        """The least depth from one to another, m, that holds a box that is heavier and smoother by the share `worse`.

        Where none does, the greatest that palms and motors bear with this one; the first where that is too much.
        """
        if self.problem(depth, worse=worse) is None:
            return depth
        depths = np.linspace(depth, deepest, HARDER_TRIED)
        held, _ = self._halve(depths, worse=worse)
        if held is None or self.problem(held) is not None:
            held, _ = self._halve(depths, greatest=True)
        return depth if held is None else held

    def _halve(self, depths, *, greatest: bool = False, **options) -> tuple[float | None, list[tuple[float, str]]]:
        """The least or the greatest of growing depths without a problem, found by halving; and the nearest with one.

        What is too little for one depth is so for those below it, what is too much for those above.
        """
        fits, little, much = None, [], []
        low, high = 0, len(depths)
        while low < high:
            k = (low + high) // 2
            depth = float(depths[k])
            problem = self.problem(depth, **options)
            if problem is None:
                fits = depth
            elif problem.more_helps:
                little = [(depth, problem.what)]
            else:
                much = [(depth, problem.what)]
            more = greatest if problem is None else problem.more_helps
            low, high = (k + 1, high) if more else (low, k)
        return fits, little + much


def Motors(plant: MultibodyPlant, postures: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The motors' limits (14,), what of the arms they bear in postures (N, 14), N m; the palms' distance (N,), m."""
    context = plant.CreateDefaultContext()
    arms = [plant.GetModelInstanceByName(arm) for arm in ARMS]
    palms = [plant.GetFrameByName("palm", arm) for arm in arms]
    limits = np.array([actuator.effort_limit() for arm in arms for actuator in ArmActuators(plant, arm)])
    bears, places = np.empty(postures.shape), np.empty((len(postures), 2, 3))
    for k, q in enumerate(postures):
        plant.SetPositions(context, q)
        bears[k] = -np.concatenate([gravity_torque(plant, context, arm) for arm in arms])
        places[k] = [palm.CalcPoseInWorld(context).translation() for palm in palms]
    return limits, bears, np.linalg.norm(places[:, 1] - places[:, 0], axis=1)
