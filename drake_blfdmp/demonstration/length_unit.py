"""Which unit a file's lengths are in: what is stated, checked against the one ruler every recording has, the arms."""

from typing import NamedTuple

import numpy as np

from drake_blfdmp.demonstration.bones import FOREARMS, PLAUSIBLE_BONE, UPPER_ARMS, link_lengths
from drake_blfdmp.errors import RecordingError

METRES = {"m": 1.0, "cm": 0.01, "mm": 0.001}
"""Metres per unit of length."""

_LEAST_RUN = 3  # Frames in another unit that are no jump of the sensor any more.


class LengthUnit(NamedTuple):
    """A key of METRES, and a sentence on how it was found."""

    unit: str
    evidence: str


def find_length_unit(
    where: str, x: np.ndarray, frames: np.ndarray, *, stated: str | None = None, given: str | None = None
) -> LengthUnit:
    """The unit of (N, 6, 3) points.

    Args:
        where: the file, for messages.
        x: as they stand in the file; NaN where missing.
        frames: (N,) frame numbers, for messages.
        stated: by the file or its format; the arms overrule it where they are plausible in another unit alone.
        given: by the user; nothing overrules it.

    Raises:
        RecordingError: the unit changes within the file.
    """
    lengths = link_lengths(x)
    bones = np.stack([_row_median(lengths[:, pair]) for pair in (UPPER_ARMS, FOREARMS)], axis=-1)
    _require_one_unit(where, bones, frames)
    if given is not None:
        return LengthUnit(given, f"unit: {given}, as set")
    seen = np.isfinite(bones).all(axis=1)
    if not seen.any():
        return LengthUnit(stated or "m", f"unit: {stated or 'm'}, {_source(stated)}; no whole arm is seen to check it")
    upper, fore = np.median(bones[seen], axis=0)
    measured = f"upper arms measure {upper:.4g} and forearms {fore:.4g}"
    fitting = [unit for unit, metres in METRES.items() if _plausible(np.array([upper, fore]) * metres)]
    if stated in fitting:
        return LengthUnit(stated, f"unit: {stated}, {_source(stated)}; {measured}")
    if fitting:
        against = f", although {_source(stated)} {stated}" if stated else ""
        return LengthUnit(fitting[0], f"unit: {fitting[0]}, for {measured}{against}")
    return LengthUnit(stated or "m", f"unit: {stated or 'm'}, {_source(stated)}; {measured}, which no arm does")


def _source(stated: str | None) -> str:
    return "the file or its format says" if stated else "assumed"


def _plausible(bones: np.ndarray) -> np.ndarray:
    return np.all((bones >= PLAUSIBLE_BONE[0]) & (bones <= PLAUSIBLE_BONE[1]), axis=-1)


def _row_median(pair: np.ndarray) -> np.ndarray:
    """(N,) the mean of the two sides, or the one that is seen; NaN where neither is."""
    seen = np.isfinite(pair)
    return np.where(seen.any(axis=1), np.where(seen, pair, 0.0).sum(axis=1) / np.maximum(seen.sum(axis=1), 1), np.nan)


def _require_one_unit(where: str, bones: np.ndarray, frames: np.ndarray) -> None:
    units = np.full(len(bones), -1)
    for index, metres in enumerate(METRES.values()):
        units[_plausible(bones * metres)] = index
    known = np.flatnonzero(units >= 0)
    if len(known) == 0:
        return
    usual = np.bincount(units[known]).argmax()
    other = units[known] != usual
    runs = np.flatnonzero(np.convolve(other, np.ones(_LEAST_RUN), "valid") == _LEAST_RUN)
    if len(runs):
        names = tuple(METRES)
        first = known[runs[0]]
        raise RecordingError(
            f"{where}: the units are mixed: at frame {frames[first]} the arms measure {bones[first, 0]:.4g} and "
            f"{bones[first, 1]:.4g} ({names[units[first]]}), elsewhere they are in {names[usual]}; "
            "convert them or cut one part with --frames"
        )
