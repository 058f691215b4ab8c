"""What fills the null space of the palm's task: the swivel (the default), nothing, or the paper's (18) as printed.

All three are q' = J^+ X' + alpha n with J n = 0, |n| = 1, and differ in alpha alone; `differential_ik.resolve_null`
puts the joint limits on all of them.

    swivel      alpha such that J_psi q' = psi'_cmd (`differential_ik`)
    none        alpha = 0
    published   (18): (I - J^+ J) J_E^+ psi U_psi = n n^T J_E^+ psi U_psi, hence alpha = psi n^T J_E^+ U_psi

(18) to the letter has four faults:

1. psi, an angle, is used as a speed of the elbow (m/s): the elbow keeps moving while the person's is swung out at all.
2. The projector stands outside the pseudo-inverse. Where the null motion moves the elbow along U_psi, the elbow gets
   the share |J_E^+ J_E n|^2 of the speed psi (`leak`), not all of it.
3. What J^+ X' does to the elbow is added, not taken off.
4. Nothing feeds the robot's own swivel back.

Where (18) leaves a choice: psi is the person's angle, as the paper has it. U_psi, (19), is that of the robot's
shoulder, elbow and wrist, although the paper forms it from the person's points: J_E^+ takes a velocity of the robot's
elbow, and null motion can move that along the robot's normal only. docs/redundancy.md measures the other readings.
"""

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import JacobianWrtVariable

from drake_blfdmp.robot.plant import ARMS, JOINTS_PER_ARM, MakeKinematicPlant
from drake_blfdmp.robot.swivel import swivel_direction, wrap

REDUNDANCIES = ("swivel", "none", "published")
"""The resolutions a scenario may choose."""

RANK = 1e-6
"""Singular values of J_E below this share of the largest count as zero: the elbow stays on a sphere about the shoulder,
where the first three axes meet, so J_E has rank 2."""


def elbow_inverse(elbow_jacobian):
    """J_E^+ (7, 3) of J_E (3, 7), which has rank 2."""
    return np.linalg.pinv(elbow_jacobian, rcond=RANK)


def published_null_speed(n, elbow_jacobian, psi, direction) -> float:
    """The alpha of (18) as printed: psi n^T J_E^+ U_psi.

    Args:
        n: (7,) the null direction of the palm's Jacobian.
        elbow_jacobian: (3, 7) J_E of the elbow's velocity.
        psi: the person's swivel angle, rad, which (18) uses as a speed.
        direction: (3,) U_psi.
    """
    return float(psi * (n @ elbow_inverse(elbow_jacobian) @ direction))


def leak(n, elbow_jacobian) -> float:
    """|J_E^+ J_E n|^2, in [0, 1]: the share of its speed along J_E n that an elbow task keeps in (18).

    Args:
        n: (7,) the null direction.
        elbow_jacobian: (3, 7) J_E.
    """
    kept = elbow_inverse(elbow_jacobian) @ (elbow_jacobian @ n)
    return float(kept @ kept)


def persons_angle(swivel, mirrored: bool):
    """The person's swivel angle, rad, of the angle (...) that was asked of the robot.

    Args:
        swivel: from `retargeting.retarget_motion`, rad.
        mirrored: the arms hold their elbows up; their angle is then measured from straight up, as the person's is from
            straight down (`Retarget.elbow_up`).
    """
    return wrap(np.pi - swivel) if mirrored else wrap(swivel)


class ElbowKinematics:
    """Shoulders, elbows and wrists of both arms and the elbows' Jacobians; holds a plant of its own and its context."""

    def __init__(self, plant: MultibodyPlant | None = None):
        """Use a finalized plant with both arms and nothing else that moves; one is made when none is given."""
        self._plant = plant or MakeKinematicPlant()
        self._context = self._plant.CreateDefaultContext()
        self._frames, self._columns = [], []
        for arm in ARMS:
            instance = self._plant.GetModelInstanceByName(arm)
            names = ("shoulder", "elbow", "wrist")
            self._frames.append([self._plant.GetFrameByName(name, instance) for name in names])
            first = self._plant.GetJointByName("panda_joint1", instance).velocity_start()
            self._columns.append(slice(first, first + JOINTS_PER_ARM))

    def points(self, q) -> np.ndarray:
        """Shoulder, elbow and wrist of both arms at q (14,), rad: (2, 3, 3), m in W."""
        self._plant.SetPositions(self._context, q)
        return np.array(
            [[frame.CalcPoseInWorld(self._context).translation() for frame in frames] for frames in self._frames]
        )

    def evaluate(self, q) -> tuple[np.ndarray, np.ndarray]:
        """J_E (2, 3, 7), m/s per rad/s in W, and U_psi (2, 3), (19), of both arms at q (14,), rad."""
        points = self.points(q)
        plant, world, origin = self._plant, self._plant.world_frame(), np.zeros(3)
        jacobians = [
            plant.CalcJacobianTranslationalVelocity(self._context, JacobianWrtVariable.kV, elbow, origin, world, world)[
                :, columns
            ]
            for (_, elbow, _), columns in zip(self._frames, self._columns, strict=True)
        ]
        return np.array(jacobians), swivel_direction(points[:, 0], points[:, 1], points[:, 2])
