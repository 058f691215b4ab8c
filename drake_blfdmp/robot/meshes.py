"""The Panda's real meshes in place of the primitives of its URDF: looks alone, with the extra `visuals`.

The meshes are those of the package `example-robot-data` (Apache-2.0), COLLADA files that Drake cannot draw. `trimesh`
turns each into one glTF file in memory, colours kept; nothing is written or downloaded.
"""

from collections.abc import Sequence
from functools import lru_cache
from importlib.metadata import PackageNotFoundError, files
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from pydrake.common import MemoryFile
from pydrake.geometry import InMemoryMesh, Mesh, Role, SceneGraph
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import ModelInstanceIndex

from drake_blfdmp.errors import ScenarioError

VISUALS = ("primitive", "meshes")
"""What the arms can look like."""

LINKS = tuple(f"link{k}" for k in range(8))

_DISTRIBUTION = "example-robot-data"
_FOLDER = "panda_description/meshes/visual"
_SMOOTH = 0.5  # rad
_WHITEST = 0.89


def _refusal(what: str) -> ScenarioError:
    return ScenarioError(
        f"scenario: simulation.visuals is 'meshes', but {what}; install the extra with python -m pip install "
        "'drake_blfdmp[visuals]', or choose primitive"
    )


def RequireMeshes() -> dict[str, Path]:
    """Link (`link0`...) -> the file of its mesh.

    Raises:
        ScenarioError: the extra `visuals`, or a part of it, is not installed; the message says how to.
    """
    for module, package in (("trimesh", "trimesh"), ("collada", "pycollada")):
        if find_spec(module) is None:
            raise _refusal(f"the package {package} is missing")
    try:
        installed = files(_DISTRIBUTION) or []
    except PackageNotFoundError:
        raise _refusal(f"the package {_DISTRIBUTION} is missing") from None
    wanted = {f"{_FOLDER}/{link}.dae": link for link in LINKS}
    found = {}
    for file in installed:
        link = wanted.get("/".join(file.parts[-4:]))
        if link is not None and Path(str(file.locate())).is_file():
            found[link] = Path(str(file.locate()))
    missing = [link for link in LINKS if link not in found]
    if missing:
        raise _refusal(f"{_DISTRIBUTION} has no mesh of the Panda's {', '.join(missing)}")
    return found


@lru_cache(maxsize=len(LINKS))
def _gltf(path: Path) -> dict[str, bytes]:
    """One COLLADA file as glTF: name of file to content, the first of them the mesh.

    The files hold flat facets, each with corners of its own; corners are shared here, and edges below `_SMOOTH`
    smoothed, which looks better and takes a quarter of the room.
    """
    import trimesh  # pyright: ignore[reportMissingImports]  An extra.
    from trimesh.graph import smooth_shade  # pyright: ignore[reportMissingImports]
    from trimesh.visual import TextureVisuals  # pyright: ignore[reportMissingImports]

    scene = trimesh.load_scene(path)
    for name, part in scene.geometry.items():
        material = part.visual.material
        material.roughnessFactor, material.metallicFactor = 0.6, 0.0  # glTF's own default is a mirror.
        # COLLADA's colours are those of a screen, glTF's are linear; pure white would have no shades in our light.
        rgb = _WHITEST * material.baseColorFactor[:3] / 255.0
        material.baseColorFactor = [*np.where(rgb > 0.04045, ((rgb + 0.055) / 1.055) ** 2.4, rgb / 12.92), 1.0]
        part.merge_vertices(merge_norm=True, merge_tex=True)
        smooth = smooth_shade(part, angle=_SMOOTH, facet_minarea=None)
        smooth.visual, smooth.metadata = TextureVisuals(material=material), {}
        scene.geometry[name] = smooth
    # glTF's y axis is up; Drake turns it back.
    scene.apply_transform(RigidTransform(RotationMatrix.MakeXRotation(-np.pi / 2)).GetAsMatrix4())
    exported: Any = scene.export(file_type="gltf", merge_buffers=True)
    return {"model.gltf": exported.pop("model.gltf"), **exported}


def LinkMesh(link: str) -> Mesh:
    """The mesh of one link, in the link's frame, m.

    Raises:
        ScenarioError: the extra `visuals` is not installed.
    """
    mesh, *others = (
        (name, MemoryFile(content, Path(name).suffix, f"panda_{link}_{name}"))
        for name, content in _gltf(RequireMeshes()[link]).items()
    )
    return Mesh(InMemoryMesh(mesh_file=mesh[1], supporting_files=dict(others)))


def ShowMeshes(plant: MultibodyPlant, scene_graph: SceneGraph, arms: Sequence[ModelInstanceIndex]) -> None:
    """Draws the arms' links as meshes from now on; the palm stays as it is, and so does all that touches or weighs.

    Args:
        plant: holds the arms; not finalized.
        scene_graph: where it is registered.

    Raises:
        ScenarioError: the extra `visuals` is not installed.
    """
    source = plant.get_source_id()
    meshes = {link: LinkMesh(link) for link in LINKS}
    for arm in arms:
        for link, mesh in meshes.items():
            body = plant.GetBodyByName(f"panda_{link}", arm)
            for primitive in plant.GetVisualGeometriesForBody(body):
                for role in (Role.kIllustration, Role.kPerception):
                    scene_graph.RemoveRole(source, primitive, role)
            # The colour is for those who cannot read the mesh's own.
            plant.RegisterVisualGeometry(body, RigidTransform(), mesh, f"{link}_mesh", [0.93, 0.93, 0.91, 1.0])
