"""Takes of the virtual Kinect with the truth beside them, and tables of them and of surveyed recordings."""

from collections.abc import Callable, Sequence

import numpy as np

from drake_blfdmp.demonstration.modelled_person import ModelledPerson, held_interval
from drake_blfdmp.demonstration.virtual_kinect import record_hold_and_place
from drake_blfdmp.evaluation.studies.noise_metrics import (
    KINDS,
    ErrorStatistics,
    SurveyedFile,
    distinct_frames,
    error_statistics,
    survey_recording,
)
from drake_blfdmp.evaluation.study import Table

Take = tuple[np.ndarray, np.ndarray]
"""Times (N,), s, and errors (N, 6, 3), m, of one recording."""

SPREAD_KEYS = ("mean_m", "std_m", "min_m", "max_m")


def film(
    person: ModelledPerson, seeds: range, progress: Callable[[str, float], None] = lambda what, share: None
) -> tuple[list[Take], list[SurveyedFile]]:
    """A take a seed, and what each take's recording tells by itself.

    Args:
        progress: called with what is done and the share of it done, 0 to 1.
    """
    takes, surveyed = [], []
    for i, seed in enumerate(seeds):
        progress(f"filming, seed {seed}", i / len(seeds))
        recording, truth = record_hold_and_place(person, seed=seed)
        rows = distinct_frames(recording)
        takes.append((recording.t[rows], (recording.x - truth)[rows]))
        surveyed.append(survey_recording(f"virtual Kinect, seed {seed}", recording))
    return takes, surveyed


def statistics(
    takes: Sequence[Take], keep: Callable[[np.ndarray], np.ndarray] = lambda t: np.full(len(t), True)
) -> dict[str, ErrorStatistics]:
    """Statistics of every kind of point over all takes, at the times for which `keep(t)` is true."""
    longest = max(len(t) for t, _ in takes)
    padded = np.full((len(takes), longest, 6, 3), np.nan)
    for row, (t, errors) in zip(padded, takes, strict=True):
        row[: len(t)][keep(t)] = errors[keep(t)]
    return {kind: error_statistics(padded[:, :, list(points)]) for kind, points in KINDS.items()}


def error_table(takes: Sequence[Take]) -> Table:
    """Errors of every kind of point: of all samples, and RMS while the box is held and while it is not."""
    start, end = held_interval()
    held = statistics(takes, lambda t: (t >= start) & (t <= end))
    free = statistics(takes, lambda t: (t < start) | (t > end))
    every = statistics(takes)
    table: dict[str, list] = {"points": list(KINDS)}
    for key in ("rms_m", "median_m", "p95_m", "largest_m", "jump_share"):
        table[key] = [getattr(every[kind], key) for kind in KINDS]
    for axis in range(3):
        table[f"rms_{'xyz'[axis]}_m"] = [every[kind].axis_rms_m[axis] for kind in KINDS]
    table["rms_held_m"] = [held[kind].rms_m for kind in KINDS]
    table["rms_free_m"] = [free[kind].rms_m for kind in KINDS]
    return Table(table)


def spreads_of(surveyed: Sequence[SurveyedFile], length: str) -> np.ndarray:
    """Mean, standard deviation, least and greatest of a length of each recording (K, 4), m; NaN where unknown."""
    return np.array([[getattr(one.spreads.get(length), key, np.nan) for key in SPREAD_KEYS] for one in surveyed])


def recording_table(readable: Sequence[SurveyedFile], lengths: Sequence[str]) -> Table:
    """Size, spreads of the named lengths and jitter of every recording."""
    table: dict[str, list] = {
        "recording": [one.name for one in readable],
        "frames": [one.samples for one in readable],
        "rate_hz": [one.rate_hz for one in readable],
    }
    for name in lengths:
        values = spreads_of(readable, name)
        table |= {f"{name}_{key}": list(column) for key, column in zip(SPREAD_KEYS, values.T, strict=True)}
    for column, kind in enumerate(KINDS):
        table[f"jitter_{kind}_m"] = [one.jitter_m[column] for one in readable]
    table["no_held_box_because"] = [one.not_held for one in readable]
    return Table(table)
