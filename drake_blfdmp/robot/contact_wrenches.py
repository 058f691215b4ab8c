"""What contact does to a body as one wrench: force and torque in its own frame, at its origin."""

from collections.abc import Container, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from pydrake.geometry import GeometryId
from pydrake.math import RigidTransform
from pydrake.multibody.math import SpatialForce
from pydrake.multibody.plant import ContactResults
from pydrake.multibody.tree import RigidBody


class ContactPair(NamedTuple):
    """The body that feels the contact, and the bodies whose contact counts."""

    body: RigidBody
    others: tuple[RigidBody, ...]


class PointForce(NamedTuple):
    """One contact: on which body, from which (indices), as a spatial force in W at a point (3,), m in W."""

    on: int
    by: int
    force: SpatialForce
    point: np.ndarray


def bodies_of_geometries(pairs: Sequence[ContactPair]) -> dict[GeometryId, int]:
    """Collision geometry -> index of its body, of every body in `pairs`."""
    bodies = {body.index(): body for pair in pairs for body in (pair.body, *pair.others)}
    plant = pairs[0].body.GetParentPlant()
    return {id: int(index) for index, body in bodies.items() for id in plant.GetCollisionGeometriesForBody(body)}


def point_forces(contact_results: ContactResults, bodies: Mapping[GeometryId, int]) -> list[PointForce]:
    """Every contact between two of the bodies, once: on the body that Drake calls A (hydroelastic) or B (point).

    Args:
        contact_results: the value of the plant's contact results output port.
        bodies: collision geometry -> index of its body; others are left out.
    """
    found = []
    for i in range(contact_results.num_hydroelastic_contacts()):
        info = contact_results.hydroelastic_contact_info(i)
        surface = info.contact_surface()
        on, by = bodies.get(surface.id_M()), bodies.get(surface.id_N())  # M is of A.
        if on is not None and by is not None:
            found.append(PointForce(on, by, info.F_Ac_W(), surface.centroid()))
    for i in range(contact_results.num_point_pair_contacts()):
        info = contact_results.point_pair_contact_info(i)
        pair = info.point_pair()
        by, on = bodies.get(pair.id_A), bodies.get(pair.id_B)
        if on is not None and by is not None:
            force = SpatialForce(tau=np.zeros(3), f=info.contact_force())
            found.append(PointForce(on, by, force, info.contact_point()))
    return found


def wrench_on(forces: Sequence[PointForce], body: int, others: Container[int], X_WB: RigidTransform) -> np.ndarray:
    """Sum of the contacts of a body with others, moved to its origin.

    Args:
        forces: from `point_forces`.
        body, others: indices of bodies.
        X_WB: pose of the body.

    Returns:
        (6,) torque (N m), then force (N), as in Drake's SpatialForce: expressed in B, the force applied at B's origin.
    """
    total, origin = None, X_WB.translation()
    for one in forces:
        if one.on == body and one.by in others:
            force = one.force
        elif one.by == body and one.on in others:
            force = -one.force  # What acts on the other acts back.
        else:
            continue
        moved = force.Shift(origin - one.point)
        total = moved if total is None else total + moved
    if total is None:
        return np.zeros(6)
    return (total.get_coeffs().reshape(2, 3) @ X_WB.rotation().matrix()).ravel()  # R_BW times columns, as rows.
