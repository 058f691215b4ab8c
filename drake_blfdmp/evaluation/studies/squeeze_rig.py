"""Two of the robot's palms on rails press on a box with a set force, and may be lifted: pads and friction alone.

The rig's frame is that of a carriage on a vertical rail, at z = 0 before the lift; axes as in W. The palms slide along
x on the carriage, faces towards each other; whatever they touch with (shapes, moduli, friction) is taken from the model
of the arm. No gravity acts on carriage and palms, as none does on the simulated arms.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from pydrake.geometry import ProximityProperties
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import AddMultibodyPlant, MultibodyPlant
from pydrake.multibody.tree import (
    FixedOffsetFrame,
    ModelInstanceIndex,
    PdControllerGains,
    PrismaticJoint,
    RigidBody,
    SpatialInertia,
)
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, DiagramBuilder
from pydrake.systems.primitives import TrajectorySource
from pydrake.trajectories import PiecewisePolynomial

from drake_blfdmp.errors import TaskError
from drake_blfdmp.evaluation.studies.squeeze_metrics import Limits, Patch, creep, least_that_holds, polygon_area
from drake_blfdmp.robot.box import AddBox, BoxParameters
from drake_blfdmp.robot.contact import TIME_STEP, ContactPlantConfig, palm_forces
from drake_blfdmp.robot.models import PACKAGE_NAME, MakeParser
from drake_blfdmp.skill.profiles import smooth_step

SAMPLE_S = 0.1
"""Between two readings of the box's place, s."""

SETTLE_S = 0.2
"""What the contact is given to settle before creep counts, s."""

LIFT_AT = 0.3
"""When a lift begins, s."""

GONE_M, GONE_RAD = 5e-3, np.radians(5.0)
"""A box that has moved this far in the palms will not be held any more."""

_CARRIAGE_KG = 50.0
_CARRIAGE_GAINS = PdControllerGains(p=1e7, d=1e5)
_RAIL_DAMPING = 500.0  # N s/m: about critical for a palm of 0.25 kg on its pad; without effect on what is at rest.


@dataclass(frozen=True)
class Pad:
    """A palm's pad as the model of the arm has it: lengths in m, modulus in Pa.

    `hint` is the length asked of the mesh's edges; friction is dynamic.
    """

    radius: float
    thickness: float
    modulus: float
    hint: float
    friction: float

    @property
    def depth(self) -> float:
        """From the face to where the pressure field has its greatest value, m: half the thickness."""
        return 0.5 * self.thickness

    @property
    def area(self) -> float:
        """Of the face as it is meshed, m^2."""
        return polygon_area(self.radius, self.hint)


@dataclass(frozen=True)
class Lift:
    """A smooth lift: `height`, m, with accelerations of up to `acceleration`, m/s^2, up and then down."""

    height: float = 0.25
    acceleration: float = 1.5

    @property
    def duration_s(self) -> float:
        """Of the lift, s: the smooth step's second derivative is at most 10/sqrt(3)."""
        return float(np.sqrt(10.0 / np.sqrt(3.0) * self.height / self.acceleration))


@dataclass(frozen=True)
class Hold:
    """The box between the palms, read every `SAMPLE_S`.

    Attributes:
        t: (N,) s.
        moved: (N, 3) how far the box's point that was on the palms' axis has moved in the rig's frame, m.
        turned: (N,) rotation about the palms' axis, rad.
        force: (2,) normal force of the palms at the end, N.
        held: to the end, and within the limits asked for.
    """

    t: np.ndarray
    moved: np.ndarray
    turned: np.ndarray
    force: np.ndarray
    held: bool

    def creep(self) -> tuple[float, float]:
        """Greatest speeds of slip, m/s, and pivot, rad/s, once the contact has settled."""
        return creep(self.t, self.moved, self.turned, SETTLE_S)


class SqueezeRig:
    """One box between two palms; every trial starts anew, in touch and at the estimated depth.

    Args:
        box: its `friction` is the box's own.
        centre: (2,) y, z of the box's centre from the palms' axis, m.
        lift: of the carriage; None leaves it at rest.
        modulus: of both pads, Pa; None takes the model's.
        time_step: of the plant, s.
    """

    def __init__(
        self,
        box: BoxParameters,
        centre: tuple[float, float] = (0.0, 0.0),
        lift: Lift | None = None,
        modulus: float | None = None,
        time_step: float = TIME_STEP,
    ):
        builder = DiagramBuilder()
        plant, _ = AddMultibodyPlant(ContactPlantConfig(time_step), builder)
        carriage_instance = plant.AddModelInstance("carriage")
        carriage = plant.AddRigidBody(
            "carriage", carriage_instance, SpatialInertia.SolidBoxWithMass(_CARRIAGE_KG, 0.1, 0.1, 0.1)
        )
        rail = plant.AddJoint(PrismaticJoint("rail", plant.world_frame(), carriage.body_frame(), [0, 0, 1]))
        plant.AddJointActuator("rail", rail).set_controller_gains(_CARRIAGE_GAINS)
        self._palms = plant.AddModelInstance("palms")
        self.pad, add_palm = _palm_of_the_model(modulus)
        self._bodies, self._slides = [], []
        for name, side in (("left", 1), ("right", -1)):
            palm = add_palm(plant, self._palms, f"{name}_palm")
            # The slide's zero is where the face touches the box; its axis is the palm's normal.
            X_CM = RigidTransform(RotationMatrix.MakeYRotation(side * np.pi / 2), [-side * 0.5 * box.width, 0, 0])
            mount = plant.AddFrame(FixedOffsetFrame(f"{name}_mount", carriage.body_frame(), X_CM))
            slide = plant.AddJoint(
                PrismaticJoint(f"{name}_slide", mount, palm.body_frame(), [0, 0, 1], damping=_RAIL_DAMPING)
            )
            plant.AddJointActuator(slide.name(), slide)
            self._bodies.append(palm)
            self._slides.append(slide)
        self._box = AddBox(plant, box)
        for instance in (carriage_instance, self._palms):
            plant.set_gravity_enabled(instance, False)
        plant.Finalize()
        path = builder.AddSystem(TrajectorySource(_path(lift), output_derivative_order=1))
        builder.Connect(path.get_output_port(), plant.get_desired_state_input_port(carriage_instance))
        self._plant, self._carriage = plant, carriage
        self._simulator = Simulator(builder.Build())
        self._p_BAxis = -np.array([0.0, *centre])

    def hold(self, force: float, seconds: float, limits: Limits | None = None) -> Hold:
        """Press with `force`, N, on both sides for `seconds`, or until the box is lost or creeps beyond the limits."""
        context = self._start(force)
        t, moved, turned, held = [0.0], [np.zeros(3)], [0.0], True
        while held and t[-1] < seconds - 1e-9:
            t.append(min(t[-1] + SAMPLE_S, seconds))
            self._simulator.AdvanceTo(t[-1])
            X_CB = self._box.body_frame().CalcPose(context, self._carriage.body_frame())
            moved.append(X_CB.multiply(self._p_BAxis))
            turned.append(float(X_CB.rotation().ToRollPitchYaw().roll_angle()))
            held = bool(np.linalg.norm(moved[-1]) < GONE_M and abs(turned[-1]) < GONE_RAD)
            if held and limits is not None:
                slip, pivot = creep(t, moved, turned, SETTLE_S)
                held = slip <= limits.slip and pivot <= limits.pivot
        return Hold(np.array(t), np.array(moved), np.array(turned), self._forces(context), held)

    def least(self, guess: float, seconds: float, limits: Limits) -> tuple[float, Hold]:
        """The least force, N, that holds for `seconds`, looked for from `guess` on, and the hold with it.

        Raises:
            BlfDmpError: none is found near the guess.
        """
        held: dict[float, Hold] = {}

        def holds(force: float) -> bool:
            held[force] = self.hold(force, seconds, limits)
            return held[force].held

        force = least_that_holds(holds, guess)
        return force, held[force]

    def press(self, force: float, seconds: float = 0.3) -> tuple[np.ndarray, Patch]:
        """How deep, m, each palm (2,) sits in the box after pressing with `force`, N, and the left palm's patch.

        Raises:
            TaskError: the palms do not touch the box after all.
        """
        context = self._start(force)
        self._simulator.AdvanceTo(seconds)
        results = self._plant.get_contact_results_output_port().Eval(context)
        left = set(self._plant.GetCollisionGeometriesForBody(self._bodies[0]))
        for i in range(results.num_hydroelastic_contacts()):
            surface = results.hydroelastic_contact_info(i).contact_surface()
            if surface.id_M() in left or surface.id_N() in left:
                faces = range(surface.num_faces())
                area = np.array([surface.area(f) for f in faces])
                # Centroids in the plane of the palm, from its axis.
                point = np.array([surface.centroid(f) for f in faces])[:, 1:]
                # The field's own vertices have the pressure; a plane field's greatest value is at one of them.
                field = surface.poly_e_MN()
                pressure = max(field.EvaluateAtVertex(v) for v in range(surface.num_vertices()))
                depth = np.array([slide.get_translation(context) for slide in self._slides])
                return depth, Patch(area, point, float(pressure), float(self._forces(context)[0]))
        raise TaskError(f"squeeze rig: the palms do not touch the box at {force:g} N")

    def _start(self, force: float) -> Context:
        """A new start: palms as deep as estimated, the box still; the plant's context."""
        root = self._simulator.get_system().CreateDefaultContext()
        self._simulator.reset_context(root)
        context = self._plant.GetMyMutableContextFromRoot(root)
        depth = force * self.pad.depth / (self.pad.modulus * self.pad.area)
        for slide in self._slides:
            slide.set_translation(context, depth)
        self._plant.SetFreeBodyPose(context, self._box, RigidTransform(-self._p_BAxis))
        self._plant.get_actuation_input_port(self._palms).FixValue(context, [force, force])
        self._simulator.Initialize()
        return context

    def _forces(self, context) -> np.ndarray:
        results = self._plant.get_contact_results_output_port().Eval(context)
        return palm_forces(results, self._bodies, self._box)


def _path(lift: Lift | None) -> PiecewisePolynomial:
    """Height of the carriage over time."""
    if lift is None:
        return PiecewisePolynomial.FirstOrderHold([0.0, 1.0], np.zeros((1, 2)))
    u = np.linspace(0.0, 1.0, 201)
    height, rate = (lift.height * part[None] for part in smooth_step(u)[:2])
    return PiecewisePolynomial.CubicHermite(LIFT_AT + lift.duration_s * u, height, rate / lift.duration_s)


def _palm_of_the_model(
    modulus: float | None,
) -> tuple[Pad, Callable[[MultibodyPlant, ModelInstanceIndex, str], RigidBody]]:
    """The pad of the arm's model, and what adds a palm like the model's to another plant."""
    plant, scene_graph = AddMultibodyPlant(ContactPlantConfig(), DiagramBuilder())
    (arm,) = MakeParser(plant).AddModelsFromUrl(f"package://{PACKAGE_NAME}/panda_palm.urdf")
    plant.Finalize()
    inspector = scene_graph.model_inspector()
    model = plant.GetBodyByName("palm", arm)
    parts, pad = [], None
    for geometry in plant.GetCollisionGeometriesForBody(model):
        shape, properties = (
            inspector.GetShape(geometry),
            ProximityProperties(inspector.GetProximityProperties(geometry)),
        )
        if properties.HasProperty("hydroelastic", "hydroelastic_modulus"):
            if modulus is not None:
                properties.UpdateProperty("hydroelastic", "hydroelastic_modulus", modulus)
            pad = Pad(
                radius=shape.radius(),
                thickness=shape.length(),
                modulus=properties.GetProperty("hydroelastic", "hydroelastic_modulus"),
                hint=properties.GetProperty("hydroelastic", "resolution_hint"),
                friction=properties.GetProperty("material", "coulomb_friction").dynamic_friction(),
            )
        parts.append((inspector.GetPoseInFrame(geometry), shape, inspector.GetName(geometry), properties))
    if pad is None:
        raise TaskError("squeeze rig: the palm of panda_palm.urdf has no compliant pad")
    inertia = model.default_spatial_inertia()

    def add(other: MultibodyPlant, instance: ModelInstanceIndex, name: str) -> RigidBody:
        body = other.AddRigidBody(name, instance, inertia)
        for X_BG, shape, part, properties in parts:
            other.RegisterCollisionGeometry(body, X_BG, shape, f"{name}_{part}", properties)
        return body

    return pad, add
