"""The least squeeze that friction asks for and the largest that the joints allow, each against a direct computation."""

import numpy as np
import pytest
from pydrake.geometry import Cylinder
from pydrake.multibody.math import SpatialForce
from pydrake.multibody.plant import (
    AddMultibodyPlant,
    CalcContactFrictionFromSurfaceProperties,
    CoulombFriction,
    MultibodyPlant,
)
from pydrake.multibody.tree import MultibodyForces
from pydrake.systems.framework import DiagramBuilder

from drake_blfdmp.errors import TaskError
from drake_blfdmp.robot import grasp_force
from drake_blfdmp.robot.contact import ContactPlantConfig
from drake_blfdmp.robot.grasp_force import (
    combined_friction,
    gravity_torque,
    largest_squeeze,
    least_squeeze,
    mean_distance,
    turning_factor,
)
from drake_blfdmp.robot.plant import ARMS, HOME, AddDualPanda, ArmActuators, MakeKinematicPlant

POSTURES = np.array([HOME, (0.245, 0.16, 0.11, -2.345, -1.292, 1.35, -1.127), (0.3, 0.9, -0.6, -1.2, 0.5, 2.4, -1.0)])


def unit_disc(rings=60, spokes=90):
    """Points and shares of area of a disc of radius 1."""
    edges = np.sqrt(np.linspace(0.0, 1.0, rings + 1))
    radius = (2.0 / 3.0) * np.diff(edges**3) / np.diff(edges**2)
    angle = 2.0 * np.pi * (np.arange(spokes) + 0.5) / spokes
    points = radius[:, None, None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    return points.reshape(-1, 2)


@pytest.mark.parametrize("c", [0.0, 0.3, 0.9, 1.0, 1.1, 3.0, 99.0, 101.0])
def test_the_mean_distance_is_that_of_the_discs_points(c):
    points = unit_disc()
    assert mean_distance(c) == pytest.approx(np.linalg.norm(points - [c, 0.0], axis=1).mean(), rel=3e-4)


def test_the_mean_distance_has_no_jump_where_its_form_changes():
    for c in (1.0, 100.0):
        before, after = mean_distance(np.array([c * (1 - 1e-9), c * (1 + 1e-9)]))
        assert after == pytest.approx(before, rel=1e-7)


@pytest.mark.parametrize("offset", [0.005, 0.02, 0.05])
def test_a_centre_anywhere_in_the_plane_bears_no_less(offset):
    """The least of power over speed for every centre of rotation of the whole plane, by brute force."""
    points, share = unit_disc(20, 36), offset / 0.045
    x, y = np.meshgrid(np.linspace(-8.0, 8.0, 161), np.linspace(-4.0, 4.0, 41))
    centre = np.stack([x.ravel(), y.ravel()], axis=-1)
    friction = np.linalg.norm(points - centre[:, None], axis=-1).mean(axis=1)
    with np.errstate(divide="ignore"):
        bears = np.min(friction / np.abs(share - centre[:, 0]))  # The load is vertical, its arm horizontal.
    assert 1.0 / turning_factor(offset, 0.045) == pytest.approx(min(1.0, bears), rel=2e-3)


def test_the_turning_factor_has_its_limits():
    assert turning_factor(0.0) == pytest.approx(1.0, abs=1e-12)
    assert turning_factor(4.5) == pytest.approx(4.5 / (2.0 / 3.0 * 0.045), rel=0.01)
    factors = turning_factor(np.linspace(0.0, 0.1, 50))
    assert factors.shape == (50,) and np.all(np.diff(factors) > 0.0)


def test_the_least_squeeze_is_the_friction_cones_with_the_factor():
    assert least_squeeze(2.0, 0.5, factor=1.0) == pytest.approx(2.0 * 9.81)
    assert least_squeeze(2.0, 0.5, 1.5, factor=1.0) == pytest.approx(2.0 * 11.31)
    assert least_squeeze(2.0, 0.5) == pytest.approx(grasp_force.ARMS_FACTOR * 2.0 * 9.81)
    aside = least_squeeze(2.0, 0.5, offset=0.03, radius=0.06, factor=1.0)
    assert aside == pytest.approx(2.0 * 9.81 * turning_factor(0.03, 0.06))
    assert least_squeeze(np.ones((3, 1)), np.full(4, 0.5), offset=0.01).shape == (3, 4)


@pytest.mark.parametrize(
    ("values", "named"),
    [
        ({"mass": 0.0}, "mass"),
        ({"friction": -0.1}, "friction"),
        ({"friction": np.array([0.5, np.nan])}, "friction"),
        ({"acceleration": -1.0}, "acceleration"),
        ({"offset": np.inf}, "offset"),
        ({"factor": 0.0}, "factor"),
        ({"radius": 0.0}, "radius"),
    ],
)
def test_what_is_out_of_range_is_named(values, named):
    with pytest.raises(TaskError, match=f"least squeeze: {named}"):
        least_squeeze(**{"mass": 1.0, "friction": 0.8} | values)


@pytest.mark.parametrize("pair", [(0.8, 0.8), (0.3, 0.8), (1.5, 0.2)])
def test_friction_is_combined_as_drake_does(pair):
    surfaces = [CoulombFriction(mu, mu) for mu in pair]
    theirs = CalcContactFrictionFromSurfaceProperties(*surfaces).dynamic_friction()
    assert combined_friction(*pair) == pytest.approx(theirs)


def test_the_palm_is_that_of_the_model():
    plant, scene_graph = AddMultibodyPlant(ContactPlantConfig(), DiagramBuilder())
    arms = AddDualPanda(plant)
    plant.Finalize()
    inspector = scene_graph.model_inspector()
    for arm in arms:
        ids = plant.GetCollisionGeometriesForBody(plant.GetBodyByName("palm", arm))
        (pad,) = (i for i in ids if isinstance(inspector.GetShape(i), Cylinder))
        assert inspector.GetShape(pad).radius() == grasp_force.PALM_RADIUS
        friction = inspector.GetProximityProperties(pad).GetProperty("material", "coulomb_friction")
        assert friction.dynamic_friction() == grasp_force.PALM_FRICTION
    np.testing.assert_allclose(plant.gravity_field().gravity_vector(), [0.0, 0.0, -grasp_force.GRAVITY])


@pytest.fixture(scope="module")
def arms():
    """Both arms: a plant as the project makes it, and one with the arms' gravity on."""
    heavy = MultibodyPlant(0.0)
    for arm in AddDualPanda(heavy):
        heavy.set_gravity_enabled(arm, True)
    heavy.Finalize()
    plant = MakeKinematicPlant()
    return plant, plant.CreateDefaultContext(), heavy, heavy.CreateDefaultContext()


def place(arms, name, q):
    """The model instance in both plants, both in that posture."""
    plant, context, heavy, heavy_context = arms
    for each, its in ((plant, context), (heavy, heavy_context)):
        each.SetPositions(its, each.GetModelInstanceByName(name), q)
    return plant.GetModelInstanceByName(name), heavy.GetModelInstanceByName(name)


@pytest.mark.parametrize("name", ARMS)
@pytest.mark.parametrize("q", POSTURES)
def test_gravity_torque_is_drakes_although_gravity_is_off(arms, name, q):
    plant, context, heavy, heavy_context = arms
    arm, its = place(arms, name, q)
    theirs = heavy.GetVelocitiesFromArray(its, heavy.CalcGravityGeneralizedForces(heavy_context))
    np.testing.assert_allclose(gravity_torque(plant, context, arm), theirs, atol=1e-9)
    assert np.abs(theirs).max() > 5.0
    np.testing.assert_allclose(plant.CalcGravityGeneralizedForces(context), 0.0, atol=1e-12)


@pytest.mark.parametrize("name", ARMS)
@pytest.mark.parametrize("q", POSTURES)
@pytest.mark.parametrize("load", [(0.0, 0.0, 0.0), (3.0, -2.0, -20.0)])
def test_with_the_largest_squeeze_one_joint_is_at_its_limit_by_inverse_dynamics(arms, name, q, load):
    plant, context, heavy, heavy_context = arms
    arm, its = place(arms, name, q)
    force = largest_squeeze(plant, context, arm, load)
    assert 20.0 < force < 500.0

    palm = heavy.GetBodyByName("palm", its)
    normal = palm.EvalPoseInWorld(heavy_context).rotation().col(2)
    applied = MultibodyForces(heavy)
    heavy.CalcForceElementsContribution(heavy_context, applied)  # Gravity and the joints' damping, which is at rest.
    palm.AddInForce(
        heavy_context,
        np.zeros(3),
        SpatialForce(np.zeros(3), np.array(load) - force * normal),
        heavy.world_frame(),
        applied,
    )
    torque = heavy.CalcInverseDynamics(heavy_context, np.zeros(heavy.num_velocities()), applied)
    effort = np.array([actuator.effort_limit() for actuator in ArmActuators(heavy, its)])
    share = np.abs(heavy.GetVelocitiesFromArray(its, torque)) / effort
    assert share.max() == pytest.approx(1.0, abs=1e-9)


def test_without_its_own_weight_an_arm_is_held_by_the_wrist(arms):
    """At home the palm's normal passes the wrist's sixth axis at 0.088 m, whose joint has 12 N m."""
    plant, context, _, _ = arms
    arm, _ = place(arms, "right_arm", np.array(HOME))
    assert largest_squeeze(plant, context, arm, gravity=False) == pytest.approx(12.0 / 0.088, rel=1e-6)


def test_an_arm_that_cannot_bear_the_load_cannot_squeeze(arms):
    plant, context, _, _ = arms
    arm, _ = place(arms, "left_arm", np.array(HOME))
    assert largest_squeeze(plant, context, arm, (0.0, 0.0, -2000.0)) == 0.0
    with pytest.raises(TaskError, match="load"):
        largest_squeeze(plant, context, arm, (0.0, 0.0))
    with pytest.raises(TaskError, match="load"):
        largest_squeeze(plant, context, arm, (0.0, 0.0, np.nan))
