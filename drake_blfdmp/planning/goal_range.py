"""How far, and when, the goal of a plan may be moved while it is carried out."""

import itertools

import numpy as np

from drake_blfdmp.planning.box_path import lacking_room
from drake_blfdmp.planning.plan import CLEARANCE
from drake_blfdmp.planning.planned import IndexAt, Plan
from drake_blfdmp.robot.box import BoxParameters
from drake_blfdmp.robot.clearance import ClearanceChecker
from drake_blfdmp.robot.following import Following, follow_all
from drake_blfdmp.robot.kinematics import DualArmKinematics
from drake_blfdmp.robot.plant import ARMS, MakeKinematicPlant, ReadJointLimits
from drake_blfdmp.robot.reach_evaluation import JOINT_MARGIN, POSE_TOLERANCE
from drake_blfdmp.robot.retargeting import retarget_motion
from drake_blfdmp.robot.rigid import rigid

GOAL_STEP = 0.005
"""The goal is moved by multiples of it, m."""

FARTHEST = 0.15
"""The goal is never moved farther along an axis, m."""

ABOVE = 0.03
"""The goal moves while the box is at least so far, m, above where it stands: it drags along no table."""

SETTLING = 5.0
"""Time constants in which what the goal did last comes to rest: 4 % are left of its lag."""

ON_TABLE = 0.04
"""How far the box's middle stays from its table's edge, m."""

_WAY = 4
"""Samples on the way from the planned place to another one."""


def GoalWindow(plan: Plan) -> tuple[float, float] | None:
    """When the goal may move, on the skill's clock, s; None where there is no time for it.

    Before the box is up, the hands must be where it stands; and when it comes down again, they must be at rest over
    the ground. A motion without a box has no such times.
    """
    skill = plan.task.skill
    if plan.box is None or plan.start is None or plan.goal is None:
        return plan.settle_s, float(skill.tau)
    height = plan.planned_box()[:, 6] - max(plan.start[6], plan.goal[6])
    above = plan.coupled.t[np.flatnonzero(height > ABOVE)]
    settling = SETTLING * 2.0 * skill.tau / skill.alpha_z
    if len(above) == 0 or above[-1] - settling <= above[0]:
        return None
    return float(above[0]), float(above[-1] - settling)


def GoalRange(plan: Plan) -> np.ndarray:
    """How far the goal may be moved: rows (lowest, highest), m along W's axes, multiples of `GOAL_STEP`.

    With a box two rows, x and y: its table stays where it is, and so the height. All of the rectangle keeps the box on
    its table, in the arms' reach and clear of the tables. Without a box three rows; what is out of reach then, the
    inverse kinematics leaves out.
    """
    if plan.box is None or plan.goal is None:
        return FARTHEST * np.array([[-1.0, 1.0]] * 3)
    table = plan.tables[-1]
    middle, half = np.array(table.top_center[:2]), 0.5 * np.array(table.size) - ON_TABLE
    edges = np.stack([middle - half, middle + half], axis=1) - plan.goal[4:6, None]
    edges = np.clip(edges, [[-FARTHEST, 0.0]] * 2, [[0.0, FARTHEST]] * 2)
    steps = np.trunc(np.round(edges / GOAL_STEP, 6)).astype(int)
    fits = _Fit(plan, plan.box, plan.goal)
    corners = [np.array(signs) for signs in itertools.product((-1, 0, 1), repeat=2) if any(signs)]
    while steps.any():
        points = [np.where(signs < 0, steps[:, 0], np.where(signs > 0, steps[:, 1], 0)) for signs in corners]
        failed = np.flatnonzero(~fits(GOAL_STEP * np.array(points)))
        if len(failed) == 0:
            break
        smaller = np.zeros((2, 2), dtype=int)
        for k in failed:
            for axis in np.flatnonzero(corners[k]):
                smaller[axis, (corners[k][axis] + 1) // 2] = 1
        steps -= np.sign(steps) * smaller
    return GOAL_STEP * steps


class _Fit:
    """Whether a box can be put down somewhere else than planned."""

    def __init__(self, plan: Plan, box: BoxParameters, goal: np.ndarray):
        plant = MakeKinematicPlant()
        self._box, self._tables, self._start, self._goal = box, plan.tables, plan.start, np.asarray(goal)
        self._kinematics = DualArmKinematics(plant)
        self._limits = ReadJointLimits(plant, [plant.GetModelInstanceByName(arm) for arm in ARMS])
        self._checker = ClearanceChecker(plan.tables, box, max_distance=0.05)
        # Held where it is put down, and opened at the end; the posture nearest to either is known.
        times = np.minimum((plan.reach.samples * plan.stretch).astype(int), len(plan.coupled.t) - 1)
        index = [IndexAt(plan.coupled, plan.task.held[1]), len(plan.coupled.t) - 1]
        self._q = plan.reach.following.q[[int(np.argmin(np.abs(times - k))) for k in index]]
        turn = None if plan.coupled.turn is None else plan.coupled.turn[index]
        x = plan.coupled.x[index]
        pose, _, swivel, _ = retarget_motion(x, np.zeros_like(x), plan.retarget, turn=turn)
        self._pose, self._swivel = pose, swivel
        start = 0.0 if (window := GoalWindow(plan)) is None else window[1]
        coming = (plan.coupled.t >= start) & (plan.coupled.t <= plan.task.held[1])
        self._coming = plan.planned_box()[coming]
        # Where the planned place itself is nearer to something, that is near enough.
        self._least = np.minimum(CLEARANCE, self._clearances(np.zeros((1, 2)), self._followed(np.zeros((1, 2)))))

    def _followed(self, offsets) -> list[Following]:
        """The arms' ways (2 K), first to every held posture and then to every opened one."""
        share = np.linspace(1.0 / _WAY, 1.0, _WAY)
        count = len(offsets)
        pose = np.tile(self._pose[:, None, None], (1, count, _WAY, 1, 1))
        pose[..., 4:6] += (share[:, None] * offsets[:, None])[None, :, :, None]
        swivel = np.broadcast_to(self._swivel[:, None, None], (2, count, _WAY, 2))
        q = np.repeat(self._q, count, axis=0)
        flat = pose.reshape(2 * count, _WAY, 2, 7), swivel.reshape(2 * count, _WAY, 2)
        return follow_all(self._kinematics, self._limits, q, *flat)

    def _clearances(self, offsets, ways: list[Following]) -> np.ndarray:
        """Of the held and of the opened posture at every offset: (K, 2), m."""
        found = np.empty((len(offsets), 2))
        for k, offset in enumerate(offsets):
            place = rigid(self._goal + np.concatenate([np.zeros(4), offset, [0.0]]))
            for opened in range(2):
                found[k, opened] = self._checker.min_clearance(ways[k + opened * len(offsets)].q[-1], place)[0]
        return found

    def __call__(self, offsets) -> np.ndarray:
        """Whether the box can be put down at each of the offsets (K, 2), m, from the planned goal: (K,)."""
        ways = self._followed(offsets)
        reached = [way.pose_error <= POSE_TOLERANCE and way.joint_margin >= JOINT_MARGIN for way in ways]
        clear = (self._clearances(offsets, ways) >= self._least - 1e-6).all(axis=1)
        roomy = np.empty(len(offsets), dtype=bool)
        for k, offset in enumerate(offsets):
            moved, ends = self._coming.copy(), np.array([self._start, self._goal])
            moved[:, 4:6] += offset
            ends[1, 4:6] += offset
            roomy[k] = lacking_room(moved, self._box, self._tables, ends).max() <= 0.0
        return np.reshape(reached, (2, -1)).all(axis=0) & clear & roomy
