"""Every LeafSystem's `.. pydrake_system::` block against its real ports: names, order, and which need no source."""

import ast
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pydrake.common.value import AbstractValue
from pydrake.math import RigidTransform
from pydrake.multibody.plant import ContactResults
from pydrake.systems.framework import LeafSystem

from drake_blfdmp.diagrams.hold_and_place import MakeHoldAndPlace
from drake_blfdmp.recording.mcap_recorder import McapRecorder
from drake_blfdmp.recording.topic_recorder import TopicRecorder
from drake_blfdmp.recording.topics import VectorTopic
from drake_blfdmp.robot.contact import palm_bodies
from drake_blfdmp.robot.contact_wrenches import ContactPair
from drake_blfdmp.ros2.cdr import CdrTemplate, CdrWriter
from drake_blfdmp.ros2.messages import STRING
from drake_blfdmp.skill.laws import LAWS
from drake_blfdmp.skill.laws.primitive import Primitive
from drake_blfdmp.skill.orientation import OrientationSkill
from drake_blfdmp.systems.contact_wrenches import ContactWrenches
from drake_blfdmp.systems.live_goal import LiveGoal
from drake_blfdmp.systems.live_push import LivePush
from drake_blfdmp.systems.orientation_system import OrientationSystem
from drake_blfdmp.systems.passed_times import PassedTimes
from drake_blfdmp.systems.point_coupler import PointCoupler
from drake_blfdmp.systems.skill_clock import SkillClock
from drake_blfdmp.systems.timed_push import TimedPush
from drake_blfdmp.viewing.meshcat_scene import start_meshcat
from drake_blfdmp.viewing.skeleton_drawer import SkeletonDrawer, SkeletonGhost

PACKAGE = Path(__file__).resolve().parents[2] / "drake_blfdmp"


BASES = {"TopicInputs"}
"""What is no system by itself."""


def is_leaf(base):
    node = base.value if isinstance(base, ast.Subscript) else base
    return ast.unparse(node).rsplit(".", 1)[-1] in ("LeafSystem", "LeafSystem_", "TopicInputs", "TopicRecorder")


def declared():
    """Name of the block -> docstring, of every class in the package's source that derives from LeafSystem."""
    found = {}
    for path in sorted(PACKAGE.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ClassDef) and node.name not in BASES and any(map(is_leaf, node.bases)):
                text = ast.get_docstring(node) or ""
                named = re.search(r"\.\. pydrake_system::\s+name: (\w+)", text)
                assert named, f"{path.name}: class {node.name} has no `.. pydrake_system::` block"
                assert named[1] not in found
                found[named[1]] = text
    return found


BLOCKS = declared()


def documented(text):
    """Input and output ports of a block: lists of (name, whether it is optional)."""
    block = re.search(r"\.\. pydrake_system::\n(.*?)(?=\n\S)", text + "\nend", re.DOTALL)[1]
    ports, kind = {"input_ports": [], "output_ports": []}, None
    for line in map(str.strip, block.splitlines()):
        if line.rstrip(":") in ports:
            kind = line.rstrip(":")
        elif line.startswith("- "):
            name, optional = re.fullmatch(r"- (.+?)( \(optional\))?", line).groups()
            ports[kind].append((name, bool(optional)))
        else:
            assert not line or line.startswith("name: "), f"not understood: {line}"
    return ports["input_ports"], ports["output_ports"]


def real(system):
    inputs = [system.get_input_port(i).get_name() for i in range(system.num_input_ports())]
    outputs = [system.get_output_port(i).get_name() for i in range(system.num_output_ports())]
    return inputs, outputs


@pytest.fixture(scope="module")
def systems(default_plan, tmp_path_factory):
    """One of every LeafSystem, by the name of its block."""
    diagram, parts = MakeHoldAndPlace(default_plan)
    found = {}
    for system in diagram.GetSystems():
        kind = re.sub(r"_?\U0001d4e3.*$", "", type(system).__name__)
        found[kind] = system
    found["PointCoupler"] = PointCoupler(law=LAWS["published"], primitive=Primitive(1.0, 25.0))
    found["SkeletonDrawer"] = SkeletonDrawer(SkeletonGhost(start_meshcat(port=0)))
    recorder = McapRecorder(
        filename=tmp_path_factory.mktemp("ports") / "run.mcap",
        joints={"<joint group>": ["a"]},
        bodies={"box": 1},
    )
    _add_inputs(recorder)
    recorder.Close()
    found["McapRecorder"] = recorder
    topics = TopicRecorder(filename=tmp_path_factory.mktemp("ports") / "topics.mcap")
    _add_inputs(topics)
    topics.Close()
    found["TopicRecorder"] = topics
    skill = default_plan.task.skill
    unit = np.array([1.0, 0.0, 0.0, 0.0])
    turning = replace(skill, orientation=OrientationSkill(np.zeros((len(skill.centers), 3)), unit, unit))
    found["OrientationSystem"] = OrientationSystem(skill=turning, time_step=0.004)
    found["SkillClock"] = SkillClock(tau=1.0)
    found["PassedTimes"] = PassedTimes(times=[1.0])
    palms = palm_bodies(parts.plant, parts.arms)
    found["ContactWrenches"] = ContactWrenches(pairs=[ContactPair(palms[0], (parts.box,))])
    push = {"force": [1.0, 0.0, 0.0], "start_s": 0.0, "duration_s": 1.0}
    found["TimedPush"] = TimedPush(body=parts.box, **push)
    found["LivePush"] = LivePush(body=parts.box)
    found["LiveGoal"] = LiveGoal(scale=1.0, window=(0.0, 1.0), rate=0.1, tau=1.0, time_step=0.004)
    found["keep"] = (diagram, parts)
    return found


def _add_inputs(recorder):
    recorder.AddVectorInput("vector", 1, ["x"], "m")
    recorder.AddVectorInputs("vectors", [VectorTopic("one", ["x"], "m")])
    recorder.AddWrenchInput("wrench", "world")
    recorder.AddWrenchInputs("wrenches", {"two": "world"})
    recorder.AddMessageInput("message", 1, STRING, lambda t_ns, value: b"")
    recorder.AddTemplateInput("template", 1, STRING, CdrTemplate(CdrWriter()))
    recorder.AddEventInput("event", ["", "on"])


def test_there_are_as_many_as_the_architecture_says():
    assert len(BLOCKS) >= 12
    assert {"CanonicalSystem", "SwivelDifferentialIk", "McapRecorder", "SkeletonDrawer"} <= set(BLOCKS)


@pytest.mark.parametrize("name", sorted(BLOCKS))
def test_the_block_lists_the_real_ports_in_their_order(name, systems):
    assert name in systems, f"make one of {name} in this file's fixture, so that its ports can be compared"
    inputs, outputs = documented(BLOCKS[name])
    aliases = {
        "<name given to AddVectorInput>": "vector",
        "<name given to AddVectorInputs>": "vectors",
        "<name given to AddWrenchInput>": "wrench",
        "<name given to AddWrenchInputs>": "wrenches",
        "<name given to AddMessageInput>": "message",
        "<name given to AddTemplateInput>": "template",
        "<name given to AddEventInput>": "event",
    }
    inputs = [aliases.get(port, port) for port, _ in inputs]
    assert (inputs, [aliases.get(port, port) for port, _ in outputs]) == real(systems[name])
    assert not any(optional for _, optional in outputs_of(name))


def outputs_of(name):
    return documented(BLOCKS[name])[1]


@pytest.mark.parametrize("name", sorted(set(BLOCKS) - {"McapRecorder", "TopicRecorder"}))
def test_what_is_optional_and_nothing_else_may_be_left_open(name, systems):
    """With every input that is not optional given a value, a state is updated and every output has one."""
    system = systems[name]
    context = system.CreateDefaultContext()
    for port, optional in documented(BLOCKS[name])[0]:
        if not optional:
            give(system.GetInputPort(port), context)
    evaluate(system, context)
    for port, optional in documented(BLOCKS[name])[0]:
        if not optional:
            lacking = system.CreateDefaultContext()
            for other, other_optional in documented(BLOCKS[name])[0]:
                if other != port and not other_optional:
                    give(system.GetInputPort(other), lacking)
            with pytest.raises(Exception, match=port):
                evaluate(system, lacking)


def give(port, context):
    """A harmless value: unit quaternions at unit places for poses, six different points, bands around them."""
    name, size = port.get_name(), port.size()
    if name == "palm_poses":
        value = np.tile([1.0, 0.0, 0.0, 0.0, 0.0, 0.4, 0.7], 2)
    elif name == "bands":
        value = np.concatenate([np.full(5, 0.05), np.full(5, 9.0), np.zeros(20)])
    elif name in ("position", "points"):
        value = np.array(
            [[-0.2, 0, 0], [-0.2, 0.2, -0.1], [-0.15, 0.4, 0], [0.2, 0, 0], [0.2, 0.2, -0.1], [0.15, 0.4, 0]]
        )
    elif size:
        value = np.full(size, 0.5)
    elif name == "body_poses":
        value = AbstractValue.Make([RigidTransform([0.01 * k, 0.0, 0.0]) for k in range(60)])
    else:
        value = AbstractValue.Make(ContactResults())
    port.FixValue(context, np.ravel(value) if size else value)


def evaluate(system, context):
    for i in range(system.num_output_ports()):
        port = system.get_output_port(i)
        port.Eval(context)
    if context.num_discrete_state_groups():
        context.SetTime(10.0)  # The inverse kinematics waits at first.
        system.EvalUniquePeriodicDiscreteUpdate(context)
    elif not system.num_output_ports():
        system.ForcedPublish(context)


def test_the_test_sees_a_port_that_is_not_documented(systems):
    class Grown(LeafSystem):
        """It has grown.

        .. pydrake_system::

            name: Grown
            input_ports:
            - old
            output_ports:
            - result
        """

        def __init__(self):
            super().__init__()
            self.DeclareVectorInputPort("old", 1)
            self.DeclareVectorInputPort("new", 1)

    inputs, outputs = documented(Grown.__doc__)
    assert inputs == [("old", False)] and outputs == [("result", False)]
    assert real(Grown()) == (["old", "new"], [])
