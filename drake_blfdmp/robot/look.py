"""What a body looks like, as data: for a plant's illustration geometry and for a URDF alike."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from pydrake.geometry import Box, Cylinder
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import RigidBody


class VisualPart(NamedTuple):
    """One shape of what a body looks like.

    Attributes:
        name: after the body's.
        shape: a box or a cylinder along z.
        at: (3,) its middle in the body's frame, m.
        color: red, green, blue, alpha.
        tilt: about the body's y axis, rad.
    """

    name: str
    shape: Box | Cylinder
    at: Sequence[float]
    color: Sequence[float]
    tilt: float = 0.0


def AddLook(plant: MultibodyPlant, body: RigidBody, parts: Sequence[VisualPart], name: str) -> None:
    """Adds illustration geometry, `<name>_<part's name>`, to a body of a plant."""
    for part in parts:
        X_BG = RigidTransform(RollPitchYaw(0.0, part.tilt, 0.0), np.asarray(part.at, dtype=float))
        plant.RegisterVisualGeometry(body, X_BG, part.shape, f"{name}_{part.name}", np.array(part.color))
