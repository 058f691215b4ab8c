"""What contact does to a body as one wrench: force and torque, in W or in its own frame."""

from collections.abc import Container, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from pydrake.geometry import GeometryId
from pydrake.multibody.math import SpatialForce
from pydrake.multibody.plant import ContactResults
from pydrake.multibody.tree import RigidBody

from drake_blfdmp.vectors import cross


class ContactPair(NamedTuple):
    """The body that feels the contact, and the bodies whose contact counts."""

    body: RigidBody
    others: tuple[RigidBody, ...]


class ContactForce(NamedTuple):
    """One contact: on which body, from which (indices), as a wrench (6,), see `wrench_on`."""

    on: int
    by: int
    wrench: np.ndarray


def bodies_of_geometries(pairs: Sequence[ContactPair]) -> dict[GeometryId, int]:
    """Collision geometry -> index of its body, of every body in `pairs`."""
    bodies = {body.index(): body for pair in pairs for body in (pair.body, *pair.others)}
    plant = pairs[0].body.GetParentPlant()
    return {id: int(index) for index, body in bodies.items() for id in plant.GetCollisionGeometriesForBody(body)}


def contact_forces(contact_results: ContactResults, bodies: Mapping[GeometryId, int]) -> list[ContactForce]:
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
            found.append(_at_origin(on, by, info.F_Ac_W(), surface.centroid()))
    for i in range(contact_results.num_point_pair_contacts()):
        info = contact_results.point_pair_contact_info(i)
        pair = info.point_pair()
        by, on = bodies.get(pair.id_A), bodies.get(pair.id_B)
        if on is not None and by is not None:
            force = SpatialForce(tau=np.zeros(3), f=info.contact_force())
            found.append(_at_origin(on, by, force, info.contact_point()))
    return found


def _at_origin(on: int, by: int, force: SpatialForce, point: Any) -> ContactForce:
    """Of a force applied at a point (3,)."""
    return ContactForce(on, by, force.Shift(-point).get_coeffs())


def wrench_on(forces: Sequence[ContactForce], body: int, others: Container[int]) -> np.ndarray:
    """Sum of the contacts of a body with others.

    Args:
        forces: from `contact_forces`.
        body, others: indices of bodies.

    Returns:
        (6,) torque (N m), then force (N), as in Drake's SpatialForce: expressed in W, the force applied at W's origin.
    """
    total = np.zeros(6)
    for one in forces:
        if one.on == body and one.by in others:
            total += one.wrench
        elif one.by == body and one.on in others:
            total -= one.wrench  # What acts on the other acts back.
    return total


def wrench_in_body(wrench: np.ndarray, X_WB: np.ndarray) -> np.ndarray:
    """A wrench in a body's own frame, its force applied at that frame's origin.

    Args:
        wrench: (..., 6) torque (N m), then force (N), expressed in W, the force applied at W's origin.
        X_WB: (..., 3, 4) poses [R p] of the body.

    Returns:
        (..., 6) torque, then force.
    """
    torque, force = wrench[..., :3], wrench[..., 3:]
    torque = torque - cross(X_WB[..., 3], force)
    R_BW = np.swapaxes(X_WB[..., :3], -1, -2)
    return np.concatenate([(R_BW @ part[..., None])[..., 0] for part in (torque, force)], axis=-1)
