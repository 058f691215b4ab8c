"""The Panda's real meshes; what needs the extra `visuals` is skipped without it."""

import re
from importlib.metadata import PackageNotFoundError
from pathlib import Path

import numpy as np
import pytest
from pydrake.geometry import Cylinder, Mesh, Role
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.framework import DiagramBuilder

from drake_blfdmp.errors import ScenarioError
from drake_blfdmp.planning.scenario import ApplySetting, CheckScenario, Scenario
from drake_blfdmp.robot import meshes
from drake_blfdmp.robot.plant import AddDualPanda
from drake_blfdmp.viewing.mesh_triangles import is_gltf_in_memory, mesh_triangles
from drake_blfdmp.viewing.planned_scene import shape_solid
from drake_blfdmp.viewing.solids import solid_triangles

REFUSAL = r"^scenario: simulation\.visuals is 'meshes', but {}; install the extra with [^\n]*\[visuals\][^\n]*$"


def with_extra():
    try:
        meshes.RequireMeshes()
    except ScenarioError as error:
        pytest.skip(str(error))


@pytest.mark.parametrize("package", ["trimesh", "pycollada"])
def test_a_missing_converter_is_refused_with_the_extras_name(monkeypatch, package):
    module = {"trimesh": "trimesh", "pycollada": "collada"}[package]
    monkeypatch.setattr(meshes, "find_spec", lambda name: None if name == module else object())
    with pytest.raises(ScenarioError, match=REFUSAL.format(f"the package {package} is missing")):
        CheckScenario(ApplySetting(Scenario(), "simulation.visuals=meshes"))


def test_missing_or_incomplete_meshes_are_refused(monkeypatch):
    def missing(name):
        raise PackageNotFoundError(name)

    monkeypatch.setattr(meshes, "find_spec", lambda name: object())
    monkeypatch.setattr(meshes, "files", missing)
    with pytest.raises(ScenarioError, match=REFUSAL.format("the package example-robot-data is missing")):
        meshes.RequireMeshes()
    monkeypatch.setattr(meshes, "files", lambda name: [])
    with pytest.raises(ScenarioError, match=REFUSAL.format("example-robot-data has no mesh .* link0, link1, .*")):
        meshes.RequireMeshes()


def test_another_look_is_refused():
    with pytest.raises(ScenarioError, match="simulation.visuals is 'photo'; choose one of primitive, meshes"):
        CheckScenario(ApplySetting(Scenario(), "simulation.visuals=photo"))


def dual_panda(show):
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, 0.002)
    arms = AddDualPanda(plant)
    if show:
        meshes.ShowMeshes(plant, scene_graph, arms)
    plant.Finalize()
    return plant, scene_graph.model_inspector(), arms


@pytest.fixture(scope="module")
def real():
    with_extra()
    return dual_panda(True)


def drawn(plant, inspector, body):
    return [g for g in plant.GetVisualGeometriesForBody(body) if inspector.GetIllustrationProperties(g) is not None]


def test_every_link_is_one_mesh_and_the_palm_stays(real):
    plant, inspector, arms = real
    for arm in arms:
        for link in meshes.LINKS:
            (geometry,) = drawn(plant, inspector, plant.GetBodyByName(f"panda_{link}", arm))
            assert isinstance(inspector.GetShape(geometry), Mesh)
        palm = [inspector.GetShape(g) for g in drawn(plant, inspector, plant.GetBodyByName("palm", arm))]
        assert len(palm) == 3 and all(isinstance(shape, Cylinder) for shape in palm)


def test_what_touches_and_weighs_is_as_without_meshes(real):
    def told(plant, inspector, arms):
        rows = []
        for arm in arms:
            for index in plant.GetBodyIndices(arm):
                body = plant.get_body(index)
                rows.append((body.name(), body.default_mass()))
                for geometry in plant.GetCollisionGeometriesForBody(body):
                    pose = inspector.GetPoseInFrame(geometry).GetAsMatrix4().tolist()
                    rows.append((inspector.GetName(geometry), str(inspector.GetShape(geometry)), pose))
        return rows, inspector.NumGeometriesWithRole(Role.kProximity)

    assert told(*real) == told(*dual_panda(False))


def test_each_mesh_fills_the_room_of_the_primitives_it_replaces(real):
    """Turned, shifted or scaled meshes would not."""
    plant, inspector, arms = real
    other, primitives, other_arms = dual_panda(False)
    for link in meshes.LINKS:
        (geometry,) = drawn(plant, inspector, plant.GetBodyByName(f"panda_{link}", arms[0]))
        hull = inspector.GetShape(geometry).GetConvexHull()
        points = np.array([hull.vertex(v) for v in range(hull.num_vertices())])
        corners = []
        for part in drawn(other, primitives, other.GetBodyByName(f"panda_{link}", other_arms[0])):
            local = solid_triangles(shape_solid(primitives.GetShape(part), (1.0, 1.0, 1.0))).corners.reshape(-1, 3)
            corners.append((primitives.GetPoseInFrame(part) @ local.T).T)
        corners = np.concatenate(corners)
        # How far the mesh ends beyond the primitives; their round ends reach up to 30 mm into the next link.
        beyond = np.concatenate([corners.min(axis=0) - points.min(axis=0), points.max(axis=0) - corners.max(axis=0)])
        assert np.all((beyond > -0.03) & (beyond < 0.012)), f"{link}: {beyond}"


def test_stills_draw_meshes_in_their_own_colours(real):
    mesh = meshes.LinkMesh("link5")
    assert is_gltf_in_memory(mesh)
    triangles = mesh_triangles(mesh)
    hull = mesh.GetConvexHull()
    points = np.array([hull.vertex(v) for v in range(hull.num_vertices())])
    drawn_points = triangles.corners.reshape(-1, 3)
    np.testing.assert_allclose(drawn_points.min(axis=0), points.min(axis=0), atol=1e-6)
    np.testing.assert_allclose(drawn_points.max(axis=0), points.max(axis=0), atol=1e-6)
    # White shells (255 in the file) and a dark inlay (64), each a little darker so that white keeps its shades.
    dark, white = triangles.colours.min(), triangles.colours.max()
    assert dark == pytest.approx(64 / 255 * meshes._WHITEST, abs=0.02)
    assert white == pytest.approx(meshes._WHITEST, abs=0.02)


def test_the_extra_is_declared_with_all_it_needs():
    text = (Path(__file__).resolve().parents[2] / "pyproject.toml").read_text(encoding="utf-8")
    extra = re.search(r"^visuals = \[(.*)\]$", text, re.MULTILINE).group(1)
    assert set(re.findall(r'"([a-z-]+)>=', extra)) == {"example-robot-data", "trimesh", "pycollada"}
