"""What is recorded of a run: its signals, and the systems that make them; docs/mcap_topics.md lists them for people."""

import hashlib
import math
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from pydrake.math import RigidTransform
from pydrake.systems.framework import DiagramBuilder, OutputPort
from pydrake.systems.primitives import Multiplexer

from drake_blfdmp.diagrams.hold_and_place import HoldAndPlace
from drake_blfdmp.evaluation.planned_signals import MakePlannedSignals, PlannedEvents
from drake_blfdmp.evaluation.summary import versions
from drake_blfdmp.planning.plan import Plan
from drake_blfdmp.planning.scenario import DumpScenario
from drake_blfdmp.recording.event_recorder import EventRecorder
from drake_blfdmp.recording.mcap_recorder import McapRecorder
from drake_blfdmp.recording.planned_signals import ATTACHMENT, PlannedSignals
from drake_blfdmp.recording.plant_names import plant_names
from drake_blfdmp.robot.carry_phases import PHASES
from drake_blfdmp.robot.contact import palm_bodies
from drake_blfdmp.robot.contact_wrenches import ContactPair
from drake_blfdmp.robot.description import MakeSceneDescription
from drake_blfdmp.ros2.messages import MARKERS
from drake_blfdmp.ros2.skeleton_markers import SkeletonMarkers
from drake_blfdmp.skeleton import LINKS, POINTS
from drake_blfdmp.systems.arm_swivels import ArmSwivels
from drake_blfdmp.systems.contact_wrenches import ContactWrenches
from drake_blfdmp.systems.link_lengths import ELEMENTS as LINK_LENGTHS
from drake_blfdmp.systems.link_lengths import LinkLengths
from drake_blfdmp.systems.passed_times import PassedTimes
from drake_blfdmp.systems.planned_pose import PlannedPose
from drake_blfdmp.systems.skill_clock import SkillClock

GHOST_AT = np.array([0.95, -0.1, 1.4])
"""Where the ghost's shoulders are drawn, m in W: beside the arms, life-size, its feet on the floor."""

PERSON = "person"
"""Name of the person's torso frame, as the ghost is drawn."""

SLOW_RATE = 25.0
"""Of what is only looked at, Hz."""

_ARMS = ("left", "right")
_POSE = ("qw", "qx", "qy", "qz", "x", "y", "z")
_POINTS = [f"{point}_{axis}" for point in POINTS for axis in "xyz"]
_LINKS = [link.name for link in LINKS]
_JOINTS = [f"{arm}_{joint}" for arm in _ARMS for joint in range(1, 8)]


class Signal(NamedTuple):
    """A topic of named numbers.

    Attributes:
        name: of the topic, without `/`.
        port: whose values it has.
        elements: their names.
        unit: of all, or of each kind.
        slow: recorded at `SLOW_RATE` at most.
        exact: in double precision, where seven digits are not enough.
    """

    name: str
    port: OutputPort
    elements: Sequence[str]
    unit: str
    slow: bool = False
    exact: bool = False


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
    clock = builder.AddNamedSystem(
        "skill_clock", SkillClock(tau=plan.task.skill.tau, gamma=plan.task.skill.gamma)
    ).get_output_port()
    builder.Connect(parts.skill.canonical.GetOutputPort("phase"), clock.get_system().GetInputPort("phase"))
    for signal in _signals(builder, parts, planned, clock):
        port = recorder.AddVectorInput(
            signal.name,
            len(signal.elements),
            signal.elements,
            signal.unit,
            single_precision=not signal.exact,
            every=_every(plan) if signal.slow else 1,
        )
        builder.Connect(signal.port, port)
    _add_contact(builder, parts, recorder)
    _add_skeleton(builder, parts, recorder)
    _add_events(builder, parts, recorder, clock)
    return recorder


def _palm_frames(parts: HoldAndPlace) -> dict[str, str]:
    """Arm -> name under which its palm is recorded."""
    arms = [parts.plant.GetModelInstanceName(arm) for arm in parts.arms]
    names = {index: name for name, index in plant_names(parts.plant, arms).bodies.items()}
    palms = palm_bodies(parts.plant, parts.arms)
    return {arm: names[int(palm.index())] for arm, palm in zip(_ARMS, palms, strict=True)}


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


def _signals(builder: DiagramBuilder, parts: HoldAndPlace, planned: PlannedSignals, clock: OutputPort) -> list[Signal]:
    """Every topic of named numbers."""
    skill = parts.skill
    signals = [
        Signal("phase", skill.canonical.GetOutputPort("phase"), ["s"], "1", exact=True),
        Signal("skill_clock", clock, ["clock"], "s", slow=True),
        Signal("points", skill.transformation.GetOutputPort("position"), _POINTS, "m"),
        Signal("link_lengths", _link_lengths(builder, parts), LINK_LENGTHS, "m"),
        Signal("barrier", skill.coupler.GetOutputPort("barrier"), _LINKS, "1"),
        Signal("margin", skill.coupler.GetOutputPort("margin"), _LINKS, "1"),
        Signal("desired_position", parts.ik.GetOutputPort("position"), _JOINTS, "rad"),
        Signal("task_scale", parts.ik.GetOutputPort("task_scale"), _ARMS, "1"),
        Signal("hands", parts.observer.GetOutputPort("effective_distance"), ["distance"], "m"),
        Signal("swivel", _swivels(builder, parts), [*_ARMS, *(f"{arm}_person" for arm in _ARMS)], "rad", slow=True),
        Signal(
            "planned_palms",
            parts.retargeting.GetOutputPort("palm_poses"),
            [f"{arm}_{part}" for arm in _ARMS for part in _POSE],
            "1, m",
        ),
    ]
    if parts.tempo is not None:
        signals.append(Signal("tempo", parts.tempo, ["tempo"], "1"))
    if parts.orientation is not None:
        signals.append(Signal("turn", parts.orientation.GetOutputPort("orientation"), ["qw", "qx", "qy", "qz"], "1"))
    if parts.palm_forces is not None:
        signals.append(Signal("palm_force", parts.palm_forces.get_output_port(), _ARMS, "N"))
    if parts.carry_phase is not None:
        signals.append(Signal("carry_phase", parts.carry_phase.get_output_port(), ["phase"], "1", slow=True))
    if planned.box is not None:
        box = builder.AddNamedSystem("planned_box", PlannedPose(t=planned.clock, poses=planned.box))
        builder.Connect(clock, box.get_input_port())
        signals.append(Signal("planned_box", box.get_output_port(), _POSE, "1, m", slow=True))
    return signals


def _link_lengths(builder: DiagramBuilder, parts: HoldAndPlace) -> OutputPort:
    lengths = builder.AddNamedSystem("link_lengths", LinkLengths())
    builder.Connect(parts.skill.transformation.GetOutputPort("position"), lengths.GetInputPort("position"))
    builder.Connect(parts.skill.bands.GetOutputPort("bands"), lengths.GetInputPort("bands"))
    return lengths.get_output_port()


def _swivels(builder: DiagramBuilder, parts: HoldAndPlace) -> OutputPort:
    """The robot's, then what is asked of it: the person's, mirrored where the arms' elbows point up."""
    robot = builder.AddNamedSystem("arm_swivels", ArmSwivels(plant=parts.plant, arms=parts.arms))
    builder.Connect(parts.plant.get_body_poses_output_port(), robot.get_input_port())
    return _together(builder, "swivels", robot.get_output_port(), parts.retargeting.GetOutputPort("swivel"))


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
    pairs = {f"{arm}_palm": ContactPair(palm, (box,)) for arm, palm in zip(_ARMS, palms, strict=True)}
    pairs["box"] = ContactPair(box, tables)
    frames = {f"{arm}_palm": frame for arm, frame in _palm_frames(parts).items()} | {"box": box.name()}
    wrenches = builder.AddNamedSystem("contact_wrenches", ContactWrenches(pairs=pairs))
    builder.Connect(plant.get_contact_results_output_port(), wrenches.GetInputPort("contact_results"))
    builder.Connect(plant.get_body_poses_output_port(), wrenches.GetInputPort("body_poses"))
    for name in pairs:
        port = recorder.AddWrenchInput(f"contact/{name}", frames[name], single_precision=True, every=_every(parts.plan))
        builder.Connect(wrenches.GetOutputPort(name), port)


def _add_skeleton(builder: DiagramBuilder, parts: HoldAndPlace, recorder: McapRecorder) -> None:
    skill = parts.skill
    shown = skill.transformation.GetOutputPort("position"), skill.coupler.GetOutputPort("margin")
    port = _together(builder, "points_and_margin", *shown)
    encode = SkeletonMarkers(PERSON).encode
    builder.Connect(port, recorder.AddMessageInput("skeleton", 23, MARKERS, encode, every=_every(parts.plan)))


def _add_events(builder: DiagramBuilder, parts: HoldAndPlace, recorder: McapRecorder, clock: OutputPort) -> None:
    """The phases of the carry as they are recognised, or a motion's start and end as the skill reaches them."""
    rate = parts.plan.scenario.simulation.record_rate_hz
    if parts.carry_phase is not None:
        number, names = parts.carry_phase.get_output_port(), PHASES
    else:
        planned = PlannedEvents(parts.plan)
        passed = builder.AddNamedSystem("passed_times", PassedTimes(times=[t for _, t in planned]))
        builder.Connect(clock, passed.get_input_port())
        number, names = passed.get_output_port(), ("", *(name for name, _ in sorted(planned, key=lambda one: one[1])))
    events = EventRecorder(recorder=recorder, names=names, rate=rate)
    builder.Connect(number, builder.AddNamedSystem("events", events).get_input_port())
