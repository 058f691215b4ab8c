"""The arms and the box of a plan in any posture, as solids and their poses: what stills are drawn from."""

from itertools import pairwise

import numpy as np
from pydrake.geometry import (
    Box,
    Capsule,
    Convex,
    Cylinder,
    Ellipsoid,
    Mesh,
    QueryObject,
    Rgba,
    Role,
    SceneGraphInspector,
    Shape,
    Sphere,
)
from pydrake.systems.framework import DiagramBuilder

from drake_blfdmp.diagrams.hold_and_place import AddPlannedPlant
from drake_blfdmp.errors import BlfDmpError
from drake_blfdmp.planning.plan import Plan
from drake_blfdmp.robot.rigid import rigid
from drake_blfdmp.viewing.mesh_triangles import is_gltf_in_memory, mesh_triangles
from drake_blfdmp.viewing.rendering import Triangles, coloured
from drake_blfdmp.viewing.solids import Solid


def shape_solid(shape: Shape, colour: tuple[float, float, float]) -> Solid | Triangles:
    """A Drake shape in its own frame; a mesh by its convex hull, unless it is a glTF in memory, with its own colours.

    Raises:
        BlfDmpError: the shape is no body, as a half space.
    """
    if isinstance(shape, Sphere):
        return Solid("ball", (shape.radius(),), colour)
    if isinstance(shape, Capsule):
        return Solid("capsule", (shape.radius(), shape.length()), colour)
    if isinstance(shape, Cylinder):
        return Solid("cylinder", (shape.radius(), shape.length()), colour)
    if isinstance(shape, Ellipsoid):
        return Solid("ellipsoid", (shape.a(), shape.b(), shape.c()), colour)
    if isinstance(shape, Box):
        x, y, z = (float(side) for side in shape.size())
        return Solid("box", (x, y, z), colour)
    if is_gltf_in_memory(shape):
        return mesh_triangles(shape)
    if isinstance(shape, Mesh | Convex):
        return coloured(_hull_corners(shape), colour)
    raise BlfDmpError(f"still: a {type(shape).__name__} cannot be drawn; remove its illustration role")


def _hull_corners(shape: Mesh | Convex) -> np.ndarray:
    hull = shape.GetConvexHull()
    corner = np.array([hull.vertex(v) for v in range(hull.num_vertices())])
    fans = []
    for f in range(hull.num_faces()):
        face = hull.element(f)
        ring = [face.vertex(i) for i in range(face.num_vertices())]
        fans += [(ring[0], b, c) for b, c in pairwise(ring[1:])]
    return corner[np.array(fans)]


class SceneShapes:
    """The illustration geometry of a scene graph: made into solids once, posed for every still.

    Attributes:
        solids: S of them.
    """

    def __init__(self, inspector: SceneGraphInspector):
        """Take every geometry of the illustration role, in the colour that it has there."""
        self._geometries, self.solids = [], []
        for geometry in inspector.GetAllGeometryIds(Role.kIllustration):
            properties = inspector.GetIllustrationProperties(geometry)
            rgba = properties.GetPropertyOrDefault("phong", "diffuse", Rgba(0.9, 0.9, 0.9, 1.0))
            if rgba.a() > 0:
                self._geometries.append(geometry)
                self.solids.append(shape_solid(inspector.GetShape(geometry), (rgba.r(), rgba.g(), rgba.b())))

    def poses(self, query: QueryObject) -> np.ndarray:
        """X_WG (S, 3, 4) of the solids in the query's context."""
        return np.array([query.GetPoseInWorld(geometry).GetAsMatrix34() for geometry in self._geometries])


class PlannedScene:
    """The plant of a plan, without its controllers, in any posture.

    Attributes:
        solids: S of them, all that is seen.
    """

    def __init__(self, plan: Plan):
        """Build it."""
        builder = DiagramBuilder()
        self._plant, scene_graph, self._arms, self._box = AddPlannedPlant(builder, plan)
        self._diagram = builder.Build()
        self._context = self._diagram.CreateDefaultContext()
        self._plant_context = self._plant.GetMyMutableContextFromRoot(self._context)
        self._scene_context = scene_graph.GetMyContextFromRoot(self._context)
        self._query = scene_graph.get_query_output_port()
        self._shapes = SceneShapes(scene_graph.model_inspector())
        self.solids = self._shapes.solids

    def at(self, q, box=None) -> np.ndarray:
        """Poses X_WG (S, 3, 4) with the arms at q (14,), rad, and the box, if any, at X_WB (7,) qw qx qy qz x y z."""
        for arm, angles in zip(self._arms, np.split(np.asarray(q), 2), strict=True):
            self._plant.SetPositions(self._plant_context, arm, angles)
        if self._box is not None:
            self._plant.SetFreeBodyPose(self._plant_context, self._box, rigid(box))
        return self._shapes.poses(self._query.Eval(self._scene_context))
