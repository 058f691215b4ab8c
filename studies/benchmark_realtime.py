"""How fast the default run is, and what the Python systems cost beside the bare plant, measured in one process.

    python studies/benchmark_realtime.py [--repeat N]

Three diagrams carry out the same plan: everything (recorder, logs, viewer), the systems alone, and the bare plant with
its joint PD fed from a stored trajectory, so that contacts and solver work are the same. Medians over the repeats,
taken in turn, so that a machine that slows down slows all three.
"""

import argparse
import statistics
import sys
import tempfile
import time
from contextlib import ExitStack
from pathlib import Path

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import LogVectorOutput, TrajectorySource
from pydrake.trajectories import PiecewisePolynomial

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from drake_blfdmp.diagrams.hold_and_place import AddHoldAndPlace, AddPlannedPlant, SetInitialState  # noqa: E402
from drake_blfdmp.evaluation.carry_out import AddViewer  # noqa: E402
from drake_blfdmp.evaluation.run_logger import AddRunLogger  # noqa: E402
from drake_blfdmp.evaluation.run_recorder import AddRecorder  # noqa: E402
from drake_blfdmp.planning.plan import MakePlan, Plan  # noqa: E402
from drake_blfdmp.planning.scenario import LoadScenario  # noqa: E402
from drake_blfdmp.robot.rigid import rigid  # noqa: E402
from drake_blfdmp.viewing.meshcat_scene import start_meshcat  # noqa: E402


def run(simulator: Simulator, end: float) -> float:
    """Wall seconds for the simulation alone."""
    simulator.Initialize()
    started = time.perf_counter()
    simulator.AdvanceTo(end)
    return time.perf_counter() - started


def chain(plan: Plan, end: float, everything: bool) -> tuple[float, tuple]:
    """Wall seconds of the project's diagram, and the commands it gave: times and states of both arms."""
    builder = DiagramBuilder()
    parts = AddHoldAndPlace(builder, plan)
    with ExitStack() as stack:
        if everything:
            AddRunLogger(builder, parts)
            folder = stack.enter_context(tempfile.TemporaryDirectory())
            stack.enter_context(AddRecorder(builder, parts, Path(folder) / "run.mcap"))
            meshcat = start_meshcat(port=0)
            AddViewer(builder, parts, meshcat)
            meshcat.StartRecording(frames_per_second=plan.scenario.simulation.scene_rate_hz)
        sinks = [LogVectorOutput(parts.ik.GetOutputPort(name), builder, 0.01) for name in ("position", "velocity")]
        diagram = builder.Build()
        simulator = Simulator(diagram)
        context = simulator.get_mutable_context()
        SetInitialState(parts, diagram, context)
        wall = run(simulator, end)
        logs = [sink.FindLog(context) for sink in sinks]
        commands = np.array(logs[0].sample_times()), np.array(logs[0].data()), np.array(logs[1].data())
    return wall, commands


def bare(plan: Plan, end: float, commands: tuple) -> float:
    """Wall seconds of the plant alone on the same commands."""
    builder = DiagramBuilder()
    plant, _, arms, box = AddPlannedPlant(builder, plan)
    t, q, v = commands
    for i, arm in enumerate(arms):
        joints = slice(7 * i, 7 * i + 7)
        state = np.vstack([q[joints], v[joints]])
        source = builder.AddSystem(TrajectorySource(PiecewisePolynomial.FirstOrderHold(t, state)))
        builder.Connect(source.get_output_port(), plant.get_desired_state_input_port(arm))
    diagram = builder.Build()
    simulator = Simulator(diagram)
    context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    for i, arm in enumerate(arms):
        plant.SetPositions(context, arm, plan.reach.start[7 * i : 7 * i + 7])
    plant.SetFreeBodyPose(context, box, rigid(plan.start))
    return run(simulator, end)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n\n")[0])
    parser.add_argument("--repeat", type=int, default=5)
    repeat = parser.parse_args().repeat
    plan = MakePlan(LoadScenario(ROOT / "studies" / "hold_and_place.yaml"))
    end = plan.duration_s
    times: dict[str, list[float]] = {"everything": [], "systems alone": [], "bare plant": []}
    for _ in range(repeat):
        times["everything"].append(chain(plan, end, True)[0])
        wall, commands = chain(plan, end, False)
        times["systems alone"].append(wall)
        times["bare plant"].append(bare(plan, end, commands))
    print(f"{end:.1f} s simulated, {repeat} repeats, medians")
    for name, walls in times.items():
        wall = statistics.median(walls)
        ratio = statistics.median(b / w for b, w in zip(times["bare plant"], walls, strict=True))
        print(f"{name:<14} {end / wall:5.2f} x real time, {100 * ratio:4.0f} % of the bare plant's speed")


if __name__ == "__main__":
    main()
