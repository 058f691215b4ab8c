"""What is recorded of a run: its signals, and the systems that make them; docs/mcap_topics.md lists them for people."""

import hashlib
import math
from pathlib import Path

import numpy as np
from pydrake.math import RigidTransform
from pydrake.systems.framework import DiagramBuilder, OutputPort
from pydrake.systems.primitives import Multiplexer

from drake_blfdmp.diagrams.hold_and_place import HoldAndPlace
from drake_blfdmp.evaluation.planned_signals import MakePlannedSignals, PlannedEvents
from drake_blfdmp.evaluation.recorded_signals import ARMS, RunSignals
from drake_blfdmp.evaluation.summary import versions
from drake_blfdmp.planning.plan import Plan
from drake_blfdmp.planning.scenario import DumpScenario
from drake_blfdmp.recording.mcap_recorder import McapRecorder
from drake_blfdmp.recording.planned_signals import ATTACHMENT
from drake_blfdmp.recording.plant_names import plant_names
from drake_blfdmp.recording.topics import VectorTopic
from drake_blfdmp.robot.carry_phases import PHASES
from drake_blfdmp.robot.contact import palm_bodies
from drake_blfdmp.robot.contact_wrenches import ContactPair
from drake_blfdmp.robot.description import MakeSceneDescription
from drake_blfdmp.ros2.messages import MARKERS
from drake_blfdmp.ros2.skeleton_markers import skeleton_numbers, skeleton_template
from drake_blfdmp.systems.contact_wrenches import ContactWrenches
from drake_blfdmp.systems.passed_times import PassedTimes
from drake_blfdmp.systems.skill_clock import SkillClock

GHOST_AT = np.array([0.95, -0.1, 1.4])
"""Where the ghost's shoulders are drawn, m in W: beside the arms, life-size, its feet on the floor."""

PERSON = "person"
"""Name of the person's torso frame, as the ghost is drawn."""

SLOW_RATE = 25.0
"""Of what is only looked at, Hz."""


def AddRecorder(builder: DiagramBuilder, parts: HoldAndPlace, path: Path) -> McapRecorder:
    """Record arms, box, contact and the skill's signals to an MCAP file, from which alone the run can be drawn.

    What the figures need of the plan is attached at once, so that a run that is killed can be drawn, too.
    """
    plan, plant = parts.plan, parts.plant
    planned = MakePlannedSignals(plan, parts.limits)
    recorder = McapRecorder.AddToBuilder(
        filename=path,
        builder=builder,
        plant=plant,
        arms=[plant.GetModelInstanceName(arm) for arm in parts.arms],
        rate=plan.scenario.simulation.record_rate_hz,
        static_frames={PERSON: RigidTransform(GHOST_AT - plan.retarget.person)},  # pyright: ignore[reportArgumentType, reportCallIssue]
        robot_description=MakeSceneDescription(plan.box, plan.tables),
        metadata=_metadata(parts),
    )
    recorder.set_name("recorder")
    recorder.AddAttachment(ATTACHMENT, planned.to_bytes(), "application/octet-stream")
    signals = RunSignals(parts, planned)
    for name, slow in (("signals", False), ("slow_signals", True)):
        some = [signal for signal in signals if signal.slow == slow]
        topics = [
            VectorTopic(
                one.name,
                one.elements,
                one.unit,
                single_precision=not one.exact,
                size=sum(port.size() for port in one.ports),
                make=one.make,
                bodies=one.bodies,
            )
            for one in some
        ]
        port = recorder.AddVectorInputs(name, topics, every=_every(plan) if slow else 1)
        builder.Connect(_together(builder, f"recorded_{name}", *(port for one in some for port in one.ports)), port)
    _add_contact(builder, parts, recorder)
    _add_skeleton(builder, parts, recorder)
    _add_events(builder, parts, recorder)
    return recorder


def _palm_frames(parts: HoldAndPlace) -> dict[str, str]:
    """Arm -> name under which its palm is recorded."""
    arms = [parts.plant.GetModelInstanceName(arm) for arm in parts.arms]
    names = {index: name for name, index in plant_names(parts.plant, arms).bodies.items()}
    palms = palm_bodies(parts.plant, parts.arms)
    return {arm: names[int(palm.index())] for arm, palm in zip(ARMS, palms, strict=True)}


def _metadata(parts: HoldAndPlace) -> dict[str, object]:
    """The record "run": what the run was, and the names of its palms and events."""
    plan = parts.plan
    scenario = plan.scenario
    simulation = scenario.simulation
    return {
        "scenario": scenario.name,
        "scenario_sha256": hashlib.sha256(DumpScenario(scenario).encode()).hexdigest(),
        "seed": scenario.seed,
        "synthetic": plan.source.recording.synthetic,
        "law": scenario.law,
        "kind": "motion" if plan.box is None else "box",
        "time_step_s": simulation.time_step,
        "skill_time_step_s": simulation.skill_time_step,
        "record_rate_hz": simulation.record_rate_hz,
        "duration_s": plan.duration_s,
        "tau_s": plan.task.skill.tau,
        "gamma": plan.task.skill.gamma,
        **{f"{arm}_palm": frame for arm, frame in _palm_frames(parts).items()},
        **{f"version_{name}": value for name, value in versions().items()},
        **{f"event_{name}": t for name, t in PlannedEvents(plan)},
        **({} if plan.box is None else {f"carry_phase_{number}": name for number, name in enumerate(PHASES)}),
    }


def _every(plan: Plan) -> int:
    """Of how many samples one is recorded of what is slow."""
    return math.ceil(plan.scenario.simulation.record_rate_hz / SLOW_RATE - 1e-9)


def _together(builder: DiagramBuilder, name: str, *ports: OutputPort) -> OutputPort:
    """One port of several, in their order."""
    joined = builder.AddNamedSystem(name, Multiplexer([port.size() for port in ports]))
    for k, port in enumerate(ports):
        builder.Connect(port, joined.get_input_port(k))
    return joined.get_output_port()


def _add_contact(builder: DiagramBuilder, parts: HoldAndPlace, recorder: McapRecorder) -> None:
    """What the box does to each palm, and the tables to the box."""
    if parts.box is None:
        return
    plant, box, palms = parts.plant, parts.box, palm_bodies(parts.plant, parts.arms)
    tables = tuple(plant.GetBodyByName(table.name) for table in parts.plan.tables)
    pairs = {f"{arm}_palm": ContactPair(palm, (box,)) for arm, palm in zip(ARMS, palms, strict=True)}
    pairs["box"] = ContactPair(box, tables)
    frames = {f"{arm}_palm": frame for arm, frame in _palm_frames(parts).items()} | {"box": box.name()}
    wrenches = builder.AddNamedSystem("contact_wrenches", ContactWrenches(pairs=list(pairs.values())))
    builder.Connect(plant.get_contact_results_output_port(), wrenches.GetInputPort("contact_results"))
    topics = {f"contact/{name}": frames[name] for name in pairs}
    bodies = [int(pair.body.index()) for pair in pairs.values()]
    port = recorder.AddWrenchInputs("contact", topics, bodies=bodies, single_precision=True, every=_every(parts.plan))
    builder.Connect(wrenches.get_output_port(), port)


def _add_skeleton(builder: DiagramBuilder, parts: HoldAndPlace, recorder: McapRecorder) -> None:
    skill = parts.skill
    shown = skill.transformation.GetOutputPort("position"), skill.coupler.GetOutputPort("margin")
    port = _together(builder, "points_and_margin", *shown)
    template, every = skeleton_template(PERSON), _every(parts.plan)
    wanted = recorder.AddTemplateInput("skeleton", port.size(), MARKERS, template, skeleton_numbers, every=every)
    builder.Connect(port, wanted)


def _add_events(builder: DiagramBuilder, parts: HoldAndPlace, recorder: McapRecorder) -> None:
    """The phases of the carry as they are recognised, or a motion's start and end as the skill reaches them."""
    if parts.carry_phase is not None:
        number, names = parts.carry_phase.get_output_port(), PHASES
    else:
        planned, skill = PlannedEvents(parts.plan), parts.plan.task.skill
        clock = builder.AddNamedSystem("skill_clock", SkillClock(tau=skill.tau, gamma=skill.gamma)).get_output_port()
        builder.Connect(parts.skill.canonical.GetOutputPort("phase"), clock.get_system().GetInputPort("phase"))
        passed = builder.AddNamedSystem("passed_times", PassedTimes(times=[t for _, t in planned]))
        builder.Connect(clock, passed.get_input_port())
        number, names = passed.get_output_port(), ("", *(name for name, _ in sorted(planned, key=lambda one: one[1])))
    builder.Connect(number, recorder.AddEventInput("event_number", names))
