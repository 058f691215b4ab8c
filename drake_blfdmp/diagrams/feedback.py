"""Wiring of what the robot's state changes in its motion: the tempo of the skill, the distance between its palms."""

from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import ModelInstanceIndex
from pydrake.systems.framework import DiagramBuilder, OutputPort, System

from drake_blfdmp.diagrams.skill import ConnectTempo, SkillSystems
from drake_blfdmp.planning.plan import Plan
from drake_blfdmp.robot.contact import palm_bodies
from drake_blfdmp.systems.hands_observer import HandsObserver, Squeeze
from drake_blfdmp.systems.phase_stopping import PhaseStopping

Arms = tuple[ModelInstanceIndex, ...]


def AddTempo(
    builder: DiagramBuilder,
    plan: Plan,
    plant: MultibodyPlant,
    arms: Arms,
    skill: SkillSystems,
    retargeting: System,
    ik: System,
) -> OutputPort | None:
    """Let the clock of the skill run as fast as the scenario's `feedback` has it.

    Returns:
        The port of the tempo (1); None where nothing slows the skill.
    """
    feedback = plan.scenario.feedback
    if feedback.phase_stopping:
        stopping = builder.AddNamedSystem(
            "phase_stopping",
            PhaseStopping(
                palms=_palm_indices(plant, arms),
                time_step=plan.scenario.simulation.skill_time_step,
                slack=feedback.slack,
                scale=feedback.scale,
            ),
        )
        builder.Connect(plant.get_body_poses_output_port(), stopping.GetInputPort("body_poses"))
        builder.Connect(ik.GetOutputPort("commanded_palms"), stopping.GetInputPort("commanded_palms"))
        if feedback.tempo:
            builder.Connect(ik.GetOutputPort("tempo"), stopping.GetInputPort("arms_tempo"))
        tempo = stopping.GetOutputPort("tempo")
    elif feedback.tempo:
        tempo = ik.GetOutputPort("tempo")
    else:
        return None
    ConnectTempo(builder, skill, tempo)
    builder.Connect(tempo, retargeting.GetInputPort("tempo"))
    return tempo


def AddHandsObserver(
    builder: DiagramBuilder,
    plan: Plan,
    plant: MultibodyPlant,
    arms: Arms,
    skill: SkillSystems,
    palm_forces: System | None,
    tempo: OutputPort | None,
) -> System:
    """Observe the palms' real distance and, where the scenario wants it, close the default law's loop around it."""
    scenario = plan.scenario
    squeeze = None
    if plan.box is not None and plan.squeeze_compliance is not None:
        squeeze = Squeeze(plan.box.width, plan.squeeze_compliance, scenario.feedback.contact_force)
    observer = builder.AddNamedSystem(
        "hands_observer",
        HandsObserver(
            palms=_palm_indices(plant, arms),
            time_step=scenario.simulation.skill_time_step,
            rate=scenario.feedback.rate,
            largest=scenario.feedback.largest,
            squeeze=squeeze,
            hands_scale=plan.retarget.hands_scale,
            active_from=plan.settle_s,
        ),
    )
    for name in ("position", "velocity"):
        builder.Connect(skill.transformation.GetOutputPort(name), observer.GetInputPort(name))
    builder.Connect(plant.get_body_poses_output_port(), observer.GetInputPort("body_poses"))
    if palm_forces is not None:
        builder.Connect(palm_forces.GetOutputPort("palm_force"), observer.GetInputPort("palm_force"))
    if tempo is not None:
        builder.Connect(tempo, observer.GetInputPort("tempo"))
    if scenario.feedback.hands and scenario.law == "default":
        builder.Connect(observer.GetOutputPort("measured_distance"), skill.coupler.GetInputPort("measured_distance"))
    return observer


def _palm_indices(plant: MultibodyPlant, arms: Arms) -> tuple[int, int]:
    left, right = (int(body.index()) for body in palm_bodies(plant, arms))
    return left, right
