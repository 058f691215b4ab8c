"""A glTF mesh of a Drake scene as triangles with its own colours, for `rendering`; needs the extra `visuals`."""

from io import BytesIO

import numpy as np
from pydrake.geometry import Mesh

from drake_blfdmp.viewing.rendering import Triangles, coloured, joined


class _InMemory:
    """Answers trimesh's questions for the files that a mesh refers to."""

    def __init__(self, mesh: Mesh):
        self._files = mesh.source().in_memory().supporting_files

    def get(self, name: str) -> bytes:
        return self._files[name].contents()

    __getitem__ = get


def is_gltf_in_memory(shape) -> bool:
    """Whether `mesh_triangles` reads it."""
    return isinstance(shape, Mesh) and shape.source().is_in_memory() and shape.extension() == ".gltf"


def mesh_triangles(mesh: Mesh) -> Triangles:
    """Triangles in the mesh's own frame, z up, each in the colour of its material."""
    import trimesh  # pyright: ignore[reportMissingImports]  An extra.

    contents = mesh.source().in_memory().mesh_file.contents()
    scene = trimesh.load_scene(BytesIO(contents), file_type="gltf", resolver=_InMemory(mesh), process=False)
    parts = []
    for node in scene.graph.nodes_geometry:
        X_MN, name = scene.graph[node]
        part = scene.geometry[name]
        corners = (part.vertices @ X_MN[:3, :3].T + X_MN[:3, 3])[part.faces]
        # glTF's y axis is up.
        corners = np.stack([corners[..., 0], -corners[..., 2], corners[..., 1]], axis=-1) * mesh.scale3()
        parts.append(coloured(corners, _screen_colour(part.visual.material.baseColorFactor[:3])))
    return joined(*parts)


def _screen_colour(linear) -> np.ndarray:
    """Red, green, blue (3,) in [0, 1] of a screen from glTF's linear ones in [0, 255]."""
    c = np.asarray(linear, dtype=float) / 255.0
    return np.clip(np.where(c > 0.0031308, 1.055 * c ** (1 / 2.4) - 0.055, 12.92 * c), 0.0, 1.0)
