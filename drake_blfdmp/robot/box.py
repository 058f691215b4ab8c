"""The box that is carried and the tables it stands on."""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from pydrake.geometry import (
    AddCompliantHydroelasticProperties,
    AddContactMaterial,
    AddRigidHydroelasticProperties,
    Box,
    ProximityProperties,
    Shape,
)
from pydrake.math import RigidTransform
from pydrake.multibody.plant import CoulombFriction, MultibodyPlant
from pydrake.multibody.tree import RigidBody, SpatialInertia

from drake_blfdmp.errors import TaskError
from drake_blfdmp.robot.box_look import BoxLook
from drake_blfdmp.robot.look import AddLook
from drake_blfdmp.robot.table_look import TableLeg, TableLook

TABLE_MODULUS = 5.0e6  # Pa
DISSIPATION = 1.0  # s/m, Hunt & Crossley
TABLE_FRICTION = 0.6


@dataclass(frozen=True)
class BoxParameters:
    """A solid box of uniform density, carried between two palms.

    Attributes:
        width: m, along the box's x, between the palms.
        depth: m, along its y.
        height: m, along its z.
        mass: kg.
        friction: Coulomb coefficient of its faces, static and dynamic alike. Drake combines two surfaces' coefficients
            by 2 m n / (m + n).
    """

    width: float = 0.30
    depth: float = 0.20
    height: float = 0.20
    mass: float = 1.0
    friction: float = 0.8

    def __post_init__(self):
        for item in fields(self):
            value = getattr(self, item.name)
            if not (np.isfinite(value) and value > 0):
                raise TaskError(f"box {item.name}: {value} must be a finite number > 0")

    @property
    def size(self) -> np.ndarray:
        """(3,) width, depth, height, m."""
        return np.array([self.width, self.depth, self.height])


@dataclass(frozen=True)
class TableParameters:
    """A slab on one leg, welded to the world.

    Attributes:
        name: of the body and its model instance.
        top_center: (3,) centre of the upper face in W, m.
        size: (2,) along x and y, m.
        thickness: of the slab, m.
    """

    name: str = "table"
    top_center: tuple[float, float, float] = (0.0, 0.45, 0.6)
    size: tuple[float, float] = (0.26, 0.18)
    thickness: float = 0.03

    def __post_init__(self):
        lengths = (*self.size, self.thickness)
        if len(self.size) != 2 or not all(np.isfinite(length) and length > 0 for length in lengths):
            raise TaskError(f"table {self.name}: size {self.size} and thickness {self.thickness} must be lengths > 0")
        if len(self.top_center) != 3 or not np.all(np.isfinite(self.top_center)):
            raise TaskError(f"table {self.name}: top_center {self.top_center} must be three finite numbers")


def _vector(values: Sequence[float]) -> Any:
    # Any: the stubs of Drake 1.51 name an array type that NumPy's own never match.
    return np.array(values, dtype=float)


def _friction(coefficient: float) -> CoulombFriction:
    return CoulombFriction(static_friction=coefficient, dynamic_friction=coefficient)


def AddBox(plant: MultibodyPlant, parameters: BoxParameters, name: str = "box") -> RigidBody:
    """Adds a free box, its frame at its centre, to a plant that is not finalized.

    Its proximity geometry is rigid hydroelastic; palms and tables are compliant, so every contact of the box is a
    pressure field, and a rigid box has the fewest faces to intersect.

    Returns:
        The body.
    """
    instance = plant.AddModelInstance(name)
    body = plant.AddRigidBody(
        name, instance, SpatialInertia.SolidBoxWithMass(parameters.mass, *(float(s) for s in parameters.size))
    )
    if plant.geometry_source_is_registered():
        properties = ProximityProperties()
        AddContactMaterial(DISSIPATION, None, _friction(parameters.friction), properties)
        AddRigidHydroelasticProperties(properties)
        X_BG = RigidTransform()
        plant.RegisterCollisionGeometry(body, X_BG, Box(*parameters.size), f"{name}_faces", properties)
        AddLook(plant, body, BoxLook(parameters.size), name)
    return body


def AddTable(plant: MultibodyPlant, parameters: TableParameters) -> RigidBody:
    """Adds a table (slab, and a leg down to z = 0), welded to the world, to a plant that is not finalized.

    The slab is compliant hydroelastic and stiff (a 1 kg box sinks in by micrometres). Slab and leg both count for
    clearance.

    Returns:
        The body, its frame at the centre of the upper face, axes as W's.
    """
    name, thickness = parameters.name, parameters.thickness
    width, depth = parameters.size
    instance = plant.AddModelInstance(name)
    # Welded, so the inertia is of no effect; a valid one keeps every later computation finite.
    body = plant.AddRigidBody(name, instance, SpatialInertia.SolidBoxWithMass(10.0, width, depth, thickness))
    plant.WeldFrames(plant.world_frame(), body.body_frame(), RigidTransform(_vector(parameters.top_center)))
    if not plant.geometry_source_is_registered():
        return body

    slab: Shape = Box(width, depth, thickness)
    X_TS = RigidTransform(_vector([0.0, 0.0, -thickness / 2]))
    properties = ProximityProperties()
    AddContactMaterial(DISSIPATION, None, _friction(TABLE_FRICTION), properties)
    AddCompliantHydroelasticProperties(max(width, depth), TABLE_MODULUS, properties)
    plant.RegisterCollisionGeometry(body, X_TS, slab, f"{name}_slab", properties)
    dimensions = parameters.size, thickness, parameters.top_center[2]
    leg = TableLeg(*dimensions)
    if leg is not None:
        X_TL = RigidTransform(_vector(leg.at))
        plant.RegisterCollisionGeometry(body, X_TL, leg.shape, f"{name}_leg", _friction(TABLE_FRICTION))
    AddLook(plant, body, TableLook(*dimensions), name)
    return body
