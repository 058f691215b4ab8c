"""What recording the default run costs: wall time a millisecond of the plant, and bytes a simulated second.

    python studies/benchmark_recording.py [--repeat N] [--seconds S] [--topics]

Timed is the recorder's own event, with every port that is evaluated for it, and the closing of the file: more than what
recording adds, for the run's log looks at most of these ports at the same instants. Beside it stands the difference to
a second diagram of the main job without a recorder; the two advance in turns of 0.1 s in one process. It counts what
the event leaves behind, too, but as the difference of two long times it is seldom known to better than the budget, so
its standard error is given. On a slow machine as on a fast one the shares say the same: of the rest of the run, and of
what the bare plant takes on the same commands.
"""

import argparse
import statistics
import sys
import tempfile
import time
from collections import defaultdict
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import NamedTuple
from unittest.mock import patch

import numpy as np
import zstandard
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from benchmark_realtime import bare, chain  # noqa: E402

from drake_blfdmp.diagrams.hold_and_place import AddHoldAndPlace, SetInitialState  # noqa: E402
from drake_blfdmp.evaluation.console import ProgressBar  # noqa: E402
from drake_blfdmp.evaluation.run_logger import AddRunLogger  # noqa: E402
from drake_blfdmp.evaluation.run_recorder import AddRecorder  # noqa: E402
from drake_blfdmp.planning.plan import MakePlan, Plan  # noqa: E402
from drake_blfdmp.planning.scenario import LoadScenario  # noqa: E402
from drake_blfdmp.recording.stream import McapStream  # noqa: E402
from drake_blfdmp.recording.topic_recorder import TopicRecorder  # noqa: E402

SLICE_S = 0.1
WALL_BUDGET_US, BYTES_BUDGET_KB = 15.0, 150.0


def make(plan: Plan, file: Path | None, stack: ExitStack) -> Simulator:
    """The main job's simulator, with a recorder where there is a file for it."""
    builder = DiagramBuilder()
    parts = AddHoldAndPlace(builder, plan)
    AddRunLogger(builder, parts)
    if file is not None:
        stack.enter_context(AddRecorder(builder, parts, file))
    simulator = Simulator(builder.Build())
    SetInitialState(parts, simulator.get_system(), simulator.get_mutable_context())
    simulator.Initialize()
    return simulator


class Cost(NamedTuple):
    """What the recorder takes, microseconds a plant millisecond.

    Attributes:
        wall, processor: of its own event and of its closing.
        share: of the processor time of the rest of the run, which says the same on a slow machine as on a fast one.
        difference, error: in wall time to a run without it, and the standard error.
    """

    wall: float
    processor: float
    share: float
    difference: float
    error: float


def measure(plan: Plan, end: float, file: Path, bar: ProgressBar) -> Cost:
    """What the recorder costs."""
    own, publish = np.zeros(2), TopicRecorder._publish

    def timed(spent: np.ndarray, work: Callable, *arguments) -> None:
        started = np.array([time.perf_counter(), time.thread_time()])
        try:
            work(*arguments)
        finally:
            spent += np.array([time.perf_counter(), time.thread_time()]) - started

    with ExitStack() as closing:
        closing.enter_context(
            patch.object(TopicRecorder, "_publish", lambda self, context: timed(own, publish, self, context))
        )
        simulators = [make(plan, None, closing), make(plan, file, closing)]
        own[:] = 0.0
        times = np.append(np.arange(SLICE_S, end, SLICE_S), end)
        turns = np.zeros((len(times), 2, 2))  # Without, with; wall, processor.
        for k, t in enumerate(times):
            for row in ((0, 1), (1, 0))[k % 2]:
                timed(turns[k, row], simulators[row].AdvanceTo, float(t))
            bar(f"simulating {end:.1f} s twice", t / end)
        timed(own, closing.pop_all().close)
    wall, processor = own * 1e3 / end
    differences = (turns[:, 1, 0] - turns[:, 0, 0]) * 1e3 / end
    error = float(np.std(differences) * np.sqrt(len(times)))
    rest = turns[:, 1, 1].sum() - own[1]
    return Cost(wall, processor, own[1] / rest, float(differences.sum()), error)


def bytes_by_topic(file: Path) -> list[tuple[str, float, float, float]]:
    """(topic, raw, compressed, index) bytes, the compressed ones as what the file would shrink by without the topic."""
    chunks: dict[int, list[tuple[str, bytes]]] = defaultdict(list)
    for topic, message in McapStream(file).messages():
        head = np.array([message.log_time, message.publish_time]).tobytes()
        chunks[message.log_time // 10**9].append((topic.name, bytes(15) + head + message.data))

    def size(left_out: str) -> int:
        compress = zstandard.ZstdCompressor().compress
        return sum(len(compress(b"".join(data for name, data in c if name != left_out))) for c in chunks.values())

    whole = size("")
    messages = [message for chunk in chunks.values() for message in chunk]
    return [
        (
            name,
            sum(len(data) for topic, data in messages if topic == name),
            whole - size(name),
            16.0 * sum(topic == name for topic, _ in messages),
        )
        for name in sorted({name for name, _ in messages})
    ]


def main() -> int:
    """Measure and print; 1 where a budget is not kept."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n\n")[0])
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--seconds", type=float, default=None, help="simulated seconds; default: the whole run")
    parser.add_argument("--topics", action="store_true", help="say what each topic takes in the file")
    options = parser.parse_args()
    plan = MakePlan(LoadScenario(ROOT / "studies" / "hold_and_place.yaml"))
    end = options.seconds or plan.duration_s
    bar = ProgressBar()
    costs = []
    with tempfile.TemporaryDirectory() as folder:
        for k in range(options.repeat):
            file = Path(folder) / f"{k}.mcap"
            costs.append(measure(plan, end, file, bar))
            bar.finish()
        size = file.stat().st_size / end / 1e3
        topics = bytes_by_topic(file) if options.topics else []
    cost = Cost(*(statistics.median(values) for values in zip(*costs, strict=True)))
    rate = plan.scenario.simulation.record_rate_hz
    print(f"{end:.1f} s simulated, recorded at {rate:g} Hz, median of {options.repeat}")
    print(f"wall time       {cost.wall:6.1f} us a plant millisecond (budget {WALL_BUDGET_US:g})")
    print(f"processor time  {cost.processor:6.1f} us a plant millisecond, {100 * cost.share:.1f} % of the rest")
    plant = bare(plan, end, chain(plan, end, everything=False)[1]) * 1e3 / end
    share = 100.0 * cost.wall / plant
    print(f"bare plant      {plant:6.1f} us a millisecond of its own, of which the recorder takes {share:.1f} %")
    print(f"difference      {cost.difference:6.1f} us of wall time to a run without, +- {cost.error:.0f}")
    print(f"file            {size:6.1f} KB a simulated second (budget {BYTES_BUDGET_KB:g})")
    if topics:
        print(f"\n{'KB a simulated second':<24}{'raw':>8}{'in file':>9}{'index':>8}")
        for name, *sizes in topics:
            print(f"{name:<24}{sizes[0] / end / 1e3:8.1f}{sizes[1] / end / 1e3:9.1f}{sizes[2] / end / 1e3:8.1f}")
    return 0 if cost.wall <= WALL_BUDGET_US and size <= BYTES_BUDGET_KB else 1


if __name__ == "__main__":
    sys.exit(main())
