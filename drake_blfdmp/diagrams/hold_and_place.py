"""The whole diagram: skill, retargeting, inverse kinematics, and two Frankas, with a box where the plan has one."""

from dataclasses import dataclass

import numpy as np
from pydrake.geometry import SceneGraph
from pydrake.multibody.plant import AddMultibodyPlant, MultibodyPlant
from pydrake.multibody.tree import ModelInstanceIndex, RigidBody
from pydrake.systems.framework import Context, Diagram, DiagramBuilder, OutputPort, System
from pydrake.systems.primitives import ConstantVectorSource

from drake_blfdmp.diagrams.feedback import AddHandsObserver, AddTempo
from drake_blfdmp.diagrams.skill import AddSkill, SkillSystems
from drake_blfdmp.planning.plan import Plan
from drake_blfdmp.planning.task import LawGains
from drake_blfdmp.robot.box import AddBox, AddTable
from drake_blfdmp.robot.contact import ContactPlantConfig, palm_bodies
from drake_blfdmp.robot.kinematics import DualArmKinematics
from drake_blfdmp.robot.meshes import ShowMeshes
from drake_blfdmp.robot.plant import (
    DEFAULT_DAMPING,
    DEFAULT_STIFFNESS,
    AddDualPanda,
    JointLimits,
    ReadJointLimits,
    SetJointPd,
)
from drake_blfdmp.robot.rigid import rigid
from drake_blfdmp.skill.canonical import time_at
from drake_blfdmp.systems.carry_phase import CarryPhase
from drake_blfdmp.systems.orientation_system import OrientationSystem
from drake_blfdmp.systems.palm_forces import PalmForces
from drake_blfdmp.systems.retargeting import Retargeting
from drake_blfdmp.systems.swivel_differential_ik import SwivelDifferentialIk
from drake_blfdmp.systems.timed_push import TimedPush


@dataclass(frozen=True)
class HoldAndPlace:
    """The parts that `AddHoldAndPlace` added.

    Attributes:
        plan: what is carried out.
        skill: phase to reshaper.
        retargeting, ik: from points to joints.
        plant, scene_graph: two arms, a box, tables.
        arms: model instances, left and right.
        box: the free body; None in a motion without one.
        palm_forces: the monitor of contact forces on it; None without one.
        limits: of the joints.
        tempo: of the skill's clock; None where nothing slows it.
        observer: of the palms' real distance, fed back or not.
        carry_phase: the phase of the carry as measured; None without a box.
        orientation: how what is held turns about the line between the hands; None where no recording tells.
    """

    plan: Plan
    skill: SkillSystems
    retargeting: System
    ik: System
    plant: MultibodyPlant
    scene_graph: SceneGraph
    arms: tuple[ModelInstanceIndex, ...]
    box: RigidBody | None
    palm_forces: System | None
    limits: JointLimits
    tempo: OutputPort | None
    observer: System
    carry_phase: System | None
    orientation: System | None = None


def AddPlannedPlant(
    builder: DiagramBuilder, plan: Plan
) -> tuple[MultibodyPlant, SceneGraph, tuple[ModelInstanceIndex, ...], RigidBody | None]:
    """Add the finalized plant of a plan: both arms under joint PD, the tables and, where there is one, the box.

    What `scenario.reality` says otherwise than the plan believes is so here.
    """
    plant, scene_graph = AddMultibodyPlant(ContactPlantConfig(plan.scenario.simulation.time_step), builder)
    arms = AddDualPanda(plant)
    if plan.scenario.simulation.visuals == "meshes":
        ShowMeshes(plant, scene_graph, arms)
    for table in plan.tables:
        AddTable(plant, table)
    real_box = plan.real_box
    box = None if real_box is None else AddBox(plant, real_box)
    plant.Finalize()
    softer = plan.scenario.reality.stiffness_scale
    SetJointPd(plant, arms, softer * np.array(DEFAULT_STIFFNESS), np.sqrt(softer) * np.array(DEFAULT_DAMPING))
    return plant, scene_graph, arms, box


def AddHoldAndPlace(builder: DiagramBuilder, plan: Plan) -> HoldAndPlace:
    """Add and connect everything between the phase and the arms or the box; recorders and viewers are the caller's.

    Raises:
        ScenarioError: the gains are not safe at the scenario's time step.
    """
    scenario = plan.scenario
    plant, scene_graph, arms, box = AddPlannedPlant(builder, plan)
    limits = ReadJointLimits(plant, arms)

    step = scenario.simulation.skill_time_step
    skill = AddSkill(
        builder,
        plan.task.skill,
        plan.task.bands,
        law=scenario.law,
        gains=LawGains(scenario),
        time_step=step,
    )
    retargeting = builder.AddNamedSystem("retargeting", Retargeting(retarget=plan.retarget))
    ik = builder.AddNamedSystem(
        "ik",
        SwivelDifferentialIk(
            kinematics=DualArmKinematics(),
            limits=limits,
            initial_position=plan.reach.start,
            time_step=step,
            hold_until=plan.settle_s,
            redundancy=scenario.retarget.redundancy,
            mirrored=plan.retarget.elbow_up,
            clearance=scenario.retarget.clearance,
        ),
    )
    for name in ("position", "velocity"):
        builder.Connect(skill.transformation.GetOutputPort(name), retargeting.GetInputPort(name))
    orientation = AddOrientation(builder, plan, skill, retargeting)
    for name in ("palm_poses", "palm_twists", "swivel", "swivel_rate"):
        builder.Connect(retargeting.GetOutputPort(name), ik.GetInputPort(name))
    for arm, name in zip(arms, ("left", "right"), strict=True):
        builder.Connect(ik.GetOutputPort(f"desired_state_{name}"), plant.get_desired_state_input_port(arm))
    _add_push(builder, plan, plant, arms)
    forces = None if box is None else _add_palm_forces(builder, plant, arms, box)
    tempo = AddTempo(builder, plan, plant, arms, skill, retargeting, ik)
    if orientation is not None and tempo is not None:
        builder.Connect(tempo, orientation.GetInputPort("tempo"))
    observer = AddHandsObserver(builder, plan, plant, arms, skill, forces, tempo)
    phase = None if box is None or forces is None else _add_carry_phase(builder, plan, plant, box, forces)
    return HoldAndPlace(
        plan,
        skill,
        retargeting,
        ik,
        plant,
        scene_graph,
        arms,
        box,
        forces,
        limits,
        tempo,
        observer,
        phase,
        orientation,
    )


def AddOrientation(builder: DiagramBuilder, plan: Plan, skill: SkillSystems, retargeting: System) -> System | None:
    """Add the skill's orientation and its goal, and let the palms roll by it; nothing where the skill has none."""
    own = plan.task.skill
    if own.orientation is None:
        return None
    time_step = plan.scenario.simulation.skill_time_step
    orientation = builder.AddNamedSystem("orientation", OrientationSystem(skill=own, time_step=time_step))
    goal = builder.AddNamedSystem("goal_orientation", ConstantVectorSource(own.orientation.goal))
    builder.Connect(skill.canonical.GetOutputPort("phase"), orientation.GetInputPort("phase"))
    builder.Connect(goal.get_output_port(), orientation.GetInputPort("goal_orientation"))
    for name in ("orientation", "angular_velocity"):
        builder.Connect(orientation.GetOutputPort(name), retargeting.GetInputPort(name))
    return orientation


def _add_palm_forces(
    builder: DiagramBuilder, plant: MultibodyPlant, arms: tuple[ModelInstanceIndex, ...], box: RigidBody
) -> System:
    forces = builder.AddNamedSystem("palm_forces", PalmForces(palms=palm_bodies(plant, arms), box=box))
    builder.Connect(plant.get_contact_results_output_port(), forces.GetInputPort("contact_results"))
    return forces


def _add_carry_phase(
    builder: DiagramBuilder, plan: Plan, plant: MultibodyPlant, box: RigidBody, forces: System
) -> System:
    height = plan.real_box.height if plan.real_box is not None else 0.0
    phase = builder.AddNamedSystem("carry_phase", CarryPhase(tables=plan.tables, box_height=height))
    builder.Connect(forces.get_output_port(), phase.GetInputPort("palm_force"))
    builder.Connect(plant.get_state_output_port(box.model_instance()), phase.GetInputPort("box_state"))
    return phase


def _add_push(builder: DiagramBuilder, plan: Plan, plant: MultibodyPlant, arms: tuple[ModelInstanceIndex, ...]) -> None:
    reality = plan.scenario.reality
    if not np.any(reality.push_force):
        return
    palm = palm_bodies(plant, arms)[("left", "right").index(reality.push_arm)]
    push = TimedPush(body=palm, force=reality.push_force, start_s=plan.push_at_s, duration_s=reality.push_duration)
    builder.AddNamedSystem("push", push)
    builder.Connect(push.get_output_port(), plant.get_applied_spatial_force_input_port())


def SetInitialState(parts: HoldAndPlace, diagram: Diagram, context: Context) -> None:
    """Put the arms into the plan's first posture and the box, where there is one, where the hands will take it."""
    plant_context = parts.plant.GetMyMutableContextFromRoot(context)
    start = np.asarray(parts.plan.reach.start)
    for arm, q in zip(parts.arms, (start[:7], start[7:]), strict=True):
        parts.plant.SetPositions(plant_context, arm, q)
    if parts.box is not None:
        parts.plant.SetFreeBodyPose(plant_context, parts.box, rigid(parts.plan.start))


def MakeHoldAndPlace(plan: Plan) -> tuple[Diagram, HoldAndPlace]:
    """The diagram alone, without recorders and viewers, for those who take it apart."""
    builder = DiagramBuilder()
    parts = AddHoldAndPlace(builder, plan)
    return builder.Build(), parts


def SkillClock(parts: HoldAndPlace, context: Context) -> float:
    """How far the skill is on its own clock in a diagram's context, s: behind the time where the tempo was below 1."""
    skill = parts.plan.task.skill
    phase = parts.skill.canonical.GetOutputPort("phase").Eval(parts.skill.canonical.GetMyContextFromRoot(context))
    return float(time_at(np.asarray(phase)[0], skill.tau, skill.gamma))
