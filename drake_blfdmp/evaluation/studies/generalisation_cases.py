"""Other starts, goals (moving ones too), durations and boxes than a task's own, and what a law makes of them.

A case is a batch of problems in which one thing is changed; all cases are run as one batch.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from drake_blfdmp.evaluation.studies.generalisation_metrics import (
    end_errors,
    hands_middle,
    in_normalised_time,
    path_distance,
    profile_correlation,
)
from drake_blfdmp.planning.scenario import Scenario
from drake_blfdmp.planning.sources import Source
from drake_blfdmp.planning.task import LawGains, MakeTask, Task
from drake_blfdmp.skeleton import HANDS
from drake_blfdmp.skill.bands import Bands
from drake_blfdmp.skill.geometry import link_lengths
from drake_blfdmp.skill.laws import law
from drake_blfdmp.skill.profiles import HandDistance, smooth_step
from drake_blfdmp.skill.projection import nearest_skeleton
from drake_blfdmp.skill.rollout import MovingGoal, margins, steps
from drake_blfdmp.skill.sampled import Gains

START_M, GOAL_M, OWN_M = 0.05, 0.15, 0.05
"""Rms of every coordinate's shift, m: of each point's start, of the goal as a whole, of each point's goal alone."""

RADIUS_M, TURNS, MOVES = 0.10, 2, (0.3, 0.7)
"""The circular goal, m, turns a duration; when the other moving goal moves, over the duration."""

WIDTHS_M, SCALES = (0.20, 0.45), (0.5, 2.0)
"""Of the boxes, m; of the durations, over the skill's own."""

LEARNED, AT_ODDS, STATIC = "unchanged", "goal moved, each point", "goal moved, within the bones"
MOVING, STARTS = ("goal moves and stops", "goal moves in a circle"), "start moved"
DURATIONS, BOXES = "duration x 0.5 to 2", "box 0.20 to 0.45 m"


@dataclass(frozen=True)
class Case:
    """P problems: start and goal (P, 6, 3) m, a goal perhaps a function of time; tau (P,) s; the hands' distance."""

    start: np.ndarray
    goal: np.ndarray | MovingGoal
    tau: np.ndarray
    hands: HandDistance

    def goal_at(self, t: float) -> np.ndarray:
        """(P, 6, 3) m."""
        return np.asarray(self.goal(t) if callable(self.goal) else self.goal)

    def every(self, stride: int) -> "Case":
        """Only each of these many problems, the first included."""
        hands = HandDistance(**{name: value[::stride] for name, value in vars(self.hands).items()})
        return Case(self.start[::stride], lambda t: self.goal_at(t)[::stride], self.tau[::stride], hands)


@dataclass(frozen=True)
class Motion:
    """P problems with one law: the hands' middle (N, P, 3) and distance (N, P), m, at t (N,), s, and how each ended.

    Attributes:
        end: points (P, 6, 3) at the last sample of each, m.
        least: least margin of each (P,).
    """

    t: np.ndarray
    middle: np.ndarray
    apart: np.ndarray
    end: np.ndarray
    least: np.ndarray

    def of(self, part: slice) -> "Motion":
        """That of some of the problems."""
        return Motion(self.t, self.middle[:, part], self.apart[:, part], self.end[part], self.least[part])


def hands_of(bands: Bands, count: int, ratio: np.ndarray | float = 1.0) -> HandDistance:
    """The hands' distance of the task for `count` problems, its times stretched by `ratio`."""
    values = vars(bands.hands)
    one = np.ones(count)
    return HandDistance(
        **{name: value * (ratio if name.endswith("_s") else 1.0) * one for name, value in values.items()}
    )


def make_cases(scenario: Scenario, source: Source, task: Task, count: int) -> dict[str, Case]:
    """The cases, by what is changed: `count` problems each, one where nothing is. Drawn from the scenario's seed."""
    rng = np.random.default_rng(scenario.seed)
    skill, bands = task.skill, task.bands
    lengths = bands.desired(skill.tau)[0]
    within = nearest_skeleton(skill.goal, lengths)
    start, learned, goal = (np.repeat(value[None], count, axis=0) for value in (skill.start, skill.goal, within))
    same = Case(start, goal, np.full(count, skill.tau), hands_of(bands, count))
    shift = GOAL_M * rng.normal(size=(count, 1, 3))
    own = learned + shift + OWN_M * rng.normal(size=goal.shape)
    angle = 2.0 * np.pi * TURNS / skill.tau

    def stops(t: float) -> np.ndarray:
        u = (t / skill.tau - MOVES[0]) / (MOVES[1] - MOVES[0])
        return goal + smooth_step(u)[0] * shift

    def circle(t: float) -> np.ndarray:
        return goal + RADIUS_M * np.array([np.cos(angle * t) - 1.0, np.sin(angle * t), 0.0])

    ratio = np.geomspace(*SCALES, count)
    widths = np.linspace(*WIDTHS_M, count)
    motion = task.motion
    boxes = [
        MakeTask(other, replace(source, dimensions=replace(source.dimensions, box_width=other.box.width)), motion)
        for other in (replace(scenario, box=replace(scenario.box, width=float(width))) for width in widths)
    ]
    profiles = [vars(box.bands.hands) for box in boxes]
    wide = HandDistance(**{name: np.array([profile[name] for profile in profiles]) for name in profiles[0]})

    def ends(box: Task) -> np.ndarray:
        return nearest_skeleton(skill.goal, box.bands.desired(skill.tau)[0])

    return {
        LEARNED: Case(start[:1], learned[:1], same.tau[:1], hands_of(bands, 1)),
        STARTS: replace(same, start=start + START_M * rng.normal(size=start.shape)),
        AT_ODDS: replace(same, goal=own),
        STATIC: replace(same, goal=nearest_skeleton(own, lengths)),
        MOVING[0]: replace(same, goal=stops),
        MOVING[1]: replace(same, goal=circle),
        DURATIONS: replace(same, tau=skill.tau * ratio, hands=hands_of(bands, count, ratio)),
        BOXES: replace(same, hands=wide, goal=np.stack([ends(box) for box in boxes])),
    }


def together(cases: Sequence[Case]) -> Case:
    """All problems of all cases in one batch."""
    hands = [vars(case.hands) for case in cases]
    return Case(
        np.concatenate([case.start for case in cases]),
        lambda t: np.concatenate([case.goal_at(t) for case in cases]),
        np.concatenate([case.tau for case in cases]),
        HandDistance(**{name: np.concatenate([each[name] for each in hands]) for name in hands[0]}),
    )


def run_cases(
    scenario: Scenario,
    task: Task,
    cases: Mapping[str, Case],
    laws: Sequence[str],
    step: float,
    progress: Callable[[str, float], None] = lambda what, share: None,
    gains: Mapping[str, Any] | None = None,
) -> dict[tuple[str, str], Motion]:
    """The motions by case and law; each law runs all cases in one batch.

    Args:
        step: s.
        gains: of some laws; the others take the scenario's.
        progress: called with the law and the share of its steps done, 0 to 1.

    Raises:
        ScenarioError: the step is too long for the default law's gains.
    """
    every = together(list(cases.values()))
    ends = np.cumsum([len(case.tau) for case in cases.values()])
    own = {name: LawGains(replace(scenario, law=name)) for name in laws} | dict(gains or {})
    whole = {
        name: _run(task, every, name, own[name], step, lambda share, name=name: progress(name, share)) for name in laws
    }
    return {
        (label, name): whole[name].of(slice(end - len(case.tau), end))
        for (label, case), end in zip(cases.items(), ends, strict=True)
        for name in laws
    }


def best_gains(
    task: Task,
    cases: Mapping[str, Case],
    name: str,
    candidates: Sequence[Any],
    step: float,
    progress: Callable[[float], None] = lambda share: None,
) -> tuple[Any, list[int]]:
    """The gains with which a law leaves its bands in the fewest of all problems, and in how many with each."""
    every = together(list(cases.values()))
    left = []
    for i, gains in enumerate(candidates):
        motion = _run(task, every, name, gains, step, lambda share, i=i: progress((i + share) / len(candidates)))
        left.append(int(np.sum(~(motion.least > 0.0))))
    return candidates[int(np.argmin(left))], left


def _run(task: Task, case: Case, name: str, gains: Any, step: float, progress: Callable[[float], None]) -> Motion:
    """All problems of a case with one law."""
    if isinstance(gains, Gains):
        gains.check(step)
    samples = int(case.tau.max() / step + 1e-9) + 1
    middle, apart = [], []
    end, least = case.start, np.full(len(case.tau), np.inf)
    rollout = steps(
        task.skill,
        time_step=step,
        samples=samples,
        bands=replace(task.bands, hands=case.hands, opening=0.0).opened_to(case.start),
        law=law(name),
        gains=gains,
        start=case.start,
        goal=case.goal,
        tau=case.tau[:, None, None],
    )
    with np.errstate(all="ignore"):  # A law that diverges overflows.
        for k, sample in enumerate(rollout):
            middle.append(hands_middle(sample.x))
            apart.append(link_lengths(sample.x)[:, HANDS])
            running = sample.t <= case.tau + 1e-9
            end = np.where(running[:, None, None], sample.x, end)
            least = np.where(running, np.minimum(least, margins(sample.x, sample.bands).min(axis=-1)), least)
            if k % 100 == 0:
                progress(k / samples)
    return Motion(step * np.arange(samples), np.array(middle), np.array(apart), end, least)


def measure(case: Case, motion: Motion, plain: np.ndarray, home: np.ndarray) -> dict[str, float]:
    """A row of numbers: how many bands are left, and lengths, m, of the problems that did not diverge.

    Args:
        plain, home: hands' middles (M, P, 3) of the same problems without coupling, and (M, 1, 3) of the unchanged one.
    """
    end = end_errors(motion.end, case.goal_at(float(case.tau.max())))
    middle = in_normalised_time(motion.t, motion.middle, case.tau)
    ended = np.isfinite(motion.end).all(axis=(1, 2))
    profile = profile_correlation(middle, np.broadcast_to(home, middle.shape))
    # NaN where every problem diverged.
    hands, points, changed, profile = (
        values[ended] if ended.any() else np.array([np.nan])
        for values in (end.hands, end.points, path_distance(middle, plain), profile)
    )
    return {
        "problems": len(case.tau),
        "left": int(np.sum(~(motion.least > 0.0))),
        "left_percent": 100.0 * float(np.mean(~(motion.least > 0.0))),
        "diverged": int(np.sum(~ended)),
        "least_margin": float(np.where(np.isnan(motion.least), -np.inf, motion.least).min()),
        "end_hands_mean_m": float(hands.mean()),
        "end_hands_max_m": float(hands.max()),
        "end_points_mean_m": float(points.mean()),
        "path_mean_m": float(changed.mean()),
        "path_max_m": float(changed.max()),
        "profile_least": float(profile.min()),
    }


def measure_all(
    cases: Mapping[str, Case], motions: Mapping[tuple[str, str], Motion]
) -> dict[tuple[str, str], dict[str, float]]:
    """The rows of all motions, by case and law; among them those of `LEARNED` and of the law "none"."""
    paths = {key: in_normalised_time(motion.t, motion.middle, cases[key[0]].tau) for key, motion in motions.items()}
    return {
        (label, name): measure(cases[label], motion, paths[label, "none"], paths[LEARNED, name])
        for (label, name), motion in motions.items()
    }
