"""Poses of a plant's bodies at many positions at once, as products of arrays."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import Joint, JointIndex

from drake_blfdmp.vectors import cross

WELD, REVOLUTE, PRISMATIC, FLOATING = "weld", "revolute", "prismatic", "quaternion_floating"
"""The joints (Drake's `type_name`) that are known here."""

_FEATURES = 4
"""A joint's X_FM is a sum of constants times 1, sin q, cos q, q; a floating one's is made of its quaternion."""


class _Place(NamedTuple):
    """Where a body hangs: on which moving body (0: the world), how many joints that move away, and X_MB there."""

    moving: int
    level: int
    offset: np.ndarray


class BodyPoses:
    """X_WB of chosen bodies of a finalized plant, for N positions in about the time that Drake takes for a few.

    Bodies that are welded together move as one. Those equally many joints away from the world are placed together.
    Frames stand on their bodies where the plant has them by default, whatever a context says.
    """

    def __init__(self, plant: MultibodyPlant, bodies: Sequence[int]):
        """Of bodies by their indices.

        Raises:
            ValueError: a joint on the way to the world is none of those known here, see `known`.
        """
        self._size = plant.num_positions()
        inboard = _inboard(plant)
        places = {0: _Place(0, 0, np.eye(4))}
        moving: dict[int, tuple[Joint, np.ndarray]] = {}

        def place(body: int) -> _Place:
            if body not in places:
                joint = inboard.get(body)
                if joint is None:
                    raise ValueError(f"body {body} is the child of no joint, or of several")
                parent, X = place(int(joint.parent_body().index())), _coefficients(joint)
                if _kind(joint) == WELD:
                    places[body] = parent._replace(offset=parent.offset @ X[0])
                else:
                    moving[body] = joint, parent.offset @ X
                    places[body] = _Place(body, parent.level + 1, np.eye(4))
            return places[body]

        wanted = [place(int(body)) for body in bodies]
        order = sorted(moving, key=lambda body: places[body].level)
        row = {body: k + 1 for k, body in enumerate(order)} | {0: 0}  # The world stands first.
        joints = [moving[body][0] for body in order]
        turning = [k for k, joint in enumerate(joints) if _kind(joint) != FLOATING]
        self._turning, self._q = turning, [joints[k].position_start() for k in turning]
        self._floating = [
            (k, joint.position_start(), _X_MB(joint)) for k, joint in enumerate(joints) if _kind(joint) == FLOATING
        ]
        coefficients = [moving[body][1] for body in order]
        self._coefficients = np.array(coefficients).reshape(len(order), _FEATURES, 16)
        parents = [row[places[int(joint.parent_body().index())].moving] for joint in joints]
        levels = np.array([places[body].level for body in order], dtype=int)
        self._levels = []
        for level in np.unique(levels):
            first, last = np.searchsorted(levels, level), np.searchsorted(levels, level, side="right")
            self._levels.append((slice(first + 1, last + 1), parents[first:last]))
        self._wanted = [row[one.moving] for one in wanted]
        offsets = np.array([one.offset for one in wanted]).reshape(-1, 1, 4, 4)
        self._offsets = None if (offsets == np.eye(4)).all() else offsets

    @staticmethod
    def known(plant: MultibodyPlant) -> bool:
        """Whether all joints of a finalized plant are known here, and every body hangs on one as its child."""
        kinds = {_kind(joint) for joint in _joints(plant)}
        return kinds <= {WELD, REVOLUTE, PRISMATIC, FLOATING} and len(_inboard(plant)) == plant.num_bodies() - 1

    def evaluate(self, q: np.ndarray) -> np.ndarray:
        """The poses [R p] of the bodies (N, B, 3, 4) at the plant's positions (N, nq)."""
        if q.shape[-1] != self._size:
            raise ValueError(f"{q.shape[-1]} positions of a plant that has {self._size}")
        n, count = len(q), len(self._coefficients)
        features = np.zeros((count, n, _FEATURES))
        features[..., 0] = 1.0
        angles = q[:, self._q].T
        features[self._turning, :, 1:] = np.stack([np.sin(angles), np.cos(angles), angles], axis=-1)
        poses = np.empty((1 + count, n, 4, 4))
        poses[0] = np.eye(4)
        poses[1:] = (features @ self._coefficients).reshape(count, n, 4, 4)
        for k, first, X_MB in self._floating:
            poses[1 + k] = poses[1 + k] @ _floating(q[:, first : first + 7]) @ X_MB
        for some, parents in self._levels:
            poses[some] = poses[parents] @ poses[some]
        found = poses[self._wanted]
        if self._offsets is not None:
            found = found @ self._offsets
        return found[:, :, :3].swapaxes(0, 1)


def _joints(plant: MultibodyPlant) -> list[Joint]:
    return [plant.get_joint(JointIndex(index)) for index in map(int, plant.GetJointIndices())]


def _inboard(plant: MultibodyPlant) -> dict[int, Joint]:
    """Body -> the one joint whose child it is."""
    joints = _joints(plant)
    children = [int(joint.child_body().index()) for joint in joints]
    return {body: joint for body, joint in zip(children, joints, strict=True) if body and children.count(body) == 1}


def _kind(joint: Any) -> str:
    return str(joint.type_name())


def _coefficients(joint: Any) -> np.ndarray:
    """(4, 4, 4) of X_PB by 1, sin q, cos q, q; of a floating joint's X_PF alone.

    Raises:
        ValueError: it is none of the known joints.
    """
    kind = _kind(joint)
    X_PF = joint.frame_on_parent().GetFixedPoseInBodyFrame().GetAsMatrix4()
    X_FM = np.zeros((_FEATURES, 4, 4))
    X_FM[0, 3, 3] = 1.0
    if kind == WELD:
        X_FM[0] = joint.X_FM().GetAsMatrix4()
    elif kind == REVOLUTE:
        # Rodrigues: a a^T + sin q [a] + cos q (1 - a a^T).
        axis = np.asarray(joint.revolute_axis())
        along = np.outer(axis, axis)
        X_FM[0, :3, :3], X_FM[2, :3, :3] = along, np.eye(3) - along
        X_FM[1, :3, :3] = np.cross(np.eye(3), axis)  # Of an antisymmetric matrix, row by row.
    elif kind == PRISMATIC:
        X_FM[0, :3, :3] = np.eye(3)
        X_FM[3, :3, 3] = joint.translation_axis()
    elif kind == FLOATING:
        X_FM[0] = np.eye(4)
        return X_PF @ X_FM
    else:
        raise ValueError(f"joint {joint.name()}: {kind} is not known here")
    return X_PF @ X_FM @ _X_MB(joint)


def _X_MB(joint: Any) -> np.ndarray:
    return joint.frame_on_child().GetFixedPoseInBodyFrame().inverse().GetAsMatrix4()


def _floating(q: np.ndarray) -> np.ndarray:
    """X_FM (N, 4, 4) of quaternions, of any length, and positions (N, 7): w x y z, x y z."""
    w, v = q[:, :1, None], q[:, 1:4]
    # The columns of the antisymmetric matrix [v] are v x e_i; R = 1 + 2 (w [v] + [v]^2) of a unit quaternion.
    skew, square = cross(v[:, None], np.eye(3)).swapaxes(1, 2), (q[:, :4] ** 2).sum(axis=1)[:, None, None]
    poses = np.zeros((len(q), 4, 4))
    poses[:, :3, :3] = np.eye(3) + 2.0 * (w * skew + skew @ skew) / square
    poses[:, :3, 3] = q[:, 4:]
    poses[:, 3, 3] = 1.0
    return poses
