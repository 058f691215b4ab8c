"""Contact: how it is modelled, how hard each palm presses on the box, and how deep a squeeze that takes."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from pydrake.geometry import ContactSurface, GeometryId
from pydrake.multibody.plant import ContactResults, MultibodyPlant, MultibodyPlantConfig
from pydrake.multibody.tree import JacobianWrtVariable, ModelInstanceIndex, RigidBody
from pydrake.systems.framework import Context

from drake_blfdmp.robot.plant import ArmActuators

TIME_STEP = 0.002  # s


def ContactPlantConfig(time_step: float = TIME_STEP) -> MultibodyPlantConfig:
    """The configuration of every simulated plant: hydroelastic contact, the convex approximation `lagged`.

    Friction is regularized, so what is held creeps: with Drake's stiction tolerance of 1e-4 m/s a box tilts between the
    palms by 0.1 deg/s, with 1e-5 m/s by less than 0.02, at the same speed of simulation.
    """
    return MultibodyPlantConfig(
        time_step=time_step,
        contact_model="hydroelastic_with_fallback",
        discrete_contact_approximation="lagged",
        stiction_tolerance=1e-5,
    )


def palm_stiffness(
    plant: MultibodyPlant, context: Context, arm: ModelInstanceIndex, joint_stiffness: Sequence[float] | np.ndarray
) -> float:
    """How stiffly joint PD holds a palm along its normal n: k = 1/(n^T J K^-1 J^T n).

    A palm whose desired position lies F/k inside the box presses with about F (the trials measured 13-16 % more, as
    the face of the box also resists the palm's rotation).

    Args:
        plant: finalized.
        context: its context, with the arm's positions.
        arm: the model instance.
        joint_stiffness: (7,) N m/rad.

    Returns:
        N/m.
    """
    palm = plant.GetFrameByName("palm", arm)
    origin: Any = np.zeros(3)  # Any: the stubs of Drake 1.51 name an array type that NumPy's own never match.
    jacobian = plant.CalcJacobianTranslationalVelocity(
        context, JacobianWrtVariable.kV, palm, origin, plant.world_frame(), palm
    )
    columns = [actuator.joint().velocity_start() for actuator in ArmActuators(plant, arm)]
    normal = np.asarray(jacobian)[2, columns]
    return float(1.0 / np.sum(normal**2 / np.asarray(joint_stiffness, dtype=float)))


def palm_bodies(plant: MultibodyPlant, arms: Sequence[ModelInstanceIndex]) -> tuple[RigidBody, ...]:
    """The palms of the given model instances, in their order."""
    return tuple(plant.GetBodyByName("palm", arm) for arm in arms)


def _patch_normal(surface: ContactSurface) -> np.ndarray:
    """The area-weighted unit normal (3,) of a patch in W; zero of one without area.

    The box is rigid and its faces are flat, so a patch on one face has one normal: where the first, the middle and the
    last agree, the others are not asked, which is what takes time.
    """
    count = surface.num_faces()
    first, middle, last = (np.array(surface.face_normal(f), dtype=float) for f in (0, count // 2, count - 1))
    if min(first @ middle, first @ last) > 1.0 - 1e-12:
        return first
    faces = range(count)
    area = np.array([surface.area(f) for f in faces]) @ np.array([surface.face_normal(f) for f in faces])
    norm = float(np.linalg.norm(area))
    return area / norm if norm > 0 else np.zeros(3)


def palm_forces(contact_results: ContactResults, palms: Sequence[RigidBody], box: RigidBody) -> np.ndarray:
    """Normal force of each palm on the box.

    A hydroelastic patch counts with its resultant along its area-weighted normal, a point contact with the force along
    its normal; several patches of one palm add up.

    Args:
        contact_results: the value of the plant's contact results output port.
        palms: the palms' bodies, left and right.
        box: the box's body.

    Returns:
        (len(palms),) N, >= 0; 0 without contact.
    """
    plant = box.GetParentPlant()
    box_ids = set(plant.GetCollisionGeometriesForBody(box))
    palm_of: dict[GeometryId, int] = {
        id: k for k, palm in enumerate(palms) for id in plant.GetCollisionGeometriesForBody(palm)
    }
    palm_of_body = {palm.index(): k for k, palm in enumerate(palms)}
    force = np.zeros(len(palms))

    for i in range(contact_results.num_hydroelastic_contacts()):
        info = contact_results.hydroelastic_contact_info(i)
        surface = info.contact_surface()
        id_M, id_N = surface.id_M(), surface.id_N()
        k = palm_of.get(id_M if id_N in box_ids else id_N)
        if k is None or not (id_M in box_ids or id_N in box_ids):
            continue
        force[k] += abs(float(info.F_Ac_W().translational() @ _patch_normal(surface)))

    for i in range(contact_results.num_point_pair_contacts()):
        info = contact_results.point_pair_contact_info(i)
        bodies = (info.bodyA_index(), info.bodyB_index())
        if box.index() not in bodies:
            continue
        k = palm_of_body.get(bodies[0] if bodies[1] == box.index() else bodies[1])
        if k is not None:
            force[k] += abs(float(np.dot(info.contact_force(), info.point_pair().nhat_BA_W)))
    return force
