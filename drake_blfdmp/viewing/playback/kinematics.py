"""Where a robot's links are: as /tf says, and by forward kinematics from joint positions where it says nothing."""

from collections.abc import Mapping

import numpy as np

from drake_blfdmp.errors import BlfDmpError
from drake_blfdmp.viewing.playback.frames import FrameTree
from drake_blfdmp.viewing.playback.poses import about, translation
from drake_blfdmp.viewing.playback.urdf import Joint, Robot


def joint_position(joint: Joint, robot: Robot, positions: Mapping[str, np.ndarray]) -> np.ndarray | None:
    """Positions (F,), rad or m, of a joint, of one that mimics another too; None where they are not known."""
    if joint.mimic is None or joint.name in positions:
        return positions.get(joint.name)
    other, multiplier, offset = joint.mimic
    return multiplier * positions[other] + offset if other in positions else None


def joint_motion(joint: Joint, position) -> np.ndarray:
    """X_JM (F, 4, 4): what positions (F,), rad or m, make of a movable joint's frame."""
    if joint.kind == "prismatic":
        return translation(np.asarray(position)[..., None] * joint.axis)
    return about(joint.axis, position)


def link_poses(robot: Robot, frames: FrameTree, positions: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """X_WL of every link: (F, 4, 4), or (1, 4, 4) of a link that does not move.

    A link whose frame is in `frames` is where that says. Others hang at their parent link by their joint: at the
    joint's position where that is known, at 0 where not. A root link without a frame is at the origin of the frames.

    Args:
        robot: the description.
        frames: from /tf and /tf_static.
        positions: joint -> (F,), rad or m.

    Raises:
        BlfDmpError: links or frames form a ring.
    """
    poses: dict[str, np.ndarray] = {}

    def known(link: str) -> np.ndarray | None:
        if link in poses:
            return poses[link]
        if link in frames or link not in robot.joints:
            return frames.pose(link)
        return None

    for name in robot.links:
        chain = [name]
        while (X := known(chain[-1])) is None:
            parent = robot.joints[chain[-1]].parent
            if parent in chain:
                raise BlfDmpError(f"{frames.where}: the links of the URDF form a ring at {parent}; repair the URDF")
            chain.append(parent)
        poses[chain[-1]] = X
        for child in reversed(chain[:-1]):
            joint = robot.joints[child]
            X = X @ joint.X_PJ
            position = joint_position(joint, robot, positions) if joint.movable else None
            if position is not None:
                X = X @ joint_motion(joint, position)
            poses[child] = X
    return poses
