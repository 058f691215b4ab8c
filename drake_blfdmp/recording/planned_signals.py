"""What a run's figures need that is no signal of it: known before it starts, by the skill's clock. Without pydrake."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from drake_blfdmp.quaternions import interpolated_poses
from drake_blfdmp.recording.mcap_file import RecorderError
from drake_blfdmp.recording.plain_data import PlainDataError, npz_arrays, npz_bytes

ATTACHMENT = "planned.npz"
"""Name under which a recording holds it."""

MEASURED = "measured.npz"
"""Name under which it holds what was measured once the run was over."""

MOST_SAMPLES = 20_000
"""More are not kept; those that are lie evenly in the run."""

_JOINTS = 14


@dataclass(frozen=True)
class PlannedSignals:
    """K samples by the skill's clock, and what does not change. Frames and orders as in `RunLog`.

    Attributes:
        clock: (K,) growing, s.
        uncoupled: (K, 6, 3) the skill without coupling, m.
        demonstrated: (K, 6, 3) what it was learned from, m.
        spread: (K, 6, 3) over the recordings it was learned from, m; None of one recording.
        box: (K, 7) X_WB as qw qx qy qz x y z; None in a motion without a box.
        q_lower, q_upper: (14,) rad; v_limit (14,) rad/s; effort_limit (14,) N m.
    """

    clock: np.ndarray
    uncoupled: np.ndarray
    demonstrated: np.ndarray
    spread: np.ndarray | None
    box: np.ndarray | None
    q_lower: np.ndarray
    q_upper: np.ndarray
    v_limit: np.ndarray
    effort_limit: np.ndarray

    def points_at(self, name: str, clock: np.ndarray) -> np.ndarray:
        """(N, 6, 3) of `uncoupled`, `demonstrated` or `spread` at times (N,) of the skill's clock, held outside."""
        points = getattr(self, name)
        columns = [np.interp(clock, self.clock, column) for column in points.reshape(len(points), 18).T]
        return np.stack(columns, axis=-1).reshape(-1, 6, 3)

    def spread_at(self, clock: np.ndarray) -> np.ndarray | None:
        """As `points_at`; None where there is no spread."""
        return None if self.spread is None else self.points_at("spread", clock)

    def box_at(self, clock: np.ndarray) -> np.ndarray | None:
        """(N, 7) X_WB at times (N,) of the skill's clock, held outside; None without a box."""
        return None if self.box is None else interpolated_poses(self.clock, self.box, clock)

    def to_bytes(self) -> bytes:
        """An .npz file, in single precision but for the clock; the same signals give the same bytes."""
        arrays = {field.name: getattr(self, field.name) for field in fields(self)}
        return _packed({name: value for name, value in arrays.items() if value is not None}, exact=("clock",))


def read_planned(data: bytes, where: str) -> PlannedSignals:
    """The signals in an attachment.

    Args:
        data: from `PlannedSignals.to_bytes`.
        where: the file, for messages.

    Raises:
        RecorderError: it is no such attachment.
    """
    arrays = _unpacked(data, where, ATTACHMENT)
    found: dict[str, Any] = {field.name: arrays.get(field.name) for field in fields(PlannedSignals)}
    signals = PlannedSignals(**found)
    try:
        _check(signals)
    except ValueError as error:
        raise _not_ours(where, ATTACHMENT, error) from None
    return signals


def measured_bytes(t: np.ndarray, clearance: np.ndarray) -> bytes:
    """The attachment `MEASURED`: times (N,), s, and the least distances (N,) then, m."""
    return _packed({"t": t, "clearance": clearance}, exact=("t",))


def read_measured(data: bytes, where: str) -> tuple[np.ndarray, np.ndarray]:
    """Times (N,), s, and clearances (N,), m, of the attachment `MEASURED` of a file; raises as `read_planned`."""
    arrays = _unpacked(data, where, MEASURED)
    t, clearance = arrays.get("t"), arrays.get("clearance")
    if t is None or clearance is None or t.ndim != 1 or len(t) == 0 or t.shape != clearance.shape:
        raise _not_ours(where, MEASURED, ValueError("it needs t and clearance of one length"))
    return t, clearance


def _packed(arrays: Mapping[str, np.ndarray], exact: tuple[str, ...]) -> bytes:
    kinds = {name: float if name in exact else np.float32 for name in arrays}
    return npz_bytes({name: np.asarray(value, kinds[name]) for name, value in arrays.items()})


def _unpacked(data: bytes, where: str, name: str) -> dict[str, np.ndarray]:
    try:
        return {key: np.asarray(array, dtype=float) for key, array in npz_arrays(data).items()}
    except (PlainDataError, TypeError, ValueError) as error:
        raise _not_ours(where, name, error) from None


def _not_ours(where: str, name: str, error: Exception) -> RecorderError:
    reason = " ".join(str(error).split()) or type(error).__name__
    return RecorderError(f"{where}: the attachment {name} is not what a run has ({reason}); record the run anew")


def _check(signals: PlannedSignals) -> None:
    """Raises ValueError where a shape is not what `PlannedSignals` states."""
    samples = 0 if signals.clock is None else len(np.atleast_1d(signals.clock))
    points, joints = (samples, 6, 3), (_JOINTS,)
    expected = {
        "clock": (samples,),
        "uncoupled": points,
        "demonstrated": points,
        "spread": points,
        "box": (samples, 7),
        "q_lower": joints,
        "q_upper": joints,
        "v_limit": joints,
        "effort_limit": joints,
    }
    for name, shape in expected.items():
        value = getattr(signals, name)
        if value is None and name in ("spread", "box"):
            continue
        if np.shape(value) != shape:
            raise ValueError(f"{name} has shape {np.shape(value)}, not {shape}")
    if samples < 2 or not np.all(np.diff(signals.clock) > 0):
        raise ValueError("clock must be 2 or more growing times")
