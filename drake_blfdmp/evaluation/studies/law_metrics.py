"""What the studies of the laws measure, on one rollout of a task: violations, distances, directions, the two rounds."""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from drake_blfdmp.evaluation.metrics import rms_distance, samples_until_inside
from drake_blfdmp.evaluation.studies.gain_search import coupled_links, demonstrated_motion
from drake_blfdmp.planning.scenario import Scenario
from drake_blfdmp.planning.task import LawGains, Task
from drake_blfdmp.skeleton import ELBOWS, HANDS, SHOULDERS, WRISTS
from drake_blfdmp.skill.bands import Bands
from drake_blfdmp.skill.geometry import link_vectors
from drake_blfdmp.skill.laws import law as law_named
from drake_blfdmp.skill.laws.follower import PublishedGains, follower_acceleration
from drake_blfdmp.skill.laws.primitive import Primitive
from drake_blfdmp.skill.laws.rounds import BETWEEN_HANDS, FOREARMS, OTHER_WRISTS, UPPER_ARMS, common, interval
from drake_blfdmp.skill.rollout import Rollout, margins, roll_out


@dataclass(frozen=True)
class LawResult:
    """How a law did; links are those that it couples.

    Attributes:
        outside: samples at which a link is outside the opened bands; `outside_paper` outside those of (13), (20).
        samples: all of them.
        first_s: when the opened bands are first left, infinite where never.
        least_margin: of the opened bands, share of the half width; negative infinity where numbers overflow.
        until_inside: the recording's samples until every link is in the paper's own band for good; None where never.
        distance_m: RMS of the six points to the demonstrated motion.
        from_goal_m: the farthest point's distance from its own goal at the end.
    """

    outside: int
    outside_paper: int
    samples: int
    first_s: float
    least_margin: float
    until_inside: int | None
    distance_m: float
    from_goal_m: float


def roll_out_law(
    scenario: Scenario, task: Task, name: str, *, gains: Any = None, time_step: float | None = None
) -> Rollout:
    """The task's skill with the law of that name, the scenario's gains for it by default; numbers may overflow.

    `none` has the bands beside it, which it ignores.
    """
    with np.errstate(all="ignore"):
        return roll_out(
            task.skill,
            time_step=scenario.simulation.skill_time_step if time_step is None else time_step,
            bands=task.bands,
            law=law_named(name),
            gains=LawGains(replace(scenario, law=name)) if gains is None else gains,
        )


def measure(rollout: Rollout, task: Task, name: str, bands: Bands | None = None) -> LawResult:
    """The figures of a rollout with the law of that name, against `bands`, the task's by default."""
    bands = task.bands if bands is None else bands
    links = coupled_links(name)
    t = rollout.t
    with np.errstate(all="ignore"):
        room = margins(rollout.x, bands.evaluate(t))[:, links]
        paper = bands.paper().evaluate(t)
        paper_room = margins(rollout.x, paper)[:, links]
        distance = rms_distance(rollout.x, demonstrated_motion(task, t))
        lengths = rollout.lengths
        from_goal = float(np.linalg.norm(rollout.x[-1] - task.skill.goal, axis=-1).max())
    kept = np.all(room > 0.0, axis=-1)
    whole = bool(np.all(np.isfinite(rollout.x)))
    counts: list[int | None] = [None]
    if whole:
        counts = [samples_until_inside(t, lengths[:, i], paper[:, 0, i], paper[:, 1, i]) for i in links]
    known = [count for count in counts if count is not None]
    return LawResult(
        outside=int(np.sum(~kept)),
        outside_paper=int(np.sum(~np.all(paper_room > 0.0, axis=-1))),
        samples=len(t),
        first_s=float(t[np.argmin(kept)]) if not np.all(kept) else np.inf,
        least_margin=float(room.min()) if whole else -np.inf,
        until_inside=max(known) if len(known) == len(counts) else None,
        distance_m=distance if np.isfinite(distance) else np.inf,
        from_goal_m=from_goal if np.isfinite(from_goal) else np.inf,
    )


def turned(x) -> np.ndarray:
    """How far each link has turned from its direction at the first sample: (N, 5), rad, of points (N, 6, 3)."""
    r = link_vectors(x)
    n = r / np.linalg.norm(r, axis=-1, keepdims=True)
    across = np.linalg.norm(np.cross(n[0], n), axis=-1)
    return np.arctan2(across, np.sum(n[0] * n, axis=-1))


@dataclass(frozen=True)
class CommonResults:
    """Remark 2 along a rollout of N samples.

    Attributes:
        empty: (N, 2, 3) where a wrist's conditions (15) have no common interval on an axis.
        widening: (N, 2, 3) how far the hands' interval had to be widened there, m.
        elbows_empty: (N, 2, 3) the same of (16), where no condition has priority.
    """

    empty: np.ndarray
    widening: np.ndarray
    elbows_empty: np.ndarray


def common_results(rollout: Rollout) -> CommonResults:
    """Where (15) and (16) have a common result, at the states that the rollout came through."""
    x, zero = rollout.x, np.zeros_like(rollout.x)
    sides = [
        interval(own, partner, link, x, zero, zero, rollout.bands)
        for own, partner, link in (
            (WRISTS, ELBOWS, FOREARMS),
            (WRISTS, OTHER_WRISTS, BETWEEN_HANDS),
            (ELBOWS, SHOULDERS, UPPER_ARMS),
            (ELBOWS, WRISTS, FOREARMS),
        )
    ]
    found, empty = common(sides[0], sides[1], True)
    short = np.maximum(sides[1].lower - found.lower, found.upper - sides[1].upper)
    return CommonResults(empty, np.where(empty, np.maximum(short, 0.0), 0.0), common(sides[2], sides[3], False)[1])


def first_round(
    x,
    velocity,
    nominal_acceleration,
    previous_acceleration,
    bands,
    primitive: Primitive,
    gains: PublishedGains = PublishedGains(),
):
    """Round 1 alone, as a law: (14), the wrists follow the elbows, which nothing couples. As in `skill.laws`."""
    bounds = interval(WRISTS, ELBOWS, FOREARMS, x, velocity, nominal_acceleration, bands)
    wanted = follower_acceleration(
        x[..., WRISTS, :],
        velocity[..., WRISTS, :],
        bounds.lower,
        bounds.upper,
        bounds.velocity,
        bounds.acceleration,
        primitive.tau,
        gains,
    )
    coupling = np.zeros_like(x)
    coupling[..., WRISTS, :] = wanted - nominal_acceleration[..., WRISTS, :]
    return coupling


def second_round_distance(first: Rollout, bands: Bands) -> np.ndarray:
    """The hands' distance (N,), m, if round 2 holds both wrists at d_j from where round 1 left the other.

    With D between round 1's wrists along n, x_l = x_r^1 - d n and x_r = x_l^1 + d n are |2 d - D| apart: the
    error changes its sign and not its size.
    """
    return np.abs(2.0 * bands.desired(first.t)[0][:, HANDS] - first.lengths[:, HANDS])


@dataclass(frozen=True)
class OfflineOrder:
    """Round 1 rolled out to its end, and round 2 from its result: the procedure as the paper describes it.

    Attributes:
        samples: N.
        forearms_outside: samples at which a forearm leaves its opened band in round 1.
        first_m, second_m: (N,) how far the hands are from d_j after either round.
        outside: (N,) where they are then outside their opened band.
    """

    samples: int
    forearms_outside: int
    first_m: np.ndarray
    second_m: np.ndarray
    outside: np.ndarray


def offline_order(task: Task, gains: PublishedGains, *, time_step: float) -> OfflineOrder:
    """What comes of that order on a task; time_step in s."""
    first = roll_out(task.skill, time_step=time_step, bands=task.bands, law=first_round, gains=gains)
    desired = task.bands.desired(first.t)[0][:, HANDS]
    second = np.abs(second_round_distance(first, task.bands) - desired)
    return OfflineOrder(
        samples=len(first.t),
        forearms_outside=int(np.sum(np.any(first.margins[:, FOREARMS] <= 0.0, axis=-1))),
        first_m=np.abs(first.lengths[:, HANDS] - desired),
        second_m=second,
        outside=second >= task.bands.half_widths(first.t)[0][:, HANDS],
    )


def cost_ratio(
    rollout: Rollout, names: tuple[str, str], primitive: Primitive, batch: int, gains: tuple[Any, Any], repeats: int
) -> float:
    """CPU time of one evaluation of the first law by that of the second, both at the rollout's states; the median.

    Args:
        batch: states at once, spread over the rollout; repeats: of the measurement, which take turns.
    """
    pick = np.linspace(0, len(rollout.t) - 1, batch).astype(int)
    if rollout.bands is None:
        raise ValueError("this rollout has no bands")
    zero = np.zeros((batch, 6, 3))
    arguments = rollout.x[pick], rollout.velocity[pick], zero, zero, rollout.bands[pick], primitive

    def seconds(law: Callable, own: Any) -> float:
        count = max(1, 200 // batch)
        begun = time.process_time()
        for _ in range(count):
            law(*arguments, gains=own)
        return (time.process_time() - begun) / count

    laws = [law_named(name) for name in names]
    pairs = [[seconds(law, own) for law, own in zip(laws, gains, strict=True)] for _ in range(repeats)]
    first, second = np.median(pairs, axis=0)
    return float(first / max(second, 1e-9))
