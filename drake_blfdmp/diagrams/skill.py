"""The skill's half of the diagram: phase, forcing, transformation, bands, coupler, reshaper."""

from dataclasses import dataclass
from typing import Any

from pydrake.systems.framework import DiagramBuilder, OutputPort, System
from pydrake.systems.primitives import ConstantVectorSource

from drake_blfdmp.skill.bands import Bands
from drake_blfdmp.skill.laws import law as law_named
from drake_blfdmp.skill.laws.primitive import Primitive
from drake_blfdmp.skill.sampled import Gains
from drake_blfdmp.skill.skill import Skill
from drake_blfdmp.systems.blf_coupler import BlfCoupler
from drake_blfdmp.systems.canonical_system import CanonicalSystem
from drake_blfdmp.systems.distance_bands import DistanceBands
from drake_blfdmp.systems.distance_reshaper import DistanceReshaper
from drake_blfdmp.systems.forcing_term import ForcingTerm
from drake_blfdmp.systems.point_coupler import PointCoupler
from drake_blfdmp.systems.transformation_system import TransformationSystem


@dataclass(frozen=True)
class SkillSystems:
    """The systems that `AddSkill` added; the reshaper with the default law only, the point coupler with the others."""

    canonical: System
    forcing: System
    goal: System
    transformation: System
    bands: System
    coupler: System
    reshaper: System | None = None
    point_coupler: System | None = None


def AddSkill(
    builder: DiagramBuilder,
    skill: Skill,
    bands: Bands,
    *,
    law: str = "default",
    gains: Any = None,
    time_step: float = 0.0,
) -> SkillSystems:
    """Add and connect the systems that carry out a skill inside its bands.

    Args:
        builder: receives the systems, named canonical, forcing, goal, transformation, bands, coupler, and reshaper or
            point_coupler.
        skill, bands: what to carry out; the skill's mobility, where it has one, weighs the reshaper.
        law: a name of `skill.laws.LAWS`; with another than "default" the coupler only watches.
        gains: of the law, its defaults if None.
        time_step: 0 for continuous states, otherwise the period of the discrete ones, s.

    Raises:
        ScenarioError: unknown law, or gains that are not safe at this time step.
    """
    chosen = law_named(law)
    canonical = builder.AddNamedSystem(
        "canonical", CanonicalSystem(tau=skill.tau, gamma=skill.gamma, time_step=time_step)
    )
    forcing = builder.AddNamedSystem("forcing", ForcingTerm(skill=skill, time_step=time_step))
    goal = builder.AddNamedSystem("goal", ConstantVectorSource(skill.goal.reshape(18)))
    transformation = builder.AddNamedSystem("transformation", TransformationSystem(skill=skill, time_step=time_step))
    band_system = builder.AddNamedSystem("bands", DistanceBands(bands=bands, tau=skill.tau, gamma=skill.gamma))
    watched = {"gains": gains or Gains(), "time_step": time_step} if law == "default" else {}
    coupler = builder.AddNamedSystem("coupler", BlfCoupler(**watched))

    def connect(source, output, target, inputs=None):
        builder.Connect(source.GetOutputPort(output), target.GetInputPort(inputs or output))

    connect(canonical, "phase", forcing)
    connect(canonical, "phase", band_system)
    connect(forcing, "forcing", transformation)
    builder.Connect(goal.get_output_port(), transformation.GetInputPort("goal"))
    connect(transformation, "position", coupler)
    connect(transformation, "velocity", coupler)
    connect(band_system, "bands", coupler)
    reshaper = point_coupler = None
    if law == "default":
        gains = gains or Gains()
        weights = {} if skill.mobility is None else {"mobility": skill.mobility}
        reshaper = builder.AddNamedSystem(
            "reshaper", DistanceReshaper(law_stiffness=1.0 + gains.k_1 * gains.k_2, **weights)
        )
        connect(coupler, "link_acceleration", reshaper)
    elif law != "none":
        primitive = Primitive(skill.tau, skill.alpha_z)
        point_coupler = builder.AddNamedSystem(
            "point_coupler", PointCoupler(law=chosen, primitive=primitive, gains=gains, time_step=time_step)
        )
        connect(band_system, "bands", point_coupler)
    for source in (reshaper, point_coupler):
        if source is not None:
            for name in ("position", "velocity", "nominal_acceleration"):
                connect(transformation, name, source)
            connect(source, "coupling_acceleration", transformation)
    return SkillSystems(
        canonical, forcing, goal, transformation, band_system, coupler, reshaper=reshaper, point_coupler=point_coupler
    )


def ConnectTempo(builder: DiagramBuilder, skill: SkillSystems, tempo: OutputPort) -> None:
    """Let `tempo` (1), >= 0, run the clock of a skill that was added: of all its systems alike."""
    for system in (skill.canonical, skill.forcing, skill.transformation):
        builder.Connect(tempo, system.GetInputPort("tempo"))
