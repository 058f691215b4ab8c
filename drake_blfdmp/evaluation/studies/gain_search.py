"""The search for a law's gains: a grid, all of it one batch rollout of a task, one criterion for every law.

First the fewest samples outside the (opened) bands of the links that the law couples, then the least distance to the
demonstrated motion; over several tasks together the samples add up. A member whose numbers overflow counts as outside
from there on. `docs/laws.md` has the results.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields
from itertools import product
from typing import Any

import numpy as np

from drake_blfdmp.errors import ScenarioError
from drake_blfdmp.evaluation.study import Table
from drake_blfdmp.planning.task import Task
from drake_blfdmp.skeleton import HANDS, LINKS
from drake_blfdmp.skill.laws import law as law_named
from drake_blfdmp.skill.laws.follower import PublishedGains
from drake_blfdmp.skill.laws.gams import GamsGains
from drake_blfdmp.skill.rollout import margins, steps
from drake_blfdmp.skill.sampled import Gains

_PUBLISHED = {
    "k_z": (30.0, 100.0, 200.0, 300.0, 500.0, 1000.0),
    "d_z": (0.1, 0.2, 0.3, 0.5, 1.0, 3.0),
    "largest_rate": (25.0, 50.0, 100.0, 150.0, 200.0),
}
GRIDS: dict[str, Mapping[str, Sequence[float]]] = {
    "default": {"k_1": (4.0, 6.0, 8.0, 12.0, 16.0), "k_2": (10.0, 15.0, 20.0, 30.0, 40.0)},
    "published": _PUBLISHED,
    "published_loop": _PUBLISHED,
    "published_lagged": {
        "k_z": (1.0, 10.0, 100.0, 300.0, 1000.0),
        "d_z": (0.03, 0.3, 1.0, 3.0, 30.0),
        "largest_rate": (1.0, 3.0, 10.0, 30.0, 150.0),
    },
    "gams": {"c_k": (10.0, 30.0, 100.0, 200.0, 300.0, 500.0, 700.0, 1000.0), "c_2": (0.0, 1.0, 3.0, 10.0, 30.0)},
}
"""What is searched for each law, in the units of its gains."""

DURATIONS = (0.5, 0.7, 1.0, 1.4, 2.0)
"""The task is searched at these multiples of its duration: gains that hold at one alone are of little use."""


def _kind(law: str) -> Callable:
    return {"default": Gains, "gams": GamsGains}.get(law, PublishedGains)


@dataclass(frozen=True)
class GainSearch:
    """A finished search over a grid of B members.

    Attributes:
        law: its name.
        time_step: s.
        samples: of every member.
        gains: name -> (B,) values.
        outside: (B,) samples at which any coupled link is outside its band.
        first: (B,) time at which one first is, s; infinite where none ever is.
        distance: (B,) RMS distance of the six points to the demonstrated motion, m; infinite where numbers overflow.
    """

    law: str
    time_step: float
    samples: int
    gains: Mapping[str, np.ndarray]
    outside: np.ndarray
    first: np.ndarray
    distance: np.ndarray

    @property
    def best(self) -> int:
        """The member that the criterion prefers."""
        return int(np.lexsort((self.distance, self.outside))[0])

    def gains_of(self, member: int) -> Any:
        """The gains of a member, of the law's own type."""
        return _kind(self.law)(**{name: float(values[member]) for name, values in self.gains.items()})

    @property
    def kept(self) -> int:
        """How many members keep every band of the links that the law couples."""
        return int(np.sum(self.outside == 0))

    def member(self, gains: Any) -> int | None:
        """The member with these gains, of the law's own type; None where the grid has none."""
        same = np.all([np.isclose(values, getattr(gains, name)) for name, values in self.gains.items()], axis=0)
        return int(np.flatnonzero(same)[0]) if np.any(same) else None

    def table(self) -> Table:
        """All members, best first."""
        order = np.lexsort((self.distance, self.outside))
        columns = {name: values[order] for name, values in self.gains.items()}
        return Table(
            columns
            | {
                "samples_outside": self.outside[order],
                "first_outside_s": self.first[order],
                "rms_to_demonstration_m": self.distance[order],
            }
        )


def best_for_all(searches: Sequence[GainSearch]) -> int:
    """The member of one grid that the criterion prefers for several laws together: both figures summed over the laws.

    Raises:
        ScenarioError: the searches are over different grids.
    """
    for search in searches[1:]:
        if [*map(list, search.gains.values())] != [*map(list, searches[0].gains.values())]:
            raise ScenarioError("gain search: only searches over the same grid have a best member together")
    outside = np.sum([search.outside for search in searches], axis=0)
    return int(np.lexsort((np.sum([search.distance for search in searches], axis=0), outside))[0])


def coupled_links(law: str) -> np.ndarray:
    """Indices of the links that the law of this name couples: Gams et al. couple the hands alone."""
    return np.array([HANDS]) if law == "gams" else np.arange(len(LINKS))


def search_gains(
    task: Task,
    law: str,
    grid: Mapping[str, Sequence[float]] | None = None,
    *,
    time_step: float,
    duration: float | None = None,
    progress: Callable[[float], None] = lambda share: None,
) -> GainSearch:
    """Roll the task out with every combination of the grid at once.

    Args:
        law: one of `GRIDS`.
        grid: gain -> values, `GRIDS[law]` by default.
        time_step: s; duration: s, that of the skill by default.

    Raises:
        ScenarioError: the law has no gains, or the grid names one that it does not have.
    """
    if law not in GRIDS:
        raise ScenarioError(f"gain search: '{law}' has no gains to search for; choose from {', '.join(GRIDS)}")
    grid = GRIDS[law] if grid is None else grid
    kind = _kind(law)
    known = [field.name for field in fields(kind)]
    for name in grid:
        if name not in known:
            raise ScenarioError(f"gain search: '{law}' has no gain '{name}'; there are {', '.join(known)}")
    combinations = np.array(list(product(*grid.values())), dtype=float)
    gains = dict(zip(grid, combinations.T, strict=True))
    members = len(combinations)
    # The default law's gains meet arrays (B, links), the others' (B, points, axes).
    shape = (members, 1) if kind is Gains else (members, 1, 1)
    options: Any = kind(**{name: values.reshape(shape) for name, values in gains.items()})
    skill = task.skill
    n = round((skill.tau if duration is None else duration) / time_step) + 1
    demonstrated = demonstrated_motion(task, time_step * np.arange(n))
    links = coupled_links(law)
    outside, squares = np.zeros(members, dtype=int), np.zeros(members)
    first = np.full(members, np.inf)
    start = np.broadcast_to(skill.start, (members, 6, 3))
    with np.errstate(all="ignore"):
        samples = steps(
            skill, time_step=time_step, samples=n, bands=task.bands, law=law_named(law), gains=options, start=start
        )
        for k, sample in enumerate(samples):
            lost = ~np.all(margins(sample.x, sample.bands)[:, links] > 0.0, axis=-1)
            outside += lost
            first = np.where(lost & np.isinf(first), sample.t, first)
            squares += np.mean(np.sum((sample.x - demonstrated[k]) ** 2, axis=-1), axis=-1)
            if k % 200 == 0:
                progress((k + 1) / n)
    distance = np.sqrt(squares / n)
    distance[~np.isfinite(distance)] = np.inf
    return GainSearch(law, time_step, n, gains, outside, first, distance)


def search_tasks(
    tasks: Sequence[Task],
    law: str,
    grid: Mapping[str, Sequence[float]] | None = None,
    *,
    time_step: float,
    duration: float | None = None,
    progress: Callable[[float], None] = lambda share: None,
) -> GainSearch:
    """One search over several tasks: samples add up, distances count by their mean square, the earliest time counts.

    Args are those of `search_gains`.
    """
    searches = []
    for i, task in enumerate(tasks):
        searches.append(search_gains(task, law, grid, time_step=time_step, duration=duration))
        progress((i + 1) / len(tasks))
    return GainSearch(
        law,
        time_step,
        sum(search.samples for search in searches),
        searches[0].gains,
        np.sum([search.outside for search in searches], axis=0),
        np.min([search.first for search in searches], axis=0),
        np.sqrt(np.mean([search.distance**2 for search in searches], axis=0)),
    )


def search_steps(
    task: Task,
    law: str,
    grid: Mapping[str, Sequence[float]] | None = None,
    *,
    time_steps: Sequence[float],
    duration: float,
) -> Table:
    """A search at each of these time steps, s, a row each: how many gains keep the bands, and which do for longest."""
    searches = [search_gains(task, law, grid, time_step=h, duration=duration) for h in time_steps]
    longest = [int(np.argmax(search.first)) for search in searches]
    return Table(
        {
            "step_s": list(time_steps),
            "gains_tried": [len(search.outside) for search in searches],
            "that_keep_all_bands": [search.kept for search in searches],
            "longest_inside_s": [float(search.first[i]) for search, i in zip(searches, longest, strict=True)],
            "with": [
                ", ".join(f"{name} {values[i]:g}" for name, values in search.gains.items())
                for search, i in zip(searches, longest, strict=True)
            ],
        }
    )


def demonstrated_motion(task: Task, t: np.ndarray) -> np.ndarray:
    """The motion that the task's skill was learned from, at times (N,), s, held after its end: (N, 6, 3), m."""
    motion = task.motion
    flat = motion.x.reshape(len(motion.t), 18)
    stretch = motion.t[-1] / task.skill.tau
    return np.stack([np.interp(t * stretch, motion.t, column) for column in flat.T], axis=-1).reshape(len(t), 6, 3)
