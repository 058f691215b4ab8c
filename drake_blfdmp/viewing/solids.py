"""What a scene is made of, as plain data: bodies in their own frames, and their poses at an instant. No Drake here."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from drake_blfdmp.errors import BlfDmpError
from drake_blfdmp.viewing.rendering import (
    Triangles,
    box_corners,
    capsule_corners,
    coloured,
    cylinder_corners,
    joined,
)


@dataclass(frozen=True)
class Solid:
    """A body of one colour.

    Attributes:
        kind: one of `KINDS`.
        size: m, as its kind has it.
        colour: red, green, blue, in [0, 1].
    """

    kind: str
    size: tuple[float, ...]
    colour: tuple[float, float, float]


KINDS: dict[str, Callable[..., np.ndarray]] = {
    "ball": lambda radius: capsule_corners(radius, 0.0),
    "capsule": capsule_corners,  # Radius, length without the half balls; along z, as a cylinder.
    "cylinder": cylinder_corners,
    "ellipsoid": lambda a, b, c: capsule_corners(1.0, 0.0) * [a, b, c],
    "box": lambda x, y, z: box_corners((x, y, z)),
}
"""Kind to the function from its size to corners (T, 3, 3)."""


def solid_triangles(solid: Solid | Triangles) -> Triangles:
    """A body's triangles in its own frame; of a mesh, which is triangles, itself.

    Raises:
        BlfDmpError: there is no such kind, or its size has more or fewer numbers.
    """
    if isinstance(solid, Triangles):
        return solid
    try:
        return coloured(KINDS[solid.kind](*solid.size), solid.colour)
    except (KeyError, TypeError):
        raise BlfDmpError(f"still: a {solid.kind} of size {solid.size} cannot be drawn") from None


def posed(shapes: Sequence[Triangles], poses: np.ndarray) -> Triangles:
    """All bodies in W.

    Args:
        shapes: S bodies, each in its own frame G.
        poses: (S, 3, 4) X_WG, rotation beside translation, m.
    """
    parts = zip(shapes, np.asarray(poses), strict=True)
    return joined(*(Triangles(shape.corners @ X[:, :3].T + X[:, 3], shape.colours) for shape, X in parts))
