"""A carry whose elbows are led around each other: taught, so that all that follows sees a person who moves so."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from drake_blfdmp.errors import TaskError
from drake_blfdmp.planning.carry import Carry, CarryPlanner
from drake_blfdmp.planning.planned import BelowPalms, IndexAt
from drake_blfdmp.robot.elbow_paths import Scene
from drake_blfdmp.robot.kinematics import DualArmKinematics
from drake_blfdmp.robot.led_reach import reach_of_led
from drake_blfdmp.robot.plant import JOINTS_PER_ARM, JointLimits
from drake_blfdmp.robot.posture import ROLL_JOINT
from drake_blfdmp.robot.retargeting import Retarget, box_pose

ROOM = 0.02
"""What the arms' links keep clear of tables and box, m."""

TRIALS = 4
"""How often elbows are taught: the skill follows what it is taught not quite."""


def SceneOf(planner: CarryPlanner, carry: Carry, rest_s: float) -> Callable[[Retarget, np.ndarray], Scene]:
    """What stands around a carry in the place of a retargeting, at samples counted from when the arms join in, s."""

    def scene(retarget: Retarget, samples: np.ndarray) -> Scene:
        task, coupled, in_palms = carry.task, carry.coupled, planner.in_palms(retarget)
        _, tables = in_palms.standing(task, coupled)
        first, (grasp, release) = IndexAt(coupled, rest_s), (IndexAt(coupled, t) for t in task.held)
        held = np.clip(samples + first, grasp, release)
        poses = box_pose(coupled.x[held], retarget, None if coupled.turn is None else coupled.turn[held])
        return Scene(tables, in_palms.box, BelowPalms(poses, in_palms.grasp_above), ROOM)

    return scene


def TeachElbows(
    planner: CarryPlanner, carry: Carry, rest_s: float, kinematics: DualArmKinematics, limits: JointLimits
) -> Carry:
    """The carry with the swings of its reach taught; as it is where it has none.

    Args:
        planner: of the carry.
        carry: with the reach of its rollout.
        rest_s: when the arms join in, s.
        kinematics: of both arms.
        limits: of their joints.

    Raises:
        TaskError: the arms do not get along what was learned.
    """
    before = carry.reach
    if before.swings is None:
        return carry
    at = int(np.argmin(np.abs(carry.coupled.t[before.samples] - carry.task.held[0])))
    grasp = before.following.q[at].copy()
    grasp[[ROLL_JOINT, ROLL_JOINT + JOINTS_PER_ARM]] = 0.0
    turned = before.swings.farthest(carry.motion.t, carry.motion.x)
    wanted, taught = before.swings, before.swings
    for _ in range(TRIALS):
        carry = planner.taught(carry, replace(carry.motion, x=taught.of(carry.motion.t, carry.motion.x)))
        taught = taught.corrected(wanted, carry.coupled.t, carry.coupled.x)
    coupled, first = carry.coupled, IndexAt(carry.coupled, rest_s)
    anchor = IndexAt(coupled, carry.task.held[0]) - first
    t, x = coupled.t[first:], coupled.x[first:]
    turn = None if coupled.turn is None else coupled.turn[first:]
    reach = reach_of_led(t, x, anchor, before.retarget, grasp, kinematics, limits, turn)
    if reach is None:
        raise TaskError(
            "reach: the arms do not get along with elbows led around each other; use a smaller box or move it less",
            reason="reach",
        )
    return replace(carry, reach=replace(reach, samples=reach.samples + first, swings=before.swings)).noted(
        f"elbows led around each other, by up to {np.rad2deg(turned):.0f} degrees from the person's, and the hands' "
        f"yaw limited to {np.rad2deg(before.retarget.yaw[1]):.0f} degrees: with the person's the arms do not get along"
    )
