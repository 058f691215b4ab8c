"""The diagram of a run as a graph: everything that `CarryOut` simulates but the logs."""

import tempfile
from pathlib import Path

from pydrake.systems.framework import Diagram, DiagramBuilder

from drake_blfdmp.diagrams.hold_and_place import AddHoldAndPlace
from drake_blfdmp.evaluation.carry_out import AddViewer
from drake_blfdmp.evaluation.run_recorder import AddRecorder
from drake_blfdmp.planning.plan import Plan
from drake_blfdmp.viewing.diagram_graph import diagram_dot
from drake_blfdmp.viewing.meshcat_scene import start_meshcat

LISTENERS = "recording and viewing"
GROUPS = {
    "skill": ("canonical", "forcing", "goal", "transformation", "bands", "coupler", "reshaper", "point_coupler"),
    "robot": (
        "retargeting",
        "ik",
        "plant",
        "scene_graph",
        "palm_forces",
        "push",
        "hands_observer",
        "phase_stopping",
        "carry_phase",
    ),
    LISTENERS: (
        "recorder",
        "recorded_signals",
        "recorded_slow_signals",
        "contact_wrenches",
        "points_and_margin",
        "skill_clock",
        "passed_times",
        "ghost",
        "skeleton",
        "meshcat_visualizer(visualizer)",
    ),
}
"""Frame in the graph -> names of the systems in it."""


def MakeRunDiagram(plan: Plan, folder: Path) -> Diagram:
    """The diagram, with a recorder into `folder` that the caller is to remove."""
    builder = DiagramBuilder()
    parts = AddHoldAndPlace(builder, plan)
    with AddRecorder(builder, parts, folder / "run.mcap"):
        AddViewer(builder, parts, start_meshcat(port=0))
    diagram = builder.Build()
    diagram.set_name(plan.scenario.name)
    return diagram


def RunDiagramDot(plan: Plan) -> str:
    """The graph of what a plan would be carried out by, in Graphviz's language."""
    with tempfile.TemporaryDirectory() as folder:
        return diagram_dot(MakeRunDiagram(plan, Path(folder)), GROUPS, LISTENERS)
