"""A box held between two palms at rest: what follows from the pads alone, from equilibrium, from friction's limit."""

import re
from pathlib import Path

import numpy as np
import pytest
from pydrake.multibody.tree import JacobianWrtVariable

from drake_blfdmp.robot import held_box
from drake_blfdmp.robot.grasp_force import GRAVITY, PALM_RADIUS, least_squeeze
from drake_blfdmp.robot.held_box import CarryQuasiStatically, HeldBox
from drake_blfdmp.robot.pad_points import FOUNDATION, MakePadPoints
from drake_blfdmp.robot.plant import ARMS, ArmActuators, MakeKinematicPlant

PALM = Path(__file__).resolve().parents[2] / "models" / "panda_palm.urdf"
STIFF = np.full(7, 1e9)
WIDTH, FRICTION = 0.3, 0.6
HEXAGON = 1.5 * np.sqrt(3.0) * PALM_RADIUS**2


@pytest.fixture(scope="module")
def plant():
    return MakeKinematicPlant()


@pytest.fixture(scope="module")
def postures(default_plan):
    """Of the default run's carry, a few."""
    first, last = default_plan.task.held
    # The samples were taken before the motion was slowed down.
    t = default_plan.stretch * default_plan.scenario.simulation.skill_time_step * default_plan.reach.samples
    return default_plan.reach.following.q[(t >= first) & (t <= last)][::4]


def box(mass=1e-9, friction=FRICTION, centre=(0.0, 0.0, 0.0)):
    return HeldBox(WIDTH, mass, friction, np.array(centre))


def palms(plant, q):
    """Poses of the palms, and for each the Jacobian (6, 7) of its arm's joints."""
    context = plant.CreateDefaultContext()
    plant.SetPositions(context, q)
    found = []
    for arm in map(plant.GetModelInstanceByName, ARMS):
        palm, world = plant.GetFrameByName("palm", arm), plant.world_frame()
        J = plant.CalcJacobianSpatialVelocity(context, JacobianWrtVariable.kV, palm, np.zeros(3), world, world)
        columns = [actuator.joint().velocity_start() for actuator in ArmActuators(plant, arm)]
        found.append((palm.CalcPoseInWorld(context), J[:, columns]))
    return found


def test_the_foundation_is_the_models():
    """Drake's pressure of a flat cylinder: the modulus where it is half as deep as it is thick."""
    collision = PALM.read_text().split("drake:compliant_hydroelastic")[0].split("<collision")[-1]
    thickness = float(re.search(r'length="([\d.]+)"', collision)[1])
    modulus = float(re.search(r'hydroelastic_modulus value="([\de.]+)"', PALM.read_text())[1])
    assert modulus / (0.5 * thickness) == pytest.approx(FOUNDATION)


def test_the_pad_is_a_hexagon():
    pad = MakePadPoints(60)
    assert pad.area * len(pad.at) == pytest.approx(HEXAGON)
    np.testing.assert_allclose(pad.at.mean(axis=0), 0.0, atol=1e-12)
    moments = (pad.at[:, :, None] * pad.at[:, None]).sum(axis=0) * pad.area
    np.testing.assert_allclose(moments, 5.0 * np.sqrt(3.0) / 16.0 * PALM_RADIUS**4 * np.eye(2), rtol=0.02, atol=1e-12)
    assert np.abs(pad.at[:, 0]).max() > 0.97 * PALM_RADIUS > np.abs(pad.at[:, 1]).max()  # A vertex lies on x.


@pytest.mark.parametrize("depth", [2e-5, 1e-4])
def test_stiff_arms_press_with_the_pads_alone(plant, postures, depth):
    hold = CarryQuasiStatically(plant, postures, np.full(len(postures), depth), box(), stiffness=STIFF)
    np.testing.assert_allclose(hold.force, FOUNDATION * HEXAGON * depth, rtol=1e-3)
    np.testing.assert_allclose(hold.centre, 0.0, atol=1e-4)
    assert not hold.lost and (hold.touching == 1.0).all()


@pytest.mark.parametrize("share", [0.95, 1.05])
def test_stiff_arms_hold_what_friction_holds(plant, postures, share):
    """m g = 2 mu F, with a centre of mass on the palms' axis."""
    mass, depth = 3.0, 1e-4
    friction = share * mass * GRAVITY / (2.0 * FOUNDATION * HEXAGON * depth)
    hold = CarryQuasiStatically(plant, postures[:1], np.array([depth]), box(mass, friction), stiffness=STIFF)
    assert hold.lost == (share < 1.0)


@pytest.mark.parametrize(("share", "lost"), [(0.9, True), (1.25, False)])
def test_a_centre_of_mass_aside_takes_the_force_that_turning_takes(plant, postures, share, lost):
    """As `least_squeeze`, whose disc is a little larger than the hexagon."""
    (left, _), (right, _) = palms(plant, postures[0])
    line = right.translation() - left.translation()
    aside = 0.02 * np.cross([0.0, 0.0, 1.0], line / np.linalg.norm(line))
    needed = least_squeeze(2.0, FRICTION, offset=0.02, factor=1.0)
    depth = share * float(needed) / (FOUNDATION * HEXAGON)
    hold = CarryQuasiStatically(plant, postures[:1], np.array([depth]), box(2.0, FRICTION, aside), stiffness=STIFF)
    assert hold.lost == lost


def test_box_and_joints_are_in_equilibrium(plant, postures):
    """Forces and moments on the box add up to none; each motor's effort is what the palm's wrench asks of it."""
    mass, centre = 2.0, np.array([0.01, 0.02, -0.03])
    up = np.array([0.3, -0.2, 0.4])
    depths, accelerations = np.full(len(postures), 0.013), np.tile(up, (len(postures), 1))
    hold = CarryQuasiStatically(plant, postures, depths, box(mass, centre=centre), accelerations)
    assert not hold.lost and len(hold.force) == len(postures)
    for k, q in enumerate(postures):
        found = palms(plant, q)
        middle = 0.5 * (found[0][0].translation() + found[1][0].translation())
        force, moment = mass * (np.array([0.0, 0.0, -GRAVITY]) - up), np.zeros(3)
        moment += np.cross(centre, force)
        for arm, (X_WP, J) in enumerate(found):
            R = X_WP.rotation().matrix()
            # What the palm does to the box, at the palm's origin.
            push = R @ [*hold.shear[k, arm], hold.force[k, arm]]
            at = R @ [*hold.centre[k, arm], 0.0]
            twist = np.cross(at, hold.force[k, arm] * R[:, 2]) + hold.torsion[k, arm] * R[:, 2]
            force += push
            moment += twist + np.cross(X_WP.translation() - middle, push)
            effort = J.T @ np.concatenate([twist, push])
            np.testing.assert_allclose(hold.effort[k, 7 * arm : 7 * arm + 7], effort, atol=2e-3)
        np.testing.assert_allclose(force, 0.0, atol=2e-3)
        np.testing.assert_allclose(moment, 0.0, atol=2e-3)


def test_nothing_is_there_of_a_box_that_is_lost_at_once(plant, postures):
    hold = CarryQuasiStatically(plant, postures, np.full(len(postures), 0.01), box(20.0))
    assert hold.lost and hold.force.shape == (0, 2) and hold.effort.shape == (0, 14)


@pytest.mark.parametrize("factor", [0.2, 5.0])
@pytest.mark.parametrize("name", ["VISCOSITY", "THINNEST"])
def test_what_is_found_does_not_depend_on_the_viscosity_it_is_found_with(plant, postures, monkeypatch, name, factor):
    depths, turning = np.full(len(postures), 0.013), box(2.0, centre=(0.01, 0.02, -0.03))
    usual = CarryQuasiStatically(plant, postures, depths, turning)
    monkeypatch.setattr(held_box, name, factor * getattr(held_box, name))
    other = CarryQuasiStatically(plant, postures, depths, turning)
    assert not usual.lost and not other.lost
    np.testing.assert_allclose(other.force, usual.force, rtol=5e-3)
    np.testing.assert_allclose(other.turned, usual.turned, atol=np.deg2rad(0.05))


def test_palms_that_close_turn_a_box_that_slides_as_they_would_without_a_table(plant, postures, monkeypatch):
    """Arms yield unlike each other: palms move and turn, and the box with them, which the table only keeps upright."""

    def turned(slides):
        hold = CarryQuasiStatically(plant, postures[:1], np.array([0.02]), box(), slides=slides)
        return np.rad2deg(hold.turned[0, 2])

    held, sliding = turned(False), turned(True)
    monkeypatch.setattr(held_box, "TABLE", 0.0)
    assert sliding == pytest.approx(turned(True), rel=0.1) and abs(sliding) > 0.3
    assert abs(held) < 0.5 * abs(sliding)
