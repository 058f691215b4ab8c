"""Which of several recorded people is meant: the one named, else the one who moves both hands most."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from drake_blfdmp.demonstration.raw_recording import Body
from drake_blfdmp.errors import RecordingError
from drake_blfdmp.skeleton import WRISTS

_FARTHEST = 1e9  # In any unit; false for NaN, too.


class Person(NamedTuple):
    """The id in the file, the points, and a sentence on the choice (empty where there was none)."""

    name: str
    body: Body
    evidence: str


def choose_person(where: str, bodies: Mapping[str, Body], given: str | None = None) -> Person:
    """The person `given`, or else the one whose less moving hand has the longest way.

    Raises:
        RecordingError: there is nobody, or nobody of that name.
    """
    if not bodies:
        raise RecordingError(f"{where}: holds no person; record with somebody in view")
    if given is not None:
        if given not in bodies:
            raise RecordingError(f"{where}: holds no person '{given}'; it has {', '.join(bodies)}")
        return Person(given, bodies[given], f"person: {given}, as set" if len(bodies) > 1 else "")
    paths = {name: _hand_path(body) for name, body in bodies.items()}
    best = max(paths, key=lambda name: (paths[name], len(bodies[name].frames)))
    if len(bodies) == 1:
        return Person(best, bodies[best], "")
    others = ", ".join(f"{name}" for name in paths if name != best)
    return Person(
        best,
        bodies[best],
        f"person: {best} of {len(bodies)}, whose hands move most ({len(bodies[best].frames)} frames; others: {others})",
    )


def _hand_path(body: Body) -> float:
    """The shorter of the two wrists' ways, in the file's unit, with single frames' jumps cut."""
    ways = []
    for wrist in WRISTS:
        seen = body.x[(np.abs(body.x[:, wrist]) < _FARTHEST).all(axis=-1), wrist]
        steps = np.linalg.norm(np.diff(seen, axis=0), axis=-1)
        # A jump is no way: steps beyond ten times the usual are cut to that.
        usual = np.quantile(steps, 0.9) if len(steps) else 0.0
        ways.append(float(np.minimum(steps, 10.0 * usual).sum()))
    return min(ways)
