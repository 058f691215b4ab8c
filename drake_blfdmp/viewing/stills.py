"""Pictures of the arms, the box and the person at given instants, side by side on a page; `rendering` makes them."""

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from pydrake.geometry import QueryObject, Rgba, Role, SceneGraphInspector
from pydrake.systems.framework import DiagramBuilder

from drake_blfdmp.diagrams.hold_and_place import AddPlannedPlant
from drake_blfdmp.planning.plan import Plan
from drake_blfdmp.robot.reach import rigid
from drake_blfdmp.skeleton import LINKS
from drake_blfdmp.viewing import style
from drake_blfdmp.viewing.mesh_triangles import is_gltf_in_memory, mesh_triangles
from drake_blfdmp.viewing.rendering import Triangles, capsule_corners, coloured, joined, shape_corners

INSIDE, OUTSIDE, BODY = style.GREEN, style.VERMILLION, "#5A6470"
LEGEND = {"link inside its band": INSIDE, "link outside (drawn thicker)": OUTSIDE}
"""Text -> colour, of `skeleton`."""


class SceneShapes:
    """The illustration geometry of a scene graph, made into triangles once and posed for every still."""

    def __init__(self, inspector: SceneGraphInspector):
        """Take every geometry of the illustration role, in the colour that it has there."""
        self._shapes = []
        for geometry in inspector.GetAllGeometryIds(Role.kIllustration):
            properties = inspector.GetIllustrationProperties(geometry)
            rgba = properties.GetPropertyOrDefault("phong", "diffuse", Rgba(0.9, 0.9, 0.9, 1.0))
            if rgba.a() > 0:
                shape, colour = inspector.GetShape(geometry), (rgba.r(), rgba.g(), rgba.b())
                gltf = is_gltf_in_memory(shape)
                triangles = mesh_triangles(shape) if gltf else coloured(shape_corners(shape), colour)
                self._shapes.append((geometry, triangles))

    def posed(self, query: QueryObject) -> Triangles:
        """The whole scene in W, as posed in the query's context."""
        parts = []
        for geometry, shape in self._shapes:
            X_WG = query.GetPoseInWorld(geometry)
            corners = shape.corners @ X_WG.rotation().matrix().T + X_WG.translation()
            parts.append(Triangles(corners, shape.colours))
        return joined(*parts)


class PlannedScene:
    """The plant of a plan, without its controllers, in any posture."""

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

    def at(self, q, box=None) -> Triangles:
        """Everything with the arms at q (14,), rad, and the box, if there is one, at X_WB (7,) qw qx qy qz x y z."""
        for arm, angles in zip(self._arms, np.split(np.asarray(q), 2), strict=True):
            self._plant.SetPositions(self._plant_context, arm, angles)
        if self._box is not None:
            self._plant.SetFreeBodyPose(self._plant_context, self._box, rigid(box))
        return self._shapes.posed(self._query.Eval(self._scene_context))


def rod(start, end, radius: float, colour) -> Triangles:
    """A capsule from one point (3,) to another, m."""
    along = np.asarray(end) - start
    length = float(np.linalg.norm(along))
    z = along / length if length > 0 else np.array([0.0, 0.0, 1.0])
    x = np.cross(z, [0.0, 0.0, 1.0] if abs(z[2]) < 0.9 else [1.0, 0.0, 0.0])
    x /= np.linalg.norm(x)
    rotation = np.stack([x, np.cross(z, x), z], axis=-1)
    return coloured(capsule_corners(radius, length) @ rotation.T + 0.5 * (start + np.asarray(end)), colour)


def skeleton(points, inside, radius: float = 0.025) -> Triangles:
    """The person: bones, the line of the hands, joints, shoulders and head.

    Args:
        points: (6, 3) in the order of `skeleton.POINTS`, m.
        inside: (5,) whether each link is inside its band; one outside is vermillion, and thicker.
        radius: of the bones, m.
    """
    points = np.asarray(points, dtype=float)
    parts = []
    for link, within in zip(LINKS, inside, strict=True):
        size, colour = (radius, INSIDE) if within else (1.5 * radius, OUTSIDE)
        # The hands' link is no bone.
        size *= 0.5 if link.name == "hands" else 1.0
        parts.append(rod(points[link.a], points[link.b], size, colour))
    parts += [rod(point, point, 1.6 * radius, BODY) for point in points]
    middle = 0.5 * (points[0] + points[3])
    head = middle + np.array([0.0, 0.0, 0.24])
    parts += [rod(points[0], points[3], radius, BODY), rod(middle, head, radius, BODY), rod(head, head, 0.1, BODY)]
    return joined(*parts)


@style.styled
def strip(rows: Mapping[str, Sequence[np.ndarray]], titles: Sequence[str], legend: Mapping[str, str]) -> Figure:
    """Rows of pictures, a page wide.

    Args:
        rows: name to pictures, those of one row of one size.
        titles: of the columns.
        legend: text to colour.
    """
    above, below, beside = 0.22, 0.22, 0.18  # Inches for titles, legend and names.
    width = (style.PAGE - beside) / len(titles)
    heights = [width * row[0].shape[0] / row[0].shape[1] for row in rows.values()]
    height = above + below + sum(heights)
    figure = Figure(figsize=(style.PAGE, height), layout="none")
    place = {"left": beside / style.PAGE, "right": 1.0, "bottom": below / height, "top": 1.0 - above / height}
    grid = figure.add_gridspec(len(rows), len(titles), height_ratios=heights, wspace=0.0, hspace=0.0, **place)
    for i, (name, row) in enumerate(rows.items()):
        for j, image in enumerate(row):
            axis = figure.add_subplot(grid[i, j])
            axis.imshow(image, interpolation="antialiased", aspect="auto")
            axis.set_axis_off()
            if i == 0:
                axis.set_title(titles[j], pad=3)
            if j == 0:
                x = -0.5 * beside / width
                axis.text(x, 0.5, name, transform=axis.transAxes, rotation=90, ha="center", va="center", fontsize=8)
    handles = [Patch(facecolor=colour, label=text) for text, colour in legend.items()]
    figure.legend(handles=handles, loc="lower center", ncols=len(handles), borderaxespad=0.2)
    return figure
