"""The simulated arms: gains, tracking, gravity compensation, and a box squeezed and lifted."""

import numpy as np
import pytest
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.inverse_kinematics import InverseKinematics
from pydrake.multibody.plant import AddMultibodyPlant, MultibodyPlant
from pydrake.solvers import Solve
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from drake_blfdmp.errors import TaskError
from drake_blfdmp.robot.box import AddBox, AddTable, BoxParameters, TableParameters
from drake_blfdmp.robot.contact import ContactPlantConfig, palm_bodies, palm_forces, palm_stiffness
from drake_blfdmp.robot.plant import (
    ARMS,
    DEFAULT_DAMPING,
    DEFAULT_STIFFNESS,
    HOME,
    AddDualPanda,
    ArmActuators,
    MakeKinematicPlant,
    ReadJointLimits,
    SetJointPd,
)

BOX = BoxParameters()
TABLE = TableParameters()
BOX_START = np.array([0.0, 0.45, 0.7])
LIFT = 0.1
ROLL = 2.618
NEAR_GRASP = np.array([0.245, 0.16, 0.11, -2.345, -1.292, 1.35, -1.127])
MIRROR = np.array([-1, 1, -1, 1, -1, 1, -1])


class World:
    """Both arms, a table and a box, driven by holding a desired state for a while."""

    def __init__(self, box=BOX):
        builder = DiagramBuilder()
        self.plant, _ = AddMultibodyPlant(ContactPlantConfig(), builder)
        self.arms = AddDualPanda(self.plant)
        AddTable(self.plant, TABLE)
        self.box = AddBox(self.plant, box)
        self.plant.Finalize()
        SetJointPd(self.plant, self.arms)
        self.simulator = Simulator(builder.Build())
        self.root = self.simulator.get_mutable_context()
        self.context = self.plant.GetMyMutableContextFromRoot(self.root)
        self.limits = ReadJointLimits(self.plant, self.arms)
        self.effort_share = 0.0

    def set(self, q, box):
        for arm, q_arm in zip(self.arms, (q[:7], q[7:]), strict=True):
            self.plant.SetPositions(self.context, arm, q_arm)
        self.plant.SetFreeBodyPose(self.context, self.box, RigidTransform(box))

    def follow(self, start, end, duration, steps=25, after_step=None):
        for k in range(1, steps + 1):
            u = k / steps
            q = start + (10 * u**3 - 15 * u**4 + 6 * u**5) * (end - start)
            v = (30 * u**2 - 60 * u**3 + 30 * u**4) / duration * (end - start)
            for i, arm in enumerate(self.arms):
                part = slice(7 * i, 7 * i + 7)
                port = self.plant.get_desired_state_input_port(arm)
                port.FixValue(self.context, np.concatenate([q[part], v[part]]))
            self.simulator.AdvanceTo(self.root.get_time() + duration / steps)
            if after_step is not None:
                after_step(q)
            effort = self.plant.get_net_actuation_output_port().Eval(self.context)
            self.effort_share = max(self.effort_share, np.max(np.abs(effort) / self.limits.effort))

    def forces(self):
        results = self.plant.get_contact_results_output_port().Eval(self.context)
        return palm_forces(results, palm_bodies(self.plant, self.arms), self.box)

    def box_pose(self):
        return self.plant.EvalBodyPoseInWorld(self.context, self.box)


def facing_palms(gap, height, guess):
    """(14,) joint angles with the palms facing each other across `gap`, centred over the table."""
    plant = MakeKinematicPlant()
    ik = InverseKinematics(plant)
    for side, arm in zip((1, -1), ARMS, strict=True):
        z = np.array([side, 0, 0])
        x = np.array([0, 0, 1])
        R_WP = RotationMatrix(np.column_stack([x, np.cross(z, x), z])) @ RotationMatrix.MakeZRotation(side * ROLL)
        X_WP = RigidTransform(R_WP, [-side * gap / 2, BOX_START[1], height])
        palm = plant.GetFrameByName("palm", plant.GetModelInstanceByName(arm))
        for point in (np.zeros(3), np.array([0.1, 0, 0]), np.array([0, 0.1, 0])):
            target = X_WP.multiply(point)
            ik.AddPositionConstraint(palm, point, plant.world_frame(), target - 1e-5, target + 1e-5)
    ik.prog().AddQuadraticErrorCost(0.02 * np.eye(14), guess, ik.q())
    ik.prog().SetInitialGuess(ik.q(), guess)
    result = Solve(ik.prog())
    assert result.is_success()
    return result.GetSolution(ik.q())


@pytest.fixture(scope="module")
def carried():
    """A box squeezed by 10 mm a side, lifted by 0.1 m, and held; what was read on the way."""
    world = World()
    apart = facing_palms(0.34, BOX_START[2], np.concatenate([NEAR_GRASP, MIRROR * NEAR_GRASP]))
    squeeze = facing_palms(BOX.width - 0.02, BOX_START[2], apart)
    high = facing_palms(BOX.width - 0.02, BOX_START[2] + LIFT, squeeze)
    world.set(apart, BOX_START)
    readings = {"squeeze": squeeze}
    world.follow(apart, apart, 0.5)
    readings["drift"] = world.box_pose().translation() - BOX_START
    readings["no_force"] = world.forces()
    world.follow(apart, squeeze, 0.6)
    world.follow(squeeze, squeeze, 0.3)
    readings["force"] = world.forces()
    world.follow(squeeze, high, 0.8)
    world.follow(high, high, 0.4)
    readings["held_force"] = world.forces()
    readings["box"] = world.box_pose()
    world.follow(high, high, 0.4)
    readings["box_later"] = world.box_pose()
    return world, readings


def test_a_resting_box_stays_where_it_is(carried):
    _, readings = carried
    np.testing.assert_allclose(readings["drift"], 0, atol=1e-5)
    np.testing.assert_array_equal(readings["no_force"], 0)


def test_both_palms_press_alike_and_within_the_effort_limits(carried):
    world, readings = carried
    left, right = readings["force"]
    assert left == pytest.approx(right, rel=0.02)
    assert 60 < left < 90
    assert readings["held_force"][0] == pytest.approx(readings["held_force"][1], rel=0.02)
    assert world.effort_share < 0.7


def test_palm_stiffness_predicts_the_squeeze(carried):
    _, readings = carried
    plant = MakeKinematicPlant()
    context = plant.CreateDefaultContext()
    plant.SetPositions(context, readings["squeeze"])
    arm = plant.GetModelInstanceByName("left_arm")
    predicted = 0.01 * palm_stiffness(plant, context, arm, DEFAULT_STIFFNESS)
    assert predicted == pytest.approx(readings["force"][0], rel=0.2)


def test_the_box_comes_along_level(carried):
    _, readings = carried
    X_WB = readings["box"]
    # The arms give way under the box's weight by about a millimetre.
    np.testing.assert_allclose(X_WB.translation(), BOX_START + np.array([0, 0, LIFT]), atol=4e-3)
    assert np.degrees(X_WB.rotation().ToAngleAxis().angle()) < 1.0
    np.testing.assert_allclose(readings["box_later"].translation(), X_WB.translation(), atol=1e-4)


def test_forces_count_point_contact_too():
    """With the point model throughout, the same reading holds."""
    builder = DiagramBuilder()
    config = ContactPlantConfig()
    config.contact_model = "point"
    plant, _ = AddMultibodyPlant(config, builder)
    arms = AddDualPanda(plant)
    box = AddBox(plant, BOX)
    plant.Finalize()
    SetJointPd(plant, arms)
    simulator = Simulator(builder.Build())
    context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    apart = facing_palms(0.34, BOX_START[2], np.concatenate([NEAR_GRASP, MIRROR * NEAR_GRASP]))
    squeeze = facing_palms(BOX.width - 0.02, BOX_START[2], apart)
    touching = facing_palms(BOX.width - 0.001, BOX_START[2], apart)
    plant.SetFreeBodyPose(context, box, RigidTransform(BOX_START))
    for arm, part in zip(arms, (slice(0, 7), slice(7, 14)), strict=True):
        plant.SetPositions(context, arm, touching[part])
        plant.get_desired_state_input_port(arm).FixValue(context, np.concatenate([squeeze[part], np.zeros(7)]))
    simulator.AdvanceTo(0.3)
    results = plant.get_contact_results_output_port().Eval(context)
    assert results.num_point_pair_contacts() >= 2 and results.num_hydroelastic_contacts() == 0
    force = palm_forces(results, palm_bodies(plant, arms), box)
    assert force[0] == pytest.approx(force[1], rel=0.05)
    assert 50 < force[0] < 100


def test_arms_float_at_home_and_track_a_free_motion():
    world = World()
    home = np.concatenate([HOME, MIRROR * HOME])
    out_of_the_way = np.array([0.0, 5.0, 0.5])
    world.set(home, out_of_the_way)
    world.follow(home, home, 0.2)
    np.testing.assert_allclose(world.plant.GetPositions(world.context)[:14], home, atol=1e-9)

    # 0.35 m of palm travel at up to 0.4 m/s.
    goal = home + np.concatenate([[0.6, 0.35, 0, 0, 0, 0, 0], [-0.6, 0.35, 0, 0, 0, 0, 0]])
    kinematic = MakeKinematicPlant()
    context = kinematic.CreateDefaultContext()

    def palms(q):
        kinematic.SetPositions(context, q)
        frames = [kinematic.GetFrameByName("palm", kinematic.GetModelInstanceByName(arm)) for arm in ARMS]
        return np.array([frame.CalcPoseInWorld(context).translation() for frame in frames])

    errors, path = [], []

    def compare(q_desired):
        path.append(palms(q_desired))
        errors.append(path[-1] - palms(world.plant.GetPositions(world.context)[:14]))

    world.follow(home, goal, 1.4, steps=700, after_step=compare)
    speed = np.linalg.norm(np.diff(path, axis=0), axis=-1).max() / 0.002
    assert 0.35 < speed < 0.6
    assert np.linalg.norm(errors, axis=-1).max() < 1e-3
    world.follow(goal, goal, 0.3)
    np.testing.assert_allclose(world.plant.GetPositions(world.context)[:14], goal, atol=1e-5)


def test_pd_gains_are_set_per_joint(carried):
    world, _ = carried
    for arm in world.arms:
        gains = [actuator.get_controller_gains() for actuator in ArmActuators(world.plant, arm)]
        np.testing.assert_array_equal([g.p for g in gains], DEFAULT_STIFFNESS)
        np.testing.assert_array_equal([g.d for g in gains], DEFAULT_DAMPING)


@pytest.mark.parametrize(
    ("stiffness", "damping", "message"),
    [
        ([100.0] * 6, DEFAULT_DAMPING, "stiffness.*7 finite"),
        (DEFAULT_STIFFNESS, [-1.0] * 7, "damping.*>= 0"),
        ([0.0] * 7, DEFAULT_DAMPING, "stiffness.*> 0"),
        ([np.nan] * 7, DEFAULT_DAMPING, "stiffness.*finite"),
    ],
)
def test_bad_gains_are_refused(carried, stiffness, damping, message):
    world, _ = carried
    with pytest.raises(TaskError, match=message):
        SetJointPd(world.plant, world.arms, stiffness, damping)


def test_gains_before_finalize_are_refused_not_ignored():
    plant = MultibodyPlant(time_step=0.002)
    arms = AddDualPanda(plant)
    with pytest.raises(TaskError, match="Finalize"):
        SetJointPd(plant, arms)


def test_gravity_acts_on_the_box_alone(carried):
    world, _ = carried
    tau = world.plant.CalcGravityGeneralizedForces(world.context)
    np.testing.assert_array_equal(tau[:14], 0)
    assert tau[-1] == pytest.approx(-9.81 * BOX.mass)


def test_box_inertia_is_a_solid_boxs():
    plant = MultibodyPlant(time_step=0.002)
    body = AddBox(plant, BoxParameters(width=0.3, depth=0.2, height=0.1, mass=2.4))
    plant.Finalize()
    inertia = body.default_spatial_inertia()
    assert inertia.get_mass() == pytest.approx(2.4)
    moments = 0.2 * np.array([0.2**2 + 0.1**2, 0.3**2 + 0.1**2, 0.3**2 + 0.2**2])
    np.testing.assert_allclose(inertia.CalcRotationalInertia().CopyToFullMatrix3(), np.diag(moments), atol=1e-12)


@pytest.mark.parametrize("name", ["width", "depth", "height", "mass", "friction"])
@pytest.mark.parametrize("value", [0.0, -1.0, float("nan"), float("inf")])
def test_impossible_boxes_are_refused(name, value):
    with pytest.raises(TaskError, match=f"box {name}"):
        BoxParameters(**{name: value})


@pytest.mark.parametrize(
    "change", [{"size": (0.0, 0.2)}, {"thickness": -0.1}, {"top_center": (0.0, float("nan"), 0.5)}, {"size": (1.0,)}]
)
def test_impossible_tables_are_refused(change):
    with pytest.raises(TaskError, match="table shelf"):
        TableParameters(name="shelf", **change)
