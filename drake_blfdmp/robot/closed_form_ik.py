"""All postures of an arm whose palm is at a place and faces a way, in closed form.

A palm that only has to be somewhere and face some way leaves an arm one freedom. The palm's normal is the axis of joint
7, so the roll of the palm is that joint's alone; what is left is where the wrist is on a circle about that axis. For
each angle on the circle the other six joints have up to eight solutions, for the wrist is where axes 5 and 6 meet and
the shoulder where axes 1 to 3 do: their distance gives joint 4, the forearm's angle to their line joint 6. See Y. He
and S. Liu, "Analytical inverse kinematics for Franka Emika Panda", ICCMA 2021; here the circle is the parameter, not
joint 7.
"""

import numpy as np
from pydrake.multibody.plant import MultibodyPlant

from drake_blfdmp.robot.plant import ARMS, JOINTS_PER_ARM, JointLimits, ReadJointLimits
from drake_blfdmp.vectors import cross, dot

BRANCHES = 8
"""Solutions for an angle: two each of joint 4, joint 6 and joints 1 to 3."""

_SIGNS = np.array([[one, two, three] for one in (1.0, -1.0) for two in (1.0, -1.0) for three in (1.0, -1.0)])


class ClosedFormIk:
    """The postures of both arms, of lengths read from a plant.

    Attributes:
        lower, upper: (2, 7) limits of the joints, rad.
    """

    def __init__(self, plant: MultibodyPlant, limits: JointLimits | None = None):
        """Of a finalized plant with both arms, their bases welded to the world; None takes the plant's own limits."""
        context = plant.CreateDefaultContext()
        plant.SetPositions(context, np.zeros(plant.num_positions()))
        instances = [plant.GetModelInstanceByName(arm) for arm in ARMS]
        limits = limits or ReadJointLimits(plant, instances)
        self.lower, self.upper = (array.reshape(2, JOINTS_PER_ARM) for array in (limits.lower, limits.upper))
        self._bases, self._shoulders = np.empty((2, 3, 3)), np.empty((2, 3))
        for arm, instance in enumerate(instances):
            X_W0 = plant.GetFrameByName("panda_link0", instance).CalcPoseInWorld(context)
            self._bases[arm] = X_W0.rotation().matrix()
            self._shoulders[arm] = plant.GetFrameByName("shoulder", instance).CalcPoseInWorld(context).translation()
            # Where each frame is at zero angles, seen from the shoulder: both arms have the same lengths.
            names = ("panda_link4", "panda_link6", "panda_link7", "palm")
            poses = [X_W0.InvertAndCompose(plant.GetFrameByName(n, instance).CalcPoseInWorld(context)) for n in names]
            elbow, wrist, hand, palm = (pose.translation() for pose in poses)
            self._elbow_aside = elbow[0]
            self._upper = elbow[2] - (X_W0.inverse() @ self._shoulders[arm])[2]
            self._fore = wrist[2] - elbow[2]
            self._hand_aside = hand[0] - wrist[0]
            self._hand = hand[2] - palm[2]

    def postures(self, arm: int, palm, normal, angles) -> np.ndarray:
        """Joints for each angle and branch, joint 7 at 0, whether within limits or not.

        Args:
            arm: 0 for the left one, 1 for the right one.
            palm: (..., 3) p_WP, m.
            normal: (..., 3) unit vectors that the palm faces, in W.
            angles: (F,) of the wrist on its circle, rad.

        Returns:
            (..., F, 8, 7) rad, whole turns counted from the lower limits; NaN where there is no solution.
        """
        n = (np.asarray(normal) @ self._bases[arm])[..., None, None, :]
        centre = ((np.asarray(palm) - self._shoulders[arm]) @ self._bases[arm])[..., None, None, :] - self._hand * n
        away = np.where(np.abs(n[..., 2:]) < 0.9, [0.0, 0.0, 1.0], [1.0, 0.0, 0.0])
        one = cross(away, n)
        one = one / np.sqrt(dot(one, one))[..., None]
        angle = np.asarray(angles)[:, None, None]
        x6 = np.cos(angle) * one + np.sin(angle) * cross(n, one)
        wrist = centre - self._hand_aside * x6
        straight, other, flip = _SIGNS.T
        with np.errstate(invalid="ignore", divide="ignore"):
            q4 = self._joint4(wrist, straight)
            forward, aside = self._forearm(q4)
            q6, u = _joint6(wrist, n, x6, forward, other)
            x4 = (wrist - forward[..., None] * u) / aside[..., None]
            z4 = cross(x4, u)
            cosine, sine = np.cos(q4)[..., None], np.sin(q4)[..., None]
            x3, z3 = cosine * x4 - sine * u, sine * x4 + cosine * u
            q1, q2, q3 = _shoulder_joints(x3, z3, flip)
            x5 = np.cos(q6)[..., None] * x6 + np.sin(q6)[..., None] * n
            q5 = np.arctan2(-dot(x5, z4), dot(x5, x4))
        q = np.stack(np.broadcast_arrays(q1, q2, q3, q4, q5, q6, np.zeros_like(q1)), axis=-1)
        q[np.isnan(q).any(axis=-1)] = np.nan
        return self.lower[arm] + (q - self.lower[arm]) % (2.0 * np.pi)

    def may_reach(self, arm: int, palm, normal) -> np.ndarray:
        """Whether the wrist of such palms (..., 3) comes near enough to the shoulder; if not, there is no posture."""
        n = np.asarray(normal)
        centre = np.asarray(palm) - self._shoulders[arm] - self._hand * n
        along = dot(centre, n)
        aside = np.sqrt(np.maximum(dot(centre, centre) - along**2, 0.0))
        length = np.hypot(self._upper, self._elbow_aside) + np.hypot(self._fore, self._elbow_aside)
        return np.hypot(np.maximum(aside - self._hand_aside, 0.0), along) <= length

    def within_limits(self, arm: int, q) -> np.ndarray:
        """Which of (..., 7) are solutions within the limits."""
        return np.all((q >= self.lower[arm]) & (q <= self.upper[arm]), axis=-1)

    def _joint4(self, wrist, sign):
        """From the distance of wrist and shoulder."""
        a, upper, fore = self._elbow_aside, self._upper, self._fore
        size = np.hypot(upper * fore - a * a, a * (upper + fore))
        straight = -np.arctan2(a * (upper + fore), upper * fore - a * a)
        c = (dot(wrist, wrist) - 2.0 * a * a - upper**2 - fore**2) / (2.0 * size)
        return straight - sign * np.arccos(c)

    def _forearm(self, q4):
        """The wrist, seen from the shoulder, along the forearm and along x of frame 4, m."""
        a, upper, fore = self._elbow_aside, self._upper, self._fore
        return fore + upper * np.cos(q4) - a * np.sin(q4), a * np.cos(q4) - a + upper * np.sin(q4)


def _joint6(wrist, n, x6, forward, sign):
    """Joint 6 and the forearm's direction, which is sin(q6) x6 - cos(q6) n and has `forward` of the wrist along it."""
    along, against = dot(x6, wrist), -dot(n, wrist)
    q6 = np.arctan2(along, against) + sign * np.arccos(forward / np.hypot(along, against))
    return q6, np.sin(q6)[..., None] * x6 - np.cos(q6)[..., None] * n


def _shoulder_joints(x3, z3, sign):
    """Joints 1 to 3 of the upper arm's frame, seen from the base."""
    q2 = sign * np.arccos(np.clip(z3[..., 2], -1.0, 1.0))
    q1 = np.arctan2(sign * z3[..., 1], sign * z3[..., 0])
    c1, s1, zero = np.cos(q1), np.sin(q1), np.zeros_like(q1)
    z2 = np.stack([-s1, c1, zero], axis=-1)
    x2 = np.stack([np.cos(q2) * c1, np.cos(q2) * s1, -np.sin(q2)], axis=-1)
    return q1, q2, np.arctan2(dot(x3, z2), dot(x3, x2))
