"""Rows of 18 numbers without a header: the six points and nothing else, in one of two orders.

A frame number or a time may stand first. Wrists, elbows, shoulders (each left, right) is the order of some recordings
of assembly work; shoulder, elbow, wrist of the left arm, then of the right, is our own. A person's bones and shoulders
keep their lengths only in the order that is meant.
"""

from collections import Counter
from collections.abc import Iterable
from itertools import islice
from pathlib import Path

import numpy as np

from drake_blfdmp.demonstration.bones import BONES, link_lengths
from drake_blfdmp.demonstration.formats.point_names import resolve
from drake_blfdmp.demonstration.formats.recording_format import Joints
from drake_blfdmp.demonstration.formats.tables.dialect import COMMENTS, Dialect, find_dialect
from drake_blfdmp.demonstration.formats.tables.joint_rows import width_of_numbers
from drake_blfdmp.demonstration.formats.tables.table_rows import leading_columns
from drake_blfdmp.demonstration.formats.tables.tables import read_columns
from drake_blfdmp.demonstration.formats.text import head_lines, numbered_lines
from drake_blfdmp.demonstration.raw_recording import RawRecording, one_body
from drake_blfdmp.errors import RecordingError
from drake_blfdmp.skeleton import POINTS, SHOULDERS

ORDERS = {
    "wrists, elbows, shoulders": (
        "left_wrist", "right_wrist", "left_elbow", "right_elbow", "left_shoulder", "right_shoulder",
    ),
    "left arm, right arm": POINTS,
}  # fmt: skip
_JUMP = 0.5  # Of a length; a jump beyond counts as much, so that no single one decides.
_COLUMNS = 3 * len(POINTS)
_LARGEST = 1e7  # As for all recordings; larger numbers are no positions and would hide the other lengths.


class Points18:
    """Reader of rows of 18 or 19 numbers; `joints` may swap the six points' names."""

    name = "points18"

    def sniff(self, head: bytes) -> bool:
        """Whether some of the first lines are rows of 18 or 19 numbers."""
        return _layout(head_lines(head)) is not None

    def read(self, path: Path, joints: Joints | None) -> RawRecording:
        """Reads the file; the order of the points is that in which the bones keep their lengths.

        Raises:
            RecordingError: a row with another number of columns, a cell that is no number, or an unknown joint.
        """
        chosen = resolve(str(path), POINTS, joints)
        layout = _layout(line for _, line in numbered_lines(path))
        if layout is None:
            number, line = next(numbered_lines(path), (1, ""))
            raise RecordingError(
                f"{path}: line {number} has {len(find_dialect(line).row(line))} columns, expected 18 numbers, "
                "or 19 with a frame number or a time first; give another format"
            )
        first, dialect = layout
        columns = list(range(first + _COLUMNS))
        table = read_columns(path, dialect, len(columns), columns, skip_empty=first > 0)
        points = np.stack([table.numbers[column] for column in columns[first:]], axis=-1).reshape(-1, len(POINTS), 3)
        changes = {name: _change_of_lengths(points[:, _indices(order)]) for name, order in ORDERS.items()}
        best = min(changes, key=lambda name: changes[name])
        other = next(name for name in ORDERS if name != best)
        order = ORDERS[best]
        names = [chosen[point] for point in POINTS]
        x = points[:, [order.index(name) for name in names if isinstance(name, str)]]
        t, frames, _ = leading_columns(table, columns[:first])
        return one_body(
            x,
            frames,
            t,
            notes=(
                f"order: {best}, in which lengths change by {100 * changes[best]:.2g} % "
                f"({100 * changes[other]:.2g} % as {other})",
            ),
        )


def _indices(order: tuple[str, ...]) -> list[int]:
    return [order.index(point) for point in POINTS]


def _change_of_lengths(x: np.ndarray) -> float:
    """Mean deviation of a length from its median, as a share of it, over the four bones and the shoulders' distance."""
    x = np.where(np.abs(x) < _LARGEST, x, np.nan)
    across = np.linalg.norm(x[:, SHOULDERS[1]] - x[:, SHOULDERS[0]], axis=-1)
    changes: list[float] = []
    for length in (*link_lengths(x)[:, BONES].T, across):
        seen = length[np.isfinite(length)]
        if len(seen) and (median := float(np.median(seen))) > 0.0:
            changes.append(float(np.minimum(np.abs(seen / median - 1.0), _JUMP).mean()))
        else:
            changes.append(1.0)
    return float(np.mean(changes))


def _layout(lines: Iterable[str]) -> tuple[int, Dialect] | None:
    """Cells before the points, and separators, of most of the first rows."""
    seen: Counter[tuple[int, Dialect]] = Counter()
    rows = (line for line in lines if not line.startswith(COMMENTS))
    for line in islice(rows, 20):
        dialect = find_dialect(line, _COLUMNS, _COLUMNS + 1)
        width = width_of_numbers(line, dialect, (_COLUMNS, _COLUMNS + 1))
        if width:
            seen[width - _COLUMNS, dialect] += 1
    return max(seen, key=lambda layout: seen[layout]) if seen else None
