"""One whole run: plan, simulate, record, judge, and write its folder."""

from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from pydrake.geometry import Meshcat, MeshcatVisualizer, MeshcatVisualizerParams
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import AffineSystem

from drake_blfdmp.diagrams.hold_and_place import HoldAndPlace
from drake_blfdmp.evaluation.folders import MakeRunFolder, RefuseUsedFolder
from drake_blfdmp.evaluation.last_states import LastStatesKept
from drake_blfdmp.evaluation.live_session import LiveSession
from drake_blfdmp.evaluation.run_recorder import GHOST_AT, AddRecorder
from drake_blfdmp.evaluation.simulation import Simulate
from drake_blfdmp.evaluation.summary import MakeSummary, dump
from drake_blfdmp.planning.plan import MakePlan, Plan
from drake_blfdmp.planning.scenario import DumpScenario, Scenario
from drake_blfdmp.recording.mcap_recorder import McapRecorder
from drake_blfdmp.recording.planned_signals import MEASURED, measured_bytes
from drake_blfdmp.recording.run_log import RunLog
from drake_blfdmp.recording.run_log_from_file import read_run_log
from drake_blfdmp.viewing.figures import write_figures
from drake_blfdmp.viewing.meshcat_scene import set_scene_camera, start_meshcat, write_scene_html
from drake_blfdmp.viewing.skeleton_drawer import BAND_LEGEND, LEGEND, PERSON_LEGEND, SkeletonDrawer, SkeletonGhost
from drake_blfdmp.viewing.stage import add_stage

Progress = Callable[[str, float], None]

MOST_SCENE_FRAMES = 1000
"""A scene has no more; one of them takes about 5 kB."""


@dataclass(frozen=True)
class Run:
    """What a run left behind."""

    plan: Plan
    log: RunLog
    summary: dict
    folder: Path


def SceneRate(plan: Plan) -> float:
    """Frames a second of the scene, Hz: the scenario's, or fewer where so long a run would make a large page."""
    return min(plan.scenario.simulation.scene_rate_hz, MOST_SCENE_FRAMES / plan.duration_s)


def CarryOut(
    scenario: Scenario,
    folder: Path | None = None,
    *,
    meshcat: Meshcat | None = None,
    progress: Progress = lambda what, share: None,
) -> Run:
    """Plan and simulate a scenario and write its folder.

    Args:
        folder: must not exist or be empty; by default a new one below `runs/`.
        meshcat: a running viewer to show the simulation in, with controls to take part in it (`live_session`).
        progress: called with what is being done and the share of it done.

    Raises:
        SimulationError: the simulation had to stop, at a number that is not finite, say; run.mcap goes up to then.
        BlfDmpError: one line that says what, where and what to do. Files already written stay.
    """
    if folder is not None:
        RefuseUsedFolder("--out", Path(folder))  # Said before the planning, not after it.
    plan = MakePlan(scenario, progress)
    folder = MakeRunFolder(folder, scenario.name)
    (folder / "scenario.yaml").write_text(DumpScenario(scenario), encoding="utf-8")
    plan.task.skill.save(folder / "skill.json")
    viewer = meshcat or start_meshcat(port=0)
    session = None if meshcat is None else LiveSession(meshcat, progress)
    with ExitStack() as stack:
        recorders: list[McapRecorder] = []

        def add(builder: DiagramBuilder, parts: HoldAndPlace) -> None:
            recorders.append(stack.enter_context(AddRecorder(builder, parts, folder / "run.mcap")))
            AddViewer(builder, parts, viewer)
            if session is not None:
                session.AddToBuilder(builder, parts, recorders[0].Event)
            viewer.StartRecording(frames_per_second=SceneRate(plan), set_visualizations_while_recording=True)

        with LastStatesKept(recorders, {"scenario.yaml": DumpScenario(scenario)}):
            done = Simulate(plan, add, progress, session)
        viewer.StopRecording()
        if session is not None:
            plan = session.Finish()
        source = "synthetic" if plan.source.recording.synthetic else "recorded"
        title = f"{scenario.name}: law {scenario.law}, {source} person"
        legend = {**LEGEND, **BAND_LEGEND, **PERSON_LEGEND}
        write_scene_html(viewer, folder / "scene.html", title=title, legend=legend)
        log, recorder = done.log, recorders[0]
        summary = MakeSummary(plan, log, done.margins, done.simulated_s, done.wall_s)
        recorder.AddAttachment("scenario.yaml", DumpScenario(scenario), "application/yaml")
        recorder.AddAttachment("skill.json", (folder / "skill.json").read_bytes(), "application/json")
        # The clocks differ from run to run, the recording must not.
        timeless = {key: value for key, value in summary.items() if key != "timing"}
        recorder.AddAttachment("summary.json", dump(timeless), "application/json")
        recorder.AddAttachment(MEASURED, measured_bytes(log.t, log.clearance), "application/octet-stream")
    (folder / "summary.json").write_text(dump(summary), encoding="utf-8")
    progress("drawing figures", 0.0)
    write_figures(read_run_log(recorder.path), folder)  # What the file does not have is not in the figures.
    progress("drawing figures", 1.0)
    return Run(plan, log, summary, folder)


def AddViewer(builder: DiagramBuilder, parts: HoldAndPlace, meshcat: Meshcat) -> None:
    """Show the scene, and the skeleton as a ghost beside it, in Meshcat."""
    plan = parts.plan
    period = 1.0 / SceneRate(plan)
    meshcat.Delete()
    meshcat.DeleteAddedControls()
    set_scene_camera(meshcat)
    add_stage(meshcat, middle=(GHOST_AT[0] / 2, 0.1))
    MeshcatVisualizer.AddToBuilder(
        builder, parts.scene_graph, meshcat, MeshcatVisualizerParams(publish_period=period, enable_alpha_slider=False)
    )
    shift = np.tile(GHOST_AT - plan.retarget.person, 6)
    ghost = builder.AddNamedSystem(
        "ghost",
        AffineSystem(
            A=np.zeros((0, 0)), B=np.zeros((0, 18)), f0=np.zeros(0), C=np.zeros((18, 0)), D=np.eye(18), y0=shift
        ),
    )
    builder.Connect(parts.skill.transformation.GetOutputPort("position"), ghost.get_input_port())
    drawer = SkeletonDrawer.AddToBuilder(
        builder,
        ghost.get_output_port(),
        SkeletonGhost(meshcat),
        margin_port=parts.skill.coupler.GetOutputPort("margin"),
        bands_port=parts.skill.bands.GetOutputPort("bands"),
        publish_period=period,
    )
    drawer.set_name("skeleton")
