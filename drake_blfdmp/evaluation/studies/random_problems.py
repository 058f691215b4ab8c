"""Random problems around a task, each with its own start, goal, duration, bands and gains, and whether laws keep them.

All problems are drawn at once from one seed, and each is run for its own duration; so what comes out does not depend on
how they are shared out to processes.
"""

import os
import signal
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, fields, replace
from multiprocessing import get_context
from typing import Any

import numpy as np

from drake_blfdmp.errors import BlfDmpError
from drake_blfdmp.skeleton import HANDS, LINKS
from drake_blfdmp.skill.bands import ONLY_HANDS, Bands
from drake_blfdmp.skill.geometry import link_lengths
from drake_blfdmp.skill.laws import law
from drake_blfdmp.skill.profiles import HandDistance
from drake_blfdmp.skill.rollout import margins, steps
from drake_blfdmp.skill.sampled import Gains
from drake_blfdmp.skill.skill import Skill

CHUNK = 500
"""Problems a batch; a few hundred to a thousand cost the same per problem and step."""

NEVER = np.inf
"""`Outcome.left_s` of a link that kept its band."""


@dataclass(frozen=True)
class Spread:
    """What is drawn, uniformly where not said otherwise. A pair is a range.

    Attributes:
        start_m, goal_m: rms of the normal shift of every coordinate of every point, m.
        hands_error_m: the hands' distance at the start is off by up to this, either way, m.
        nearest_m: but the hands never start nearer to each other than this, m.
        tau: duration over the skill's own, log-uniform.
        box_m: width of the box, m; the hands open to `clearance_m` on either side and close to `squeeze_m` inside it.
        close, closing, open: beginning of closing, time that closing and opening take, beginning of opening, over tau.
        half_width_m: of all bands once the funnel has closed, m, log-uniform.
        funnel_m: additional half width between the hands at the start, m.
        gain: k_1 and k_2, 1/s, log-uniform among the pairs that `Gains.check` allows.
    """

    start_m: float = 0.03
    goal_m: float = 0.15
    hands_error_m: float = 0.35
    nearest_m: float = 0.05
    tau: tuple[float, float] = (0.5, 2.0)
    box_m: tuple[float, float] = (0.20, 0.45)
    clearance_m: float = 0.05
    squeeze_m: float = 0.012
    close: tuple[float, float] = (0.10, 0.30)
    closing: tuple[float, float] = (0.04, 0.10)
    open: tuple[float, float] = (0.60, 0.85)
    half_width_m: tuple[float, float] = (0.005, 0.02)
    funnel_m: tuple[float, float] = (0.0, 0.04)
    gain: tuple[float, float] = (1.0, 200.0)


@dataclass(frozen=True)
class Problems:
    """P problems; every array has them along its first axis.

    Attributes:
        start, goal: (P, 6, 3) m.
        tau: (P,) s.
        open_m, closed_m: (P,) the hands' distance while open and closed, m.
        close_s, open_s, closing_s: (P,) beginning of closing and of opening, and how long either takes, s.
        half_width_m, funnel_m: (P,) m, as in `Spread`.
        k_1, k_2: (P,) gains of the default law, 1/s.
    """

    start: np.ndarray
    goal: np.ndarray
    tau: np.ndarray
    open_m: np.ndarray
    closed_m: np.ndarray
    close_s: np.ndarray
    open_s: np.ndarray
    closing_s: np.ndarray
    half_width_m: np.ndarray
    funnel_m: np.ndarray
    k_1: np.ndarray
    k_2: np.ndarray

    def __len__(self) -> int:
        return len(self.tau)

    def __getitem__(self, index) -> "Problems":
        """The problems of a slice or of an array of indices."""
        return Problems(**{item.name: getattr(self, item.name)[index] for item in fields(self)})

    def with_gains(self, k_1: float | np.ndarray, k_2: float | np.ndarray) -> "Problems":
        """The same problems with other gains of the default law, 1/s: numbers or (P,)."""
        return replace(self, k_1=np.broadcast_to(k_1, self.tau.shape), k_2=np.broadcast_to(k_2, self.tau.shape))

    def bands(self, bones: np.ndarray, rate: float, filling: float = 0.8) -> Bands:
        """The moving bands, their funnels opened to the starts.

        Args:
            bones, rate, filling: as in `skill.bands`.
        """
        final = np.repeat(self.half_width_m[:, None], len(LINKS), axis=1)
        hands = HandDistance(self.open_m, self.closed_m, self.close_s, self.open_s, self.closing_s)
        initial = final + self.funnel_m[:, None] * ONLY_HANDS
        return Bands(bones=bones, hands=hands, initial=initial, final=final, rate=rate).opened_to(self.start, filling)


def draw_problems(skill: Skill, count: int, seed: int, time_step: float, spread: Spread = Spread()) -> Problems:
    """`count` problems around a skill, whose gains `Gains.check` allows at `time_step`, s."""
    rng = np.random.default_rng(seed)
    tau = skill.tau * np.exp(rng.uniform(*np.log(spread.tau), count))
    box = rng.uniform(*spread.box_m, count)
    open_m = box + 2.0 * spread.clearance_m
    start = skill.start + spread.start_m * rng.normal(size=(count, 6, 3))
    least = np.maximum(-spread.hands_error_m, spread.nearest_m - open_m)
    wanted = open_m + rng.uniform(least, spread.hands_error_m)
    k_1, k_2 = draw_gains(rng, count, time_step, spread.gain)
    return Problems(
        start=with_hands_apart(start, wanted),
        goal=skill.goal + spread.goal_m * rng.normal(size=(count, 6, 3)),
        tau=tau,
        open_m=open_m,
        closed_m=box - 2.0 * spread.squeeze_m,
        close_s=tau * rng.uniform(*spread.close, count),
        open_s=tau * rng.uniform(*spread.open, count),
        closing_s=tau * rng.uniform(*spread.closing, count),
        half_width_m=np.exp(rng.uniform(*np.log(spread.half_width_m), count)),
        funnel_m=rng.uniform(*spread.funnel_m, count),
        k_1=k_1,
        k_2=k_2,
    )


def with_hands_apart(x: np.ndarray, distance: np.ndarray) -> np.ndarray:
    """The points (P, 6, 3) with both arms moved along the hands' line until the hands are `distance` (P,) m apart."""
    own, partner = LINKS[HANDS].a, LINKS[HANDS].b
    rho = link_lengths(x)[..., HANDS]
    shift = (0.5 * (distance / rho - 1.0))[..., None] * (x[..., partner, :] - x[..., own, :])
    moved = x.copy()
    moved[..., :3, :] -= shift[..., None, :]
    moved[..., 3:, :] += shift[..., None, :]
    return moved


def draw_gains(rng, count: int, time_step: float, span: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
    """K_1 and k_2, (count,) each, 1/s: log-uniform on `span`, of those that allow `time_step`, s.

    Raises:
        BlfDmpError: hardly any in the span do.
    """
    found: list[tuple[float, float]] = []
    for _ in range(100):
        drawn = np.exp(rng.uniform(*np.log(span), (count, 2)))
        found += [(k_1, k_2) for k_1, k_2 in drawn if Gains(k_1, k_2).largest_step() >= time_step]
        if len(found) >= count:
            k_1, k_2 = np.array(found[:count]).reshape(count, 2).T
            return k_1, k_2
    raise BlfDmpError(
        f"random problems: hardly any gains from {span[0]:g} to {span[1]:g} 1/s allow a step of {time_step:g} s; "
        "take a shorter step or another span"
    )


@dataclass(frozen=True)
class Job:
    """Problems to be run with one law.

    Attributes:
        law: name; the default law takes the problems' own gains, another one `gains`, or its defaults for None.
        filling: of the opened funnel, see `Bands.opened_to`.
    """

    skill: Skill
    bones: np.ndarray
    rate: float
    problems: Problems
    law: str
    time_step: float
    gains: Any = None
    filling: float = 0.8


@dataclass(frozen=True)
class Outcome:
    """What became of P problems.

    Attributes:
        least: (P, 5) least margin 1 - |xi| of every link, -inf where the motion diverged.
        left_s: (P, 5) when a link first left its band, s, or NEVER.
    """

    least: np.ndarray
    left_s: np.ndarray

    @property
    def left(self) -> np.ndarray:
        """(P, 5): whether a link left its band."""
        return self.left_s < NEVER


def run_job(job: Job) -> Outcome:
    """All problems of a job in one batch, each for its own duration."""
    problems = job.problems
    tau = problems.tau[:, None]
    gains = Gains(problems.k_1[:, None], problems.k_2[:, None]) if job.law == "default" else job.gains
    bands = problems.bands(job.bones, job.rate, job.filling)
    samples = int(np.floor(problems.tau.max() / job.time_step)) + 1
    least = np.full((len(problems), len(LINKS)), np.inf)
    left_s = np.full_like(least, NEVER)
    with np.errstate(all="ignore"):  # A law that diverges overflows.
        for k, sample in enumerate(
            steps(
                job.skill,
                time_step=job.time_step,
                samples=samples,
                bands=bands,
                law=law(job.law),
                gains=gains,
                start=problems.start,
                goal=problems.goal,
                tau=tau[..., None],
            )
        ):
            margin = margins(sample.x, sample.bands)
            running = sample.t <= tau
            left = running & ~(margin > 0.0) & (left_s == NEVER)
            left_s[left] = sample.t
            # A number that is not finite is a motion that diverged.
            margin = np.where(running, np.where(np.isfinite(margin), margin, -np.inf), np.inf)
            least = np.minimum(least, margin)
            if k % 100 == 0 and np.all(least == -np.inf):
                break
    return Outcome(least, left_s)


def run_jobs(
    jobs: Sequence[Job],
    workers: int = 1,
    progress: Callable[[float], None] = lambda share: None,
    chunk: int = CHUNK,
) -> list[Outcome]:
    """The outcomes of all jobs, shared out to processes in chunks of problems of similar duration.

    Args:
        workers: processes; with one, everything runs in this process.
        progress: called with the share done, 0 to 1.
        chunk: problems a batch.
    """
    parts: list[tuple[int, np.ndarray]] = []
    for j, job in enumerate(jobs):
        longest_first = np.argsort(-job.problems.tau, kind="stable")
        parts += [(j, longest_first[i : i + chunk]) for i in range(0, len(job.problems), chunk)]
    work = [replace(jobs[j], problems=jobs[j].problems[index]) for j, index in parts]
    costs = np.array([len(part.problems) * part.problems.tau.max() / part.time_step for part in work])
    outcomes = [
        Outcome(np.empty((len(job.problems), len(LINKS))), np.empty((len(job.problems), len(LINKS)))) for job in jobs
    ]
    with _map(workers) as run:
        for i, result in enumerate(run(run_job, work)):
            j, index = parts[i]
            outcomes[j].least[index], outcomes[j].left_s[index] = result.least, result.left_s
            progress(float(costs[: i + 1].sum() / costs.sum()))
    return outcomes


_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


@contextmanager
def _map(workers: int) -> Iterator[Callable]:
    """`map`, over processes that leave the cores to each other: one thread each."""
    if workers <= 1:
        yield map
        return
    before = {name: os.environ.get(name) for name in _THREADS}
    os.environ.update(dict.fromkeys(_THREADS, "1"))
    # Spawned, not forked: the libraries here have threads, and read the variables above when they are loaded.
    pool = ProcessPoolExecutor(workers, get_context("spawn"), _die_of_an_interruption)
    try:
        yield pool.map
    finally:
        pool.shutdown(cancel_futures=True)
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


def _die_of_an_interruption() -> None:
    """Ctrl-C reaches the workers too: they end without a word, and the parent tells."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
