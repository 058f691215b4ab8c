"""The model files: geometry against Franka's published DH table, limits, inertias, filters, mounts."""

import itertools
import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from pydrake.geometry import SceneGraphInspector
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.framework import DiagramBuilder

from drake_blfdmp.errors import TaskError
from drake_blfdmp.robot import models
from drake_blfdmp.robot.clearance import SECOND_NEIGHBOURS
from drake_blfdmp.robot.plant import ARMS, AddDualPanda, ArmActuators, MakeKinematicPlant, ReadJointLimits

# Franka's table, modified DH: a, d in m, alpha in quarter turns; the last row is the flange.
DH = (
    (0.0, 0.333, 0),
    (0.0, 0.0, -1),
    (0.0, 0.316, 1),
    (0.0825, 0.0, 1),
    (-0.0825, 0.384, -1),
    (0.0, 0.0, 1),
    (0.088, 0.0, 1),
    (0.0, 0.107, 0),
)
PALM_BEYOND_FLANGE = 0.06
LOWER = np.array([-2.8973, -1.7628, -2.8973, -3.0718, -2.8973, -0.0175, -2.8973])
UPPER = np.array([2.8973, 1.7628, 2.8973, -0.0698, 2.8973, 3.7525, 2.8973])
MASSES = (0.629769, 4.970684, 0.646926, 3.228604, 3.587895, 1.225946, 1.666555, 0.735522)
BASES = {"left_arm": (-0.2, 0.0, 0.4), "right_arm": (0.2, 0.0, 0.4)}


def dh_step(a, d, quarter_turns, theta):
    """One row of the table, written out element by element."""
    ca, sa = (1, 0, -1, 0)[quarter_turns % 4], (0, 1, 0, -1)[quarter_turns % 4]
    c, s = np.cos(theta), np.sin(theta)
    return np.array(
        [
            [c, -s, 0, a],
            [s * ca, c * ca, -sa, -sa * d],
            [s * sa, c * sa, ca, ca * d],
            [0, 0, 0, 1],
        ]
    )


def dh_frames(q, base):
    """(9, 4, 4): links 1-7, the flange, the palm, in W."""
    transform = np.array([[0, -1, 0, base[0]], [1, 0, 0, base[1]], [0, 0, 1, base[2]], [0, 0, 0, 1.0]])
    frames = []
    for (a, d, quarter_turns), theta in zip(DH, (*q, 0.0), strict=True):
        transform = transform @ dh_step(a, d, quarter_turns, theta)
        frames.append(transform)
    frames.append(transform @ dh_step(0, PALM_BEYOND_FLANGE, 0, 0))
    return np.array(frames)


@pytest.fixture(scope="module")
def kinematic():
    plant = MakeKinematicPlant()
    return plant, plant.CreateDefaultContext()


@pytest.fixture(scope="module")
def scene():
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=0.0)
    AddDualPanda(plant)
    plant.Finalize()
    diagram = builder.Build()
    return plant, scene_graph, diagram


@settings(max_examples=50, deadline=None)
@given(unit=hnp.arrays(float, 14, elements=st.floats(0, 1)))
def test_links_and_palms_stand_where_the_dh_table_puts_them(kinematic, unit):
    plant, context = kinematic
    q = np.tile(LOWER, 2) + unit * np.tile(UPPER - LOWER, 2)
    plant.SetPositions(context, q)
    names = [*(f"panda_link{k}" for k in range(1, 8)), "flange", "palm"]
    for arm, q_arm in zip(ARMS, (q[:7], q[7:]), strict=True):
        expected = dh_frames(q_arm, BASES[arm])
        instance = plant.GetModelInstanceByName(arm)
        actual = [plant.GetFrameByName(n, instance).CalcPoseInWorld(context).GetAsMatrix4() for n in names]
        np.testing.assert_allclose(actual, expected, atol=1e-9)
        points = {"shoulder": expected[1], "elbow": expected[3], "wrist": expected[5]}
        for name, frame in points.items():
            p = plant.GetFrameByName(name, instance).CalcPoseInWorld(context).translation()
            np.testing.assert_allclose(p, frame[:3, 3], atol=1e-9)


def test_limits_are_the_data_sheets(kinematic):
    plant, _ = kinematic
    limits = ReadJointLimits(plant, [plant.GetModelInstanceByName(arm) for arm in ARMS])
    np.testing.assert_array_equal(limits.lower, np.tile(LOWER, 2))
    np.testing.assert_array_equal(limits.upper, np.tile(UPPER, 2))
    np.testing.assert_array_equal(limits.velocity, np.tile([2.175] * 4 + [2.61] * 3, 2))
    np.testing.assert_array_equal(limits.acceleration, np.tile([15, 7.5, 10, 12.5, 15, 20, 20], 2))
    np.testing.assert_array_equal(limits.effort, np.tile([87] * 4 + [12] * 3, 2))


@pytest.mark.parametrize("arm", ARMS)
def test_masses_and_reflected_inertias(kinematic, arm):
    plant, context = kinematic
    instance = plant.GetModelInstanceByName(arm)
    masses = [plant.GetBodyByName(f"panda_link{k}", instance).default_mass() for k in range(8)]
    np.testing.assert_array_equal(masses, MASSES)
    for index in plant.GetBodyIndices(instance):
        assert plant.get_body(index).CalcSpatialInertiaInBodyFrame(context).IsPhysicallyValid()
    actuators = ArmActuators(plant, instance)
    assert [actuator.joint().name() for actuator in actuators] == [f"panda_joint{k}" for k in range(1, 8)]
    reflected = [actuator.default_reflected_inertia() for actuator in actuators]
    np.testing.assert_allclose(reflected, [0.6057] * 2 + [0.4625] * 2 + [0.2055] * 3, rtol=1e-3)


def test_both_arms_are_the_same_model_on_mirrored_bases(kinematic):
    plant, context = kinematic
    left, right = (plant.GetModelInstanceByName(arm) for arm in ARMS)
    names = [[plant.get_body(i).name() for i in plant.GetBodyIndices(arm)] for arm in (left, right)]
    assert names[0] == names[1]
    # Reflected in the plane x = 0, joints 1, 3, 5 and 7 change sign.
    q = np.array([0.3, -0.4, 0.2, -2.0, 0.5, 1.6, 0.9])
    plant.SetPositions(context, left, q)
    plant.SetPositions(context, right, q * np.array([-1, 1, -1, 1, -1, 1, -1]))
    p = [plant.GetFrameByName("palm", arm).CalcPoseInWorld(context).translation() for arm in (left, right)]
    np.testing.assert_allclose(p[0] * [-1, 1, 1], p[1], atol=1e-12)


def body_pairs_filtered(plant, inspector: SceneGraphInspector, arm):
    """Unordered pairs of body names of one arm whose collisions are filtered."""
    bodies = [plant.get_body(i) for i in plant.GetBodyIndices(arm)]
    pairs = set()
    for a, b in itertools.combinations(bodies, 2):
        geometries = [plant.GetCollisionGeometriesForBody(body)[0] for body in (a, b)]
        if inspector.CollisionFiltered(*geometries):
            pairs.add(frozenset((a.name(), b.name())))
    return pairs


def test_only_joined_links_and_the_knob_are_filtered(scene):
    plant, scene_graph, _ = scene
    joined = {frozenset((f"panda_link{k}", f"panda_link{k + 1}")) for k in range(7)} | {
        frozenset(("panda_link7", "palm"))
    }
    expected = joined | {frozenset(("panda_link5", "panda_link7"))}
    for arm in ARMS:
        filtered = body_pairs_filtered(plant, scene_graph.model_inspector(), plant.GetModelInstanceByName(arm))
        assert filtered == expected
        assert frozenset(("panda_link5", "panda_link0")) not in filtered
        assert frozenset(("panda_link5", "palm")) not in filtered


def test_links_with_one_between_cannot_touch_within_the_limits(scene):
    plant, scene_graph, diagram = scene
    context = diagram.CreateDefaultContext()
    plant_context = plant.GetMyMutableContextFromRoot(context)
    inspector = scene_graph.model_inspector()
    pairs = []
    for a, b in SECOND_NEIGHBOURS:
        bodies = [plant.GetBodyByName(name, plant.GetModelInstanceByName("left_arm")) for name in (a, b)]
        ids = itertools.product(*(plant.GetCollisionGeometriesForBody(body) for body in bodies))
        pairs += [(a, b, *pair) for pair in ids if not inspector.CollisionFiltered(*pair)]
    assert {pair[:2] for pair in pairs} >= {("panda_link0", "panda_link2"), ("panda_link3", "panda_link5")}
    rng = np.random.default_rng(1)
    for _ in range(150):
        plant.SetPositions(plant_context, rng.uniform(np.tile(LOWER, 2), np.tile(UPPER, 2)))
        query = scene_graph.get_query_output_port().Eval(scene_graph.GetMyContextFromRoot(context))
        for a, b, id_a, id_b in pairs:
            distance = query.ComputeSignedDistancePairClosestPoints(id_a, id_b).distance
            assert distance > 0.005, f"{a} and {b} come within {distance} m"


def test_every_file_the_directives_name_exists_and_none_needs_the_network():
    directory = models.ModelsDirectory()
    text = "".join(path.read_text() for path in directory.iterdir() if path.suffix in (".yaml", ".urdf"))
    names = set(re.findall(r"package://(\S+?)/(\S+\.urdf)", text))
    assert names == {("blfdmp_models", "panda_palm.urdf"), ("blfdmp_models", "pedestal.urdf")}
    assert all((directory / name).is_file() for _, name in names)


def test_missing_models_are_reported_in_one_line(monkeypatch, tmp_path):
    monkeypatch.setattr(models, "__file__", str(tmp_path / "a" / "b" / "models.py"))
    with pytest.raises(TaskError, match=r"models are missing .* reinstall") as error:
        models.ModelsDirectory()
    assert "\n" not in str(error.value)


def test_models_are_found_inside_an_installed_package(monkeypatch, tmp_path):
    shipped = tmp_path / "drake_blfdmp" / "_models"
    shipped.mkdir(parents=True)
    (shipped / "dual_panda.dmd.yaml").touch()
    monkeypatch.setattr(models, "__file__", str(tmp_path / "drake_blfdmp" / "robot" / "models.py"))
    assert models.ModelsDirectory() == shipped.resolve()
