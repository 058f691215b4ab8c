"""The competitors' gains for random problems: the best of a grid on other problems of the same kind."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, replace
from itertools import product
from typing import Any

from drake_blfdmp.evaluation.studies.guarantee_metrics import violations
from drake_blfdmp.evaluation.studies.random_problems import Job, Problems, run_jobs
from drake_blfdmp.evaluation.study import Table
from drake_blfdmp.skeleton import HANDS
from drake_blfdmp.skill.laws.follower import PublishedGains
from drake_blfdmp.skill.laws.gams import GamsGains

PUBLISHED = [
    PublishedGains(k_z, d_z, 0.0, rate)
    for k_z, d_z, rate in product((100.0, 300.0, 1000.0), (0.03, 0.1, 0.3), (200.0, 400.0))
]
CANDIDATES: Mapping[str, Sequence[Any]] = {
    "published": PUBLISHED,
    "published_loop": PUBLISHED,
    "gams": [GamsGains(c_k, c_2) for c_k, c_2 in product((100.0, 300.0, 1000.0), (0.0, 3.0, 10.0))],
}
"""What is tried for each law."""


def search_on_problems(
    base: Job,
    problems: Problems,
    candidates: Mapping[str, Sequence[Any]] = CANDIDATES,
    workers: int = 1,
    progress: Callable[[float], None] = lambda share: None,
) -> tuple[dict[str, Any], Table]:
    """The gains of each law with which it leaves its bands in the fewest problems, and all that were tried.

    A law that couples the hands alone is judged by the hands; of equals the first counts.

    Args:
        base: everything but law, gains and problems.
        problems: to search on; others than those to be judged by.
        candidates: law -> gains to try.
        workers, progress: as in `run_jobs`.
    """
    tried = [(law, gains) for law, several in candidates.items() for gains in several]
    jobs = [replace(base, problems=problems, law=law, gains=gains) for law, gains in tried]
    # Small batches, so that both workers have something to do until the end.
    outcomes = run_jobs(jobs, workers, progress)
    left = [
        int(outcome.left[:, HANDS].sum()) if law == "gams" else violations(outcome).count
        for (law, _), outcome in zip(tried, outcomes, strict=True)
    ]
    best = {}
    for law in candidates:
        own = [(count, i) for i, ((name, _), count) in enumerate(zip(tried, left, strict=True)) if name == law]
        best[law] = tried[min(own)[1]][1]
    return best, Table(
        {
            "law": [law for law, _ in tried],
            "gains": [", ".join(f"{name} {value:g}" for name, value in asdict(gains).items()) for _, gains in tried],
            "problems": [len(problems)] * len(tried),
            "left": left,
        }
    )
