"""Tables with a header and one joint a row: frame or time, joint (a name, or a sensor's number), x, y, z.

Columns may stand in any order, with confidence, person and others between. Rows of one frame belong together by frame
number, else by time, else by the order in which each joint's rows come.
"""

from collections.abc import Callable, Iterable
from functools import cache
from pathlib import Path

import numpy as np

from drake_blfdmp.demonstration.formats.confidence import confidence_of_numbers
from drake_blfdmp.demonstration.formats.point_names import guess, resolve
from drake_blfdmp.demonstration.formats.recording_format import Joints
from drake_blfdmp.demonstration.formats.sensor_joints import NumberedJoints, joints_by_number
from drake_blfdmp.demonstration.formats.tables.table_header import Header, columns_of_words, find_header, first_rows
from drake_blfdmp.demonstration.formats.tables.table_names import (
    body_column,
    confidence_column,
    frame_column,
    joint_column,
    joints_of,
    position_columns,
    time_column,
)
from drake_blfdmp.demonstration.formats.tables.table_rows import clock_values, confidence_values, frame_values
from drake_blfdmp.demonstration.formats.tables.tables import Columns, Words, read_columns
from drake_blfdmp.demonstration.formats.text import head_lines, numbered_lines
from drake_blfdmp.demonstration.raw_recording import Body, RawRecording
from drake_blfdmp.errors import RecordingError
from drake_blfdmp.skeleton import POINTS


class LongCsv:
    """Reader of tables with a header and one joint a row; `joints` names joints, "time" a column."""

    name = "long_csv"

    def sniff(self, head: bytes) -> bool:
        """Whether some line names a column of joints and columns x, y and z."""
        return _find_header(enumerate(head_lines(head), 1)) is not None

    def read(self, path: Path, joints: Joints | None) -> RawRecording:
        """Reads the file.

        Raises:
            RecordingError: no header, a joint that is not there, a row with other columns than the header has, or a
                cell that is no number.
        """
        header = _find_header(numbered_lines(path))
        if header is None:
            raise RecordingError(
                f"{path}: no line names a column of joints and columns x, y and z; add a header or give another format"
            )
        names = header.names
        joint, position = joint_column(names), position_columns(names)
        if joint is None or position is None:
            raise RecordingError(f"{path}: line {header.line} names no joints; give another format")
        time, time_unit = time_column(str(path), names, joints)
        frame, person, said = frame_column(names), body_column(names), confidence_column(names)
        dialect, rows = first_rows(numbered_lines(path, header.line + 1), len(names))
        optional = {column for column in (time, frame, said) if column is not None}
        words = columns_of_words(rows, optional) | ({joint, person} - {None})
        numbers = dict.fromkeys([*position.columns, *sorted(optional - words)])
        table = read_columns(
            path,
            dialect,
            len(names),
            list(numbers),
            [joint, *sorted(words - {joint})],
            first_line=header.line + 1,
            names=names,
            keep=_wanted(joints),
        )
        if not table.words[joint].known:
            raise RecordingError(f"{path}: holds a header but no samples; export the recording again")
        sensor = _sensor(table.words[joint])
        point = _points_of(path, table.words[joint], sensor, joints)
        t, written_unit = clock_values(path, table, time, names[time] if time is not None else "")
        frames = frame_values(path, table, frame, names[frame] if frame is not None else "")
        x = np.stack([table.numbers[column] for column in position.columns], axis=-1)
        confidence, note = confidence_of_numbers(confidence_values(table, [said]), x[:, None])
        people = _people(table, person)
        bodies: dict[str, Body] = {}
        repeated = 0
        for name in dict.fromkeys(people.known):
            own = (point >= 0) & (np.array(people.known, dtype=object) == name)[people.index]
            bodies[name or "?"], more = _gather(path, np.flatnonzero(own), point, x, t, frames, confidence)
            repeated += more
        notes = (
            f"joints: numbered as by {sensor.sensor}" if sensor else "",
            note,
            f"{repeated} rows give a joint of a frame once more and are left out" if repeated else "",
        )
        return RawRecording(
            bodies,
            unit=position.unit or header.unit,
            time_unit=written_unit or time_unit,
            clock_hz=header.rate_hz,
            up=sensor.up if sensor else None,
            notes=tuple(note for note in notes if note),
        )


def _find_header(lines: Iterable[tuple[int, str]]) -> Header | None:
    return find_header(lines, _is_long)


def _is_long(names: list[str]) -> bool:
    long = joint_column(names) is not None and position_columns(names) is not None
    return long and len(guess(joints_of(names))) < len(POINTS)  # Else a wide table with a box, say, in x, y and z.


def _wanted(joints: Joints | None) -> Callable[[str], bool]:
    """Whether a joint may be one of the points: most files have many more rows of others."""
    given = {value.lower() for value in (joints or {}).values() if isinstance(value, str)}

    @cache
    def wanted(cell: str) -> bool:
        name = cell.strip()
        return name.isdecimal() or bool(guess([name])) or name.lower() in given

    return wanted


def _sensor(words: Words) -> NumberedJoints | None:
    """The sensor that numbers its joints so; None where joints have names, or numbers of no known sensor."""
    if not all(word.isdecimal() and len(word) < 4 for word in words.known):
        return None
    return joints_by_number({int(word) for word in words.known})


def _points_of(path: Path, words: Words, sensor: NumberedJoints | None, joints: Joints | None) -> np.ndarray:
    """(N,) the index in POINTS of each row's joint; -1 for other joints."""
    names = [sensor.names[int(word)] if sensor else word for word in words.known]
    chosen = resolve(str(path), names, joints)
    point = {}
    for index, key in enumerate(POINTS):
        name = chosen[key]
        if not isinstance(name, str):
            raise RecordingError(f"{path}: a joint has its own rows in this format; give {key} one joint name")
        point[name] = index
    return np.array([point.get(name, -1) for name in names])[words.index]


def _people(table: Columns, column: int | None) -> Words:
    """Whose each row is; the same one's where no column says so, or where it differs in nearly every row."""
    words = table.words[column] if column is not None else None
    if words is None or (len(words.known) > 1 and 2 * len(words.known) > len(words.index)):
        return Words(np.zeros(len(table.lines), dtype=int), ["0"])
    return words


def _gather(
    path: Path,
    rows: np.ndarray,
    point: np.ndarray,
    x: np.ndarray,
    t: np.ndarray | None,
    frames: np.ndarray | None,
    confidence: np.ndarray | None,
) -> tuple[Body, int]:
    """One person's frames in the order in which they come, and the number of rows that repeat one before."""
    point = point[rows]
    if frames is not None:
        key = frames
    elif t is not None:
        key = np.unique(t, return_inverse=True)[1]
    else:
        key = np.zeros(len(x), dtype=int)
        key[rows] = _turns(path, point)
    _, first, frame = np.unique(key[rows], return_index=True, return_inverse=True)
    order = np.argsort(first)  # Of the sorted keys: as in the file.
    frame = np.argsort(order)[frame]
    first = rows[first[order]]
    kept = np.unique(frame * len(POINTS) + point, return_index=True)[1]
    gathered = np.full((len(first), len(POINTS), 3), np.nan)
    gathered[frame[kept], point[kept]] = x[rows[kept]]
    seen = None
    if confidence is not None:
        seen = np.zeros((len(first), len(POINTS)))
        seen[frame[kept], point[kept]] = confidence[rows[kept], 0]
    return Body(gathered, key[first], None if t is None else t[first], seen), len(rows) - len(kept)


def _turns(path: Path, point: np.ndarray) -> np.ndarray:
    """(N,) how often each row's joint has come before."""
    counts = np.bincount(point, minlength=len(POINTS))
    if counts.min() != counts.max():
        raise RecordingError(
            f"{path}: names neither frame nor time, and its joints have {counts.min()} to {counts.max()} rows, so "
            "nothing tells which belong together; add a column frame"
        )
    turn = np.empty(len(point), dtype=int)
    for index in range(len(POINTS)):
        turn[point == index] = np.arange(counts[index])
    return turn
