"""The scene as plain URDF: one tree, the names under which runs are recorded, and the very poses of Drake's plant."""

import xml.etree.ElementTree as ET

import numpy as np
import pytest
from pydrake.geometry import Role
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, MultibodyPlant
from pydrake.systems.framework import DiagramBuilder

from drake_blfdmp.recording.plant_names import plant_names
from drake_blfdmp.robot.box import AddBox, AddTable, BoxParameters, TableParameters
from drake_blfdmp.robot.description import MakeSceneDescription
from drake_blfdmp.robot.plant import ARMS, AddDualPanda

BOX = BoxParameters(width=0.31, depth=0.22, height=0.18)
TABLES = [
    TableParameters(name="table", top_center=(0.1, 0.45, 0.6), size=(0.3, 0.2)),
    TableParameters(name="shelf", top_center=(-0.1, 0.75, 0.9), size=(0.35, 0.25)),
]


@pytest.fixture(scope="module")
def text():
    return MakeSceneDescription(BOX, TABLES)


@pytest.fixture(scope="module")
def scene(text):
    return ET.fromstring(text)


@pytest.fixture(scope="module")
def plant():
    plant = MultibodyPlant(0.0)
    AddDualPanda(plant)
    for table in TABLES:
        AddTable(plant, table)
    AddBox(plant, BOX)
    plant.Finalize()
    return plant


def parsed(text):
    """The description as Drake's own parser reads it, standing on `world`."""
    plant = MultibodyPlant(0.0)
    Parser(plant=plant).AddModelsFromString(text, "urdf")
    plant.Finalize()
    return plant


def test_links_are_one_tree_below_world(scene):
    links = [link.get("name") for link in scene.findall("link")]
    assert len(set(links)) == len(links)
    children = [joint.find("child").get("link") for joint in scene.findall("joint")]
    parents = [joint.find("parent").get("link") for joint in scene.findall("joint")]
    assert len(set(children)) == len(children)
    assert set(children) | {"world"} == set(links)
    assert set(parents) <= set(links)


def test_bodies_have_the_names_under_which_poses_are_recorded(scene, plant):
    names = plant_names(plant, ARMS)
    links = {link.get("name") for link in scene.findall("link")}
    assert set(names.bodies) | set(names.static_bodies) == links - {"world"}


def test_joints_have_the_names_under_which_states_are_recorded(scene, plant):
    moving = [joint.get("name") for joint in scene.findall("joint") if joint.get("type") == "revolute"]
    recorded = [name for names in plant_names(plant, ARMS).joints.values() for name in names]
    assert sorted(moving) == sorted(recorded)
    assert len(moving) == 14


def test_drake_reads_it_and_its_arms_stand_where_the_plants_do(text, plant):
    other = parsed(text)
    rng = np.random.default_rng(4)
    context, other_context = plant.CreateDefaultContext(), other.CreateDefaultContext()
    for arm in ARMS:
        instance = plant.GetModelInstanceByName(arm)
        for index in range(1, 8):
            name = f"panda_joint{index}"
            angle = rng.uniform(-0.5, 0.0)
            plant.GetJointByName(name, instance).set_angle(context, angle)
            other.GetJointByName(f"{arm}_{name}").set_angle(other_context, angle)
    for arm in ARMS:
        instance = plant.GetModelInstanceByName(arm)
        for index in plant.GetBodyIndices(instance):
            body = plant.get_body(index)
            twin = other.GetBodyByName(f"{arm}_{body.name()}")
            np.testing.assert_allclose(
                other.EvalBodyPoseInWorld(other_context, twin).GetAsMatrix4(),
                plant.EvalBodyPoseInWorld(context, body).GetAsMatrix4(),
                atol=1e-6,
            )
    for table in TABLES:
        pose = other.EvalBodyPoseInWorld(other_context, other.GetBodyByName(table.name))
        np.testing.assert_allclose(pose.translation(), table.top_center, atol=1e-9)


def test_box_and_tables_have_their_sizes(scene):
    sizes = {
        link.get("name"): [float(v) for v in link.find("collision/geometry/box").get("size").split()]
        for link in scene.findall("link")
        if link.find("collision/geometry/box") is not None
    }
    np.testing.assert_allclose(sizes["box"], BOX.size, rtol=1e-5)
    for table in TABLES:
        np.testing.assert_allclose(sizes[table.name], [*table.size, table.thickness], rtol=1e-5)


def test_the_slab_lies_below_its_upper_face(scene):
    for table in TABLES:
        link = next(link for link in scene.findall("link") if link.get("name") == table.name)
        height = float(link.find("visual/origin").get("xyz").split()[2])
        assert height == pytest.approx(-0.5 * table.thickness)


def test_only_the_box_floats(scene):
    floating = [joint for joint in scene.findall("joint") if joint.get("type") == "floating"]
    assert [joint.find("child").get("link") for joint in floating] == ["box"]


def test_nothing_of_drakes_own_is_left(text, scene):
    assert "drake" not in text
    shapes = {geometry[0].tag for geometry in scene.iter("geometry")}
    assert shapes <= {"box", "cylinder", "sphere", "mesh"}
    for geometry in scene.iter("geometry"):
        assert len(geometry) == 1


def test_a_capsule_becomes_a_cylinder_with_a_ball_at_each_end(scene):
    """Ends lie half the cylinder's length along its own axis from its middle."""
    cylinders = 0
    for link in scene.findall("link"):
        parts = {part.get("name"): part for part in [*link.findall("visual"), *link.findall("collision")]}
        for name, part in parts.items():
            top, bottom = parts.get(f"{name}_top"), parts.get(f"{name}_bottom")
            if name is None or top is None:
                continue
            cylinders += 1
            shape = part.find("geometry")[0]
            ends = [np.array([float(v) for v in end.find("origin").get("xyz").split()]) for end in (top, bottom)]
            assert np.linalg.norm(ends[0] - ends[1]) == pytest.approx(float(shape.get("length")), abs=1e-5)
            for end in (top, bottom):
                assert end.find("geometry")[0].get("radius") == shape.get("radius")
    assert cylinders > 0


def test_no_name_of_a_part_appears_twice_in_a_link(scene):
    for link in scene.findall("link"):
        for kind in ("visual", "collision"):
            names = [part.get("name") for part in link.findall(kind) if part.get("name")]
            assert len(set(names)) == len(names)


def test_without_a_box_everything_else_is_the_same(text):
    bare, whole = ET.fromstring(MakeSceneDescription(None, TABLES)), ET.fromstring(text)
    names = [[link.get("name") for link in scene.findall("link")] for scene in (bare, whole)]
    assert [*names[0], "box"] == names[1]
    assert "box" not in {joint.find("child").get("link") for joint in bare.findall("joint")}


def seen(plant, scene_graph, body):
    """Shape, pose and colour of all that is seen of a body, in any order."""
    inspector = scene_graph.model_inspector()
    found = []
    for geometry in inspector.GetGeometries(plant.GetBodyFrameIdOrThrow(body.index()), Role.kIllustration):
        shape, X_BG = inspector.GetShape(geometry), inspector.GetPoseInFrame(geometry).GetAsMatrix4()
        rgba = inspector.GetIllustrationProperties(geometry).GetProperty("phong", "diffuse")
        size = shape.size() if hasattr(shape, "size") else [shape.radius(), shape.length()]
        numbers = [*size, *X_BG.ravel(), rgba.r(), rgba.g(), rgba.b(), rgba.a()]
        found.append((type(shape).__name__, *np.round(numbers, 5) + 0.0))
    return sorted(found)


@pytest.mark.parametrize("name", ["box", "table", "shelf"])
def test_box_and_tables_look_as_in_the_simulation(text, name):
    plants = []
    for described in (False, True):
        plant, scene_graph = AddMultibodyPlantSceneGraph(DiagramBuilder(), 0.0)
        if described:
            Parser(plant=plant).AddModelsFromString(text, "urdf")
        else:
            AddBox(plant, BOX)
            for table in TABLES:
                AddTable(plant, table)
        plant.Finalize()
        plants.append(seen(plant, scene_graph, plant.GetBodyByName(name)))
    assert plants[0] == plants[1] and len(plants[0]) >= 4
