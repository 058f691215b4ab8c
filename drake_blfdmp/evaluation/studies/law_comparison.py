"""Fig. 10's comparison on one task: the search for gains, every law with its own, the learning of Gams et al."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from drake_blfdmp.evaluation.studies.gain_search import GRIDS, GainSearch, search_tasks
from drake_blfdmp.evaluation.studies.law_metrics import LawResult, measure, roll_out_law
from drake_blfdmp.evaluation.study import Table
from drake_blfdmp.planning.scenario import Scenario
from drake_blfdmp.planning.task import LawGains, Task
from drake_blfdmp.skeleton import HANDS
from drake_blfdmp.skill.gams_learning import Epoch, iterate
from drake_blfdmp.skill.laws import LAWS
from drake_blfdmp.skill.profiles import ConstantDistance

FAR = 0.4
"""m from the desired distance: nothing comes back from there."""


@dataclass(frozen=True)
class LawRun:
    """A law on a task.

    Attributes:
        gains: that it ran with; None for `none`.
        t: (N,) s.
        hands: (N,) the hands' distance, m; NaN once it has been `FAR` off.
        result: how it did.
    """

    gains: Any
    t: np.ndarray
    hands: np.ndarray
    result: LawResult


@dataclass(frozen=True)
class Case:
    """All of it on one task.

    Attributes:
        task: that was carried out.
        searches: law -> the search for its gains.
        runs: law -> the run.
        epochs: of the learning of Gams et al., without c_2.
    """

    task: Task
    searches: Mapping[str, GainSearch]
    runs: Mapping[str, LawRun]
    epochs: Sequence[Epoch]

    def best(self, name: str) -> Any:
        """The gains that the search prefers for this law."""
        return self.searches[name].gains_of(self.searches[name].best)

    def outside(self, name: str) -> int:
        """Samples of this law's run at which a link that it couples is outside its opened band."""
        return self.runs[name].result.outside

    def lag(self, hands: np.ndarray, after: float) -> float:
        """How far the hands' distance (N,), m, is from d_j at most, later than `after`, s: m."""
        t = self.runs["default"].t
        return float(np.abs(hands - self.task.bands.desired(t)[0][:, HANDS])[t >= after].max())


def compare_case(
    scenario: Scenario,
    task: Task,
    searched: Sequence[str],
    *,
    search_on: Sequence[Task] = (),
    with_best: bool,
    time_step: float,
    quick: bool,
    progress: Callable[[str, float], None],
) -> Case:
    """Search, run and learn on a task.

    The learning is without c_2. What a large c_2 leaves of the hands' error at the start fades slowly, no reference can
    undo it, and learning to undo it can diverge.

    Args:
        searched: laws whose gains are searched for.
        search_on: the tasks on which they are, this one by default.
        with_best: run those with what was found here, not with the scenario's gains.
        time_step: s, of all rollouts.
        quick: search every other value of the grids on the first 2 s, and learn for 3 epochs, not 10.
        progress: called with what is done and the share of it.
    """
    searches = {}
    for i, name in enumerate(searched):
        progress(f"searching gains of {name}", 0.7 * i / len(searched))
        grid = {gain: values[::2] if quick else values for gain, values in GRIDS[name].items()}
        on = search_on or (task,)
        searches[name] = search_tasks(on, name, grid, time_step=time_step, duration=2.0 if quick else None)
    progress("every law", 0.7)
    found = {name: one.gains_of(one.best) for name, one in searches.items()} if with_best else {}
    runs = compare_laws(scenario, task, found, time_step=time_step)
    progress("learning", 0.85)
    gains = replace(runs["gams"].gains, c_2=0.0)
    epochs = iterate(task.skill, task.bands, epochs=3 if quick else 10, time_step=time_step, gains=gains)
    return Case(task, searches, runs, epochs)


def with_constant_distance(task: Task, distance: float = 0.3) -> Task:
    """The task with d_j constant, m, and its funnels opened to the start anew."""
    bands = replace(task.bands, hands=ConstantDistance(distance)).paper().opened_to(task.skill.start)
    return replace(task, bands=bands)


def compare_laws(scenario: Scenario, task: Task, gains: Mapping[str, Any], *, time_step: float) -> dict[str, LawRun]:
    """Every law of `skill.laws` on the task; `gains` gives those of some laws, the scenario gives the others'."""
    runs = {}
    for name in LAWS:
        own = gains.get(name, LawGains(replace(scenario, law=name)))
        rollout = roll_out_law(scenario, task, name, gains=own, time_step=time_step)
        with np.errstate(all="ignore"):
            hands = rollout.lengths[:, HANDS]
            near = np.abs(hands - task.bands.desired(rollout.t)[0][:, HANDS]) < FAR
        gone = np.logical_or.accumulate(~near)
        runs[name] = LawRun(own, rollout.t, np.where(gone, np.nan, hands), measure(rollout, task, name))
    return runs


def told(gains: Any) -> str:
    """The gains in words: name and value of each that is neither zero nor one."""
    if gains is None:
        return "none"
    return ", ".join(f"{name} {value:g}" for name, value in asdict(gains).items() if value not in (0.0, 1.0))


def how_searched(case: Case, name: str, carried: Any) -> str:
    """In words: what the search on this case found for a law, how it did, and how the `carried` gains would do."""
    search = case.searches[name]
    member = search.member(carried)
    beside = "" if member is None else f", {search.outside[member]} of {search.samples} with the task's gains"
    return (
        f"{name} ({told(case.best(name))}; {search.kept} of {len(search.outside)} gains keep all bands) "
        f"{case.outside(name)} of {case.runs[name].result.samples} samples outside{beside}"
    )


def laws_table(cases: Mapping[str, Case]) -> Table:
    """How every law did in every case."""
    rows = [(title, name, run) for title, case in cases.items() for name, run in case.runs.items()]
    results = [run.result for _, _, run in rows]
    return Table(
        {
            "d_j": [title for title, _, _ in rows],
            "law": [name for _, name, _ in rows],
            "gains": [told(run.gains) for _, _, run in rows],
            "samples_outside": [result.outside for result in results],
            "of": [result.samples for result in results],
            "least_margin": [result.least_margin for result in results],
            "samples_30hz_until_inside": [until_inside(result) for result in results],
            "rms_to_demonstration_m": [result.distance_m for result in results],
        }
    )


def epochs_table(cases: Mapping[str, Case]) -> Table:
    """What the learning leaves after every epoch, of the whole motion and of its settled part."""
    count = min(len(case.epochs) for case in cases.values())
    return Table(
        {"epoch": list(range(1, count + 1))}
        | {
            f"{title}_{part}_m": [getattr(epoch, part) for epoch in case.epochs[:count]]
            for title, case in cases.items()
            for part in ("rms", "settled_rms")
        }
    )


def curves_table(t: np.ndarray, recorded: np.ndarray, cases: Mapping[str, Case]) -> Table:
    """The hands' distance over time (N,), s: recorded (N,), m, with every law in every case, and learned."""
    return Table(
        {"time_s": t, "recorded_m": recorded}
        | {f"{title}_{name}_m": run.hands for title, case in cases.items() for name, run in case.runs.items()}
        | {f"{title}_gams_learned_m": learned(case) for title, case in cases.items()}
    )


def learned(case: Case) -> np.ndarray:
    """The hands' distance (N,), m, with Gams et al. after the last epoch."""
    return case.epochs[-1].rollout.lengths[:, HANDS]


def until_inside(result: LawResult) -> str:
    """The recording's samples until every link is inside for good, or "never"."""
    return "never" if result.until_inside is None else str(result.until_inside)
